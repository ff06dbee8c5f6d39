// Measures the cost of a step beside the Eigen baseline, in turn in one process, one thread:
//   step_cost [--json FILE] [--generated] [scene.json …]
// Scenes of tanor's own generator, chains, clusters, nets, a lattice, are measured where they are asked for or no file
// is named. The program prints nanoseconds a rod (medians) and the ratio baseline/ours of one evaluation of the
// accelerations and of one step of RATTLE; then those of one step of Runge and Kutta's fourth order.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <tanor/tanor.hpp>

#include "bench_scenes.hpp"
#include "eigen_baseline.hpp"
#include "scene/scene.hpp"
#include "timing.hpp"

namespace {

std::vector<std::array<int, 2>> rods_of(const tanor::System& system) {
  std::vector<std::array<int, 2>> result;
  for (const tanor::Constraint& constraint : system.constraints) {
    const auto& rods = std::get<tanor::Rods>(constraint);
    result.insert(result.end(), rods.pairs.begin(), rods.pairs.end());
  }
  return result;
}

struct Row {
  std::string name;
  double num_rods, baseline, evaluation, rattle, rk4;  // ns a rod
};

/// Measures a system. The `step`, s, is such that rods turn by about a hundredth (crumpled chains), or as the stiff
/// straight lines of a flat net allow.
Row measure(const std::string& name, tanor::System system, double step) {
  using namespace tanor;
  constexpr int rounds = 15;
  const std::vector<std::array<int, 2>> rods = rods_of(system);
  const double num_rods = static_cast<double>(rods.size());

  SolverOptions one_thread;
  one_thread.threads = 1;
  const auto expect = [&](const Outcome& outcome) {
    if (!outcome.ok()) throw std::runtime_error(name + ": " + outcome.what);
  };
  const auto start = [&](Method method) {
    MotionOptions motion;
    motion.method = method;
    motion.start = StartMode::Project;
    motion.step = step;
    auto simulation = std::make_unique<Simulation>(system, motion, one_thread);
    expect(simulation->outcome());
    return simulation;
  };
  const auto rattle = start(Method::Rattle), rk4 = start(Method::Rk4);
  system.positions.assign(rattle->positions().begin(), rattle->positions().end());
  system.velocities.assign(rattle->velocities().begin(), rattle->velocities().end());
  EigenBaseline baseline(rods, system.masses, {});
  Dynamics dynamics(system, one_thread);
  std::vector<double> w(system.positions.size());

  const int repeats = std::max(1, static_cast<int>(2e5 / num_rods));
  std::vector<double> times[4];
  for (int round = 0; round < rounds; ++round) {
    times[0].push_back(seconds_of([&] {
      for (int k = 0; k < repeats; ++k) baseline.evaluate(system.positions.data(), system.velocities.data());
    }));
    times[1].push_back(seconds_of([&] {
      for (int k = 0; k < repeats; ++k) {
        (void)dynamics.solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                             {.accelerations = w});
      }
    }));
    times[2].push_back(seconds_of([&] { expect(rattle->advance_to(rattle->time() + repeats * step)); }));
    times[3].push_back(seconds_of([&] { expect(rk4->advance_to(rk4->time() + repeats * step)); }));
  }
  double difference = 0.0, largest = 1e-300;
  const double* const reference = baseline.evaluate(system.positions.data(), system.velocities.data());
  for (std::size_t i = 0; i < w.size(); ++i) {
    difference = std::max(difference, std::abs(w[i] - reference[i]));
    largest = std::max(largest, std::abs(w[i]));
  }
  // The baseline does not refine: a chain of N rods costs it cond S ~ N^2 digits.
  const double tolerance = std::max(1e-9, 1e-15 * num_rods * num_rods);
  if (!(difference <= tolerance * largest)) throw std::runtime_error(name + ": the two solutions differ");
  const double unit = 1e9 / (repeats * num_rods);
  return {name,
          num_rods,
          unit * median(times[0]),
          unit * median(times[1]),
          unit * median(times[2]),
          unit * median(times[3])};
}

}  // namespace

int main(int argc, char** argv) try {
  std::vector<Row> rows;
  std::string file;
  bool is_generated = false;
  for (int k = 1; k < argc; ++k) {
    if (std::string(argv[k]) == "--json" && k + 1 < argc) {
      file = argv[++k];
      continue;
    }
    if (std::string(argv[k]) == "--generated") {
      is_generated = true;
      continue;
    }
    const auto scene = tanor::scene::load_scene(argv[k]);
    rows.push_back(measure(scene.name, scene.system, 0.005));
  }
  if (rows.empty() || is_generated) {
    rows.push_back(measure("chain 1e3", make_generated(R"({"kind": "melt", "chains": 1, "count": 1000})"), 2e-4));
    rows.push_back(measure("chain 1e4", make_generated(R"({"kind": "melt", "chains": 1, "count": 10000})"), 2e-4));
    rows.push_back(measure("chain 1e6", make_generated(R"({"kind": "melt", "chains": 1, "count": 1000000})"), 2e-4));
    rows.push_back(
        measure("clusters 1e4 x 10", make_generated(R"({"kind": "melt", "chains": 10000, "count": 10})"), 2e-4));
    rows.push_back(measure("net 30", make_generated(R"({"kind": "net", "columns": 30, "rows": 30})"), 1e-5));
    rows.push_back(measure("net 100", make_generated(R"({"kind": "net", "columns": 100, "rows": 100})"), 1e-5));
    rows.push_back(measure("lattice 10", make_generated(R"({"kind": "lattice", "size": [10, 10, 10]})"), 1e-5));
  }
  fmt::print("{:24}{:>16}{:>16}{:>16}{:>10}{:>10}{:>16}\n", "ns a rod", "Eigen baseline", "Dynamics::solve",
             "RATTLE step", "ratio", "ratio", "RK4 step");
  for (const Row& row : rows) {
    fmt::print("{:24}{:16.0f}{:16.0f}{:16.0f}{:10.1f}{:10.1f}{:16.0f}\n", row.name, row.baseline, row.evaluation,
               row.rattle, row.baseline / row.evaluation, row.baseline / row.rattle, row.rk4);
  }
  std::vector<std::string> lines;
  for (const Row& row : rows) {
    lines.push_back(fmt::format(
        R"({{"scene": "{}", "rods": {:.0f}, "eigen_ns": {:.2f}, "ours_ns": {:.2f}, "rattle_ns": {:.2f}, "rk4_ns": {:.2f}}})",
        row.name, row.num_rods, row.baseline, row.evaluation, row.rattle, row.rk4));
  }
  if (!file.empty()) std::ofstream(file) << fmt::format("[\n{}\n]\n", fmt::join(lines, ",\n"));
} catch (const std::exception& error) {
  fmt::print(stderr, "step_cost: {}\n", error.what());
  return 1;
}
