#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "report/json_writer.hpp"

namespace tanor::report {

/// An array of a result in the user's order; none: it was not computed.
using Numbers = std::optional<std::span<const double>>;

/// Above this many points arrays go to .npy files and the JSON holds their names.
constexpr std::size_t largest_inline = 10'000;

/// Puts arrays under keys of a JSON object: inline, or as `<prefix><key>.npy`.
class ArrayWriter {
 public:
  /// Everything inline.
  explicit ArrayWriter(JsonWriter* json) : json_(json) {}
  /// Inline up to `largest_inline` points. `prefix`: folder and beginning of the files' names.
  ArrayWriter(JsonWriter* json, std::filesystem::path prefix, std::size_t num_points);

  /// The same with more words in front of the files' names.
  ArrayWriter with_prefix(std::string_view words) const;

  void write_points(std::string_view key, const Numbers& numbers);  ///< n x 3
  void write_list(std::string_view key, const Numbers& numbers);    ///< d
  /// Rows of any width; one column: rows of one number inline, a plain vector in a file.
  void write_rows(std::string_view key, const Numbers& numbers, std::size_t columns);
  void write_booleans(std::string_view key, const std::vector<bool>& values);

 private:
  void write(std::string_view key, const Numbers& numbers, std::size_t columns);
  /// Where the array of a key goes, and its name as the key's value.
  std::filesystem::path name_file(std::string_view key);

  JsonWriter* json_;
  std::optional<std::filesystem::path> prefix_;
};

}  // namespace tanor::report
