#include "report/json_text.hpp"

#include <fmt/compile.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "report/npy.hpp"

namespace tanor::report {

namespace {

constexpr std::size_t buffer_size = 1 << 16;

std::string format_in_line(const Json& value) {
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

JsonObjectFile::JsonObjectFile(OutputFile* file) : file_(file), closing_("}") {
  append("{");
}

void JsonObjectFile::add(std::string_view key, const Json& value) {
  begin_member(key);
  append_value(value, closing_.size());
  write_if_above(buffer_size);
}

void JsonObjectFile::add_numbers(std::string_view key, std::span<const double> numbers) {
  begin_member(key);
  append_list(numbers);
}

void JsonObjectFile::add_rows(std::string_view key, std::span<const double> numbers, std::size_t columns) {
  begin_list(key);
  for (std::size_t begin = 0; begin < numbers.size(); begin += columns) {
    begin_member({});
    append_list(numbers.subspan(begin, columns));
  }
  end();
}

void JsonObjectFile::begin_object(std::string_view key) {
  begin_part(key, '{', '}');
}

void JsonObjectFile::begin_list(std::string_view key) {
  begin_part(key, '[', ']');
}

void JsonObjectFile::end() {
  const char bracket = closing_.back();
  closing_.pop_back();
  if (!is_empty_) break_line(closing_.size());
  text_.push_back(bracket);
  is_empty_ = false;
}

void JsonObjectFile::finish() {
  if (!arrays_.empty()) add("arrays", arrays_);
  end();
  append("\n");
  write_if_above(0);
}

void JsonObjectFile::begin_member(std::string_view key) {
  if (!is_empty_) append(",");
  break_line(closing_.size());
  is_empty_ = false;
  if (key.empty()) return;
  append(format_in_line(key));
  append(": ");
}

void JsonObjectFile::begin_part(std::string_view key, char bracket, char closing_bracket) {
  begin_member(key);
  text_.push_back(bracket);
  closing_.push_back(closing_bracket);
  is_empty_ = true;
}

void JsonObjectFile::break_line(std::size_t level) {
  append("\n");
  for (std::size_t k = 0; k < level; ++k) append("  ");
}

void JsonObjectFile::append(std::string_view text) {
  text_.append(text.data(), text.data() + text.size());
}

void JsonObjectFile::append_list(std::span<const double> numbers) {
  append("[");
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    if (k > 0) append(",");
    append_number(numbers[k]);
    write_if_above(buffer_size);
  }
  append("]");
}

void JsonObjectFile::append_number(double number) {
  if (!std::isfinite(number)) return append("null");
  const std::size_t begin = text_.size();
  fmt::format_to(fmt::appender(text_), FMT_COMPILE("{}"), number);
  // "1" would be read as an integer, and "-0" would lose its sign.
  const auto is_of_integers = [](char c) { return c == '-' || (c >= '0' && c <= '9'); };
  if (std::all_of(text_.begin() + begin, text_.end(), is_of_integers)) append(".0");
}

void JsonObjectFile::append_value(const Json& value, std::size_t level) {
  const bool is_table = value.is_array() && !value.empty() && value.front().is_structured();
  if (!is_table && (!value.is_object() || value.empty())) return append(format_in_line(value));
  const char* before = value.is_object() ? "{" : "[";
  for (const auto& [key, each] : value.items()) {
    append(before);
    break_line(level + 1);
    if (is_table) {
      append(format_in_line(each));
    } else {
      append(format_in_line(key));
      append(": ");
      append_value(each, level + 1);
    }
    before = ",";
  }
  break_line(level);
  append(is_table ? "]" : "}");
}

void JsonObjectFile::write_if_above(std::size_t size) {
  if (text_.size() <= size) return;
  file_->write({text_.data(), text_.size()});
  text_.clear();
}

ArrayWriter::ArrayWriter(JsonObjectFile* json, const Units& units, std::filesystem::path prefix, std::size_t num_points)
    : json_(json), units_(units) {
  if (num_points > largest_inline) prefix_ = std::move(prefix);
}

ArrayWriter ArrayWriter::with_prefix(std::string_view words) const {
  ArrayWriter result(*this);
  if (prefix_) result.prefix_ = prefix_->string() + std::string(words);
  return result;
}

void ArrayWriter::write_points(std::string_view key, Dimension dimension, const Numbers& numbers) const {
  write_rows(key, numbers, 3, describe_array({"point", "x, y, z"}, units_.letters(dimension)));
}

void ArrayWriter::write_list(std::string_view key, const Numbers& numbers) const {
  if (prefix_ || !numbers) return write_rows(key, numbers, 1, describe_array({"equation"}, ""));
  json_->add_numbers(key, *numbers);
}

void ArrayWriter::write_rows(std::string_view key, const Numbers& numbers, std::size_t columns,
                             const Json& about) const {
  if (!numbers) return json_->add(key, {});
  if (!prefix_) return json_->add_rows(key, *numbers, columns);
  write_npy(name_file(key), *numbers, columns);
  add_file(key, about);
}

void ArrayWriter::write_booleans(std::string_view key, const std::optional<std::vector<bool>>& values) const {
  if (!prefix_ || !values) return json_->add(key, json_or_null(values));
  write_npy_booleans(name_file(key), *values);
  add_file(key, describe_array({"equation"}, ""));
}

void ArrayWriter::add_file(std::string_view key, const Json& about) const {
  const std::string name = name_file(key).filename().string();
  json_->add(key, name);
  json_->add_file(name, about);
}

std::filesystem::path ArrayWriter::name_file(std::string_view key) const {
  return prefix_->string() + std::string(key) + ".npy";
}

}  // namespace tanor::report
