#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "host/host_parts.hpp"

namespace tanor::detail {

/// Returns what the parts remember as bytes: "tanor co", the numbers of the format and of the byte order, a fingerprint
/// of points and constraints, the numbers, and a checksum of everything before.
std::vector<std::byte> save_state(HostParts* parts);

/// Restores what `save_state` saved. Throws InputError if the bytes are of another kind or damaged, or belong to other
/// points or constraints.
void restore_state(std::span<const std::byte> bytes, HostParts* parts);

}  // namespace tanor::detail
