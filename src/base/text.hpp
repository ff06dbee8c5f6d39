#pragma once

/// \file Text of values in messages.

#include <array>
#include <charconv>
#include <cstddef>
#include <span>
#include <string>

namespace tanor {

/// Returns the shortest text that reads back as the same number. A NaN has no sign.
template <class Number>
std::string text(Number number) {
  if (number != number) return "nan";
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
  return std::string(buffer.data(), end);
}

/// Returns a list such as "[1, 2, 3]".
template <class Number>
std::string text(std::span<const Number> numbers) {
  std::string list = "[";
  for (const Number number : numbers) list += (list.size() > 1 ? ", " : "") + text(number);
  return list + "]";
}

template <class Number, std::size_t size>
std::string text(const std::array<Number, size>& numbers) {
  return text(std::span<const Number>(numbers));
}

/// Returns "1 row", "2 rows" and the like.
inline std::string text_of_count(std::size_t count, const std::string& noun) {
  return text(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace tanor
