#include "motion/stiff_steps.hpp"

#include <memory>
#include <string>

#include "base/text.hpp"

namespace tanor::detail {

StiffSteps::StiffSteps(const IntegrationOptions& options, Mechanics& mechanics, Method explicit_method)
    : options_(options),
      mechanics_(mechanics),
      explicit_method_(explicit_method),
      may_look_(options.method == Method::Auto && mechanics.implicit_formulation() != nullptr &&
                mechanics.all(mechanics.implicit_formulation()->matrix_knows_all_forces()) &&
                (explicit_method == Method::Taylor || explicit_method == Method::Dop853)) {}

bool StiffSteps::is_due(double h, double left) const {
  constexpr double few_to_come = 2000.0, few_taken = 500.0;
  if (!may_look_ || is_stiff_ || num_steps_ < next_look_ || left < 2.0 * factor * h) return false;
  return left > few_to_come * h || num_steps_ >= few_taken;
}

bool StiffSteps::look(const State& from, double h, Rounding rounding) {
  next_look_ = 4.0 * num_steps_;
  const std::unique_ptr<Scheme> implicit = make_scheme(Method::Radau5, options_, mechanics_);
  rounding.allow(from, factor * h, implicit->rounding_gain());
  to_ = from;
  to_.t = from.t + factor * h;
  const StepResult trial = implicit->step(from, factor * h, &to_);
  is_stiff_ = trial.outcome.ok() && trial.error <= 1.0;
  if (is_stiff_) {
    since_ = from.t;
    explicit_step_ = h;
  }
  return is_stiff_;
}

bool StiffSteps::gives_up(double next_step) {
  if (!is_stiff_ || next_step > 0.5 * explicit_step_) return false;
  is_stiff_ = may_look_ = false;
  return true;
}

std::string StiffSteps::explain() const {
  return "stiff: from t = " + text(since_) + " on, stability holds steps of " + std::string(name_of(explicit_method_)) +
         " at " + text(explicit_step_) + ", where radau5 takes " + text(factor) + " times as long ones";
}

}  // namespace tanor::detail
