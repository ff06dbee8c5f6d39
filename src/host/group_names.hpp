#pragma once

#include <span>
#include <string>

#include "host/inventory.hpp"

namespace tanor {

/// The name of the host's group with that number inside a part, which may hold some of its members alone.
std::string part_name_of_group(std::size_t group);

/// The text of a part with these members, by the host's names: "\x1f3[5]" becomes the name of the fifth member of the
/// host's group 3 in this part.
std::string with_host_names(const Inventory& inventory, std::span<const ConstraintId> members, const std::string& text);

}  // namespace tanor
