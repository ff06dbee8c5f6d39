#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tanor {

/// What stands around bytes that somebody saves: in front their kind, their format, the order of bytes and what they
/// belong to, behind a checksum of all that. The same place and the same words for every kind.
struct SavedHeader {
  std::array<char, 8> magic{};
  std::uint32_t version = 0;
  std::uint32_t byte_order = 0x01020304;  // reads otherwise on a machine with another order
  std::uint64_t fingerprint = 0;
};

/// Who saves, for complaints.
struct SavedBy {
  const char* where;   ///< "/state", the place that an InputError names
  const char* writer;  ///< "a Constrainer"
  const char* owner;   ///< "other points or constraints", whose bytes they are if not these
};

/// The checksum of these bytes.
std::uint64_t checksum_of(std::span<const std::byte> bytes);

/// The bytes between header and checksum. Throws InputError where these are not what `wanted` says.
std::span<const std::byte> check_frame(std::span<const std::byte> bytes, const SavedHeader& wanted, const SavedBy& by);

}  // namespace tanor
