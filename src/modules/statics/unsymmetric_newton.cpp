#include "statics/unsymmetric_newton.hpp"

#include <algorithm>
#include <cmath>

#include "base/numbers.hpp"

namespace tanor::detail {

UnsymmetricNewton::UnsymmetricNewton(EquilibriumEquations& equations, NewtonDescent& measure)
    : equations_(equations), model_(equations.model()), measure_(measure), kkt_(equations) {}

/// Evaluates W, K, g and xi at a state; returns the largest single force, N.
double UnsymmetricNewton::linearise(const StaticState& state) {
  equations_.linearise(state.r.data(), state.lambda.data());
  return equations_.evaluate(state.r.data(), state.lambda.data(), g_.data(), xi_.data());
}

/// [ W  K ] [  dr     ]   [  g  ]
/// [ K' 0 ] [ -dlambda] = [ -xi ]
bool UnsymmetricNewton::find_step(double shift, std::vector<double>* dr, std::vector<double>* minus_dlambda) {
  ++factorizations_;
  if (!kkt_.factorize(shift)) return false;
  *dr = g_;
  minus_dlambda->resize(equations_.num_rows());
  for (std::size_t a = 0; a < minus_dlambda->size(); ++a) (*minus_dlambda)[a] = -xi_[a];
  kkt_.solve(dr, minus_dlambda);
  const auto is_finite = [](double x) { return std::isfinite(x); };
  return std::ranges::all_of(*dr, is_finite) && std::ranges::all_of(*minus_dlambda, is_finite);
}

/// Returns the length of Newton's next step, m, or 0 if there is none.
double UnsymmetricNewton::find_next_step(const StaticState& state) {
  const double scale = linearise(state);
  equations_.stiffness().hold_rows(held_rows, held_rows * scale / model_.scene_size);
  std::vector<double> dr, minus_dlambda;
  return find_step(0.0, &dr, &minus_dlambda) ? longest(dr) : 0.0;
}

Outcome UnsymmetricNewton::run(const NewtonLimits& limits, StaticState* state, std::vector<double>* residuals) {
  g_.resize(equations_.size());
  xi_.resize(model_.num_rows());
  const auto combined = [](const StaticResidual& at, double scale) {
    return (scale > 0.0 ? at.force / scale : at.force) + at.violation;
  };
  iterations_ = factorizations_ = 0;
  double shift = 0.0;
  int long_steps = 0;
  StaticResidual now = measure_.measure(*state);
  const double first_scale = now.scale;
  const auto fail = [&](const char* why) { return explain_failure(model_, now, iterations_, why); };
  for (;;) {
    residuals->push_back(now.force);
    if (!std::isfinite(now.force + now.scale + now.violation)) return explain_not_finite(model_, now, iterations_);
    // A single force that vanishes at equilibrium has no scale there. It is compared with the scale at the start, and
    // must be known to act near the equilibrium.
    const double force = iterations_ > 0 ? now.known : now.force;  // rounding is known after W was evaluated
    const bool is_small = force <= limits.force_tolerance * now.scale, is_faint = force <= 64.0 * eps * first_scale;
    if ((is_small || is_faint) && now.violation < 1e-10) {
      next_move_ = now.force == 0.0 ? 0.0 : find_next_step(*state);
      if (next_move_ <= (is_small ? short_step : limits.force_tolerance) * model_.scene_size) return {};
      if (next_move_ > short_step * model_.scene_size && ++long_steps == most_long_steps)
        return explain_fading(model_, now, iterations_);
    }
    if (iterations_++ == limits.max_iterations) return fail("no convergence");
    std::vector<double> dr, minus_dlambda;
    bool is_better = false;
    (void)linearise(*state);
    for (int attempt = 0; attempt < 40 && !is_better; ++attempt) {
      const bool is_found = find_step(shift, &dr, &minus_dlambda);
      for (double length = 1.0; is_found && !is_better && length > 1e-3; length *= 0.5) {
        StaticState next = *state;
        for (std::size_t i = 0; i < equations_.size(); ++i) next.r[i] += length * dr[i];
        for (std::size_t a = 0; a < equations_.num_rows(); ++a) next.lambda[a] -= length * minus_dlambda[a];
        const StaticResidual found = measure_.measure(next);
        is_better = combined(found, now.scale) < (1.0 - 1e-4 * length) * combined(now, now.scale);
        if (!is_better) continue;
        *state = std::move(next);
        now = found;
      }
      const double mass = *std::ranges::max_element(model_.mass);
      const double frequency2 = equations_.stiffness().largest() / mass + 1e-300;
      shift = is_better ? (shift > 1e-12 * frequency2 ? 0.1 * shift : 0.0) : std::max(10.0 * shift, 1e-6 * frequency2);
    }
    if (!is_better) return fail("the search stalls");
  }
}

}  // namespace tanor::detail
