#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/equations_of_motion.hpp"
#include "dynamics/tangent_dynamics.hpp"
#include "dynamics/tangent_linearization.hpp"
#include "dynamics/tangent_roles.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

class TangentCorners;

/// The equations of motion in tangent form, in the variables q of r = r(q, t) (see TangentDynamics). There is no drift,
/// since r(q, t) stays on the constraints by itself. Nothing is projected.
class TangentForm final : public EquationsOfMotion {
 public:
  TangentForm(Workspace& work, const SolverOptions& options);
  ~TangentForm() override;

  std::size_t size() const override { return work_.coordinates.num_coordinates(); }
  bool keeps_variables() const override { return false; }
  bool has_work_here() const override { return dynamics_.has_work(); }
  const Parallel& parallel() const override { return model_.parallel; }
  PointTolerances point_tolerances() const override {
    return {work_.scales.position_tolerances(), work_.scales.velocity_tolerances(), work_.scales.accelerations()};
  }

  void fetch_guests(double*, double*) override {}
  void prescribe(double, double*, double*) override {}
  /// Does nothing. Only the accelerations need a factor, and they make their own.
  Outcome linearise(double, const double*) override {
    return together([] { return Outcome{}; });
  }
  double reciprocal_condition_here() const override { return linearization_.reciprocal_condition(); }
  Outcome accelerations(const Kinematics& at, const Request& request, const AccelerationOutput& to) override {
    return solve_together(to, [&] { return dynamics_.solve(at, request, to); });
  }
  std::size_t rank_here() const override { return work_.rank; }
  /// Moves nothing. Where constraints are given too, their violation is measured.
  ProjectionReport project_positions(double t, double* q, Turn) override {
    return project_together([&] { return measure_violation(t, q); });
  }
  ProjectionReport project_velocities(double, const double*, double*) override { return {}; }
  ErrorRatios error_ratios(double t, const StepErrors& errors, double atol, double rtol) override;
  Reactions no_reactions() const override;
  void exchange_memory(Memory& memory) override;

  Roles roles_here() override;
  SeriesExpansion* series_here(std::string* why_not) override {
    if (why_not != nullptr) *why_not = "the motion in coordinates is not expanded in time";
    return nullptr;
  }

  StartReport start(double t, double* r, double* v, StartMode mode) override;
  ProjectionReport project_point_positions(double t, double* r) override;
  ProjectionReport project_point_velocities(double t, const double* r, double* v) override;
  Outcome set_state(double t, const double* r, const double* v, double* q, double* q_dot) override;
  void write_points(const Kinematics& at, const double* q_ddot, const Reactions& found, double* r, double* v,
                    double* w) override;
  Outcome begin(double t, const double* q, double* q_dot, const Request& request,
                const AccelerationOutput& to) override;
  void recentre(double t, double* q, double* q_dot, double* q_ddot, Reactions* found) override;
  void resume(const Counters& counters, const PhaseTimes& times) override;
  Energy energy(double t, const double* q, const double* q_dot) override;
  void minimize_multipliers(const Kinematics&, double*) override {}  // coordinates have none
  double potential(double t, const double* r) override { return sum(work_.forces.potential(model_.parallel, t, r)); }
  void write_reactions(const Kinematics& at, const Reactions& found, double* eta) override {
    dynamics_.write_reactions(at, found, eta);
  }
  void write_friction(const Reactions& found, double* tau) const override { dynamics_.write_friction(found, tau); }
  void describe(PlanSummary* plan) const override;

  TangentLinearization& linearization() { return linearization_; }
  TangentDynamics& dynamics() { return dynamics_; }
  /// Computes A and the factor of H at the start, moved by about `distance` (m) in a generic direction. Writes the
  /// positions there [3n].
  Outcome stand_beside(double t, double distance, double* r);

 private:
  ProjectionReport measure_violation(double t, const double* q);

  Workspace& work_;
  const Model& model_;
  TangentLinearization linearization_;
  TangentDynamics dynamics_;
  RankMonitor rank_;  // the condition of H = A'MA tells of singular coordinates, not how they turn
  TangentFeatures unseen_;
  TangentEvents events_;
  std::unique_ptr<TangentCorners> corners_;
  std::vector<double> moved_, rate_, r_from_, v_from_;  // [3n] for error estimates
  std::vector<double> q_;                               // initial guess of the search for coordinates
  std::vector<double> rates_;                           // [s] scratch
};

}  // namespace tanor::detail
