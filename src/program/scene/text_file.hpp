#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tanor::scene {

/// Returns the whole file. Throws InputError (without a place) if it cannot be read.
std::string read_text(const std::filesystem::path& file);

/// Returns what a file's name ends in, in small letters: ".obj" of CUBE.OBJ.
std::string ending_of(const std::filesystem::path& file);

/// The lines of a text one by one, without their ends. A line ends in LF, CR LF or, as on old Macs, CR alone.
class LineReader {
 public:
  /// `name` is that of the text, for errors; the text must outlive the reader. A byte-order mark of UTF-8 is skipped.
  /// Throws InputError (without a place) if the text is packed, or in UTF-16 or UTF-32.
  LineReader(std::string name, std::string_view text);

  /// Goes to the next line and returns true, or false at the end. Throws InputError if the line holds a zero byte.
  bool next();
  std::string_view line() const { return line_; }
  /// Returns the line without what stands behind '#', and without blanks at both ends.
  std::string_view content() const;
  std::string_view rest() const { return rest_; }  ///< text after the line
  std::size_t number() const { return number_; }   ///< 1, 2, …
  /// Returns the number that a word of the line spells. Throws InputError if it is none or not finite.
  double read_number(std::string_view word) const;
  /// Throws InputError "<name>, line <number>: found "<found>", wanted <wanted>".
  [[noreturn]] void fail(std::string_view found, std::string_view wanted) const;
  /// Throws InputError "<name>, line <number>: <what>".
  [[noreturn]] void complain(std::string_view what) const;

 private:
  std::string name_;
  std::string_view rest_, line_;
  std::size_t number_ = 0;
  bool ends_by_cr_ = false;  ///< CR alone ended the first line; an LF behind such an end is content
};

/// Returns the text without blanks at both ends.
std::string_view trim(std::string_view text);
/// Returns columns of a line, counted from 1, without blanks at both ends; columns beyond the end of the line are
/// empty.
std::string_view columns(std::string_view line, std::size_t first, std::size_t last);
/// Returns the words between blanks.
std::vector<std::string_view> split_words(std::string_view line);

/// Returns the number that the whole word spells, or nothing if it spells none or one that is not finite.
std::optional<double> parse_number(std::string_view word);
/// Returns true for numbers, also those that are not finite.
bool spells_number(std::string_view word);
std::optional<std::int64_t> parse_integer(std::string_view word);

}  // namespace tanor::scene
