#pragma once

/// \file A random system solved by the library, and the same in dense matrices.

#include <utility>
#include <vector>

#include "random_systems.hpp"

namespace tanor {

/// Vectors without a suffix have the coordinates of the moving points.
struct Solved {
  RandomSystem random;
  reference::Mechanics dense;
  Dynamics dynamics;
  std::vector<double> accelerations, multipliers, reactions;  ///< 3n, d, 3n, in the user's order
  SolveReport report;
  Eigen::VectorXd w, lambda, eta;
  double accuracy = 0.0;  ///< the relative accuracy to which identities must hold, 1e-12 sqrt(cond S)
  double size = 0.0;      ///< the size of the accelerations that meet in w

  explicit Solved(RandomSystem given, const SolverOptions& options = {})
      : random(std::move(given)),
        dense(reference::make_mechanics(random.system, random.t, random.positions, random.velocities)),
        dynamics(random.system, options),
        accelerations(random.positions.size()),
        multipliers(dynamics.num_equations()),
        reactions(random.positions.size()),
        report(dynamics.solve(state(),
                              {.accelerations = accelerations, .multipliers = multipliers, .reactions = reactions})),
        w(dense.pick(accelerations)),
        lambda(reference::vector(multipliers)),
        eta(dense.pick(reactions)),
        accuracy(1e-12 * dense.sqrt_condition()),
        size(1.0 + w.norm() + dense.f.cwiseQuotient(dense.M).norm() + dense.phi.norm()) {}

  StateView state() const { return {.time = random.t, .positions = random.positions, .velocities = random.velocities}; }
  Split split() { return dynamics.split(state()); }
  std::vector<double> active_forces() {
    std::vector<double> result(accelerations);
    (void)dynamics.solve(state(), {.active_forces = result});
    return result;
  }
  std::vector<double> support_forces() {
    std::vector<double> result(accelerations);
    (void)dynamics.solve(state(), {.support_forces = result});
    return result;
  }

  /// Returns |M^-1 x|, a force measured as an acceleration.
  double as_acceleration(const Eigen::VectorXd& force) const { return force.cwiseQuotient(dense.M).norm(); }
  bool is_small(const Eigen::VectorXd& acceleration) const { return acceleration.norm() <= accuracy * size; }
};

}  // namespace tanor
