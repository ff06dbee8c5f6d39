#include "report/terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace tanor::report {

namespace {

constexpr std::size_t least_width =
    20;  // narrower windows are not supported, since each word would have a line of its own

bool is_set(const char* name) {
  const char* const value = std::getenv(name);
  return value && *value != '\0';
}

bool begins_character(char byte) {
  return (static_cast<unsigned char>(byte) & 0xc0u) != 0x80u;
}

}  // namespace

Terminal Terminal::of(std::FILE* stream) {
  Terminal terminal;
  const int descriptor = fileno(stream);
  if (descriptor < 0 || isatty(descriptor) != 1) return terminal;
  const char* const kind = std::getenv("TERM");
  terminal.has_colours_ = !is_set("NO_COLOR") && kind && std::string_view(kind) != "dumb";
  winsize window{};
  const bool is_known = ioctl(descriptor, TIOCGWINSZ, &window) == 0 && window.ws_col > 0;
  terminal.width_ = std::max<std::size_t>(is_known ? window.ws_col : 80, least_width);
  return terminal;
}

std::string Terminal::paint(std::string_view colour, std::string_view text) const {
  if (!has_colours_ || text.empty()) return std::string(text);
  return "\x1b[" + std::string(colour) + "m" + std::string(text) + "\x1b[0m";
}

std::size_t count_columns(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, begins_character));
}

std::string_view first_columns(std::string_view text, std::size_t columns) {
  std::size_t end = 0;
  for (; end < text.size(); ++end) {
    if (begins_character(text[end]) && columns-- == 0) break;
  }
  return text.substr(0, end);
}

std::string wrap(std::string_view text, std::size_t indent, std::optional<std::size_t> width,
                 std::optional<std::size_t> begin) {
  if (!width) return std::string(text);
  std::string lines;
  std::size_t column = begin.value_or(indent);
  bool has_words = false;  // in this line
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, end);
    const std::size_t columns = count_columns(word);
    if (has_words && column + 1 + columns > *width) {
      lines += '\n' + std::string(indent, ' ');
      column = indent;
      has_words = false;
    } else if (has_words) {
      lines += ' ';
      ++column;
    }
    lines += word;
    column += columns;
    has_words = has_words || columns > 0;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

}  // namespace tanor::report
