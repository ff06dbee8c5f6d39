#include "report/error_time_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <vector>

#include "report/loglog_plot.hpp"
#include "report/output_file.hpp"
#include "report/picture.hpp"
#include "report/words.hpp"

namespace tanor::report {

namespace {

constexpr double certain_above = 3.0;  // errors of the reference

/// Describes an error. If it is within three errors of the reference, only a bound is certain.
std::string describe_error(const ErrorTimeRow& row) {
  const bool is_certain = row.error >= certain_above * row.reference_error;
  return is_certain ? in_words(row.error, "{:.2e}") : "<= " + in_words(row.error + row.reference_error, "{:.2e}");
}

std::string describe_order(const ErrorTimeRow& row) {
  return row.order != 0.0 ? in_words(row.order, "{:.2f}") : "";
}

/// Lists which run is the reference of which method, and what was left out.
std::vector<std::string> list_remarks(const ErrorTimeTable& table) {
  std::vector<std::string> remarks;
  for (const auto& [method, setting, error] : table.references) {
    remarks.push_back(fmt::format("{} is compared with {}", name_of(method), setting));
    if (error) remarks.back() += fmt::format(", whose own error is <= {} m", in_words(*error, "{:.1e}"));
  }
  for (const std::string& method : table.left_out) remarks.push_back("left out: " + method);
  return remarks;
}

/// Returns a field of text as RFC 4180 specifies it.
std::string quote(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c == '\n' ? ' ' : c);
  return quoted + "\"";
}

/// Returns the fields of a row in that format.
std::vector<std::string> split_row(std::string_view row) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (row[k] == '"' && is_quoted && k + 1 < row.size() && row[k + 1] == '"')
      fields.back() += row[k++];
    else if (row[k] == '"')
      is_quoted = !is_quoted;
    else if (row[k] == ',' && !is_quoted)
      fields.emplace_back();
    else
      fields.back() += row[k];
  }
  return fields;
}

/// Returns the number of a field, or null if there is none.
Json read_field(const std::string& text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() && !text.empty() ? Json(number) : Json();
}

/// Returns a number as a field, which is empty if the number is not finite.
std::string field(double number) {
  return std::isfinite(number) ? fmt::to_string(number) : "";
}

std::string make_csv(const ErrorTimeTable& table) {
  std::string text =
      "method,step_s,rtol,steps,factorizations,wall_s,error_m,reference_error_m,order,violation,energy_drift,trouble,"
      "scene,scene_checksum\n";
  for (const ErrorTimeRow& row : table.rows) {
    const std::string error = row.trouble.empty() ? field(row.error) : "";
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", name_of(row.method), row.step, row.tolerance,
                        row.steps, row.factorizations, row.wall_s, error, field(row.reference_error), field(row.order),
                        field(row.violation), field(row.energy_drift), quote(row.trouble), quote(table.scene),
                        table.scene_checksum);
  }
  return text;
}

std::string make_markdown(const ErrorTimeTable& table) {
  std::string text =
      fmt::format("# {}: error against run time\n\nPoints: {}; t = {:g} s; threads: {}.\n\n", table.scene, table.source,
                  table.t_end, table.threads > 0 ? fmt::to_string(table.threads) : "all");
  text +=
      "| method | setting | steps | factorizations | wall, s | error, m | order | violation | energy drift |\n"
      "|---|---|--:|--:|--:|--:|--:|--:|--:|\n";
  for (const ErrorTimeRow& row : table.rows) {
    text += fmt::format("| {} | {} | {} | {} | {:.3g} |", name_of(row.method), describe_setting(row), row.steps,
                        row.factorizations, row.wall_s);
    text += row.trouble.empty() ? fmt::format(" {} | {} | {} | {} |\n", describe_error(row), describe_order(row),
                                              in_words(row.violation, "{:.1e}"), in_words(row.energy_drift, "{:.1e}"))
                                : fmt::format(" {} | | | |\n", row.trouble);
  }
  text += "\n";
  for (const std::string& remark : list_remarks(table)) text += "- " + remark + "\n";
  return text;
}

/// Plots a line for each method, in the order of its settings.
LogLogPlot make_plot(const ErrorTimeTable& table) {
  LogLogPlot plot{table.scene + ": error against run time", "wall time, s", "largest error at the end, m", {}};
  for (const ErrorTimeRow& row : table.rows) {
    const std::string name(name_of(row.method));
    if (plot.series.empty() || plot.series.back().name != name) plot.series.push_back({name, {}});
    if (row.trouble.empty() && row.error > 0.0) plot.series.back().points.push_back({row.wall_s, row.error});
  }
  return plot;
}

}  // namespace

std::string format_error_time(const ErrorTimeTable& table) {
  std::size_t width = 8;
  for (const ErrorTimeRow& row : table.rows) width = std::max(width, name_of(row.method).size());
  std::string text = fmt::format("error against run time, t = {:g} s\n", table.t_end);
  text += fmt::format("  {:{}}{:>15}{:>8}{:>9}{:>10}{:>13}{:>7}{:>11}{:>14}\n", "method", width, "setting", "steps",
                      "factors", "wall, s", "error, m", "order", "violation", "energy drift");
  for (const ErrorTimeRow& row : table.rows) {
    text += fmt::format("  {:{}}{:>15}{:>8}{:>9}{:>10.3g}", name_of(row.method), width, describe_setting(row),
                        row.steps, row.factorizations, row.wall_s);
    text += row.trouble.empty() ? fmt::format("{:>13}{:>7}{:>11}{:>14}\n", describe_error(row), describe_order(row),
                                              in_words(row.violation, "{:.1e}"), in_words(row.energy_drift, "{:.1e}"))
                                : "  " + row.trouble + "\n";
  }
  for (const std::string& remark : list_remarks(table)) text += "  " + remark + "\n";
  return text;
}

Json describe_error_time(const ErrorTimeTable& table) {
  const auto if_any = [](double number) { return number != 0.0 ? Json(number) : Json(); };
  Json rows = Json::array();
  for (const ErrorTimeRow& row : table.rows) {
    rows.push_back({{"method", name_of(row.method)},
                    {"step_s", if_any(row.step)},
                    {"rtol", if_any(row.tolerance)},
                    {"steps", row.steps},
                    {"factorizations", row.factorizations},
                    {"wall_s", row.wall_s},
                    {"error_m", row.trouble.empty() ? Json(row.error) : Json()},
                    {"reference_error_m", row.reference_error},
                    {"order", if_any(row.order)},
                    {"violation", row.violation},
                    {"energy_drift", row.energy_drift},
                    {"trouble", json_or_null(row.trouble)}});
  }
  return {{"scene", table.scene}, {"t_end", table.t_end}, {"rows", rows}, {"remarks", list_remarks(table)}};
}

Json read_error_time(const std::filesystem::path& directory, const std::string& scene_checksum) {
  std::ifstream file(directory / "error_time.csv");
  std::string line;
  if (!std::getline(file, line)) return Json::array();
  const std::vector<std::string> head = split_row(line);
  Json rows = Json::array();
  while (std::getline(file, line)) {
    const std::vector<std::string> fields = split_row(line);
    if (fields.size() != head.size()) return Json::array();
    const auto field = [&](std::string_view name) -> std::string {
      const auto column = std::ranges::find(head, name);
      return column == head.end() ? "" : fields[static_cast<std::size_t>(column - head.begin())];
    };
    const std::string scene = field("scene"), checksum = field("scene_checksum");
    if (checksum.empty()) return Json::array();
    rows.push_back(
        {{"method", checksum == scene_checksum ? field("method") : fmt::format("{} ({})", field("method"), scene)},
         {"wall_s", read_field(field("wall_s"))},
         {"error_m", read_field(field("error_m"))}});
  }
  return rows;
}

std::string write_error_time(const std::filesystem::path& directory, const ErrorTimeTable& table) {
  make_folder(directory);
  const auto write = [&](const char* name, const std::string& text) {
    replace_file(directory / name, [&](OutputFile* file) { file->write(std::string_view(text)); });
  };
  write("error_time.csv", make_csv(table));
  write("error_time.md", make_markdown(table));
  write("error_time.svg", make_loglog_plot(make_plot(table)));
  if (convert_to_png(directory / "error_time.svg", directory / "error_time.png")) return "";
  remove_file(directory / "error_time.png");  // of another run
  return "no error_time.png: rsvg-convert (Debian: librsvg2-bin) is not here or failed";
}

}  // namespace tanor::report
