#include "report/error_time.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <numeric>
#include <vector>

#include "report/checkpoint.hpp"
#include "report/field_json.hpp"
#include "report/loglog_plot.hpp"
#include "report/output_file.hpp"
#include "report/shown_parts.hpp"
#include "report/words.hpp"
#include "scene/text_file.hpp"

namespace tanor::report {

namespace {

constexpr int rows_per_method = 4;
constexpr double coarsest_tolerance = 1e-3;
constexpr double short_run = 0.1;  // s; a shorter run is repeated three times

// A reference run begins with a hundredth of the tolerance of the finest row of its own method. That row then tells the
// error of the reference at no cost.
constexpr int first_reference_level = rows_per_method;
constexpr int most_refinements = 4;
constexpr double reference_share = 0.1;     // of the smallest error that it measures
constexpr double finest_tolerance = 1e-13;  // below, rounding decides

/// Returns the methods that may make the reference for another method, the best first: explicit adaptive ones of the
/// highest orders. No method is its own reference.
std::vector<Method> reference_methods(Method method) {
  constexpr std::size_t most_references = 2;
  std::vector<MethodTraits> found;
  for (const MethodTraits& each : methods()) {
    const bool suits = each.method != Method::Auto && !each.has_fixed_steps && !each.is_implicit;
    if (suits && each.method != method) found.push_back(each);
  }
  // An order of 0 grows as the tolerance asks and is the highest one.
  const auto has_higher_order = [](const MethodTraits& a, const MethodTraits& b) {
    return a.order != b.order && (a.order == 0 || (b.order != 0 && a.order > b.order));
  };
  std::stable_sort(found.begin(), found.end(), has_higher_order);
  std::vector<Method> result;
  for (const MethodTraits& each : found)
    if (result.size() < most_references) result.push_back(each.method);
  return result;
}

/// The coarsest step: the step of the scene, else a hundredth of the time.
double coarsest_step(const scene::Scene& scene) {
  return scene.motion.step > 0.0 ? scene.motion.step : (scene.t_end - scene.t_start) / 100.0;
}

/// Diagonal of the box around the points, m, at most 1: absolute tolerances of small scenes are as small as they are.
double small_size(const System& system) {
  const double diagonal = measure_diagonal(system.positions);
  return diagonal > 0.0 ? std::min(1.0, diagonal) : 1.0;
}

/// Level 0 is the coarsest. Each further level has half the step or a hundredth of the tolerance.
MotionOptions options_of(const scene::Scene& scene, Method method, int level) {
  MotionOptions options = scene.motion;
  options.method = method;
  if (has_fixed_steps(method)) {
    options.step = std::ldexp(coarsest_step(scene), -level);
  } else {
    options.step = 0.0;
    options.rtol = coarsest_tolerance * std::pow(0.01, level);
    options.atol = 0.01 * options.rtol * small_size(scene.system);
  }
  return options;
}

/// A run to t_end: its row without errors and order, and the final positions of the points.
struct Run {
  ErrorTimeRow row;
  Outcome outcome;
  std::vector<double> positions;
};

/// Thrown if the caller does not want to wait for the rest.
struct Stopped {};

Run run_once(const scene::Scene& scene, const MotionOptions& options, const std::function<bool()>& goes_on) {
  Simulation simulation(scene.system, options, scene.solver, scene.t_start);
  add_events(scene, &simulation);
  const auto observe = [&](const MotionReport&) { return goes_on(); };
  Run result;
  const auto begin = std::chrono::steady_clock::now();
  result.outcome = simulation.outcome().ok() ? simulation.advance_to(scene.t_end, observe) : simulation.outcome();
  if (!goes_on()) throw Stopped();
  result.row.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const MotionReport& report = simulation.report();
  result.row.method = report.method;
  result.row.step = options.step;
  result.row.tolerance = has_fixed_steps(report.method) ? 0.0 : options.rtol;
  result.row.steps = report.steps;
  result.row.factorizations = report.counters.factorizations;
  result.row.violation = report.violation.position;
  result.row.energy_drift = report.energy.drift_relative();
  result.row.trouble = result.outcome.what;
  result.positions.assign(simulation.positions().begin(), simulation.positions().end());
  return result;
}

/// Repeats short runs three times and takes the middle one of their times.
Run run(const scene::Scene& scene, const MotionOptions& options, const std::function<bool()>& goes_on) {
  Run first = run_once(scene, options, goes_on);
  if (!first.outcome.ok() || first.row.wall_s > short_run) return first;
  std::array times{first.row.wall_s, 0.0, 0.0};
  for (double* again : {&times[1], &times[2]}) *again = run_once(scene, options, goes_on).row.wall_s;
  std::sort(times.begin(), times.end());
  first.row.wall_s = times[1];
  return first;
}

/// Runs of a scene by method and level. Each run is made once, when it is first requested.
class Runs {
 public:
  Runs(const scene::Scene& scene, std::vector<Index> points, const Watcher& watcher)
      : scene_(scene), points_(std::move(points)), watcher_(watcher) {}

  const Run& get(Method method, int level) {
    const auto found = runs_.find({method, level});
    if (found != runs_.end()) return found->second;
    const Run& made = runs_[{method, level}] = run(scene_, options_of(scene_, method, level), watcher_.goes_on);
    watcher_.say(fmt::format("{} with {}: {:.3g} s", name_of(method), describe_setting(made.row), made.row.wall_s));
    return made;
  }

  /// Returns why a method cannot step this scene; empty if it can.
  const std::string& refusal(Method method) {
    const auto [found, is_new] = refusals_.try_emplace(method);
    if (is_new) {
      try {
        get(method, 0);
      } catch (const InputError& error) {
        if (error.where() != "/motion/method") throw;  // the scene itself is wrong
        found->second = error.what();
      }
    }
    return found->second;
  }

  /// Returns the largest distance among the points that are compared.
  double distance(const std::vector<double>& a, const std::vector<double>& b) const {
    double worst = 0.0;
    for (const Index point : points_) {
      const std::size_t i = 3 * static_cast<std::size_t>(point);
      worst = std::max(worst, std::hypot(a[i] - b[i], a[i + 1] - b[i + 1], a[i + 2] - b[i + 2]));
    }
    return worst;
  }

 private:
  const scene::Scene& scene_;
  std::vector<Index> points_;
  const Watcher& watcher_;
  std::map<std::pair<Method, int>, Run> runs_;
  std::map<Method, std::string> refusals_;
};

/// A run that others are compared with, and its distance from its own coarser run, which is infinite if one of them did
/// not reach t_end.
struct ReferenceRun {
  Method method;
  int level;
  const Run* run;
  double error;
  Outcome outcome;  ///< of the run that did not reach t_end
};

ReferenceRun make_reference(Runs* runs, Method method, int level) {
  const Run& finer = runs->get(method, level);
  if (!finer.outcome.ok()) return {method, level, &finer, HUGE_VAL, finer.outcome};
  const Run& coarser = runs->get(method, level - 1);
  if (!coarser.outcome.ok()) return {method, level, &finer, HUGE_VAL, coarser.outcome};
  return {method, level, &finer, runs->distance(finer.positions, coarser.positions), {}};
}

/// Returns the smallest error above 0 that a reference finds among the rows of a method.
double smallest_error(Runs* runs, Method method, const ReferenceRun& reference) {
  double smallest = HUGE_VAL;
  for (int level = 0; level < rows_per_method; ++level) {
    const Run& row = runs->get(method, level);
    const double error = runs->distance(row.positions, reference.run->positions);
    if (row.outcome.ok() && error > 0.0) smallest = std::min(smallest, error);
  }
  return smallest;
}

/// Returns a reference for a method's rows that is fine enough for them, as far as rounding permits.
ReferenceRun refine_reference(const scene::Scene& scene, Runs* runs, Method method, Method made_by) {
  ReferenceRun reference = make_reference(runs, made_by, first_reference_level);
  for (int k = 0; k < most_refinements && reference.run->outcome.ok(); ++k) {
    if (reference.error <= reference_share * smallest_error(runs, method, reference)) break;
    if (options_of(scene, made_by, reference.level + 1).rtol < 0.5 * finest_tolerance) break;
    const ReferenceRun finer = make_reference(runs, made_by, reference.level + 1);
    if (!(finer.error < reference.error)) break;
    const bool rounding_rules = finer.error > 0.5 * reference.error;
    reference = finer;
    if (rounding_rules) break;
  }
  return reference;
}

/// Returns the first possible reference of a method that reaches t_end and knows its own error. Otherwise the outcome
/// says why the last one does not.
ReferenceRun find_reference(const scene::Scene& scene, Runs* runs, Method method) {
  ReferenceRun reference{};
  for (const Method made_by : reference_methods(method)) {
    if (const std::string& refusal = runs->refusal(made_by); !refusal.empty()) {
      reference.outcome = {Status::NoSolution,
                           fmt::format("there is no reference for {}: {}", name_of(method), refusal)};
    } else {
      reference = refine_reference(scene, runs, method, made_by);
      if (reference.outcome.ok()) break;
    }
  }
  return reference;
}

std::vector<Index> list_points(const System& system) {
  std::vector<Index> points(system.masses.size());
  std::iota(points.begin(), points.end(), Index{0});
  return points;
}

/// Adds the rows of a method and its reference to the table.
void add_method(const scene::Scene& scene, Method method, const scene::ReferenceState* given, Runs* runs,
                ErrorTimeTable* table) {
  if (const std::string& refusal = runs->refusal(method); !refusal.empty()) {
    table->left_out.push_back(refusal);
    return;
  }
  const std::vector<double>* truth = given ? &given->positions : nullptr;
  ErrorTimeTable::Reference named{method, given ? given->name : "", {}};
  if (!given) {
    const ReferenceRun reference = find_reference(scene, runs, method);
    if (!reference.outcome.ok()) {
      table->outcome = reference.outcome;
      return;
    }
    truth = &reference.run->positions;
    named.setting = fmt::format("{} with {}", name_of(reference.method), describe_setting(reference.run->row));
    named.error = reference.error;
  }
  table->references.push_back(named);
  double last_error = 0.0;
  for (int level = 0; level < rows_per_method; ++level) {
    const Run& run = runs->get(method, level);
    ErrorTimeRow row = run.row;
    row.error = run.outcome.ok() ? runs->distance(run.positions, *truth) : NAN;
    row.reference_error = named.error.value_or(0.0);
    const bool has_order = has_fixed_steps(method) && last_error > 0.0 && row.error > 0.0;
    if (has_order && std::isfinite(last_error) && std::isfinite(row.error))
      row.order = std::log2(last_error / row.error);
    last_error = row.error;
    table->rows.push_back(row);
  }
}

}  // namespace

std::string describe_setting(const ErrorTimeRow& row) {
  return row.step > 0.0 ? fmt::format("step {:.4g}", row.step) : fmt::format("rtol {:.0e}", row.tolerance);
}

ErrorTimeTable measure_error_time(const scene::Scene& scene, std::span<const Method> methods,
                                  const scene::ReferenceState* given, const Watcher& watcher) {
  ErrorTimeTable table{scene.name,
                       scene.source,
                       scene.t_end,
                       scene.solver.threads,
                       {},
                       {},
                       {},
                       {},
                       make_scene_checksum(make_fingerprint(scene.files, scene.system)),
                       scene.system.units};
  Runs runs(scene, given ? given->points : list_points(scene.system), watcher);
  try {
    for (const Method method : methods) {
      add_method(scene, method, given, &runs, &table);
      if (!table.outcome.ok()) return table;
    }
  } catch (const Stopped&) {
    table.outcome = {Status::NoSolution, "it was stopped; rows are missing"};
    return table;
  }
  if (table.rows.empty()) throw InputError("--methods", table.left_out.empty() ? "none is named" : table.left_out[0]);
  return table;
}

namespace {

constexpr double certain_above = 3.0;  // errors of the reference

/// Describes an error. If it is within three errors of the reference, only a bound is certain.
std::string describe_error(const ErrorTimeRow& row) {
  const bool is_certain = row.error >= certain_above * row.reference_error;
  return is_certain ? in_words(row.error, "{:.2e}") : "<= " + in_words(row.error + row.reference_error, "{:.2e}");
}

/// Lists which run is the reference of which method, and what was left out.
std::vector<std::string> list_remarks(const ErrorTimeTable& table) {
  std::vector<std::string> remarks;
  for (const auto& [method, setting, error] : table.references) {
    remarks.push_back(fmt::format("{} is compared with {}", name_of(method), setting));
    if (error)
      remarks.back() +=
          fmt::format(", whose own error is <= {}", with_unit(in_words(*error, "{:.1e}"), table.units.length));
  }
  for (const std::string& method : table.left_out) remarks.push_back("left out: " + method);
  return remarks;
}

/// Returns the fields of a row of CSV (RFC 4180).
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

/// Returns a number as a field, which is empty if the number is not finite.
std::string field(double number) {
  return std::isfinite(number) ? fmt::to_string(number) : "";
}

/// Returns the members of a row in files.
Json list_members(const ErrorTimeRow& row) {
  return {{"method", name_of(row.method)},
          {"step", row.step},
          {"rtol", row.tolerance},
          {"steps", row.steps},
          {"factorizations", row.factorizations},
          {"wall_s", row.wall_s},
          {"error", row.trouble.empty() ? Json(row.error) : Json()},
          {"reference_error", row.reference_error},
          {"order", row.order},
          {"violation", row.violation},
          {"energy_drift", row.energy_drift}};
}

std::string make_csv(const ErrorTimeTable& table) {
  const Json names = list_members({});
  std::string text;
  for (const auto& [key, value] : names.items()) text += key + ",";
  text += "trouble,scene,scene_checksum,unit_of_length,unit_of_time\n";
  for (const ErrorTimeRow& row : table.rows) {
    for (const Json& value : list_members(row))
      text += (value.is_string() ? value.get<std::string>() : value.is_null() ? "" : field(value.get<double>())) + ",";
    text += fmt::format("{},{},{},{},{}\n", quote_csv(row.trouble), quote_csv(table.scene), table.scene_checksum,
                        quote_csv(table.units.length), quote_csv(table.units.time));
  }
  return text;
}

/// Returns what readers see of a row, in the order of `titles`; a run that did not arrive has its trouble at the end.
std::vector<std::string> list_words(const ErrorTimeRow& row) {
  std::vector<std::string> words{std::string(name_of(row.method)), describe_setting(row), fmt::to_string(row.steps),
                                 fmt::to_string(row.factorizations), fmt::format("{:.3g}", row.wall_s)};
  if (!row.trouble.empty()) {
    words.push_back(row.trouble);
  } else {
    const std::string order = row.order != 0.0 ? in_words(row.order, "{:.2f}") : "";
    words.insert(words.end(),
                 {describe_error(row), order, in_words(row.violation, "{:.1e}"), in_words(row.energy_drift, "{:.1e}")});
  }
  return words;
}

/// Returns "error, m", or "error" without letters.
std::string name_with_unit(const std::string& name, const Units& units) {
  return units.length.empty() ? name : name + ", " + units.length;
}

std::string make_markdown(const ErrorTimeTable& table) {
  std::string text = fmt::format("# {}: error against run time\n\nPoints: {}; t = {}; threads: {}.\n\n", table.scene,
                                 table.source, with_unit(fmt::format("{:g}", table.t_end), table.units.time),
                                 table.threads > 0 ? fmt::to_string(table.threads) : "all");
  text += fmt::format(
      "| method | setting | steps | factorizations | wall, s | {} | order | violation | energy drift |\n"
      "|---|---|--:|--:|--:|--:|--:|--:|--:|\n",
      name_with_unit("error", table.units));
  for (const ErrorTimeRow& row : table.rows)
    text += fmt::format("| {} |{}\n", fmt::join(list_words(row), " | "), row.trouble.empty() ? "" : " | | |");
  text += "\n";
  for (const std::string& remark : list_remarks(table)) text += "- " + remark + "\n";
  return text;
}

/// Plots a line for each method, in the order of its settings.
LogLogPlot make_plot(const ErrorTimeTable& table) {
  const std::string error = name_with_unit("largest error at the end", table.units);
  LogLogPlot plot{table.scene + ": error against run time", "wall time, s", error, {}};
  for (const ErrorTimeRow& row : table.rows) {
    const std::string name(name_of(row.method));
    if (plot.series.empty() || plot.series.back().name != name) plot.series.push_back({name, {}});
    if (row.trouble.empty() && row.error > 0.0) plot.series.back().points.push_back({row.wall_s, row.error});
  }
  return plot;
}

}  // namespace

std::string format_error_time(const ErrorTimeTable& table) {
  std::array<std::size_t, 9> widths{8, 15, 8, 9, 10, 13, 7, 11, 14};
  for (const ErrorTimeRow& row : table.rows) widths[0] = std::max(widths[0], name_of(row.method).size());
  const auto set = [&](const std::vector<std::string>& words) {
    std::string line = fmt::format("  {:{}}", words[0], widths[0]);
    for (std::size_t k = 1; k < words.size(); ++k)
      line += words.size() == widths.size() || k < 5 ? fmt::format("{:>{}}", words[k], widths[k]) : "  " + words[k];
    return line + "\n";
  };
  std::string text =
      "error against run time, t = " + with_unit(fmt::format("{:g}", table.t_end), table.units.time) + "\n";
  text += set({"method", "setting", "steps", "factors", "wall, s", name_with_unit("error", table.units), "order",
               "violation", "energy drift"});
  for (const ErrorTimeRow& row : table.rows) text += set(list_words(row));
  for (const std::string& remark : list_remarks(table)) text += "  " + remark + "\n";
  return text;
}

Json describe_error_time(const ErrorTimeTable& table) {
  Json rows = Json::array();
  for (const ErrorTimeRow& row : table.rows) {
    Json& members = rows.emplace_back(list_members(row));
    for (const char* key : {"step", "rtol", "order"})
      if (members[key] == 0.0) members[key] = nullptr;
    members["trouble"] = json_or_null(row.trouble);
  }
  return {{"scene", table.scene},
          {"units", json_of(table.units)},
          {"t_end", table.t_end},
          {"rows", rows},
          {"remarks", list_remarks(table)}};
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
    const std::string of_other = checksum == scene_checksum ? "" : fmt::format(" ({})", scene);
    rows.push_back({{"method", field("method") + of_other},
                    {"wall_s", json_or_null(scene::parse_number(field("wall_s")))},
                    {"error", json_or_null(scene::parse_number(field("error") +
                                                               field("error_m")))}});  // the latter in tables of 0.2
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
