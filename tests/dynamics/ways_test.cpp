/// Every way to S lambda = b agrees with the general one.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include <tanor/tanor.hpp>

#include "reference.hpp"

namespace tanor {
namespace {

struct Answer {
  SolveReport report;
  std::vector<double> w, lambda, eta;
};

Answer solve(const System& system, SolverOptions options, double t = 0.0) {
  Dynamics dynamics(system, options);
  Answer answer{{},
                std::vector<double>(system.positions.size()),
                std::vector<double>(dynamics.num_equations()),
                std::vector<double>(system.positions.size())};
  answer.report = dynamics.solve(t, system.positions, system.velocities, answer.w, answer.lambda, answer.eta);
  return answer;
}

double largest(const std::vector<double>& x) {
  double result = 0.0;
  for (const double each : x) result = std::max(result, std::abs(each));
  return result;
}

double relative_difference(const std::vector<double>& x, const std::vector<double>& y) {
  double result = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) result = std::max(result, std::abs(x[i] - y[i]));
  return result / std::max(largest(y), 1e-300);
}

enum class Ends { Free, First, Last, Both };

/// Rods of random lengths and directions in a row, numbered at random, with random masses.
System make_chain(std::size_t num_points, Ends ends, double mass_range, std::mt19937* random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto number = [&] { return unit(*random); };
  std::vector<Index> place(num_points);
  std::iota(place.begin(), place.end(), 0);
  std::shuffle(place.begin(), place.end(), *random);
  System system;
  for (std::vector<double>* array : {&system.positions, &system.velocities}) array->resize(3 * num_points);
  system.masses.resize(num_points);
  Rods rods;
  rods.name = "rods";
  double at[3] = {0.0, 0.0, 0.0};
  for (std::size_t k = 0; k < num_points; ++k) {
    const auto i = static_cast<std::size_t>(place[k]);
    for (std::size_t c = 0; c < 3; ++c) {
      system.positions[3 * i + c] = at[c];
      system.velocities[3 * i + c] = number();
      at[c] += number() + (c == 0 ? 0.3 : 0.0);
    }
    system.masses[i] = std::pow(mass_range, 0.5 * number());
    if (k == 0) continue;
    const bool is_turned = number() > 0.0;
    rods.pairs.push_back({place[is_turned ? k : k - 1], place[is_turned ? k - 1 : k]});
  }
  std::shuffle(rods.pairs.begin(), rods.pairs.end(), *random);
  std::vector<Index> held;
  if (ends == Ends::First || ends == Ends::Both) held.push_back(place.front());
  if (ends == Ends::Last || ends == Ends::Both) held.push_back(place.back());
  for (const Index point : held) {
    system.supports.push_back({"", {point}, VectorFunction(0.0, 0.0, 0.0)});
    std::fill_n(system.velocities.begin() + 3 * point, 3, 0.0);
  }
  system.constraints = {rods};
  system.forces = {Gravity{"", {0.1, 0.0, -9.81}}};
  return system;
}

TEST(Ways, PathsAgreeWithTheGeneralWay) {
  std::mt19937 random(6);
  for (const Ends ends : {Ends::Free, Ends::First, Ends::Last, Ends::Both}) {
    for (const std::size_t num_points : {2, 3, 4, 5, 17, 64, 65, 66, 129, 130, 131, 257, 1000}) {
      const System system = make_chain(num_points, ends, 1e2, &random);
      if (num_points == 2 && ends == Ends::Both) continue;

      const Answer general = solve(system, {.way = Way::General}), paths = solve(system, {.way = Way::Paths});

      ASSERT_TRUE(paths.report.outcome.ok()) << paths.report.outcome.what;
      EXPECT_LE(relative_difference(paths.w, general.w), 1e-12) << num_points;
      EXPECT_LE(relative_difference(paths.lambda, general.lambda), 1e-12) << num_points;
      EXPECT_LE(relative_difference(paths.eta, general.eta), 1e-12) << num_points;
    }
  }
}

}  // namespace
}  // namespace tanor
