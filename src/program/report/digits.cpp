#include "report/digits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tanor::report {

double DigitsRow::won() const {
  constexpr double most = 16.0;  // digits of a double
  if (!outcome.ok() || !(error < 1.0)) return 0.0;
  return error > 0.0 ? std::min(most, -std::log10(error)) : most;
}

std::string format_digits(const std::vector<DigitsRow>& rows) {
  std::string text = fmt::format("{:<47}{:<31}{:<18}{:>7}{:>10}{:>10}\n", "problem", "known from", "method", "digits",
                                 "promised", "ms");
  double seconds = 0.0;
  for (const DigitsRow& row : rows) {
    text += fmt::format("{:<47}{:<31}{:<18}{:>7.1f}{:>10.1f}{:>10.1f}{}\n", row.name, row.known, row.method, row.won(),
                        row.promised, 1e3 * row.wall_s, row.keeps_promise() ? "" : "  MISSED");
    seconds += row.wall_s;
  }
  const auto kept = std::count_if(rows.begin(), rows.end(), [](const DigitsRow& row) { return row.keeps_promise(); });
  return text + fmt::format("{} of {} keep their promise, {:.2f} s\n", kept, rows.size(), seconds);
}

Json describe_digits(const std::vector<DigitsRow>& rows) {
  return list_of(rows, [](const DigitsRow& row) {
    return Json{{"problem", row.name},      {"known_from", row.known},
                {"method", row.method},     {"digits", row.won()},
                {"promised", row.promised}, {"keeps_promise", row.keeps_promise()},
                {"wall_s", row.wall_s},     {"trouble", json_or_null(row.outcome.what)}};
  });
}

Outcome verify_digits(const std::vector<DigitsRow>& rows) {
  std::string missed;
  for (const DigitsRow& row : rows) {
    if (row.keeps_promise()) continue;
    const std::string why =
        row.outcome.ok() ? fmt::format("{:.1f} of {:.1f} digits", row.won(), row.promised) : row.outcome.what;
    missed += fmt::format("{}{} ({}): {}", missed.empty() ? "" : "; ", row.name, row.method, why);
  }
  return missed.empty() ? Outcome{} : Outcome{Status::NotConverged, missed};
}

}  // namespace tanor::report
