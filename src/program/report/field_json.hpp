#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <tanor/report_fields.hpp>

#include "report/json_text.hpp"

/// JSON of reports from their tables of fields (`FieldsOf`).
namespace tanor::report {

inline Json json_of(double number) {
  return std::isfinite(number) ? Json(number) : Json();
}
inline Json json_of(const std::string& text) {
  return json_or_null(text);
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

}  // namespace tanor::report
