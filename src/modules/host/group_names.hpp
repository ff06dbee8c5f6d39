#pragma once

#include <span>
#include <string>

#include "host/inventory.hpp"

namespace tanor::detail {

/// Returns the name of the host's group with that number inside a part, which may hold only some of its members.
std::string part_name_of_group(std::size_t group);

/// Returns the text of a part with the host's names in it. `members` are those of the part. "\x1f3[5]" becomes the name
/// of member 5, counted from 0, of the host's group 3 in this part.
std::string with_host_names(const Inventory& inventory, std::span<const ConstraintId> members, const std::string& text);

}  // namespace tanor::detail
