#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "cli/command_table.hpp"
#include "picture/style.hpp"

namespace tanor::cli {

/// Returns the number that the whole text is, or none.
template <class Number>
std::optional<Number> read_number(const std::string& text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

/// Reads words between commas; each use of the option adds some.
Value list(std::vector<std::string>* target);

/// Reads a word, or several between commas, of those that shells offer.
Value offer(std::vector<std::string> offers, Value value, Word word = Word::Choice);

/// Reads "1600x1000".
Value size_of_picture(picture::Style* style);
/// Reads "auto", an axis, or two angles.
Value view_of_picture(picture::Style* style);
Value projection_of_picture(picture::Style* style);
/// Reads what is shown, as names between commas. What is not named is not shown.
Value parts_of_picture(picture::Style* style);

}  // namespace tanor::cli
