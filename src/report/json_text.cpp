#include "report/json_text.hpp"

#include <string>

namespace tanor::report {

namespace {

std::string format_in_line(const Json& value) {
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// `level`: how many objects and tables are around it.
void append(const Json& value, std::size_t level, std::string* text) {
  const bool is_table = value.is_array() && !value.empty() && value.front().is_structured();
  if (!is_table && (!value.is_object() || value.empty())) {
    *text += format_in_line(value);
    return;
  }
  const std::string line_break = "\n" + std::string(2 * level + 2, ' ');
  char before = value.is_object() ? '{' : '[';
  for (const auto& [key, each] : value.items()) {
    *text += before + line_break;
    if (is_table) {
      *text += format_in_line(each);
    } else {
      *text += format_in_line(key) + ": ";
      append(each, level + 1, text);
    }
    before = ',';
  }
  *text += line_break.substr(0, line_break.size() - 2) + (is_table ? ']' : '}');
}

}  // namespace

void JsonObjectFile::add(std::string_view key, const Json& value) {
  std::string text = is_empty_ ? "{\n  " : ",\n  ";
  text += format_in_line(key) + ": ";
  append(value, 1, &text);
  file_->write(text);
  is_empty_ = false;
}

void JsonObjectFile::finish() {
  file_->write(is_empty_ ? "{}\n" : "\n}\n");
}

}  // namespace tanor::report
