#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/parallel.hpp"
#include "long_tests.hpp"
#include "scenes.hpp"

/// \file Random scenes that steps must not jump, and how the runs of each are counted.
namespace tanor::passing {
using namespace detail;

using scenes::add_point;

class Random {
 public:
  explicit Random(unsigned seed) : generator_(seed) {}
  double uniform(double a, double b) { return a + (b - a) * std::generate_canonical<double, 53>(generator_); }
  double log_uniform(double a, double b) { return std::exp(uniform(std::log(a), std::log(b))); }
  int below(int count) { return static_cast<int>(uniform(0.0, count)); }
  Vector3 direction() {
    for (;;) {
      const Vector3 d{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
      const double length = std::hypot(d[0], d[1], d[2]);
      if (length > 0.1 && length < 1.0) return {d[0] / length, d[1] / length, d[2] / length};
    }
  }

 private:
  std::mt19937_64 generator_;
};

inline std::string number(double x) {
  std::array<char, 40> buffer;
  std::snprintf(buffer.data(), buffer.size(), "(%.17g)", x);
  return buffer.data();
}

/// The result of one run, with the worst error over what the tolerance allows, in positions and velocities.
struct Verdict {
  std::string told{};  // an outcome that is not ok, or a warning
  double error = 0.0;
  std::size_t steps = 0;
};

inline constexpr double rtol = 1e-8, atol = 1e-10;

inline double over_tolerance(std::span<const double> found, std::span<const double> right) {
  double worst = 0.0;
  for (std::size_t i = 0; i < found.size(); i += 3) {
    const double size = std::hypot(right[i], right[i + 1], right[i + 2]);
    for (std::size_t k = i; k < i + 3; ++k) worst = larger(worst, std::abs(found[k] - right[k]) / (atol + rtol * size));
  }
  return worst;
}

struct State {
  std::vector<double> r, v;
};

inline State state_of(const Simulation& simulation) {
  return {{simulation.positions().begin(), simulation.positions().end()},
          {simulation.velocities().begin(), simulation.velocities().end()}};
}

/// Runs with `part` of rtol and atol and returns the error in units of the full tolerances.
inline Verdict compare(const System& system, Method method, double t_end, const State& right, double part = 1.0) {
  Simulation simulation(system, {.method = method, .rtol = part * rtol, .atol = part * atol}, {.threads = 1});
  const Outcome outcome = simulation.advance_to(t_end);
  return {outcome.what + simulation.report().accuracy_warning,
          std::max(over_tolerance(simulation.positions(), right.r), over_tolerance(simulation.velocities(), right.v)),
          simulation.report().steps};
}

/// Counts the runs that were wrong and silent, and those that said so.
struct Tally {
  int runs = 0, wrong = 0, told = 0;

  void add(const Verdict& verdict, double allowed, const std::string& what) {
    ++runs;
    if (!verdict.told.empty()) {
      ++told;
      std::printf("told: %s: %s\n", what.c_str(), verdict.told.c_str());
    } else if (!(verdict.error <= allowed)) {
      ++wrong;
      ADD_FAILURE() << what << ": off by " << verdict.error << " tolerances, " << allowed << " are allowed";
    }
  }
  void expect_good() const {
    EXPECT_EQ(wrong, 0) << "of " << runs;
    EXPECT_LE(told, runs / 100) << "of " << runs;
  }
};

}  // namespace tanor::passing
