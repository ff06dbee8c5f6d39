#pragma once

#include <vector>

#include "dynamics/chord_iteration.hpp"
#include "ranks/cut_linearization.hpp"

namespace tanor {

/// Projections onto xi = 0 and K'v + xi_t = 0 along the M^-1 K that stands, where constraints reach from rank to rank:
/// the role StepProjector of CutForm as well. Every rank makes the same iterations.
class CutProjector final : public StepProjector, private ChordEquations {
 public:
  CutProjector(Workspace& work, CutLinearization& linearization);

  /// Linearizes anew where the iterations stall.
  ProjectionReport project_positions(double t, double* r) { return iterate_positions(t, r, nullptr); }
  ProjectionReport project_velocities(double t, const double* r, double* v);
  /// The speeds of neighbourhoods have changed.
  void set_least_speed(double speed) { least_speed_ = speed; }
  void exchange_memory(Memory& memory) { memory.exchange(least_speed_); }

  // ---- StepProjector ----

  bool depends_on_velocity() const override { return work_.forces.depends_on_velocity(); }
  bool is_constant() const override { return model_.uniform_free() != nullptr && !model_.has_moving_supports(); }
  Outcome free_accelerations(const Kinematics& at, const Request& request, double* a) override;
  ProjectionReport project_step(double t, double h, double* x, double* step_velocity) override;
  ProjectionReport project_step_velocities(double t, double, const double* x, double* v) override {
    return project_velocities(t, x, v);
  }

  /// w0 = M^-1 f, of guests as well; returns the largest of this rank's.
  double evaluate_free(const Kinematics& at, double* w);

 private:
  /// `sum` [d], the multipliers' sum of a step, keeps to the K that stands.
  ProjectionReport iterate_positions(double t, double* r, double* sum);
  // ChordEquations
  double evaluate_values(const double* r) override;
  double beyond_rounding(const double* r, double violation, double allowed, double times) override;
  Outcome linearise_at(double t, const double* r) override;
  void correct_positions(double* r, double* sum) override;
  bool decide_rank_again(const double* r) override { return linearization_.decide_rank_again(work_.time(), r); }
  Outcome explain_stall(double t, double violation) const override;

  Workspace& work_;
  const Model& model_;
  CutLinearization& linearization_;
  double least_speed_ = 1.0;
  std::vector<double> rows_;      // [d] what is violated, then its correction
  std::vector<double> step_sum_;  // [d]
  std::vector<double> move_;      // [3n]
};

}  // namespace tanor
