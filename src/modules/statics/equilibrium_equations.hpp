#pragma once

#include <algorithm>
#include <vector>

#include "dynamics/workspace.hpp"
#include "statics/stiffness_matrix.hpp"

namespace tanor::detail {

/// A system at rest at the time t, and Newton's matrix of its equilibrium:
///
///   g = f + K lambda = 0   [3n], N            [ W  K ] [  dr     ]   [  g  ]
///   xi = 0                 [d]                [ K' 0 ] [ -dlambda] = [ -xi ]
///
/// The unknowns are the n moving points, which come first in the inner order; supports stay where they are at t. The
/// rows are the d equations that join moving points, `num_rows()`, which come before the idle ones. Friction takes no
/// part. In a frame that moves (see SteadyFrame) rest is that in the frame.
class EquilibriumEquations {
 public:
  /// `work` must belong to a system without friction, and with the energy of the frame's inertia if that moves; `spin`
  /// is that of the frame, rad/s.
  EquilibriumEquations(Workspace& work, double t, Vec3 spin = {});

  std::size_t size() const { return 3 * model_.num_moving(); }
  std::size_t num_rows() const { return model_.numbering.first_idle_row(); }
  const Model& model() const { return model_; }
  Workspace& work() const { return work_; }
  Eigen::VectorXd masses() const;  ///< of the unknowns [size()], kg
  double time() const { return t_; }
  Vec3 spin() const { return spin_; }

  /// Evaluates g [size()] and xi [model().num_rows()] at r [3 points] and lambda [model().num_rows()], and K there.
  /// Returns the scale of g, N: the largest force at a moving point that a single row, spring, tuple or other law
  /// exerts. The scale is not finite if some force or constraint is not.
  double evaluate(const double* r, const double* lambda, double* g, double* xi);
  /// Evaluates K and W at r and lambda.
  void linearise(const double* r, const double* lambda, StiffnessMatrix::Curvature curvature = {});
  /// Does so where r is known to `error` only, m, and finds how much W changes over that distance (see `blur`).
  void linearise_near(const double* r, const double* lambda, double error);
  /// Returns the change of the sum of |W_ij| over a row of a moving point that an error of the positions may cause,
  /// N/m.
  double blur(std::size_t point) const { return blur_[point]; }

  /// Returns G = 2 m Omega x [size(), size()], N s/m, minus the derivative of the Coriolis forces in the velocities, in
  /// a frame that turns.
  Eigen::SparseMatrix<double> find_coriolis() const;

  /// Moves each coordinate of the moving points in r [3 points] by at most `by`, m, without any symmetry and always in
  /// the same way.
  void disturb(double by, double* r) const;

  double violation() const { return violation_; }  ///< at the last `evaluate`, relative
  /// Returns the rounding error, N, of forces that cancel at a moving point. Rounding of the positions causes it,
  /// multiplied by the rows of W of the last `linearise`, of the point or of one that constraints join to it, and
  /// rounding of its weight and of the forces given on it.
  double rounding_of_forces(std::size_t point) const { return rounding_[point]; }
  /// Returns that part of it which weights and given forces leave.
  double rounding_of_loads(std::size_t point) const { return rounding_of_loads_[point]; }
  /// Returns the larger one of |f| and |K lambda| at a moving point at the last `evaluate`, N.
  double acting_force(std::size_t point) const {
    return std::max(norm(load(f_.data(), point)), norm(load(reactions_.data(), point)));
  }
  /// Returns f + K lambda at a moving point at the last `evaluate`, N.
  Vec3 net_force(std::size_t point) const { return load(f_.data(), point) + load(reactions_.data(), point); }
  /// The scene's size or the largest |r| at the last `evaluate`, m, to which positions are rounded.
  double extent() const { return extent_; }

  /// The blocks of K, as `Model::incidences` reads them, and W at the last configuration.
  const std::vector<double>& gradients() const { return blocks_; }
  const StiffnessMatrix& stiffness() const { return stiffness_; }
  StiffnessMatrix& stiffness() { return stiffness_; }
  /// The active forces f of the last `evaluate` [3 points], N.
  const std::vector<double>& forces() const { return f_; }
  /// Writes multipliers [equations], reactions K lambda and the loads of supports [3n, N] of the last `evaluate` and
  /// `linearise` in the user's order. NaN are multipliers of rods between points that prestress holds, and the forces
  /// on these points and on their supports.
  void write_forces(const std::vector<double>& lambda, std::vector<double>* multipliers, std::vector<double>* reactions,
                    std::vector<double>* support_forces) const;
  /// Sets the multipliers of constraints to 0 where no force acts on any point that they join: there they are what
  /// rounding of other islands has left. Evaluates the forces at r.
  void forget_idle_multipliers(const double* r, std::vector<double>* lambda);
  /// Compute y += K lambda [size()], and rows = K'x [model().num_rows()] with x [size()].
  void add_reactions(const double* lambda, double* y) const;
  void apply_transposed(const double* x, double* rows) const;

  /// Returns the energy U of all forces that have a potential, J.
  double energy(const double* r) { return work_.forces.potential(model_.parallel, t_, r); }

 private:
  Workspace& work_;
  const Model& model_;
  double t_, violation_ = 0.0, extent_;
  Vec3 spin_;
  StiffnessMatrix stiffness_;
  std::vector<int> joined_;  // [moving point] a point that represents all that constraints join to it
  std::vector<double> rounding_of_loads_, rounding_;  // [moving point] N
  std::vector<double> blur_;                          // [moving point] N/m
  std::vector<double> blocks_, f_, reactions_, at_rest_;
};

}  // namespace tanor::detail
