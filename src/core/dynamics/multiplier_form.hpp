#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/contacts.hpp"
#include "dynamics/forward_dynamics.hpp"
#include "dynamics/gradient_rank.hpp"
#include "dynamics/implicit_form.hpp"
#include "dynamics/linearization.hpp"
#include "dynamics/multiplier_series.hpp"
#include "dynamics/multiplier_system.hpp"
#include "dynamics/point_form.hpp"
#include "dynamics/projector.hpp"
#include "dynamics/residuals.hpp"
#include "dynamics/step_projection.hpp"
#include "dynamics/unilateral.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

class PointCorners;

/// The equations of motion in the positions r themselves, with Lagrange multipliers: the paper's normal form (31),
/// (25). Owns and connects the objects that do the work.
class MultiplierForm final : public PointForm {
 public:
  MultiplierForm(Workspace& work, const SolverOptions& options);
  ~MultiplierForm() override;

  bool has_work_here() const override {
    return work_.is_rheonomic() || work_.forces.has_work() || contacts_ != nullptr || unilateral_ != nullptr;
  }
  void prescribe(double t, double* r, double* v) override;
  Outcome linearise(double t, const double* r) override {
    return together([&] { return linearization_.update(t, r); });
  }
  double reciprocal_condition_here() const override { return linearization_.reciprocal_condition(); }
  Outcome accelerations(const Kinematics& at, const Request& request, const AccelerationOutput& to) override {
    return solve_together(to, [&] { return dynamics_.solve(at, request, to); });
  }
  ProjectionReport project_positions(double t, double* r, Turn turn) override {
    return project_together([&] { return projector_.project_positions(t, r, turn); });
  }
  ProjectionReport project_velocities(double t, const double* r, double* v) override {
    return project_together([&] { return projector_.project_velocities(t, r, v); });
  }
  ErrorRatios error_ratios(double t, const StepErrors& errors, double atol, double rtol) override;
  Reactions no_reactions() const override;
  void exchange_memory(Memory& memory) override;

  Roles roles_here() override;
  SeriesExpansion* series_here(std::string* why_not) override;

  StartReport start(double t, double* r, double* v, StartMode mode) override;
  ProjectionReport project_point_positions(double t, double* r) override;
  ProjectionReport project_point_velocities(double t, const double* r, double* v) override;
  Outcome begin(double t, const double* r, double* v, const Request& request, const AccelerationOutput& to) override;
  void recentre(double t, double* r, double* v, double*, Reactions*) override {
    if (contacts_ != nullptr) contacts_->accept(t, r, v);
  }
  void resume(const Counters& counters, const PhaseTimes& times) override;
  void write_reactions(const Kinematics&, const Reactions& found, double* eta) override {
    dynamics_.write_reactions(found.lambda, eta);
  }
  void minimize_multipliers(const Kinematics& at, double* lambda) override {
    linearization_.minimize_multiplier_norm(at.x, lambda);
  }
  void write_friction(const Reactions& found, double* tau) const override;
  void describe(PlanSummary* plan) const override;

  /// The objects that solve at the configuration of the last linearisation.
  Linearization& linearization() { return linearization_; }
  Projector& projector() { return projector_; }
  ForwardDynamics& dynamics() { return dynamics_; }
  StepProjection& steps() { return steps_; }
  /// Null if constraints are ideal.
  const Contacts* contacts() const { return contacts_.get(); }

  /// Returns the predicted flops of one evaluation and solve.
  double predicted_flops() const;
  /// Returns the orderings of S, part by part; `Natural` where elimination causes no fill.
  std::vector<Ordering> orderings() const;

 private:
  bool is_prescribed_together() const override { return is_prescribed_together_; }

  LinearizedResponse response_;             // contacts see this form by these two, …
  MultiplierSystem system_;                 // … which refer to what follows
  std::unique_ptr<Contacts> contacts_;      // null if constraints are ideal
  std::unique_ptr<Unilateral> unilateral_;  // null if all constraints act to both sides
  // Each of the other members depends on those above it.
  Linearization linearization_;
  Residuals residuals_;
  Projector projector_;
  std::unique_ptr<PointCorners> corners_;
  const bool has_no_friction_but_viscous_, is_prescribed_together_;
  ForwardDynamics dynamics_;
  StepProjection steps_;
  GradientRank gradient_rank_;
  ImplicitMultiplierForm implicit_;
  std::unique_ptr<MultiplierSeries> series_;  // made when it is requested first
  std::vector<double> error_x_, error_v_;     // [3n] errors of a step without the part that constraints take
  std::vector<double> rows_;                  // [d] scratch
};

}  // namespace tanor::detail
