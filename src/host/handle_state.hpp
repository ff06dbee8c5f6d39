#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "host/host_parts.hpp"

namespace tanor {

/// The bytes of what the parts remember: "tanor co", the number of the format and of the byte order, a mark of points
/// and constraints, the numbers, and a checksum of everything before.
std::vector<std::byte> save_state(HostParts* parts);

/// Throws InputError where these are no such bytes, are damaged, or belong to other points or constraints.
void restore_state(std::span<const std::byte> bytes, HostParts* parts);

}  // namespace tanor
