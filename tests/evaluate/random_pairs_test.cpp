/// The tests compare pair forces of random systems with a plain double loop over all pairs, in extended precision.

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "evaluate/evaluated_pairs.hpp"

namespace tanor {
namespace {

/// The force on a point by the plain formula, and the sum of the rounding errors that its pairs may have.
struct Plain {
  std::array<long double, 3> force{};
  long double potential = 0.0, largest_error = 0.0;
};

/// Evaluates the pairs in a double loop, with images by the standard library's remainder.
std::vector<Plain> evaluate_plainly(const System& system, const std::vector<double>& r) {
  using Real = long double;
  const auto& pairs = std::get<PairForces>(system.forces[0]);
  const auto n = static_cast<Index>(system.num_points());
  std::vector<char> takes_part(n, pairs.points.empty()), is_support(n, false);
  for (const Index i : pairs.points) takes_part[i] = true;
  for (const Support& support : system.supports)
    for (const Index i : support.points) is_support[i] = true;
  const auto are_joined = [&](Index i, Index j) {
    for (const Constraint& constraint : system.constraints)
      for (const auto& [a, b] : std::get<Rods>(constraint).pairs)
        if ((a == i && b == j) || (a == j && b == i)) return true;
    return false;
  };
  const Real cutoff =
      pairs.law == PairLaw::Wca ? powl(2, 1 / 6.0L) * pairs.sigma : pairs.cutoff.value_or(2.5 * pairs.sigma);
  const auto lennard_jones = [&](Real distance) {
    const Real s6 = powl(pairs.sigma / distance, 6);
    return 4 * pairs.epsilon * (s6 * s6 - s6);
  };
  std::vector<Plain> result(n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      if (i == j || !takes_part[i] || !takes_part[j]) continue;
      if (pairs.exclude_rods && are_joined(i, j)) continue;
      std::array<Real, 3> d;
      Real largest = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        d[k] = static_cast<Real>(r[3 * i + k]) - r[3 * j + k];
        largest = std::max({largest, std::abs(static_cast<Real>(r[3 * i + k])), std::abs(d[k])});
        if (pairs.box[k] > 0.0) d[k] = remainderl(d[k], pairs.box[k]);
      }
      const Real distance = sqrtl(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      Real pull = 0.0, potential = 0.0, size = 0.0;
      if (pairs.law == PairLaw::Log) {
        pull = size = pairs.strength / distance;
        potential = -pairs.strength * logl(distance);
      } else if (distance < cutoff) {
        const Real s6 = powl(pairs.sigma / distance, 6);
        pull = 24 * pairs.epsilon / distance * (2 * s6 * s6 - s6);
        size = 24 * pairs.epsilon / distance * (2 * s6 * s6 + s6);
        potential = lennard_jones(distance) - lennard_jones(cutoff);
      }
      for (std::size_t k = 0; k < 3; ++k) result[i].force[k] += pull * d[k] / distance;
      if (!is_support[i] || !is_support[j]) result[i].potential += potential / 2;
      // The bound is 20 roundings and those of the distance, which its 14th power enlarges.
      result[i].largest_error += 1.1e-16L * std::abs(size) * (20 + 14 * 4 * largest / distance);
    }
  }
  return result;
}

/// Makes points all over a box and its images, with rods, supports and a law.
System make_random_pairs(std::size_t num_points, std::mt19937& random) {
  const auto uniform = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const auto any_point = [&] { return static_cast<Index>(random() % num_points); };
  System system;
  PairForces pairs;
  pairs.law = std::array{PairLaw::Wca, PairLaw::Lj, PairLaw::Log}[random() % 3];
  pairs.epsilon = uniform(0.1, 3.0);
  pairs.sigma = uniform(0.5, 1.5);
  pairs.strength = uniform(-2.0, 2.0);
  pairs.exclude_rods = random() % 2;
  if (random() % 2) pairs.cutoff = uniform(0.8, 3.0) * pairs.sigma;
  const double extent = uniform(2.0, 12.0);
  for (double& edge : pairs.box) {
    if (pairs.law != PairLaw::Log && random() % 3) edge = uniform(5.0, 12.0) * pairs.sigma;
    if (pairs.cutoff && edge > 0.0) edge = std::max(edge, 2.0 * *pairs.cutoff);
  }
  for (std::size_t i = 0; i < num_points; ++i) {
    for (int k = 0; k < 3; ++k) system.positions.push_back(uniform(-extent, extent));
    system.masses.push_back(1.0);
    if (random() % 5 == 0) system.supports.push_back({"", {static_cast<Index>(i)}, {}});
    if (random() % 4) pairs.points.push_back(static_cast<Index>(num_points - 1 - i));
  }
  if (random() % 2) pairs.points.clear();
  Rods rods;
  for (std::size_t k = 0; k < num_points / 2; ++k) {
    const Index i = any_point(), j = any_point();
    if (i != j) rods.pairs.push_back({i, j});
  }
  system.constraints = {rods};
  system.forces = {pairs};
  return system;
}

RC_GTEST_PROP(PairField, AgreesWithADoubleLoopWhileThePointsMove, ()) {
  const auto num_points = *rc::gen::inRange<std::size_t>(2, 120).as("points");
  std::mt19937 random(*rc::gen::noShrink(rc::gen::arbitrary<std::uint32_t>()).as("seed"));
  const System system = make_random_pairs(num_points, random);
  PairEvaluator field(system);
  std::vector<double> r = system.positions;
  for (const double move : {0.0, 0.01, 0.05, 0.05, 0.1, 1.0, 0.02}) {
    for (double& x : r) x += std::uniform_real_distribution<double>(-move, move)(random);

    const PairResult result = field(r);

    const std::vector<Plain> expected = evaluate_plainly(system, r);
    long double potential = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < num_points; ++i) {
      potential += expected[i].potential;
      scale += expected[i].largest_error;
      for (std::size_t k = 0; k < 3; ++k) {
        RC_ASSERT(std::abs(result.f[3 * i + k] - expected[i].force[k]) <= expected[i].largest_error);
      }
    }
    RC_ASSERT(std::abs(result.potential - potential) <= 20.0 * scale + 1e-12);
  }
}

RC_GTEST_PROP(PairField, TakesAsMuchMomentumAsItGives, ()) {
  const auto num_points = *rc::gen::inRange<std::size_t>(2, 120).as("points");
  std::mt19937 random(*rc::gen::noShrink(rc::gen::arbitrary<std::uint32_t>()).as("seed"));
  const System system = make_random_pairs(num_points, random);

  const PairResult result = PairEvaluator(system)(system.positions);

  long double scale = 0.0;
  std::array<long double, 3> sum{};
  for (const Plain& plain : evaluate_plainly(system, system.positions)) scale += plain.largest_error;
  for (std::size_t c = 0; c < result.f.size(); ++c) sum[c % 3] += result.f[c];
  for (const long double component : sum) RC_ASSERT(std::abs(component) <= scale);
}

}  // namespace
}  // namespace tanor
