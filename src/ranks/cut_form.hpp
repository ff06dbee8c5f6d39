#pragma once

#include <string>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/point_form.hpp"
#include "ranks/agreement.hpp"
#include "ranks/cut_solver.hpp"
#include "ranks/guests.hpp"

namespace tanor {

/// The equations of motion in normal form of a rank's part, where constraints reach from rank to rank: ideal
/// constraints, each independent of the others. What a rank writes of its own points it writes of its guests, too.
///
/// Guests are supports here, for which motion is prescribed by their owners: positions and velocities come where a
/// projection moved them, accelerations where these were found. In between a step does the same arithmetic to both.
class CutForm final : public PointForm, private StepProjector, private RankMonitor {
 public:
  CutForm(Workspace& work, const SolverOptions& options, const Part& part);

  bool has_work() const override { return is_rheonomic_ || work_.forces.has_work(); }
  Outcome linearise(double t, const double* r) override;
  double reciprocal_condition() const override { return reciprocal_condition_; }
  Outcome accelerations(const Kinematics& at, const Request& request, const AccelerationOutput& to) override;
  Reactions no_reactions() const override;
  ProjectionReport project_positions(double t, double* r, Turn turn) override;
  ProjectionReport project_velocities(double t, const double* r, double* v) override;
  ErrorRatios error_ratios(double t, const StepErrors& errors, double atol, double rtol) override;
  void exchange_memory(Memory& memory) override;

  Roles roles() override {
    Roles roles = common_roles();
    roles.step_projector = this;
    roles.rank_monitor = this;
    return roles;
  }
  SeriesExpansion* series() override { return nullptr; }
  std::string why_no_series() const override { return "islands lie on several ranks"; }

  StartReport start(double t, double* r, double* v, StartMode mode) override;
  ProjectionReport project_point_positions(double t, double* r) override;
  ProjectionReport project_point_velocities(double t, const double* r, double* v) override;
  Outcome begin(double, const double*, double*, const Request& request, const AccelerationOutput& to) override;
  void recentre(double, double*, double*, double*, Reactions*) override {}
  void resume(const Counters& counters, const PhaseTimes& times) override;
  void write_reactions(const Kinematics&, const Reactions& found, double* eta) override;
  void write_friction(const Reactions& found, double* tau) const override;
  void describe(PlanSummary* plan) const override;
  void fetch_guests(double* r, double* v) override;

 private:
  // StepProjector
  bool depends_on_velocity() const override { return work_.forces.depends_on_velocity(); }
  bool is_constant() const override { return model_.uniform_free() != nullptr && !model_.has_moving_supports(); }
  Outcome free_accelerations(const Kinematics& at, const Request& request, double* a) override;
  ProjectionReport project_step(double t, double h, double* x, double* step_velocity) override;
  ProjectionReport project_step_velocities(double t, double, const double* x, double* v) override {
    return project_velocities(t, x, v);
  }
  // RankMonitor: a rank that is lost ends the motion with an outcome
  double mass_ratio() const override { return mass_ratio_; }
  void remember_gradients() override {}
  double compare_gradients() override { return 1.0; }

  Index shared_of(Index point) const { return part_.shared_neighbourhood[static_cast<std::size_t>(point)]; }
  void measure_neighbourhoods();
  void share_speeds();
  void check_start(const double* r, const double* v);
  Outcome factorize(double t);
  double evaluate_free(const Kinematics& at, double* w);
  Power find_power(const Kinematics& at);
  void solve(const double* b, double* x, double* dw);
  int refine(const double* b, double scale, double good_enough, double* residual);
  double evaluate_values(const double* r) {
    return agreement_.largest(work_.constraints.evaluate_values(model_.parallel, r, rows_.data()));
  }
  /// rows := -S^-1 rows, points += M^-1 K rows, guests included.
  void correct(double* points);
  ProjectionReport iterate_positions(double t, double* r, double* sum);

  Agreement agreement_;
  Guests guests_;
  Part part_;
  CutSolver solver_;
  std::vector<double> blocks_;  // K
  bool has_factor_ = false, has_constant_gradients_, is_rheonomic_;
  double mass_ratio_, reciprocal_condition_ = 1.0, least_speed_ = 1.0;
  std::vector<double> lambda_, b_, rows_, right_side_, step_sum_;  // [d]
  std::vector<double> dw_, move_;                                  // [3n]
};

}  // namespace tanor
