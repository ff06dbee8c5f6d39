#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include <tanor/enum_names.hpp>

#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "report/digits.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

/// Returns known_problems.json: problems whose answers are known in closed form or to published digits. Each has a
/// scene, what its observables show at the end, or at the start where it does not move, and tries, which are motions of
/// the scene with the digits that they promise: about half a digit less than found, for other compilers' rounding.
std::string_view known_problems();

namespace {

using report::Json;

/// Returns the scene of a row of uniform bars, 1 m and 1 kg each, which cranks turn from upright.
///
///   B0 --o-- B1 --o-- B2 …
///   o        o        o
///   A0       A1       A2 …
Json make_four_bars(int loops) {
  const int cranks = loops + 1;
  Json positions, velocities, masses, bars, middles, constraints;
  const auto add_point = [&](double x, double y, double speed, double mass) {
    positions.push_back({x, y, 0.0});
    velocities.push_back({speed, 0.0, 0.0});
    masses.push_back(mass);
    return static_cast<int>(masses.size()) - 1;
  };
  const auto add_bar = [&](int from, int to, double x, double y, double speed) {
    bars.push_back({from, to});
    middles.push_back({from, to, add_point(x, y, speed, 2.0 / 3.0)});
  };
  for (int k = 0; k < cranks; ++k) add_point(k, 0.0, 0.0, 1.0);
  for (int k = 0; k < cranks; ++k) add_point(k, 1.0, 1.0, (k == 0 || k == loops ? 2.0 : 3.0) / 6.0);
  for (int k = 0; k < cranks; ++k) {
    add_bar(k, cranks + k, k, 0.5, 0.5);
    if (k > 0) add_bar(cranks + k - 1, cranks + k, k - 0.5, 1.0, 1.0);
  }
  constraints.push_back({{"kind", "rod"}, {"pairs", bars}, {"length", 1.0}});
  constraints.push_back(
      {{"kind", "plane"}, {"points", {{"first", cranks}, {"count", cranks}}}, {"normal", {0.0, 0.0, 1.0}}});
  for (std::size_t axis = 0; axis < 3; ++axis) {  // middle - (from + to)/2
    Json of_end(3, 0.0), of_middle(3, 0.0);
    of_end[axis] = -0.5;
    of_middle[axis] = 1.0;
    constraints.push_back({{"kind", "linear"}, {"tuples", middles}, {"coefficients", {of_end, of_end, of_middle}}});
  }
  return {{"tanor_scene", 1},
          {"points", {{"positions", positions}, {"velocities", velocities}, {"masses", masses}}},
          {"supports", {{{"points", {{"first", 0}, {"count", cranks}}}}}},
          {"constraints", constraints},
          {"forces", {{{"kind", "gravity"}, {"acceleration", {0.0, -9.81, 0.0}}}}}};
}

scene::Scene read(const Json& scene) {
  return scene::parse_scene(scene.dump(), "selftest");
}

Simulation start(const scene::Scene& scene) {
  return Simulation(scene.system, scene.motion, scene.solver);
}

/// Returns the largest difference over the largest known number. The observables have the order of `known`.
double compare(Simulation& simulation, const Json& known) {
  double difference = 0.0, size = 0.0;
  std::size_t number = 0;
  for (const auto& [text, wanted] : known.items()) {
    std::vector<double> found{simulation.report().last_event};
    if (text != "last event") found = simulation.observe()[number++].values;
    const std::vector<double> numbers =
        wanted.is_array() ? wanted.get<std::vector<double>>() : std::vector{wanted.get<double>()};
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      // max(x, NaN) would be x.
      if (!std::isfinite(found.at(k))) return HUGE_VAL;
      difference = std::max(difference, std::abs(found[k] - numbers[k]));
      size = std::max(size, std::abs(numbers[k]));
    }
  }
  return difference / size;
}

/// Solves a problem in one of its ways, and the variants that must be refused.
void solve(const Json& problem, const Json& scene, report::DigitsRow* row) {
  for (const Json& each : problem.value("refused", Json::array())) {
    Json other = scene;
    other.update(each["with"]);
    const auto status = value_of<Status>(each["status"].get<std::string>());
    if (start(read(other)).outcome().status == status) continue;
    row->error = HUGE_VAL;
    row->outcome = {*status, each["otherwise"]};
    return;
  }
  const scene::Scene given = read(scene);
  Simulation simulation = start(given);
  for (const auto& [text, wanted] : problem["known"].items())
    if (text != "last event") simulation.add_observable({.text = text});
  row->outcome = simulation.outcome();
  if (row->outcome.ok() && given.has_end()) row->outcome = simulation.advance_to(given.t_end);
  if (row->outcome.ok()) row->error = compare(simulation, problem["known"]);
}

std::vector<report::DigitsRow> solve_all() {
  std::vector<report::DigitsRow> rows;
  for (const Json& problem : Json::parse(known_problems())) {
    for (const Json& each : problem["tries"]) {
      Json scene = problem["scene"];
      if (scene.contains("four_bars")) scene.merge_patch(make_four_bars(scene["four_bars"]));
      scene.erase("four_bars");
      scene["solver"] = {{"threads", 1}};
      if (each.contains("motion")) scene["motion"].update(each["motion"]);
      const std::string method = each.contains("motion") ? each["motion"]["method"] : Json("one instant");
      report::DigitsRow& row =
          rows.emplace_back(report::DigitsRow{problem["problem"], problem["known_from"], method, each["promised"]});
      const auto begin = std::chrono::steady_clock::now();
      solve(problem, scene, &row);
      row.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
  }
  return rows;
}

}  // namespace

ExitCode execute_selftest(const Options& options) {
  const std::vector<report::DigitsRow> rows = solve_all();
  options.json ? print_json(report::describe_digits(rows)) : print_lines(report::format_digits(rows));
  const Outcome outcome = report::verify_digits(rows);
  if (outcome.ok()) return ExitCode::Done;
  print_message("selftest: " + outcome.what, Tone::Error);
  return ExitCode::NoAnswer;
}

}  // namespace tanor::cli
