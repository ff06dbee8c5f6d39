#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "report/json_text.hpp"

namespace tanor::report {

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
  ArrayWriter(JsonObjectFile* json, std::filesystem::path prefix, std::size_t num_points);

  /// Returns a writer that puts more words in front of the files' names.
  ArrayWriter with_prefix(std::string_view words) const;

  void write_points(std::string_view key, const Numbers& numbers) const;  ///< n x 3
  void write_list(std::string_view key, const Numbers& numbers) const;    ///< d
  /// Writes rows of any width. With one column they are rows of one number inline and a plain vector in a file.
  void write_rows(std::string_view key, const Numbers& numbers, std::size_t columns) const;
  void write_booleans(std::string_view key, const std::optional<std::vector<bool>>& values) const;

 private:
  std::filesystem::path name_file(std::string_view key) const;

  JsonObjectFile* json_;
  std::optional<std::filesystem::path> prefix_;
};

}  // namespace tanor::report
