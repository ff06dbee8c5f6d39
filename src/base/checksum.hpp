#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <string_view>

namespace tanor {

/// FNV-1a, 64 bits, of bytes that come in pieces. Each byte acts on the sum one to one: a change of one byte alone, for
/// instance of one bit, always gives another sum.
class Checksum {
 public:
  void add(std::span<const std::byte> bytes) {
    for (const std::byte byte : bytes) value_ = (value_ ^ static_cast<std::uint64_t>(byte)) * 0x100000001b3u;
  }
  void add(std::string_view text) { add(std::as_bytes(std::span(text))); }
  template <class Number>
  void add(std::span<const Number> numbers) {
    add(std::as_bytes(numbers));
  }

  std::uint64_t value() const { return value_; }
  /// 16 hexadecimal digits.
  std::string text() const {
    std::array<char, 17> digits{};
    std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(value_));
    return digits.data();
  }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

}  // namespace tanor
