#include "report/json_writer.hpp"

#include <fmt/compile.h>

#include <algorithm>
#include <cmath>

namespace tanor::report {

namespace {

constexpr std::size_t buffer_size = 1 << 16;

/// Bytes of the UTF-8 sequence at the beginning of `text`; 0 where there is none.
std::size_t length_of_utf8(std::string_view text) {
  const auto first = static_cast<unsigned char>(text.front());
  const std::size_t length = first < 0x80   ? 1
                             : first < 0xC2 ? 0
                             : first < 0xE0 ? 2
                             : first < 0xF0 ? 3
                             : first < 0xF5 ? 4
                                            : 0;
  if (length > text.size()) return 0;
  for (const char c : text.substr(1, length == 0 ? 0 : length - 1)) {
    if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) return 0;
  }
  if (length < 3) return length;
  // Overlong forms, surrogates, and what lies beyond U+10FFFF show in the second byte.
  const auto second = static_cast<unsigned char>(text[1]);
  const bool is_valid = !(first == 0xE0 && second < 0xA0) && !(first == 0xED && second > 0x9F) &&
                        !(first == 0xF0 && second < 0x90) && !(first == 0xF4 && second > 0x8F);
  return is_valid ? length : 0;
}

}  // namespace

JsonWriter& JsonWriter::begin_object() {
  return open('{', true);
}
JsonWriter& JsonWriter::end_object() {
  return close('}');
}
JsonWriter& JsonWriter::begin_array() {
  return open('[', false);
}
JsonWriter& JsonWriter::end_array() {
  return close(']');
}

JsonWriter& JsonWriter::key(std::string_view name) {
  begin_element();
  append_text(name);
  append(": ");
  has_key_ = true;
  return *this;
}

JsonWriter& JsonWriter::value(double number) {
  begin_element();
  append_number(number);
  return *this;
}

JsonWriter& JsonWriter::value(std::optional<double> number) {
  return number ? value(*number) : null();
}

JsonWriter& JsonWriter::value(std::string_view text) {
  begin_element();
  append_text(text);
  return *this;
}

JsonWriter& JsonWriter::value(bool truth) {
  begin_element();
  append(truth ? "true" : "false");
  drain(buffer_size);
  return *this;
}

JsonWriter& JsonWriter::null() {
  begin_element();
  append("null");
  return *this;
}

JsonWriter& JsonWriter::numbers(std::span<const double> numbers) {
  begin_array();
  for (const double number : numbers) value(number);
  return end_array();
}

JsonWriter& JsonWriter::rows(std::span<const double> numbers, std::size_t columns) {
  begin_array();
  for (std::size_t begin = 0; begin < numbers.size(); begin += columns) {
    append(begin == 0 ? "" : ",");
    break_line();
    for (std::size_t column = 0; column < columns; ++column) {
      append(column == 0 ? "[" : ", ");
      append_number(numbers[begin + column]);
    }
    append("]");
    drain(buffer_size);
  }
  return end_array();
}

void JsonWriter::finish() {
  append("\n");
  drain(0);
}

JsonWriter& JsonWriter::open(char bracket, bool is_object) {
  begin_element();
  buffer_.push_back(bracket);
  levels_.push_back({.is_object = is_object});
  return *this;
}

JsonWriter& JsonWriter::close(char bracket) {
  const Level level = levels_.back();
  levels_.pop_back();
  if (level.is_object && !level.is_empty) break_line();
  buffer_.push_back(bracket);
  drain(buffer_size);
  return *this;
}

void JsonWriter::begin_element() {
  if (has_key_ || levels_.empty()) {
    has_key_ = false;
    return;
  }
  Level& level = levels_.back();
  if (!level.is_empty) append(level.is_object ? "," : ", ");
  if (level.is_object) break_line();
  level.is_empty = false;
}

void JsonWriter::break_line() {
  buffer_.push_back('\n');
  for (std::size_t k = 0; k < levels_.size(); ++k) append("  ");
}

void JsonWriter::append_number(double number) {
  if (std::isfinite(number)) {
    fmt::format_to(fmt::appender(buffer_), FMT_COMPILE("{}"), number);
  } else {
    append("null");
  }
  drain(buffer_size);
}

void JsonWriter::append_text(std::string_view text) {
  buffer_.push_back('"');
  while (!text.empty()) {
    const char c = text.front();
    const std::size_t length = length_of_utf8(text);
    if (length == 0) {
      append("\uFFFD");
    } else if (c == '"' || c == '\\') {
      buffer_.push_back('\\');
      buffer_.push_back(c);
    } else if (static_cast<unsigned char>(c) < 0x20) {
      fmt::format_to(fmt::appender(buffer_), "\\u{:04x}", static_cast<unsigned>(c));
    } else {
      append(text.substr(0, length));
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  buffer_.push_back('"');
}

void JsonWriter::drain(std::size_t limit) {
  if (buffer_.size() <= limit) return;
  file_->write({buffer_.data(), buffer_.size()});
  buffer_.clear();
}

}  // namespace tanor::report
