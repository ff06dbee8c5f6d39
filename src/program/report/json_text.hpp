#pragma once

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/units.hpp>

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

/// Returns the list of what describe(each) returns.
template <class Range, class Describe>
Json list_of(const Range& range, const Describe& describe) {
  Json list = Json::array();
  for (const auto& each : range) list.push_back(describe(each));
  return list;
}

/// Writes an object member by member, so that little of it is in memory. Members of objects and rows of tables have a
/// line of their own. Elements of a list have no key.
class JsonObjectFile {
 public:
  explicit JsonObjectFile(OutputFile* file);
  void add(std::string_view key, const Json& value);
  /// Adds the members of an object.
  void add_members(const Json& object) {
    for (const auto& [key, value] : object.items()) add(key, value);
  }
  void add_numbers(std::string_view key, std::span<const double> numbers);
  /// Adds a table with rows of `columns` numbers.
  void add_rows(std::string_view key, std::span<const double> numbers, std::size_t columns);

  /// Begin an object or list; what is added until `end` lies in it.
  void begin_object(std::string_view key = {});
  void begin_list(std::string_view key);
  void end();
  /// Tells of an array in a file beside this one, which has no names itself.
  void add_file(const std::string& name, const Json& about) { arrays_[name] = about; }
  /// Writes the rest, with the files beside as `arrays`. The file is complete only after this call.
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
  Json arrays_;              ///< about files beside this one
  std::string closing_;      ///< brackets that will close the open objects and lists
  bool is_empty_ = true;     ///< state of the innermost open object or list
};

/// Returns what lies along each axis of an array, and its unit.
inline Json describe_array(const Json& axes, std::string_view unit) {
  return {{"axes", axes}, {"unit", json_or_null(unit)}};
}

/// An array of a result in the user's order, or nothing if it was not computed.
using Numbers = std::optional<std::span<const double>>;

/// Above this many points arrays go to .npy files and the JSON holds their names.
constexpr std::size_t largest_inline = 10'000;

/// Writes arrays as members of a JSON file: either their numbers, or the name of the file `<prefix><key>.npy` that is
/// written for them. An array that was not computed is null.
class ArrayWriter {
 public:
  /// Writes all arrays inline.
  explicit ArrayWriter(JsonObjectFile* json) : json_(json) {}
  /// Writes arrays inline up to `largest_inline` points. `prefix` is the folder and the beginning of the files' names.
  ArrayWriter(JsonObjectFile* json, const Units& units, std::filesystem::path prefix, std::size_t num_points);

  /// Returns a writer that puts more words in front of the files' names.
  ArrayWriter with_prefix(std::string_view words) const;

  void write_points(std::string_view key, Dimension dimension, const Numbers& numbers) const;  ///< n x 3
  void write_list(std::string_view key, const Numbers& numbers) const;  ///< d, of different units
  /// Writes rows of any width. With one column they are rows of one number inline and a plain vector in a file.
  void write_rows(std::string_view key, const Numbers& numbers, std::size_t columns, const Json& about) const;
  void write_booleans(std::string_view key, const std::optional<std::vector<bool>>& values) const;

 private:
  /// Adds the name of a file, and what is in it.
  void add_file(std::string_view key, const Json& about) const;
  std::filesystem::path name_file(std::string_view key) const;

  JsonObjectFile* json_;
  Units units_{};
  std::optional<std::filesystem::path> prefix_;
};

}  // namespace tanor::report
