#pragma once

#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

namespace tanor::report {

/// The style of text on a stream. On a terminal text has colours and the width of the window; elsewhere it is plain.
/// Colours are off if NO_COLOR (https://no-color.org) is set, and on a terminal without colours (TERM=dumb).
class Terminal {
 public:
  /// Examines the stream; the window may have changed since the last call.
  static Terminal of(std::FILE* stream);
  /// Has no colours and unlimited lines.
  Terminal() = default;

  bool has_colours() const { return has_colours_; }
  /// Returns the characters of a line, or nothing if lines are unlimited.
  std::optional<std::size_t> width() const { return width_; }

  std::string bold(std::string_view text) const { return paint("1", text); }
  std::string dim(std::string_view text) const { return paint("2", text); }
  std::string good(std::string_view text) const { return paint("32", text); }
  std::string warning(std::string_view text) const { return paint("33", text); }
  std::string error(std::string_view text) const { return paint("1;31", text); }
  std::string key(std::string_view text) const { return paint("36", text); }

 private:
  std::string paint(std::string_view colour, std::string_view text) const;

  bool has_colours_ = false;
  std::optional<std::size_t> width_;
};

/// Returns the number of characters of a text in UTF-8. Each of those that tanor prints takes one column.
std::size_t count_columns(std::string_view text);

/// Returns the first columns of a text, or the whole text if it has no more.
std::string_view first_columns(std::string_view text, std::size_t columns);

/// Breaks a text at spaces into lines of at most `width` columns. Lines after the first begin with `indent` spaces. The
/// first one begins at column `begin`, which the caller has filled already, or at `indent` by default. A longer word
/// has a line of its own.
std::string wrap(std::string_view text, std::size_t indent, std::optional<std::size_t> width,
                 std::optional<std::size_t> begin = {});

}  // namespace tanor::report
