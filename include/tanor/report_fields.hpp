#pragma once

/// \file
/// The fields of reports as one table each, from which JSON, tables, Python and archives are made.

#include <cstddef>
#include <tuple>

namespace tanor {

/// A field of a report: its key in files and its address.
template <class Report, class Value>
struct ReportField {
  const char* key;
  Value Report::*value;

  constexpr ReportField(const char* k, Value Report::*v) : key(k), value(v) {}
};

/// Specialised for each report: `fields`, a std::tuple of ReportField.
template <class Report>
struct FieldsOf;

template <class Report>
concept HasReportFields = requires {
  FieldsOf<Report>::fields;
};

/// Calls visit(key, value) for each field of a report.
template <HasReportFields Report, class Visit>
void for_each_field(const Report& report, const Visit& visit) {
  std::apply([&](const auto&... field) { (visit(field.key, report.*field.value), ...); }, FieldsOf<Report>::fields);
}

}  // namespace tanor
