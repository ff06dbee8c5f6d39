#pragma once

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "report/output_file.hpp"

/// JSON of the results, by nlohmann. Members keep their order, doubles read back to the same bits, a number that is not
/// finite is null, and bytes that are not UTF-8 become U+FFFD. Arrays of numbers are written directly, because a tree
/// of values would cost more than their digits.
namespace tanor::report {

using Json = nlohmann::ordered_json;

/// Returns the value, or null if there is none.
template <class Value>
Json json_or_null(const std::optional<Value>& value) {
  return value ? Json(*value) : Json();
}
inline Json json_or_null(std::string_view text) {
  return text.empty() ? Json() : Json(text);
}

/// Writes an object member by member, so that little of it is in memory. Members of objects and rows of tables have a
/// line of their own. Elements of a list have no key.
class JsonObjectFile {
 public:
  explicit JsonObjectFile(OutputFile* file);
  void add(std::string_view key, const Json& value);
  void add_numbers(std::string_view key, std::span<const double> numbers);
  /// Adds a table with rows of `columns` numbers.
  void add_rows(std::string_view key, std::span<const double> numbers, std::size_t columns);

  /// Begin an object or list; what is added until `end` lies in it.
  void begin_object(std::string_view key = {});
  void begin_list(std::string_view key);
  void end();
  /// Writes the rest. The file is complete only after this call.
  void finish();

 private:
  void begin_member(std::string_view key);
  void begin_part(std::string_view key, char bracket, char closing_bracket);
  void break_line(std::size_t level);
  void append(std::string_view text);
  void append_list(std::span<const double> numbers);
  void append_number(double number);
  /// Appends a value that is inside `level` objects and lists.
  void append_value(const Json& value, std::size_t level);
  void write_if_above(std::size_t size);

  OutputFile* file_;
  fmt::memory_buffer text_;  ///< text that is not in the file yet
  std::string closing_;      ///< brackets that will close the open objects and lists
  bool is_empty_ = true;     ///< state of the innermost open object or list
};

}  // namespace tanor::report
