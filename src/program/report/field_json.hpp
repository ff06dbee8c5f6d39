#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <tanor/report_fields.hpp>

#include "base/member_names.hpp"
#include "report/json_text.hpp"

/// JSON of reports from their tables of fields (`FieldsOf`), or of some members under their own names.
namespace tanor::report {

inline Json json_of(double number) {
  return std::isfinite(number) ? Json(number) : Json();
}
inline Json json_of(const std::string& text) {
  return json_or_null(text);
}
template <class Value>
Json json_of(const std::optional<Value>& value) {
  return json_or_null(value);
}
template <HasReportFields Report>
Json json_of(const Report& report);

template <class Value>
Json json_of(const std::vector<Value>& list) {
  Json array = Json::array();
  for (const Value& each : list) array.push_back(json_of(each));
  return array;
}

template <HasReportFields Report>
Json json_of(const Report& report) {
  Json object;
  for_each_field(report, [&](const char* key, const auto& value) { object[key] = json_of(value); });
  return object;
}

/// Returns some members under their own names.
template <auto... members, class Report>
Json json_of_members(const Report& report) {
  Json object;
  ((object[std::string(detail::name_of_member<members>())] = json_of(report.*members)), ...);
  return object;
}

}  // namespace tanor::report
