#include "report/observables_table.hpp"

namespace tanor::report {

namespace {

std::string name_with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : name + " [" + unit + "]";
}

std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string make_observables_head(std::span<const Observed> observables, const Units& units) {
  std::string head = name_with_unit("t", units.time);
  for (const Observed& each : observables)
    for (const std::string& name : column_names(each)) head += "," + cell(name_with_unit(name, each.unit));
  return head + "\n";
}

}  // namespace

ObservablesTable::ObservablesTable(const std::filesystem::path& path, std::span<const Observed> observables,
                                   const Units& units, std::uint64_t mark)
    : TextTrajectory(path, make_observables_head(observables, units), mark) {}

void ObservablesTable::print(const Frame& frame, fmt::memory_buffer* text) const {
  auto out = fmt::appender(*text);
  fmt::format_to(out, "{}", frame.time);
  for (const Observed& each : frame.observables)
    for (const double number : each.values) fmt::format_to(out, ",{}", number);
  fmt::format_to(out, "\n");
}

}  // namespace tanor::report
