/// \file One linear solver in one configuration, beside the families of constraints, and what its projections must do.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "dynamics/multiplier_form.hpp"
#include "schur/answers.hpp"
#include "schur/composite_solver.hpp"

namespace tanor {
using namespace detail;

struct SolverAtPlace {
  Workspace work;
  const Model& model{work.model()};
  CompositeSolver solver;
  std::vector<double> r, v, here, there;

  SolverAtPlace(const System& system, LinearSolver kind, int threads = 1, double t = 0.3)
      : work(system, {.threads = threads}, t),
        solver(make_composite_solver(
            {work.constraints, model.gather, model.incidences, model.numbering, model.inverse_mass, {}},
            {.linear_solver = kind, .threads = threads})),
        r(3 * model.num_points()),
        v(r.size()),
        here(model.num_rows()),
        there(model.num_rows()) {
    model.numbering.gather_points(system.positions, r);
    model.numbering.gather_points(system.velocities, v);
    work.prescribe_all(t, r.data(), v.data());
  }
};

/// Brings points from elsewhere.
class CopiedPoints final : public PointSource {
 public:
  CopiedPoints(const std::vector<double>& from, std::vector<double>* to) : from_(from), to_(*to) {}
  void bring(std::size_t first, std::size_t count) const override {
    std::copy_n(from_.begin() + static_cast<std::ptrdiff_t>(3 * first), 3 * count,
                to_.begin() + static_cast<std::ptrdiff_t>(3 * first));
  }

 private:
  const std::vector<double>& from_;
  std::vector<double>& to_;
};

/// Expects that projections move points by M^-1 K times the sums that they return, and that nothing is violated at
/// their
/// end. The bits are the same for any number of threads. Lengths are those of the system's own positions, at t = 0.3.
inline void expect_projections_along_gradients(const System& system, LinearSolver kind) {
  std::vector<std::vector<double>> found;
  for (const int threads : {1, 3}) {
    SCOPED_TRACE(testing::Message() << threads << " threads");
    SolverAtPlace at(system, kind, threads);
    const Model& model = at.model;
    const Constraints& constraints = at.work.constraints;
    const std::size_t num_moving = 3 * model.num_moving();
    std::vector<double> blocks(3 * constraints.num_blocks()), sum(model.num_rows());
    ASSERT_GT(at.solver.linearise(model.parallel, at.r.data(), nullptr, blocks.data()).reciprocal_condition, 0.0);
    const auto project = [&](double guess, std::vector<double>* points, const auto& solve, const auto& violation) {
      std::mt19937 random(36);
      std::uniform_real_distribution<double> unit(-1.0, 1.0);
      for (double& each : sum) each = guess * unit(random);
      for (std::size_t i = 0; i < num_moving; ++i) (*points)[i] += 1e-4 * unit(random);
      std::vector<double> moved = *points, alone = *points;
      const Projection projection = solve(points->data(), sum.data());
      EXPECT_LE(projection.violation, 1e-12);
      EXPECT_GT(projection.iterations, 0);
      EXPECT_LE(violation(points->data()), 1e-12);
      model.gather.add_scaled(model.parallel, blocks.data(), sum.data(), model.inverse_mass.data(), model.num_moving(),
                              moved.data());
      EXPECT_LE(largest_difference(moved, *points), 1e-12);
      found.push_back(*points);
      found.push_back(sum);
      // A caller that wants no sum gets the same from no guess.
      (void)solve(alone.data(), nullptr);
      EXPECT_LE(violation(alone.data()), 1e-12);
      EXPECT_LE(largest_difference(alone, *points), guess == 0.0 ? 0.0 : 1e-6);
      // Positions within the tolerance stay as they are, and the reported violation is the true one.
      std::vector<double> loose = moved;
      for (std::size_t i = 0; i < num_moving; ++i) loose[i] += 1e-5 * unit(random);
      const std::vector<double> before = loose;
      const double known = violation(loose.data());
      const Projection none = solve(loose.data(), nullptr, 2.0 * known);
      EXPECT_EQ(none.iterations, 0);
      EXPECT_NEAR(none.violation, known, 1e-9 * known);
      EXPECT_EQ(loose, before);
    };
    project(
        0.0, &at.v,
        [&](double* v, double* multipliers, double target = 1e-13) {
          return at.solver.project_velocities(model.parallel, blocks.data(), target, at.r.data(), v, multipliers);
        },
        [&](const double* v) { return constraints.evaluate_rates(model.parallel, at.r.data(), v, at.there.data()); });
    project(
        1e-4, &at.r,
        [&](double* r, double* multipliers, double target = 1e-13) {
          return at.solver.project_positions(model.parallel, blocks.data(), target, r, nullptr, multipliers);
        },
        [&](const double* r) { return constraints.evaluate_values(model.parallel, r, at.there.data()); });
    // Positions that are read from elsewhere go to the same result.
    std::vector<double> given = at.r, brought(given);
    for (std::size_t i = 0; i < num_moving; ++i) given[i] += 1e-5 * std::sin(static_cast<double>(i));
    std::vector<double> there = given;
    std::fill_n(brought.begin(), num_moving, std::numeric_limits<double>::quiet_NaN());
    const CopiedPoints source(given, &brought);
    (void)at.solver.project_positions(model.parallel, blocks.data(), 1e-13, there.data(), nullptr, nullptr);
    (void)at.solver.project_positions(model.parallel, blocks.data(), 1e-13, brought.data(), &source, nullptr);
    EXPECT_TRUE(brought == there);
  }
  const std::size_t half = found.size() / 2;
  for (std::size_t k = 0; k < half; ++k) EXPECT_TRUE(found[k] == found[half + k]) << k;
}

}  // namespace tanor
