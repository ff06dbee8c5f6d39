#include "motion/generalized_alpha.hpp"

#include <limits>

#include "base/text.hpp"

namespace tanor::detail {

GeneralizedAlpha::GeneralizedAlpha(const IntegrationOptions& options, Mechanics& mechanics)
    : options_(options),
      implicit_(options, mechanics),
      mechanics_(mechanics),
      equations_(*implicit_.equations),
      own_(mechanics.size()),
      next_own_(mechanics.size()),
      lambda_(equations_.num_rows()),
      residual_(mechanics.size()),
      rows_(equations_.num_rows()),
      v_increment_(mechanics.size()) {
  const double rho = options.spectral_radius;
  alpha_m_ = (2.0 * rho - 1.0) / (rho + 1.0);
  alpha_f_ = rho / (rho + 1.0);
  gamma_ = 0.5 + alpha_f_ - alpha_m_;
  beta_ = 0.25 * (gamma_ + 0.5) * (gamma_ + 0.5);
}

StepResult GeneralizedAlpha::step(const State& from, double h, State* to) {
  StepResult result;
  const bool goes_on = knows_own_ && own_time_ == from.t;
  if (!goes_on) {
    own_ = from.a;
    equations_.write_multipliers(from.reactions, from.x.data(), from.v.data(), lambda_.data());
  }
  // The first guess of b_1 is b_0.
  for (std::size_t k = 0; k < to->x.size(); ++k) to->x[k] = from.x[k] + h * (from.v[k] + 0.5 * h * own_[k]);
  to->v = from.v;
  mechanics_.prescribe(to->t, to->x.data(), to->v.data());
  if (result.outcome = solve_step(from, h, to); !result.outcome.ok()) {
    implicit_.renew();
    return result;
  }
  implicit_.note_convergence();
  to->work = from.work;
  result = implicit_.finish(to, MovedVelocity::IsNoError);
  if (!result.outcome.ok()) return result;
  if (mechanics_.has_work()) {
    // The trapezoidal rule has the scheme's order.
    to->work.add(0.5 * h, from.power);
    to->work.add(0.5 * h, to->power);
  }
  std::swap(own_, next_own_);
  own_time_ = to->t;
  knows_own_ = true;
  return result;
}

/// Iterates with the present matrix. If that stalls, makes a new matrix at the state that the iteration reached.
Outcome GeneralizedAlpha::solve_step(const State& from, double h, State* to) {
  constexpr int most_renewals = 2;
  for (int renewals = 0;; ++renewals) {
    if (implicit_.wants_linearisation()) implicit_.linearise(to->t, to->x.data(), to->v.data(), lambda_.data());
    if (implicit_.wants_factors(from, h)) {
      // dw/dr = (1 - alpha_m)/((1 - alpha_f) beta h^2), dv/dr = gamma/(beta h)
      const NewtonWeights<double> weights{(1.0 - alpha_m_) / ((1.0 - alpha_f_) * beta_ * h * h), gamma_ / (beta_ * h),
                                          1.0};
      if (Outcome found = implicit_.factorize(weights); !found.ok()) return found;
    }
    bool converged = false;
    if (Outcome found = iterate(from, h, to, &converged); !found.ok()) return found;
    if (converged) return {};
    if (renewals == most_renewals)
      return {Status::NotConverged, "Newton's iteration of the step from t = " + text(from.t) + " stalls"};
    implicit_.renew();
  }
}

Outcome GeneralizedAlpha::iterate(const State& from, double h, State* to, bool* converged) {
  const std::size_t n = from.x.size();
  for (;;) {
    for (std::size_t k = 0; k < n; ++k) {
      next_own_[k] = ((to->x[k] - from.x[k] - h * from.v[k]) / (h * h) - (0.5 - beta_) * own_[k]) / beta_;
      to->v[k] = from.v[k] + h * ((1.0 - gamma_) * own_[k] + gamma_ * next_own_[k]);
    }
    mechanics_.prescribe(to->t, to->x.data(), to->v.data());
    Outcome found =
        implicit_.evaluate(to->t, to->x.data(), to->v.data(), lambda_.data(), residual_.data(), rows_.data());
    if (!found.ok()) return found;
    // M^-1 (f + K lambda) - w_1
    for (std::size_t k = 0; k < n; ++k) {
      residual_[k] -= ((1.0 - alpha_m_) * next_own_[k] + alpha_m_ * own_[k] - alpha_f_ * from.a[k]) / (1.0 - alpha_f_);
    }
    (void)implicit_.evaluate_positions(to->t, to->x.data(), rows_.data());
    equations_.solve(residual_.data(), rows_.data());
    for (std::size_t k = 0; k < n; ++k) {
      to->x[k] += residual_[k];
      v_increment_[k] = gamma_ / (beta_ * h) * residual_[k];
    }
    for (std::size_t a = 0; a < rows_.size(); ++a) lambda_[a] += rows_[a];
    const double increment = measure(from, *to);
    const NewtonIteration::Verdict verdict = implicit_.newton.check(increment);
    if (verdict == NewtonIteration::Verdict::GoOn) continue;
    for (std::size_t k = 0; k < n; ++k) {
      next_own_[k] += residual_[k] / (beta_ * h * h);
      to->v[k] += v_increment_[k];
    }
    *converged = verdict == NewtonIteration::Verdict::Converged || increment <= measure_rounding(from, h, *to);
    return {};
  }
}

/// Returns the size, over the tolerance, of increments that are only rounding of x and do not shrink: a few eps |x|,
/// and gamma/(beta h) times as much in v.
double GeneralizedAlpha::measure_rounding(const State& from, double h, const State& to) {
  constexpr double rounding = 8.0 * std::numeric_limits<double>::epsilon();
  for (std::size_t k = 0; k < to.x.size(); ++k) {
    residual_[k] = rounding * to.x[k];
    v_increment_[k] = gamma_ / (beta_ * h) * residual_[k];
  }
  return measure(from, to);
}

/// Returns the size of the increments over the tolerance.
double GeneralizedAlpha::measure(const State& from, const State& to) {
  return mechanics_
      .error_ratios(from.t,
                    {residual_.data(), v_increment_.data(), from.x.data(), from.v.data(), to.x.data(), to.v.data()},
                    options_.atol, options_.rtol)
      .largest();
}

}  // namespace tanor::detail
