#pragma once

#include <limits>
#include <vector>

#include "dynamics/chord_iteration.hpp"
#include "dynamics/contact_state.hpp"
#include "dynamics/linearization.hpp"
#include "dynamics/residuals.hpp"
#include "dynamics/workspace.hpp"

namespace tanor {

/// Projections onto xi = 0 and onto K'v + xi_t = 0 along M^-1 K, which is orthogonal in the M-norm: chord iterations
/// with the factor of S that stands.
class Projector final : private ChordEquations {
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

  ProjectionReport iterate_positions(double t, double* r, const PointSource* source, double* sum, double far,
                                     double tolerance);
  // ChordEquations
  double evaluate_values(const double* r) override;
  double beyond_rounding(const double* r, double violation, double allowed, double times) override {
    return residuals_.beyond_rounding(r, violation, allowed, times);
  }
  Outcome linearise_at(double t, const double* r) override { return linearization_.update(t, r); }
  void correct_positions(double* r, double* sum) override;
  bool decide_rank_again(const double* r) override { return linearization_.factor().decide_rank_again(r); }
  Outcome explain_stall(double t, double violation) const override;

  Workspace& work_;
  const Model& model_;
  Linearization& linearization_;
  Residuals& residuals_;
  ContactState* contacts_;    // null: constraints are ideal
  std::vector<double> rows_;  // [d] what is violated, then its correction
};

}  // namespace tanor
