#pragma once

#include <vector>

#include "dynamics/chord_iteration.hpp"
#include "ranks/cut_linearization.hpp"

namespace tanor::detail {

/// Projections onto xi = 0 and K'v + xi_t = 0 along the present M^-1 K, where constraints reach from rank to rank. It
/// is the StepProjector of CutForm as well. Every rank makes the same iterations.
class CutProjector final : public StepProjector, private ChordEquations {
 public:
  CutProjector(Workspace& work, CutLinearization& linearization);

  /// Projects positions, and linearizes anew if the iterations stall.
  ProjectionReport project_positions(double t, double* r) { return iterate_positions(t, r, nullptr); }
  ProjectionReport project_velocities(double t, const double* r, double* v);
  /// Sets the least speed, after the speeds of neighbourhoods have changed.
  void set_least_speed(double speed) { least_speed_ = speed; }
  void exchange_memory(Memory& memory) { memory.exchange(least_speed_); }

  // ---- StepProjector ----

  bool depends_on_velocity() const override { return work_.forces.depends_on_velocity(); }
  bool is_constant() const override { return model_.uniform_free() != nullptr && !model_.has_moving_supports(); }
  /// Guests have it as well, behind the points that move.
  const Vec3* uniform_acceleration() const override { return nullptr; }
  std::size_t num_moving() const override { return model_.num_moving(); }
  Outcome free_accelerations(const Kinematics& at, const Request& request, double* a) override;
  ProjectionReport project_step(double t, double h, const PointSource& source, double* x,
                                double* step_velocity) override;
  ProjectionReport project_step_velocities(double t, double, const double* x, double* v) override {
    return project_velocities(t, x, v);
  }

  /// Computes w0 = M^-1 f, also for guests. Returns the largest on this rank.
  double evaluate_free(const Kinematics& at, double* w);

 private:
  /// Projects positions. If `sum` [d], the sum of a step's multipliers, is given, K is not evaluated anew.
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
  std::vector<double> rows_;      // [d] violations, then their correction
  std::vector<double> step_sum_;  // [d]
  std::vector<double> move_;      // [3n]
};

}  // namespace tanor::detail
