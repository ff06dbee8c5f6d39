// Measures error against run time of the method `taylor` beside `dop853`, one thread, in turn in one process:
//   series [NAME …]   scenes of bench_scenes.cpp whose name begins so; default: one of each kind
// Each scene moves until its fastest point would have gone three times the length of its shortest rod. The program
// prints, for some tolerances, seconds (medians), the largest error of a position over the largest distance that a
// point has moved, against a run of `taylor` at a tolerance of 1e-13, and how many times as fast taylor is at dop853's
// error (between its two nearest tolerances, on a logarithmic scale).

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "bench_scenes.hpp"
#include "timing.hpp"

namespace {

using namespace tanor;

constexpr double lengths_to_go = 3.0;
constexpr int rounds = 3;

struct Point {
  double seconds, error;
  std::size_t steps;
};

double largest_speed(const System& system) {
  double result = 0.0;
  for (std::size_t i = 0; i < system.velocities.size(); i += 3)
    result = std::max(result, std::hypot(system.velocities[i], system.velocities[i + 1], system.velocities[i + 2]));
  return result;
}

double shortest_rod(const System& system) {
  double result = 1e300;
  for (const Constraint& constraint : system.constraints) {
    const Rods* const rods = std::get_if<Rods>(&constraint);
    if (rods == nullptr) continue;
    for (const auto& [i, j] : rods->pairs) {
      const double* const a = &system.positions[3 * static_cast<std::size_t>(i)];
      const double* const b = &system.positions[3 * static_cast<std::size_t>(j)];
      result = std::min(result, std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]));
    }
  }
  return result;
}

/// A scene that is run again and again from its start.
class Runs {
 public:
  Runs(const System& system, double t_end) : system_(system), t_end_(t_end) {
    Simulation reference(system_, options(Method::Taylor, 1e-13), {.threads = 1});
    start_.assign(reference.positions().begin(), reference.positions().end());
    run(&reference);
    end_.assign(reference.positions().begin(), reference.positions().end());
    for (std::size_t k = 0; k < end_.size(); ++k) moved_ = std::max(moved_, std::abs(end_[k] - start_[k]));
  }

  /// Measures both methods in turn.
  std::array<Point, 2> measure(double rtol) {
    std::array<Simulation, 2> simulations{Simulation(system_, options(Method::Taylor, rtol), {.threads = 1}),
                                          Simulation(system_, options(Method::Dop853, rtol), {.threads = 1})};
    std::array<std::vector<std::byte>, 2> starts{simulations[0].save(), simulations[1].save()};
    std::array<std::vector<double>, 2> times;
    for (int round = 0; round < rounds; ++round) {
      for (std::size_t m = 0; m < 2; ++m) {
        simulations[m].restore(starts[m]);
        times[m].push_back(seconds_of([&] { run(&simulations[m]); }));
      }
    }
    std::array<Point, 2> result;
    for (std::size_t m = 0; m < 2; ++m) {
      double error = 0.0;
      for (std::size_t k = 0; k < end_.size(); ++k)
        error = std::max(error, std::abs(simulations[m].positions()[k] - end_[k]));
      result[m] = {median(times[m]), error / moved_, simulations[m].report().steps};
    }
    return result;
  }

 private:
  static MotionOptions options(Method method, double rtol) {
    MotionOptions result;
    result.method = method;
    result.start = StartMode::Project;
    result.rtol = rtol;
    result.atol = 0.01 * rtol;
    return result;
  }
  void run(Simulation* simulation) const {
    const Outcome outcome = simulation->advance_to(t_end_);
    if (!outcome.ok()) throw std::runtime_error(outcome.what);
  }

  const System& system_;
  double t_end_, moved_ = 0.0;
  std::vector<double> start_, end_;
};

/// Returns the time at which a method reaches the error, between its two nearest tolerances.
std::optional<double> seconds_at(double error, const std::vector<Point>& points) {
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const Point &a = points[k], &b = points[k + 1];
    if (!(a.error >= error && error >= b.error)) continue;
    const double part = a.error > b.error ? std::log(a.error / error) / std::log(a.error / b.error) : 0.0;
    return a.seconds * std::pow(b.seconds / a.seconds, part);
  }
  return std::nullopt;
}

void measure(const BenchScene& scene) {
  const System system = scene.make();
  Runs runs(system, lengths_to_go * shortest_rod(system) / largest_speed(system));
  std::vector<Point> taylor, dop853;
  constexpr double tolerances[]{1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10};
  for (const double rtol : tolerances) {
    const std::array<Point, 2> both = runs.measure(rtol);
    taylor.push_back(both[0]);
    dop853.push_back(both[1]);
  }
  for (std::size_t k = 0; k < taylor.size(); ++k) {
    const Point &a = taylor[k], &b = dop853[k];
    const std::optional<double> same = seconds_at(b.error, taylor);
    fmt::print("| {} | {:.0e} | {:.2f} | {} | {:.1e} | {:.2f} | {} | {:.1e} | {} |\n", scene.name, tolerances[k],
               1e3 * a.seconds, a.steps, a.error, 1e3 * b.seconds, b.steps, b.error,
               same ? fmt::format("{:.2f}", b.seconds / *same) : "");
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) try {
  std::vector<std::string> wanted(argv + 1, argv + argc);
  if (wanted.empty())
    wanted = {"melt",        "clusters 1e3", "rings 1e4", "triangles", "tetrahedra", "rings with tails",
              "dendrimer 9", "ring 1e3",     "mixed"};
  fmt::print(
      "| scene | rtol | taylor, ms | steps | error | dop853, ms | steps | error | times as fast at that error |\n"
      "|---|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  for (const std::string& name : wanted) {
    bool is_known = false;
    for (const BenchScene& scene : bench_scenes()) {
      if (!scene.name.starts_with(name)) continue;
      is_known = true;
      measure(scene);
    }
    if (!is_known) throw std::runtime_error("no scene begins with '" + name + "'");
  }
} catch (const std::exception& error) {
  fmt::print(stderr, "series: {}\n", error.what());
  return 1;
}
