#pragma once

/// \file Text of values in messages.

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <type_traits>

namespace tanor::detail {

/// So many digits tell all numbers apart; the shortest text that does so is taken then.
constexpr int all_digits = 17;

/// Returns the text of a number in a message, of so many digits. Whole numbers below a million have all of theirs, and
/// a NaN has no sign.
template <class Number>
std::string text(Number number, int digits = 4) {
  if (number != number) return "nan";
  std::array<char, 32> buffer;
  char *const begin = buffer.data(), *const end = begin + buffer.size();
  if constexpr (std::is_floating_point_v<Number>) {
    if (std::abs(number) < 1e6 && number == std::trunc(number)) return text(static_cast<long>(number));
    const std::string exact(begin, std::to_chars(begin, end, number).ptr);
    const std::string rounded(begin, std::to_chars(begin, end, number, std::chars_format::general, digits).ptr);
    return digits < all_digits && rounded.size() < exact.size() ? rounded : exact;
  }
  return std::string(begin, std::to_chars(begin, end, number).ptr);
}

/// Returns the texts of numbers that a message compares, with as many digits more as tell different ones apart.
template <std::size_t size>
std::array<std::string, size> texts_apart(const std::array<double, size>& numbers) {
  std::array<std::string, size> texts;
  const auto are_apart = [&] {
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (texts[i] == texts[j] && numbers[i] != numbers[j]) return false;
    return true;
  };
  for (int digits = 4; digits <= all_digits; ++digits) {
    for (std::size_t i = 0; i < size; ++i) texts[i] = text(numbers[i], digits);
    if (are_apart()) break;
  }
  return texts;
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

}  // namespace tanor::detail
