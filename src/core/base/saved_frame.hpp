#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tanor::detail {

/// The header of saved bytes: their kind, their format, the byte order and a fingerprint of what they belong to. A
/// checksum of all that and the bytes follows behind them. The layout is the same for every kind.
struct SavedHeader {
  std::array<char, 8> magic{};
  std::uint32_t version = 0;
  std::uint32_t byte_order = 0x01020304;  // reads as another number on a machine with another byte order
  std::uint64_t fingerprint = 0;
};

/// Names for error messages about saved bytes.
struct SavedBy {
  const char* where;   ///< "/state", the place that an InputError names
  const char* writer;  ///< "a Constrainer"
  const char* owner;   ///< "other points or constraints", the owner if the fingerprint differs
};

/// Returns the checksum of these bytes.
std::uint64_t checksum_of(std::span<const std::byte> bytes);

/// Returns the bytes between header and checksum. Throws InputError if the header or the checksum is not as `wanted`
/// says.
std::span<const std::byte> check_frame(std::span<const std::byte> bytes, const SavedHeader& wanted, const SavedBy& by);

}  // namespace tanor::detail
