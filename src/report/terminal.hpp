#pragma once

#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

namespace tanor::report {

/// How text is set on a stream: with colours and as wide as the window where that is a terminal, plainly elsewhere.
/// Colours stay away where NO_COLOR (https://no-color.org) says so, and on a terminal that has none (TERM=dumb).
class Terminal {
 public:
  /// Looks at the stream; a window may have become another one since the last look.
  static Terminal of(std::FILE* stream);
  /// No colours and no end of a line.
  Terminal() = default;

  bool has_colours() const { return has_colours_; }
  /// Characters of a line; nothing: as many as are wanted.
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

/// Characters of a text in UTF-8, which take a column each in what tanor prints.
std::size_t count_columns(std::string_view text);

/// The first columns of a text, all of it where it has no more.
std::string_view first_columns(std::string_view text, std::size_t columns);

/// Breaks a text at spaces into lines of at most `width` columns; lines behind the first begin with `indent` spaces.
/// The first line begins at column `begin`, by default `indent` too, where the caller has set something. A word that is
/// longer has a line of its own.
std::string wrap(std::string_view text, std::size_t indent, std::optional<std::size_t> width,
                 std::optional<std::size_t> begin = {});

}  // namespace tanor::report
