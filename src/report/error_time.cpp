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
constexpr double coarsest_tolerance = 1e-4;

bool has_fixed_steps(Method method) {
  return method != Method::Dopri5;
}

/// dopri5 judges the others, rk4 judges dopri5.
Method judge_of(Method method) {
  return method == Method::Dopri5 ? Method::Rk4 : Method::Dopri5;
}

/// The coarsest step: the scene's own, else a hundredth of the time.
double coarsest_step(const scene::Scene& scene) {
  return scene.motion.step > 0.0 ? scene.motion.step : scene.t_end / 100.0;
}

MotionOptions options_of(const scene::Scene& scene, Method method, double fineness) {
  MotionOptions options = scene.motion;
  options.method = method;
  options.step = has_fixed_steps(method) ? coarsest_step(scene) / fineness : 0.0;
  return options;
}

double largest_distance(std::span<const double> a, std::span<const double> b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); i += 3) {
    worst = std::max(worst, std::hypot(a[i] - b[i], a[i + 1] - b[i + 1], a[i + 2] - b[i + 2]));
  }
  return worst;
}

/// A run to t_end: its row (without error and order) and where the points end.
struct Run {
  ErrorTimeRow row;
  std::vector<double> positions;
};

Run run(const scene::Scene& scene, const MotionOptions& options) {
  Simulation simulation(scene.system, options, scene.solver);
  Run result;
  const auto begin = std::chrono::steady_clock::now();
  const Outcome outcome = simulation.outcome().ok() ? simulation.advance(scene.t_end) : simulation.outcome();
  result.row.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const MotionReport& report = simulation.report();
  result.row.method = report.method;
  result.row.step = options.step;
  result.row.tolerance = has_fixed_steps(report.method) ? 0.0 : options.rtol;
  result.row.steps = report.steps;
  result.row.violation = report.position_violation;
  result.row.energy_drift = report.energy.drift_relative();
  result.row.trouble = outcome.what;
  result.positions.assign(simulation.positions().begin(), simulation.positions().end());
  return result;
}

/// The judge's own run, far finer than any row it judges.
struct Judge {
  MotionOptions options;
  std::string setting;
};

Judge make_judge(const scene::Scene& scene, Method method) {
  Judge judge{options_of(scene, method, 32.0), {}};
  if (has_fixed_steps(method)) {
    judge.setting = fmt::format("step {:.4g}", judge.options.step);
  } else {
    judge.options.rtol = 1e-12;
    judge.options.atol = 1e-14;
    judge.setting = fmt::format("rtol {:.0e}", judge.options.rtol);
  }
  return judge;
}

std::string setting_of(const ErrorTimeRow& row) {
  return row.step > 0.0 ? fmt::format("step {:.4g}", row.step) : fmt::format("rtol {:.0e}", row.tolerance);
}

}  // namespace

ErrorTimeTable measure_error_time(const scene::Scene& scene, const std::vector<Method>& methods,
                                  const std::function<void(const std::string&)>& say) {
  ErrorTimeTable table{scene.name, scene.source, scene.t_end, scene.solver.threads, {}, {}};
  std::map<Method, std::vector<double>> references;
  for (const Method method : methods) {
    const Method judging = judge_of(method);
    const Judge judge = make_judge(scene, judging);
    table.references.push_back({method, judging, judge.setting});
    if (!references.contains(judging)) {
      say(fmt::format("reference: {} with {}", method_name(judging), judge.setting));
      Run reference = run(scene, judge.options);
      if (!reference.row.trouble.empty()) throw std::runtime_error("the reference failed: " + reference.row.trouble);
      references[judging] = std::move(reference.positions);
    }
    double fineness = 1.0, tolerance = coarsest_tolerance, last_error = 0.0;
    for (int k = 0; k < rows_per_method; ++k, fineness *= 2.0, tolerance *= 1e-2) {
      MotionOptions options = options_of(scene, method, fineness);
      if (!has_fixed_steps(method)) {
        options.rtol = tolerance;
        options.atol = 1e-2 * tolerance;
      }
      Run result = run(scene, options);
      ErrorTimeRow& row = result.row;
      row.error = largest_distance(result.positions, references[judging]);
      if (has_fixed_steps(method) && last_error > 0.0 && row.error > 0.0) row.order = std::log2(last_error / row.error);
      last_error = row.trouble.empty() ? row.error : 0.0;
      say(fmt::format("{} with {}: {:.3g} s", method_name(method), setting_of(row), row.wall_s));
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
    text += fmt::format("{:>14.2e}{:>8}{:>12.1e}{:>14.1e}\n", row.error,
                        row.order != 0.0 ? fmt::format("{:.2f}", row.order) : "", row.violation, row.energy_drift);
  }
  for (const auto& [judged, method, setting] : table.references) {
    text += fmt::format("  {} is judged by {} with {}\n", method_name(judged), method_name(method), setting);
  }
  return text;
}

void write_error_time(const std::filesystem::path& directory, const ErrorTimeTable& table) {
  make_folder(directory);
  OutputFile csv(directory / "error_time.csv");
  csv.write(std::string_view("method,step_s,rtol,steps,wall_s,error_m,order,violation,energy_drift,trouble\n"));
  std::vector<PlotSeries> series;
  for (const ErrorTimeRow& row : table.rows) {
    csv.write(std::string_view(fmt::format("{},{},{},{},{},{},{},{},{},\"{}\"\n", method_name(row.method), row.step,
                                           row.tolerance, row.steps, row.wall_s, row.error, row.order, row.violation,
                                           row.energy_drift, row.trouble)));
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
