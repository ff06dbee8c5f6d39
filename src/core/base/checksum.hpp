#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <string_view>

namespace tanor::detail {

/// A 64-bit checksum of bytes that come in pieces; how they were cut into pieces does not matter. It is FNV-1a on words
/// of eight bytes, with a shift that carries high bits down. The map from each word to the sum is one to one, so a
/// change within one word, for instance of one bit, always gives another sum.
class Checksum {
 public:
  void add(std::span<const std::byte> bytes) {
    while (!bytes.empty() && num_pending_ > 0) bytes = take_byte(bytes);
    for (; bytes.size() >= word_size; bytes = bytes.subspan(word_size)) {
      std::uint64_t word = 0;
      for (std::size_t k = 0; k < word_size; ++k) word |= static_cast<std::uint64_t>(bytes[k]) << (8 * k);
      value_ = mix(value_, word);
    }
    while (!bytes.empty()) bytes = take_byte(bytes);
  }
  void add(std::string_view text) { add(std::as_bytes(std::span(text))); }
  template <class Number>
  void add(std::span<const Number> numbers) {
    add(std::as_bytes(numbers));
  }

  std::uint64_t value() const {
    // The last word may have fewer bytes than eight. Their number tells them from bytes that are zero.
    return num_pending_ == 0 ? value_ : mix(value_, pending_ | static_cast<std::uint64_t>(num_pending_) << 56);
  }
  /// Returns the value as 16 hexadecimal digits.
  std::string text() const {
    std::array<char, 17> digits{};
    std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(value()));
    return digits.data();
  }

 private:
  static constexpr std::size_t word_size = 8;

  static std::uint64_t mix(std::uint64_t sum, std::uint64_t word) {
    sum = (sum ^ word) * 0x100000001b3u;
    return sum ^ (sum >> 32);
  }
  /// Adds the first byte to the incomplete word and returns the other bytes.
  std::span<const std::byte> take_byte(std::span<const std::byte> bytes) {
    pending_ |= static_cast<std::uint64_t>(bytes.front()) << (8 * num_pending_);
    if (++num_pending_ == word_size) {
      value_ = mix(value_, pending_);
      pending_ = num_pending_ = 0;
    }
    return bytes.subspan(1);
  }

  std::uint64_t value_ = 0xcbf29ce484222325u;
  std::uint64_t pending_ = 0;    ///< the bytes of the incomplete word
  std::size_t num_pending_ = 0;  ///< their number, 0 … 7
};

}  // namespace tanor::detail
