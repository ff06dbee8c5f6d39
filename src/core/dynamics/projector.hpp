#pragma once

#include <limits>
#include <vector>

#include "dynamics/chord_iteration.hpp"
#include "dynamics/contacts.hpp"
#include "dynamics/linearization.hpp"
#include "dynamics/residuals.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Projects onto xi = 0 and onto K'v + xi_t = 0 along M^-1 K, which is orthogonal in the M-norm, by chord iterations
/// with the present factor of S.
class Projector final : private ChordEquations {
 public:
  /// `contacts` tell which contacts stick and where they are held; null if constraints are ideal.
  Projector(Workspace& work, Linearization& linearization, Residuals& residuals, Contacts* contacts = nullptr);

  /// Projects r onto a configuration nearby. Linearises anew where the iterations stall. After a large turn it
  /// linearises at r first if that costs no more than the iterations which it saves.
  ProjectionReport project_positions(double t, double* r, Turn turn = Turn::Small);
  /// Projects along the present K in any case. `sum` [d] holds a guess of the multipliers and receives their sum.
  /// `source` brings r, or is null if r is there already. Stops where |xi|/length is at most `tolerance`.
  ProjectionReport project_along_gradients(double t, double* r, double* sum, const PointSource* source = nullptr,
                                           double tolerance = 0.0) {
    return iterate_positions(t, r, source, sum, infinity, tolerance);
  }
  /// Projects v with K at r. Adds the multipliers that change v to `sum` [d] unless it is null. Rates are measured by
  /// `speed`, m/s, or if it is 0 by the speed of their neighbourhood.
  ProjectionReport project_velocities(double t, const double* r, double* v, double* sum = nullptr, double speed = 0.0);

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  ProjectionReport iterate_positions(double t, double* r, const PointSource* source, double* sum, double far,
                                     double tolerance);
  // The functions of ChordEquations follow.
  double evaluate_values(const double* r) override;
  double beyond_rounding(const double* r, double violation, double allowed, double times) override {
    return residuals_.beyond_rounding(r, rows_.data(), violation, allowed, times);
  }
  Outcome linearise_at(double t, const double* r) override { return linearization_.update(t, r); }
  void correct_positions(double* r, double* sum) override;
  bool decide_rank_again(const double* r) override { return linearization_.decide_rank_again(r); }
  Outcome explain_stall(double t, double violation) const override;

  Workspace& work_;
  const Model& model_;
  Linearization& linearization_;
  Residuals& residuals_;
  Contacts* contacts_;  // null if constraints are ideal
  const bool is_factor_cheap_;
  std::vector<double> rows_;  // [d] residuals, then corrections
};

}  // namespace tanor::detail
