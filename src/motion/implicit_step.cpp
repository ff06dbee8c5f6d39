#include "motion/implicit_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/check.hpp"

namespace tanor {

ImplicitStep::ImplicitStep(const MotionOptions& options, Mechanics& given)
    : mechanics(given),
      equations(given.make_implicit_equations()),
      newton(options.rtol),
      options_(options),
      y_(given.size()),
      mu_(equations == nullptr ? 0 : equations->num_multipliers()) {
  ensure(equations != nullptr, "implicit methods step in normal form");
}

bool ImplicitStep::prepare(const State& from, double h, const double* lambda) {
  constexpr double same = 0.01;  // as good as the same step
  const bool linearises = !is_linearised_ || renew_;
  if (linearises) {
    equations->linearise(from.t, from.x.data(), from.v.data(), lambda);
    linearised_at_ = from.t;
    is_linearised_ = true;
    renew_ = false;
  }
  const bool factorizes = linearises || std::abs(factorized_for_ - h) > same * h;
  if (factorizes) factorized_for_ = h;
  newton.begin(!factorizes);
  return factorizes;
}

bool ImplicitStep::may_renew(const State& from) {
  renew_ = linearised_at_ != from.t;
  return renew_;
}

void ImplicitStep::note_convergence() {
  constexpr double slow = 0.05;
  renew_ = newton.rate() > slow;
}

StepResult ImplicitStep::finish(State* to) {
  mechanics.prescribe(to->t, to->x.data(), to->v.data());
  if (options_.stabilisation == Stabilisation::Projection && equations->num_multipliers() > 0) put_onto_constraints(to);
  return settle(mechanics, options_.stabilisation, to);
}

/// N y = K mu, K'y = -xi, x += y, and the same of v: chord iterations with the K of the linearisation.
void ImplicitStep::put_onto_constraints(State* to) {
  constexpr double target = 1e-13;
  constexpr int most_iterations = 10;
  const auto iterate = [&](std::vector<double>& moved, const auto& violation) {
    double before = std::numeric_limits<double>::infinity();
    for (int k = 0; k < most_iterations; ++k) {
      const double now = violation();
      if (!(now > target) || !(now < 0.5 * before)) return;
      before = now;
      std::fill(y_.begin(), y_.end(), 0.0);
      for (double& row : mu_) row = -row;
      equations->solve(y_.data(), mu_.data());
      for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += y_[i];
    }
  };
  iterate(to->x, [&] { return equations->evaluate_positions(to->t, to->x.data(), mu_.data()); });
  iterate(to->v, [&] { return equations->evaluate_rates(to->t, to->x.data(), to->v.data(), mu_.data()); });
}

}  // namespace tanor
