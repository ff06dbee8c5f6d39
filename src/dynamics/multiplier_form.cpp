#include "dynamics/multiplier_form.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/consistent_start.hpp"

namespace tanor {

MultiplierForm::MultiplierForm(Model& model, const SolverOptions& options)
    : model_(model),
      linearization_(model, options, &last_),
      residuals_(model, linearization_.blocks()),
      projector_(model, linearization_, residuals_),
      dynamics_(model, linearization_, residuals_, &last_),
      steps_(model, linearization_, projector_, dynamics_),
      gradient_rank_(model, linearization_),
      passages_(model),
      drives_(model),
      rounding_(model),
      implicit_(model, dynamics_.multipliers()),
      rows_(num_rows()),
      lambda_(dynamics_.multipliers()) {
  if (!model.has_friction()) return;
  friction_ = std::make_unique<FrictionStage>(model, options.friction, linearization_.blocks(),
                                              [this](const double* b, double* x, bool refines) {
                                                // A compliant factor alone is no answer.
                                                if (refines || is_compliant()) {
                                                  linearization_.solve_refined(b, x, points_.data());
                                                } else {
                                                  ++model_.counters.solves;
                                                  linearization_.solve_negative(b, x);
                                                }
                                                linearization_.minimize_multiplier_norm(x);
                                              });
  held_ = std::make_unique<HeldPlaces>(model);
  points_.resize(size());
  contact_rows_.resize(num_rows());
  const Tangents& tangents = model.constraints.tangents();
  for (std::size_t c = 0; c < tangents.size(); ++c) num_switches_ += tangents[c].first_row >= 0 ? 1 : 0;
  linearization_.set_contacts(this);
  projector_.set_friction(friction_.get(), num_switches_ > 0 ? held_.get() : nullptr);
  dynamics_.set_friction(friction_.get(), this);
  steps_.set_friction(friction_.get());
}

double MultiplierForm::predicted_flops() const {
  constexpr double flops_an_entry = 6.0, flops_a_row = 60.0;
  PlanSummary plan;
  linearization_.describe(&plan);
  return plan.factor_flops + 4.0 * static_cast<double>(plan.factor_nonzeros) +
         flops_an_entry * static_cast<double>(plan.pattern_nonzeros) + flops_a_row * static_cast<double>(num_rows());
}

std::string MultiplierForm::ordering() const {
  PlanSummary plan;
  linearization_.describe(&plan);
  return plan.ordering;
}

void MultiplierForm::describe(PlanSummary* plan) const {
  linearization_.describe(plan);
  auto& left_out = plan->left_out;
  if (num_rows() == 0)
    left_out.push_back("factorization: no constraints");
  else if (model_.constraints.gradients_are_constant())
    left_out.push_back("refactorization: K is constant");
  if (plan->factorization == "closed form") left_out.push_back("sparse factorization: closed form, row by row");
  if (model_.constraints.gradient_norms_are_constant()) left_out.push_back("rescaling of S: its diagonal is constant");
  if (!model_.constraints.depends_on_time()) left_out.push_back("xi_t terms: no constraint depends on time");
}

void MultiplierForm::friction_forces(double* tau) const {
  std::fill(tau, tau + size(), 0.0);
  if (friction_ != nullptr) friction_->add_all(lambda_.data(), tau);
}

void MultiplierForm::given_friction_forces(double* tau) const {
  std::fill(tau, tau + size(), 0.0);
  if (friction_ != nullptr) friction_->add_given(tau);
}

void MultiplierForm::evaluate_friction(const double* lambda, double* tau) {
  std::fill(tau, tau + size(), 0.0);
  friction_->add_at(lambda, tau);
}

Power MultiplierForm::power(const double* r, const double* v) {
  Power result = model_.power(dynamics_.reaction_accelerations().data(), r, v);
  if (friction_ == nullptr) return result;
  result.friction = friction_->power(lambda_.data(), v);
  // Of what M^-1 K lambda does, that part belongs to contacts that stick.
  if (model_.is_rheonomic()) result.supports -= friction_->held_power(lambda_.data(), v);
  return result;
}

/// What starts an iteration, or was decided where the motion has been.
void MultiplierForm::exchange_memory(Memory& memory) {
  model_.exchange_memory(memory);
  memory.exchange(lambda_);
  steps_.exchange_memory(memory);
  linearization_.exchange_memory(memory);
  if (friction_ == nullptr) return;
  memory.exchange(verdict_);
  held_->exchange_memory(memory);
  friction_->exchange_memory(memory);
}

ErrorRatios MultiplierForm::error_ratios(double, const StepErrors& errors, double atol, double rtol) {
  if (model_.joints.allows_rounding() && !errors.are_of_projections) {
    // e - M^-1 K S^-1 K'e: what constraints take is rounding most of all.
    const auto take = [&](const double* error, std::vector<double>* left) {
      left->assign(error, error + size());
      if (num_rows() == 0) return left->data();
      linearization_.apply_transposed(left->data(), nullptr, rows_.data());
      linearization_.correct(rows_.data(), left->data());
      return left->data();
    };
    StepErrors left = errors;
    left.x = take(errors.x, &error_x_);
    left.v = take(errors.v, &error_v_);
    return model_.error_ratios(left, atol, rtol);
  }
  return model_.error_ratios(errors, atol, rtol);
}

ProjectionReport MultiplierForm::project_point_positions(double t, double* r) {
  if (Outcome outcome = linearization_.update(t, r); !outcome.ok()) return {std::move(outcome)};
  return projector_.project_positions(t, r);
}

ProjectionReport MultiplierForm::project_point_velocities(double t, const double* r, double* v) {
  if (Outcome outcome = linearization_.update(t, r); !outcome.ok()) return {std::move(outcome)};
  return projector_.project_velocities(t, r, v);
}

Outcome MultiplierForm::set_state(double, const double* r, const double* v, double* x, double* x_dot) {
  std::copy(r, r + size(), x);
  std::copy(v, v + size(), x_dot);
  return {};
}

void MultiplierForm::write_points(double, const double* x, const double* x_dot, const double* x_ddot, double* r,
                                  double* v, double* w) {
  std::copy(x, x + size(), r);
  std::copy(x_dot, x_dot + size(), v);
  std::copy(x_ddot, x_ddot + size(), w);
}

StartReport MultiplierForm::start(double t, double* r, double* v, StartMode mode) {
  return ConsistentStart(model_, linearization_, projector_).find(t, r, v, mode);
}

void MultiplierForm::resume(const Counters& counters, const PhaseTimes& times) {
  steps_.forget_steps();
  model_.counters = counters;
  model_.times = times;
}

SeriesExpansion* MultiplierForm::series() {
  if (series_ == nullptr) series_ = std::make_unique<MultiplierSeries>(model_, linearization_, dynamics_);
  return series_->obstacle().empty() ? series_.get() : nullptr;
}

}  // namespace tanor
