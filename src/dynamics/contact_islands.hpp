#pragma once

#include <cstddef>
#include <vector>

#include "dynamics/workspace.hpp"

namespace tanor {

/// Contacts by the islands of their constraints. Contacts of different islands do not feel each other's friction at an
/// instant.
struct ContactIslands {
  explicit ContactIslands(const Workspace& work);

  std::vector<std::vector<std::size_t>> contacts;  ///< [island]; islands without contacts are left out
  std::vector<std::size_t> of_contact;             ///< [contact] its island

  std::size_t size() const { return contacts.size(); }
};

/// "friction at t = 0.5: why"
Outcome fail_friction(Status status, double t, const std::string& why);

}  // namespace tanor
