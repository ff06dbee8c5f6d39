#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "motion/snapshot.hpp"

namespace tanor::detail {

/// Returns the bytes of a snapshot: "tanor st", the number of the format and of the byte order, the fingerprint of the
/// system, all numbers of the snapshot, and a checksum of everything before.
std::vector<std::byte> pack(const Snapshot& snapshot, std::uint64_t fingerprint);

/// Returns the snapshot that these bytes hold. Throws InputError if they are no such bytes, are cut off or damaged,
/// have another format or belong to another system.
Snapshot unpack(std::span<const std::byte> bytes, std::uint64_t fingerprint);

}  // namespace tanor::detail
