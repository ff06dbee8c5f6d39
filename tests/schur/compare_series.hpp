#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "dynamics/multiplier_form.hpp"

/// \file The power series of a motion in lanes is compared order by order with that of the general solver.
namespace tanor::series {
using namespace detail;

constexpr int order = 12;

struct Expanded {
  Workspace work;
  const Model& model{work.model()};
  MultiplierForm form;
  std::vector<std::vector<double>> coefficients;
  std::vector<double> r, v;  // [3n]
  SeriesExtent extent;
  Outcome outcome;

  /// Solves each order so many times more than the accelerations were.
  explicit Expanded(const System& system, int extra_passes = 0, const SeriesDemand& wanted = {}, int threads = 1)
      : work(system, {.threads = threads}, 0.0), form(work, {.threads = threads}) {
    const std::size_t n = form.size();
    coefficients.assign(order + 1, std::vector<double>(n, std::nan("")));
    r.resize(n);
    v.resize(n);
    model.numbering.gather_points(system.positions, r);
    model.numbering.gather_points(system.velocities, v);
    form.prescribe(0.0, r.data(), v.data());
    work.prescribe_all(0.0, r.data(), v.data());
    outcome = form.linearise(0.0, r.data());
    if (outcome.ok()) outcome = form.project_velocities(0.0, r.data(), v.data()).outcome;
    std::vector<double*> pointers;
    for (std::vector<double>& c : coefficients) pointers.push_back(c.data());
    const Kinematics at{0.0, r.data(), v.data()};
    Reactions found;
    if (outcome.ok()) outcome = form.accelerations(at, {Gradients::Keep}, {pointers[2], nullptr, nullptr, &found});
    found.refinements += extra_passes;
    if (outcome.ok()) outcome = form.series(nullptr)->expand(at, pointers[2], found, wanted, pointers, &extent);
  }
};

/// Returns the largest difference of the terms c_k h^k over the largest term, at the h where all are at most |c_1| h,
/// in
/// units of the rounding that the condition of S leaves.
inline double compare(const System& system, int extra_passes = 0) {
  System general = system;
  general.forces.push_back(ConstantForce{"none", {0}, {0.0, 0.0, 0.0}});
  Expanded one(system, extra_passes), other(general);
  EXPECT_TRUE(one.outcome.ok()) << one.outcome.what;
  EXPECT_TRUE(other.outcome.ok()) << other.outcome.what;
  const auto largest = [](const std::vector<double>& c) {
    double result = 0.0;
    for (const double x : c) result = larger(result, std::abs(x));
    return result;
  };
  const double first = largest(other.coefficients[1]);
  double h = HUGE_VAL, worst = 0.0;
  for (std::size_t k = 2; k <= order; ++k)
    h = std::min(h, std::pow(first / largest(other.coefficients[k]), 1.0 / static_cast<double>(k - 1)));
  for (std::size_t k = 1; k <= order; ++k) {
    std::vector<double> difference = one.coefficients[k];
    for (std::size_t i = 0; i < difference.size(); ++i) difference[i] -= other.coefficients[k][i];
    worst = larger(worst, largest(difference) * std::pow(h, static_cast<double>(k - 1)) / first);
  }
  return worst * other.form.linearization().estimate_reciprocal_condition() / std::numeric_limits<double>::epsilon();
}

constexpr double agreement = 100.0;  // an order rests on those before it

}  // namespace tanor::series
