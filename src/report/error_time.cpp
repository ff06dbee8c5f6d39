#include "report/error_time.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "report/loglog_plot.hpp"
#include "report/output_file.hpp"

namespace tanor::report {

namespace {

constexpr int rows_per_method = 4;
constexpr double coarsest_tolerance = 1e-2;

// A judge begins half a step or a hundredth of a tolerance behind the finest row of its own method, which then tells
// its own error at no cost.
constexpr int first_judge_level = rows_per_method;
constexpr int most_refinements = 4;
constexpr double judge_share = 0.1;         // of the smallest error that it judges
constexpr double finest_tolerance = 1e-13;  // below, rounding decides
constexpr double certain_above = 3.0;       // errors of the judge

bool has_fixed_steps(Method method) {
  return method != Method::Dopri5 && method != Method::Dop853 && method != Method::Radau5;
}

/// dop853 judges the others, dopri5 judges dop853.
Method judge_of(Method method) {
  return method == Method::Dop853 ? Method::Dopri5 : Method::Dop853;
}

/// The coarsest step: the scene's own, else a hundredth of the time.
double coarsest_step(const scene::Scene& scene) {
  return scene.motion.step > 0.0 ? scene.motion.step : scene.t_end / 100.0;
}

/// Level 0 is the coarsest; each next one has half the step or a hundredth of the tolerance.
MotionOptions options_of(const scene::Scene& scene, Method method, int level) {
  MotionOptions options = scene.motion;
  options.method = method;
  if (has_fixed_steps(method)) {
    options.step = std::ldexp(coarsest_step(scene), -level);
  } else {
    options.step = 0.0;
    options.rtol = coarsest_tolerance * std::pow(0.01, level);
    options.atol = 0.01 * options.rtol;
  }
  return options;
}

double largest_distance(std::span<const double> a, std::span<const double> b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); i += 3) {
    worst = std::max(worst, std::hypot(a[i] - b[i], a[i + 1] - b[i + 1], a[i + 2] - b[i + 2]));
  }
  return worst;
}

/// A run to t_end: its row (without errors and order) and where the points end.
struct Run {
  ErrorTimeRow row;
  Outcome outcome;
  std::vector<double> positions;
};

Run run(const scene::Scene& scene, const MotionOptions& options) {
  Simulation simulation(scene.system, options, scene.solver);
  Run result;
  const auto begin = std::chrono::steady_clock::now();
  result.outcome = simulation.outcome().ok() ? simulation.advance(scene.t_end) : simulation.outcome();
  result.row.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const MotionReport& report = simulation.report();
  result.row.method = report.method;
  result.row.step = options.step;
  result.row.tolerance = has_fixed_steps(report.method) ? 0.0 : options.rtol;
  result.row.steps = report.steps;
  result.row.violation = report.position_violation;
  result.row.energy_drift = report.energy.drift_relative();
  result.row.trouble = result.outcome.what;
  result.positions.assign(simulation.positions().begin(), simulation.positions().end());
  return result;
}

std::string setting_of(const ErrorTimeRow& row) {
  return row.step > 0.0 ? fmt::format("step {:.4g}", row.step) : fmt::format("rtol {:.0e}", row.tolerance);
}

/// Runs of a scene by method and level, each done once, when it is asked for.
class Runs {
 public:
  Runs(const scene::Scene& scene, const std::function<void(const std::string&)>& say) : scene_(scene), say_(say) {}

  const Run& get(Method method, int level) {
    const auto [found, is_new] = runs_.try_emplace({method, level});
    if (is_new) {
      found->second = run(scene_, options_of(scene_, method, level));
      const ErrorTimeRow& row = found->second.row;
      say_(fmt::format("{} with {}: {:.3g} s", method_name(method), setting_of(row), row.wall_s));
    }
    return found->second;
  }

 private:
  const scene::Scene& scene_;
  const std::function<void(const std::string&)>& say_;
  std::map<std::pair<Method, int>, Run> runs_;
};

/// A run that judges others, and its distance from its own coarser run; infinite where one of them did not arrive.
struct Judge {
  Method method;
  int level;
  const Run* run;
  double error;
};

Judge call_judge(Runs* runs, Method method, int level) {
  const Run& finer = runs->get(method, level);
  if (!finer.outcome.ok()) return {method, level, &finer, HUGE_VAL};
  const Run& coarser = runs->get(method, level - 1);
  return {method, level, &finer,
          coarser.outcome.ok() ? largest_distance(finer.positions, coarser.positions) : HUGE_VAL};
}

/// The smallest error above 0 that a judge finds among the rows of a method.
double smallest_error(Runs* runs, Method method, const Judge& judge) {
  double smallest = HUGE_VAL;
  for (int level = 0; level < rows_per_method; ++level) {
    const Run& judged = runs->get(method, level);
    const double error = largest_distance(judged.positions, judge.run->positions);
    if (judged.outcome.ok() && error > 0.0) smallest = std::min(smallest, error);
  }
  return smallest;
}

/// The judge of a method's rows, fine enough for them where rounding permits.
Judge find_judge(const scene::Scene& scene, Runs* runs, Method method) {
  Judge judge = call_judge(runs, judge_of(method), first_judge_level);
  for (int k = 0; k < most_refinements && judge.run->outcome.ok(); ++k) {
    if (judge.error <= judge_share * smallest_error(runs, method, judge)) break;
    const MotionOptions next = options_of(scene, judge.method, judge.level + 1);
    if (!has_fixed_steps(judge.method) && next.rtol < 0.5 * finest_tolerance) break;
    const Judge finer = call_judge(runs, judge.method, judge.level + 1);
    if (!(finer.error < judge.error)) break;
    const bool rounding_rules = finer.error > 0.5 * judge.error;
    judge = finer;
    if (rounding_rules) break;
  }
  return judge;
}

/// Within three errors of the judge all that is certain is a bound.
std::string describe_error(const ErrorTimeRow& row) {
  const bool is_certain = row.error >= certain_above * row.judge_error;
  return is_certain ? fmt::format("{:.2e}", row.error) : fmt::format("<= {:.2e}", row.error + row.judge_error);
}

}  // namespace

ErrorTimeTable measure_error_time(const scene::Scene& scene, const std::vector<Method>& methods,
                                  const std::function<void(const std::string&)>& say) {
  ErrorTimeTable table{scene.name, scene.source, scene.t_end, scene.solver.threads, {}, {}, {}};
  Runs runs(scene, say);
  for (const Method method : methods) {
    const Judge judge = find_judge(scene, &runs, method);
    if (!judge.run->outcome.ok()) {
      table.outcome = judge.run->outcome;
      return table;
    }
    table.judges.push_back({method, judge.method, setting_of(judge.run->row), judge.error});
    double last_error = 0.0;
    for (int level = 0; level < rows_per_method; ++level) {
      const Run& judged = runs.get(method, level);
      ErrorTimeRow row = judged.row;
      row.error = largest_distance(judged.positions, judge.run->positions);
      row.judge_error = judge.error;
      if (has_fixed_steps(method) && last_error > 0.0 && row.error > 0.0) row.order = std::log2(last_error / row.error);
      last_error = row.trouble.empty() ? row.error : 0.0;
      table.rows.push_back(row);
    }
  }
  return table;
}

std::string format_error_time(const ErrorTimeTable& table) {
  std::string text = fmt::format("error against run time, t = {:g} s\n", table.t_end);
  text += fmt::format("  {:8}{:>16}{:>8}{:>11}{:>14}{:>8}{:>12}{:>14}\n", "method", "setting", "steps", "wall, s",
                      "error, m", "order", "violation", "energy drift");
  for (const ErrorTimeRow& row : table.rows) {
    text += fmt::format("  {:8}{:>16}{:>8}{:>11.3g}", method_name(row.method), setting_of(row), row.steps, row.wall_s);
    if (!row.trouble.empty()) {
      text += "  " + row.trouble + "\n";
      continue;
    }
    text += fmt::format("{:>14}{:>8}{:>12.1e}{:>14.1e}\n", describe_error(row),
                        row.order != 0.0 ? fmt::format("{:.2f}", row.order) : "", row.violation, row.energy_drift);
  }
  for (const auto& [judged, method, setting, error] : table.judges) {
    text += fmt::format("  {} is judged by {} with {}, judge's own error <= {:.1e} m\n", method_name(judged),
                        method_name(method), setting, error);
  }
  return text;
}

void write_error_time(const std::filesystem::path& directory, const ErrorTimeTable& table) {
  make_folder(directory);
  OutputFile csv(directory / "error_time.csv");
  csv.write(
      std::string_view("method,step_s,rtol,steps,wall_s,error_m,judge_error_m,order,violation,energy_drift,trouble\n"));
  std::vector<PlotSeries> series;
  for (const ErrorTimeRow& row : table.rows) {
    csv.write(std::string_view(fmt::format("{},{},{},{},{},{},{},{},{},{},\"{}\"\n", method_name(row.method), row.step,
                                           row.tolerance, row.steps, row.wall_s, row.error, row.judge_error, row.order,
                                           row.violation, row.energy_drift, row.trouble)));
    const std::string name(method_name(row.method));
    if (series.empty() || series.back().name != name) series.push_back({name, {}});
    if (row.trouble.empty() && row.error > 0.0) series.back().points.push_back({row.wall_s, row.error});
  }
  csv.close();
  replace_file(directory / "error_time.svg", [&](OutputFile* file) {
    file->write(std::string_view(make_loglog_plot(
        {table.scene + ": error against run time", "wall time, s", "largest error at the end, m", series})));
  });
}

}  // namespace tanor::report
