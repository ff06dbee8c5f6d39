#pragma once

#include <fmt/format.h>

#include <concepts>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "report/output_file.hpp"

namespace tanor::report {

/// Writes JSON while it is told, so that arrays of millions of rows need no memory.
///
/// Doubles get the fewest digits that read back to the same bits (17 at most); a number that is not finite, and one
/// that was not computed, is null. Bytes that are no UTF-8 become U+FFFD.
class JsonWriter {
 public:
  explicit JsonWriter(OutputFile* file) : file_(file) {}

  JsonWriter& begin_object();
  JsonWriter& end_object();
  JsonWriter& begin_array();
  JsonWriter& end_array();
  /// Name of the member whose value comes next.
  JsonWriter& key(std::string_view name);

  JsonWriter& value(double number);
  JsonWriter& value(std::optional<double> number);
  JsonWriter& value(std::string_view text);
  JsonWriter& value(const char* text) { return value(std::string_view(text)); }
  JsonWriter& value(bool truth);
  JsonWriter& null();
  template <std::integral Integer>
  JsonWriter& value(Integer number) {
    begin_element();
    fmt::format_to(fmt::appender(buffer_), "{}", number);
    return *this;
  }

  /// An array of numbers.
  JsonWriter& numbers(std::span<const double> numbers);
  /// An array of arrays: `numbers` row by row, one row a line.
  JsonWriter& rows(std::span<const double> numbers, std::size_t columns);

  /// The end of the text; nothing is complete before.
  void finish();

 private:
  struct Level {
    bool is_object = false;
    bool is_empty = true;
  };

  JsonWriter& open(char bracket, bool is_object);
  JsonWriter& close(char bracket);
  void begin_element();  ///< the comma, space or line that separates an element from what stands before
  void break_line();
  void append(std::string_view text) { buffer_.append(text); }
  void append_number(double number);
  void append_text(std::string_view text);
  void drain(std::size_t limit);  ///< to the file, when more than `limit` bytes are waiting

  OutputFile* file_;
  fmt::memory_buffer buffer_;
  std::vector<Level> levels_;
  bool has_key_ = false;
};

}  // namespace tanor::report
