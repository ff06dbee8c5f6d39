#include "dynamics/multiplier_form.hpp"

#include <algorithm>

#include "dynamics/consistent_start.hpp"
#include "dynamics/corners.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

MultiplierForm::MultiplierForm(Workspace& work, const SolverOptions& options)
    : PointForm(work),
      response_(work, linearization_),
      system_(linearization_, residuals_, projector_, dynamics_, response_),
      contacts_(work.model().has_friction() ? make_contacts(work, options.friction, system_) : nullptr),
      unilateral_(model_.numbering.one_sided.empty() ? nullptr : make_unilateral(work, system_, contacts_.get())),
      linearization_(work, options, contacts_.get()),
      residuals_(work, linearization_.blocks()),
      projector_(work, linearization_, residuals_, contacts_.get()),
      corners_(std::make_unique<PointCorners>(work, linearization_, projector_)),
      has_no_friction_but_viscous_(is_friction_viscous(work.model().system)),
      is_prescribed_together_(!work.team().is_alone() &&
                              work.team().any(work.is_rheonomic() || work.forces.depend_on_time())),
      dynamics_(work, linearization_, residuals_, contacts_.get()),
      steps_(work, linearization_, projector_, dynamics_, contacts_.get()),
      gradient_rank_(work, linearization_),
      implicit_(work),
      rows_(model_.num_rows()) {}

MultiplierForm::~MultiplierForm() = default;

/// Goes to t with all that may end there, since no process can begin a call of the team alone.
void MultiplierForm::prescribe(double t, double* r, double* v) {
  prepare([&] {
    work_.prescribe(t, r, v);
    if (work_.team().is_alone()) return;
    work_.set_time(t);
    work_.forces.set_time(t);
  });
}

double MultiplierForm::predicted_flops() const {
  const FactorSummary& factor = linearization_.summary().factor;
  return factor.flops + 4.0 * static_cast<double>(factor.factor_nonzeros) +
         plan::flops_of_normal_entry * static_cast<double>(factor.pattern_nonzeros) +
         plan::flops_of_normal_row * static_cast<double>(model_.num_rows());
}

std::vector<Ordering> MultiplierForm::orderings() const {
  return linearization_.summary().factor.orderings;
}

void MultiplierForm::describe(PlanSummary* plan) const {
  const SchurSolver::Summary& chosen = linearization_.summary();
  describe_factor(chosen.factor, plan);
  plan->linear_solvers = chosen.solvers;
  plan->linear_solver_reason = chosen.reason;
  auto& left_out = plan->left_out;
  if (model_.num_rows() == 0)
    left_out.push_back("factorization: no constraints");
  else if (work_.constraints.gradients_are_constant())
    left_out.push_back("refactorization: K is constant");
  const bool is_general = plan->linear_solvers == std::vector{LinearSolver::General};
  if (plan->linear_solvers == std::vector{LinearSolver::ClosedForm} ||
      (is_general && plan->factorizations == std::vector{Factorization::ClosedForm}))
    left_out.push_back("sparse factorization: closed form, row by row");
  if (work_.constraints.gradient_norms_are_constant())
    left_out.push_back("rescaling of the equations: their sizes do not change");
  if (!work_.constraints.depends_on_time()) left_out.push_back("moving constraints: none depends on time");
}

Reactions MultiplierForm::no_reactions() const {
  Reactions none;
  none.lambda.resize(model_.num_rows());
  if (contacts_ != nullptr) none.friction.resize(3 * work_.constraints.tangents().size());
  return none;
}

void MultiplierForm::write_friction(const Reactions& found, double* tau) const {
  if (contacts_ != nullptr) return contacts_->write_points(found.friction.data(), tau);
  std::fill(tau, tau + size(), 0.0);
}

Outcome MultiplierForm::begin(double t, const double* r, double* v, const Request& request,
                              const AccelerationOutput& to) {
  if (unilateral_ != nullptr) return unilateral_->begin(t, r, v, request, to);
  if (contacts_ != nullptr) return solve_together(to, [&] { return contacts_->begin(t, r, v, request, to); });
  return accelerations({t, r, v}, request.evaluated_anew(), to);
}

/// Exchanges initial guesses of iterations, and decisions made earlier in the motion.
void MultiplierForm::exchange_memory(Memory& memory) {
  work_.exchange_memory(memory);
  memory.exchange(dynamics_.multipliers());
  steps_.exchange_memory(memory);
  linearization_.exchange_memory(memory);
  if (contacts_ != nullptr) contacts_->exchange_memory(memory);
  if (unilateral_ != nullptr) unilateral_->exchange_memory(memory);
}

ErrorRatios MultiplierForm::error_ratios(double, const StepErrors& errors, double atol, double rtol) {
  StepErrors left = errors;
  if (work_.joints.allows_rounding() && !errors.are_of_projections) {
    // Remove the part that constraints take from errors, e - M^-1 K S^-1 K'e, since it is mostly rounding.
    const auto take = [&](const double* error, std::vector<double>* left) {
      left->assign(error, error + size());
      if (model_.num_rows() == 0) return left->data();
      linearization_.apply_transposed(left->data(), nullptr, rows_.data());
      linearization_.correct(rows_.data(), left->data());
      return left->data();
    };
    left.x = take(errors.x, &error_x_);
    left.v = take(errors.v, &error_v_);
  }
  // Errors of guests count where their owners are.
  left.x = work_.team().without_guests(left.x, &error_x_);
  left.v = work_.team().without_guests(left.v, &error_v_);
  return largest_of_all(work_.error_ratios(left, atol, rtol));
}

ProjectionReport MultiplierForm::project_point_positions(double t, double* r) {
  if (unilateral_ != nullptr) (void)unilateral_->close_touching(t, r, StartMode::Project);
  if (Outcome outcome = linearization_.update(t, r); !outcome.ok()) return {std::move(outcome)};
  return projector_.project_positions(t, r);
}

ProjectionReport MultiplierForm::project_point_velocities(double t, const double* r, double* v) {
  if (unilateral_ != nullptr) (void)unilateral_->close_touching(t, r, StartMode::Project);
  if (Outcome outcome = linearization_.update(t, r); !outcome.ok()) return {std::move(outcome)};
  return projector_.project_velocities(t, r, v);
}

StartReport MultiplierForm::start(double t, double* r, double* v, StartMode mode) {
  corners_->choose_sides(t, r, v);
  StartReport report = ConsistentStart(work_, linearization_, projector_, unilateral_.get()).find(t, r, v, mode);
  if (report.outcome.ok()) report.outcome = work_.team().check_start(*this, {t, r, v});
  return report;
}

void MultiplierForm::resume(const Counters& counters, const PhaseTimes& times) {
  steps_.forget_steps();
  work_.counters = counters;
  work_.times = times;
}

Roles MultiplierForm::roles_here() {
  Roles roles = common_roles();
  roles.step_projector = &steps_;
  roles.inexact_solves = linearization_.reuse();
  if (work_.team().may_lose_rank(model_.may_lose_rank)) roles.rank_monitor = &gradient_rank_;
  if (has_no_friction_but_viscous_ && work_.team().is_alone()) {
    // The state of other friction depends on the last call, so extra calls are ruled out with it.
    roles.rounding_groups = rounding();
    if (unilateral_ == nullptr) roles.implicit_formulation = &implicit_;
  }
  if (contacts_ != nullptr) roles.events = contacts_->events();
  if (unilateral_ != nullptr) roles.events = unilateral_.get();
  if (!corners_->empty()) roles.corners = corners_.get();
  return roles;
}

SeriesExpansion* MultiplierForm::series_here(std::string* why_not) {
  if (series_ == nullptr) series_ = std::make_unique<MultiplierSeries>(work_, linearization_);
  if (why_not != nullptr) *why_not = series_->obstacle();
  return series_->obstacle().empty() ? series_.get() : nullptr;
}

}  // namespace tanor::detail
