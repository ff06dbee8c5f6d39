#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "report/output_file.hpp"

/// JSON of the results, by nlohmann: members keep their order, doubles read back to the same bits, a number that is not
/// finite is null, and bytes that are no UTF-8 become U+FFFD.
namespace tanor::report {

using Json = nlohmann::ordered_json;

/// The value, or null where there is none.
template <class Value>
Json json_or_null(const std::optional<Value>& value) {
  return value ? Json(*value) : Json();
}
inline Json json_or_null(std::string_view text) {
  return text.empty() ? Json() : Json(text);
}

/// Writes an object member by member, so that one array at a time is in memory. Members of objects and rows of tables
/// have a line of their own.
class JsonObjectFile {
 public:
  explicit JsonObjectFile(OutputFile* file) : file_(file) {}
  void add(std::string_view key, const Json& value);
  /// Nothing is complete before.
  void finish();

 private:
  OutputFile* file_;
  bool is_empty_ = true;
};

}  // namespace tanor::report
