#pragma once

#include <limits>
#include <vector>

#include "dynamics/contact_state.hpp"
#include "dynamics/linearization.hpp"
#include "dynamics/residuals.hpp"
#include "dynamics/workspace.hpp"

namespace tanor {

/// Projections onto xi = 0 and onto K'v + xi_t = 0 along M^-1 K, which is orthogonal in the M-norm: chord iterations
/// with the factor of S that stands.
class Projector {
 public:
  /// `contacts`: what sticks, and where it is held; null where constraints are ideal.
  Projector(Workspace& work, Linearization& linearization, Residuals& residuals, ContactState* contacts = nullptr);

  /// The configuration nearby; linearises anew where the iterations stall, and after a large turn at r first where that
  /// costs no more than the iterations which it saves.
  ProjectionReport project_positions(double t, double* r, Turn turn = Turn::Small);
  /// The same along the K that stands, whatever happens. `sum` [d]: a guess of the multipliers, then their sum.
  /// `source`: where r comes from; null: it is there. `tolerance`: a largest |xi|/length that is small enough.
  ProjectionReport project_along_gradients(double t, double* r, double* sum, const PointSource* source = nullptr,
                                           double tolerance = 0.0) {
    return iterate_positions(t, r, source, sum, infinity, tolerance);
  }
  /// With K at r. Adds the multipliers that change v to `sum` [d] unless it is null. `speed`, m/s: rates are small
  /// beside it; 0: beside the speed of their neighbourhood.
  ProjectionReport project_velocities(double t, const double* r, double* v, double* sum = nullptr, double speed = 0.0);

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  struct Progress;
  ProjectionReport iterate_positions(double t, double* r, const PointSource* source, double* sum, double far,
                                     double tolerance);
  bool is_rounding(const double* r, double violation, double target, Progress* progress);
  bool decide_rank_again(const double* r, Progress* progress);
  void add_rows_to(double* sum) const;
  double evaluate_values(const double* r);
  Outcome explain_stall(double t, double violation) const;

  Workspace& work_;
  const Model& model_;
  Linearization& linearization_;
  Residuals& residuals_;
  ContactState* contacts_;    // null: constraints are ideal
  std::vector<double> rows_;  // [d] what is violated, then its correction
};

}  // namespace tanor
