#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <tanor/enum_names.hpp>
#include <tanor/report_fields.hpp>

#include "base/member_names.hpp"
#include "report/json_text.hpp"

/// JSON of reports from their tables of fields (`fields_of`), or of some members under their own names.
namespace tanor::report {

/// Returns a number, or null if it is not finite; or a yes or no.
template <class Number>
Json json_of(Number number) requires std::is_arithmetic_v<Number> {
  if constexpr (std::is_floating_point_v<Number>) return std::isfinite(number) ? Json(number) : Json();
  return number;
}
/// Returns the word of a value, or null for one that stands for nothing.
template <class Enum>
Json json_of(Enum value) requires std::is_enum_v<Enum> {
  if constexpr (std::is_same_v<Enum, FrictionMethod>) return value == Enum::Auto ? Json() : Json(name_of(value));
  if constexpr (std::is_same_v<Enum, Uniqueness>) return value == Enum::NotAsked ? Json() : Json(name_of(value));
  return name_of(value);
}
inline Json json_of(std::string_view text) {
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
  return list_of(list, [](const Value& each) { return json_of(each); });
}

template <HasReportFields Report>
Json json_of(const Report& report) {
  Json object;
  fields_of<Report>.for_each([&](auto field) {
    if (field.columns > 0) return;  // arrays of points are written apart
    const std::string_view key = field.key.empty() ? detail::name_of_member<field.member>() : field.key;
    object[std::string(key)] = json_of(std::invoke(field.member, report));
  });
  return object;
}

/// Returns some members under their own names.
template <auto... members, class Report>
Json json_of_members(const Report& report) {
  Json object;
  ((object[std::string(detail::name_of_member<members>())] = json_of(report.*members)), ...);
  return object;
}

/// Returns an object whose members under these keys, or all of them without keys, are null if `is_known` is false.
template <class... Keys>
Json known_if(bool is_known, Json object, Keys... keys) {
  if (is_known) return object;
  ((object[keys] = nullptr), ...);
  for (auto& each : object)
    if (sizeof...(keys) == 0) each = nullptr;
  return object;
}

}  // namespace tanor::report
