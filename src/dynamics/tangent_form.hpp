#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "dynamics/equations_of_motion.hpp"
#include "dynamics/model.hpp"
#include "dynamics/normal_form.hpp"
#include "schur/gram_solver.hpp"

namespace tanor {

/// The inverse problem in tangent form, in the variables q of r = r(q, t):
///
///   H q_ddot = A'(f - M psi),   H = A'MA        theory section 4; w^(q) = G^-1 A'w is another number
///   w = A q_ddot + psi,  eta = M w - f          (24)
///
/// There is no drift: r(q, t) stays on the constraints by itself, and nothing is projected. H is made of one block for
/// each member of the coordinates.
class TangentForm final : public EquationsOfMotion,
                          private RankMonitor,
                          private ForcePassages,
                          private DriveMonitor,
                          private EventFunctions {
 public:
  TangentForm(Model& model, const SolverOptions& options);

  std::size_t size() const override { return model_.coordinates.num_coordinates(); }
  bool keeps_variables() const override { return false; }
  bool has_work() const override { return model_.is_rheonomic() || model_.forces.has_work() || friction_ != nullptr; }

  void prescribe(double, double*, double*) override {}
  /// Nothing is projected, so nothing needs a factor but the accelerations, which make their own.
  Outcome linearise(double, const double*) override { return {}; }
  Outcome accelerations(const Kinematics& at, const Request& request, double* q_ddot) override;
  /// Nothing is moved; where constraints are given too their violation is measured.
  ProjectionReport project_positions(double t, double* q, Turn) override;
  ProjectionReport project_velocities(double, const double*, double*) override { return {}; }
  ErrorRatios error_ratios(double t, const StepErrors& errors, double atol, double rtol) override;
  DriveReport look_at_drives(const DrivenStep& step) override;
  std::string name_drive(std::size_t drive) const override { return model_.drives.name(drive); }
  std::size_t num_points() const override { return model_.num_points(); }
  Kinematics find_points(const Kinematics& at, double* r, double* v) override;
  PointTolerances point_tolerances() const override {
    return {model_.scales.position_tolerances(), model_.scales.velocity_tolerances(), model_.scales.accelerations()};
  }
  double find_passage(PointPath* path) override { return model_.find_passage(model_.coordinate_passages, path); }
  Power power(const double* q, const double* q_dot) const override;
  Energy energy(double t, const double* q, const double* q_dot) override;
  std::size_t rank() const override { return model_.rank; }
  /// H = A'MA has its own condition, which tells of singular coordinates; how they turn is not known.
  double mass_ratio() const override { return 1.0; }
  void remember_gradients() override {}
  double compare_gradients() override { return 1.0; }
  const SolveReport& last_solve() const override { return last_; }
  const Parallel& parallel() const override { return model_.parallel; }

  StepProjector* step_projector() override { return nullptr; }
  InexactSolves* inexact_solves() override { return nullptr; }
  RankMonitor* rank_monitor() override { return this; }
  RoundingGroups* rounding_groups() override { return nullptr; }
  ForcePassages* force_passages() override { return model_.may_be_passed(model_.coordinate_passages) ? this : nullptr; }
  SeriesExpansion* series() override { return nullptr; }
  std::string why_no_series() const override { return "the motion in coordinates is not expanded in time"; }
  DriveMonitor* drives() override { return !model_.drives.empty() ? this : nullptr; }
  EventFunctions* events() override { return friction_events() != nullptr ? this : nullptr; }
  ImplicitFormulation* implicit_formulation() override { return nullptr; }

  StartReport start(double t, double* r, double* v, StartMode mode) override;
  ProjectionReport put_positions(double t, double* r) override;
  ProjectionReport put_velocities(double t, const double* r, double* v) override;
  Outcome adopt(double t, const double* r, const double* v, double* q, double* q_dot) override;
  void write_points(double t, const double* q, const double* q_dot, const double* q_ddot, double* r, double* v,
                    double* w) override;
  void recentre(double t, double* q, double* q_dot, double* q_ddot) override;
  void exchange_memory(Memory& memory) override;
  void resume(const Counters& counters, const PhaseTimes& times) override;
  void reactions(double* eta) const override;
  /// Takes tau from the normal form at every instant, and with it what sticks and slides: friction that depends on
  /// reactions needs their multipliers (42).
  void take_friction_from(NormalForm* normal) { friction_ = normal; }
  std::size_t num_events() const override { return friction_events()->num_events(); }
  void evaluate_events(double t, const double* q, const double* q_dot, double* values) override;
  void shape_events(const double* values, double* shapes) const override { std::copy_n(values, num_events(), shapes); }
  Power work_of_switch() const override { return friction_events()->work_of_switch(); }
  Outcome switch_equations(double t, const double* q, double* q_dot, std::span<const std::size_t> which,
                           const Request& request, double* q_ddot) override;
  std::vector<int> discrete_state() const override { return friction_events()->discrete_state(); }
  void restore_discrete_state(std::span<const int> state) override { friction_events()->restore_discrete_state(state); }
  Outcome begin(double t, const double* q, double* q_dot, const Request& request, double* q_ddot) override;
  void describe(PlanSummary* plan) const override;
  /// eta = [I - M A H^-1 A'] force [3n] (24), refined to rounding, with the factor of the last linearisation; of
  /// supports: what the coordinates do there.
  void respond(const double* force, double* eta);
  /// A and the factor of H at the places of the start, moved by about `distance` (m) in a direction that nothing
  /// prefers; those places [3n].
  Outcome stand_beside(double t, double distance, double* r);
  /// Predicted flops of one evaluation and solve.
  double predicted_flops() const;

  /// x := -H^-1 x with the last factor [s].
  double estimate_reciprocal_condition() {
    complete();
    return solver_.estimate_reciprocal_condition();
  }
  void solve_negative(double* x) {
    complete();
    solver_.solve_negative(model_.parallel, x, x);
  }
  /// r(q + h q_dot + h^2/2 q_ddot, t + h) [3n] from the last accelerations.
  void write_place_along(double h, double* r);
  /// Of the last accelerations: A as blocks, psi and w [3n].
  const std::vector<double>& blocks() const {
    complete();
    return blocks_;
  }
  const std::vector<double>& psi() const {
    complete();
    return psi_;
  }
  const std::vector<double>& w() const { return w_; }

 private:
  friend struct Tampering;  // the tests' hand in the works: every corruption must be caught

  TangentForm(Model& model, const SolverOptions& options, const std::vector<Product>& products);

  /// r_, v_, psi_ and A at (t, q, q_dot).
  void evaluate(double t, const double* q, const double* q_dot, bool with_blocks) const;
  Outcome factorize(double t);
  bool accelerate(double t, const double* q, const double* q_dot, double* q_ddot);
  EventFunctions* friction_events() const { return friction_ != nullptr ? friction_->events() : nullptr; }
  void remember(double t, const double* q, const double* q_dot);
  void complete() const;
  void locate(const double* r);
  double relative_correction(double correction, double scale) const;
  double correct(double* q_ddot);
  Outcome add_friction(double t, const Request& request);
  Outcome find_rates(double t, const double* v, const double* q, double* q_dot);
  void check_constraints();

  Model& model_;
  NormalForm* friction_ = nullptr;        // null: constraints are ideal
  std::vector<double> friction_w_, tau_;  // [3n] of the normal form
  std::size_t num_products_;
  bool has_closed_form_;
  mutable GramSolver solver_;

  // The last instant. Accelerations in closed form leave out what is mutable until somebody asks or charts change.
  double t_ = 0.0;
  SolveReport last_;
  mutable bool is_complete_ = true;
  mutable std::vector<double> blocks_;                 // A
  mutable std::vector<double> r_, v_, psi_, w0_;       // [3n]; w0 = M^-1 f
  std::vector<double> w_;                              // [3n]
  mutable std::vector<double> points_;                 // [3n] scratch
  std::vector<double> error_rates_, r_from_, v_from_;  // [3n] of error estimates
  std::vector<double> right_side_, rates_;             // [s]
  std::vector<double> last_q_, last_q_dot_;            // [s] of the last accelerations
  mutable std::vector<double> last_q_ddot_;            // likewise
  std::vector<double> users_q_;                        // [s] scratch
  std::vector<double> q_;                              // where the last (r, v) was found: the next search starts there
};

}  // namespace tanor
