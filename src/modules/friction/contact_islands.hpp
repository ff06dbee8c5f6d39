#pragma once

#include <cstddef>
#include <vector>

#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Contacts grouped by the islands of their constraints. At one instant friction has no effect on the contacts of other
/// islands.
struct ContactIslands {
  explicit ContactIslands(const Workspace& work);

  std::vector<std::vector<std::size_t>> contacts;  ///< [island]; islands without contacts are left out
  std::vector<std::size_t> of_contact;             ///< [contact] its island

  std::size_t size() const { return contacts.size(); }
};

}  // namespace tanor::detail
