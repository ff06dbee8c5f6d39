// One evaluation of the accelerations on each way (SolverOptions::way), beside the Eigen baseline, in turn in one
// process:
//   ways [--threads N] [NAME …]      scenes whose name begins so; default: all of them
// Prints nanoseconds a rod (medians) and the ratios baseline/ours and general way/ours on one thread; with N > 1, by
// how much N threads are faster than one (best of each: others' work on the machine stops threads that wait for each
// other).

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dynamics/forms.hpp"
#include "eigen_baseline.hpp"
#include "scene/scene.hpp"

namespace {

using namespace tanor;
using Clock = std::chrono::steady_clock;

struct BenchScene {
  std::string name, generate;
  double bar;  ///< wanted ratio baseline/ours on one thread
};

const std::vector<BenchScene> scenes = {
    {"chain 1e3", R"({"kind": "melt", "chains": 1, "count": 1000})", 8.0},
    {"chain 1e4", R"({"kind": "melt", "chains": 1, "count": 10000})", 8.0},
    {"chain 1e5", R"({"kind": "melt", "chains": 1, "count": 100000})", 8.0},
    {"chain 1e6", R"({"kind": "melt", "chains": 1, "count": 1000000})", 12.0},
};

double seconds_of(const std::function<void()>& work) {
  const auto begin = Clock::now();
  work();
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

std::vector<std::array<int, 2>> rods_of(const System& system) {
  std::vector<std::array<int, 2>> result;
  for (const Constraint& constraint : system.constraints) {
    const auto& rods = std::get<Rods>(constraint);
    result.insert(result.end(), rods.pairs.begin(), rods.pairs.end());
  }
  return result;
}

System generated(const std::string& generate) {
  System system = scene::parse_scene(R"({"tanor_scene": 1, "generate": )" + generate + "}", "bench.json").system;
  if (!system.velocities.empty()) return system;
  // Some motion, the same each time: waves across the flat directions.
  system.velocities.resize(system.positions.size());
  for (std::size_t i = 0; i < system.positions.size(); i += 3) {
    system.velocities[i + 2] = 0.1 * std::sin(7.0 * system.positions[i] + 3.0 * system.positions[i + 1]);
  }
  return system;
}

/// A system at a consistent start in the inner order; `evaluate` finds its accelerations.
struct Ours {
  Forms forms;
  std::vector<double> r, v, w;

  Ours(const System& system, const SolverOptions& options) : forms(system, options) {
    for (std::vector<double>* array : {&r, &v, &w}) array->resize(system.positions.size());
    forms.model.numbering.gather_points(forms.model.system.positions, r);
    forms.model.numbering.gather_points(forms.model.system.velocities, v);
    forms.model.prescribe_all(0.0, r.data(), v.data());
    check(forms.start(0.0, r.data(), v.data(), StartMode::Project).outcome);
  }
  void evaluate() { check(forms.normal->accelerations(0.0, r.data(), v.data(), Gradients::Evaluate, w.data())); }
  std::vector<double> in_users_order(const std::vector<double>& inner) const {
    std::vector<double> result(inner.size());
    forms.model.numbering.scatter_points(inner, result);
    return result;
  }
  static void check(const Outcome& outcome) {
    if (!outcome.ok()) throw std::runtime_error(outcome.what);
  }
};

void measure(const BenchScene& scene, int threads) {
  constexpr int rounds = 11;
  const System system = generated(scene.generate);
  const std::vector<std::array<int, 2>> rods = rods_of(system);
  const double num_rods = static_cast<double>(rods.size());
  Ours ours(system, {.threads = 1}), general(system, {.way = Way::General, .threads = 1});
  std::unique_ptr<Ours> together;
  if (threads > 1) together = std::make_unique<Ours>(system, SolverOptions{.threads = threads});
  EigenBaseline baseline(rods, system.masses, Eigen::Vector3d::Zero());
  const std::vector<double> r = ours.in_users_order(ours.r), v = ours.in_users_order(ours.v);

  const int repeats = std::max(1, static_cast<int>(2e5 / num_rods));
  std::vector<double> times[4];
  for (int round = 0; round < rounds; ++round) {
    times[0].push_back(seconds_of([&] { (void)baseline.evaluate(r.data(), v.data()); }));
    const auto repeat = [&](Ours& each) {
      each.evaluate();  // wakes the caches after another one's work
      return seconds_of([&] {
               for (int k = 0; k < repeats; ++k) each.evaluate();
             }) /
             repeats;
    };
    times[1].push_back(repeat(ours));
    times[2].push_back(repeat(general));
    if (together) times[3].push_back(repeat(*together));
  }
  const std::vector<double> w = ours.in_users_order(ours.w);
  double difference = 0.0, largest = 1e-300;
  const Eigen::VectorXd& reference = baseline.evaluate(r.data(), v.data());
  for (std::size_t i = 0; i < w.size(); ++i) {
    difference = std::max(difference, std::abs(w[i] - reference[static_cast<Eigen::Index>(i)]));
    largest = std::max(largest, std::abs(w[i]));
  }
  // The baseline does not refine: a chain of N rods costs it cond S ~ N^2 digits.
  const double tolerance = std::max(1e-9, 1e-15 * num_rods * num_rods);
  if (!(difference <= tolerance * largest)) throw std::runtime_error(scene.name + ": the two solutions differ");
  const double unit = 1e9 / num_rods, base = median(times[0]), mine = median(times[1]), theirs = median(times[2]);
  const auto best = [](const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); };
  const std::string speedup = together ? fmt::format("{:12.2f}", best(times[1]) / best(times[3])) : "";
  fmt::print("{:20}{:>14}{:10.1f}{:10.1f}{:10.1f}{:10.1f}{:8.0f}{:10.1f}{}\n", scene.name, ours.forms.plan.way,
             unit * base, unit * theirs, unit * mine, base / mine, scene.bar, theirs / mine, speedup);
}

}  // namespace

int main(int argc, char** argv) try {
  int threads = 1;
  std::vector<std::string> wanted;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    if (word == "--threads" && k + 1 < argc) {
      threads = std::stoi(argv[++k]);
    } else {
      wanted.push_back(word);
    }
  }
  fmt::print("{:20}{:>14}{:>10}{:>10}{:>10}{:>10}{:>8}{:>10}{}\n", "ns a rod", "way", "Eigen", "general", "ours",
             "ratio", "bar", "/general", threads > 1 ? fmt::format("{:>10}x", threads) : "");
  for (const BenchScene& scene : scenes) {
    const auto begins = [&](const std::string& word) { return scene.name.starts_with(word); };
    if (wanted.empty() || std::any_of(wanted.begin(), wanted.end(), begins)) measure(scene, threads);
  }
} catch (const std::exception& error) {
  fmt::print(stderr, "ways: {}\n", error.what());
  return 1;
}
