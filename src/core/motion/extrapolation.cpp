#include "motion/extrapolation.hpp"

#include "base/text.hpp"
#include "motion/singular_thresholds.hpp"

namespace tanor::detail {

namespace {

/// The polynomial x(t0 + u p) = x + p v u + b2 u^2 + … + b5 u^5 of one variable; p is the time between the two states.
struct Polynomial {
  double b2, b3, b4, b5;

  double move(double u) const { return u * u * (b2 + u * (b3 + u * (b4 + u * b5))); }
  double rate(double u) const { return u * (2.0 * b2 + u * (3.0 * b3 + u * (4.0 * b4 + u * 5.0 * b5))); }
  double curvature(double u) const { return 2.0 * b2 + u * (6.0 * b3 + u * (12.0 * b4 + u * 20.0 * b5)); }
};

}  // namespace

void Extrapolation::follow(const State& before, const State& from, bool follows_quintic, State* to) {
  const std::size_t n = from.x.size();
  const double p = from.t - before.t, h = to->t - from.t, u = h / p;
  for (std::vector<double>* array : {&x_error_, &v_error_, &kept_}) array->resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    // The remainders of the first terms at u = -1
    const double b2 = 0.5 * p * p * from.a[i];
    const double v = p * (before.v[i] - from.v[i]) + 2.0 * b2;
    Polynomial best, other;
    if (follows_quintic) {
      const double x = before.x[i] - (from.x[i] - p * from.v[i] + b2), a = p * p * (before.a[i] - from.a[i]);
      const double b3 = -0.5 * (a + 8.0 * v + 20.0 * x), b5 = v + 4.0 * x + b3;
      best = {b2, b3, x + b3 + b5, b5};
      other = {b2, -v - 4.0 * x, -v - 3.0 * x, 0.0};
    } else {
      best = {b2, v / 3.0, 0.0, 0.0};
      other = {b2, 0.0, 0.0, 0.0};
    }
    to->x[i] = from.x[i] + h * from.v[i] + best.move(u);
    to->v[i] = from.v[i] + best.rate(u) / p;
    to->a[i] = best.curvature(u) / (p * p);
    x_error_[i] = best.move(u) - other.move(u);
    v_error_[i] = (best.rate(u) - other.rate(u)) / p;
  }
}

/// Returns true if the velocity that the constraints allow differs from the expected one.
bool Extrapolation::turns_away(Mechanics& mechanics, const std::vector<double>& found) const {
  double difference = 0.0, size = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    difference += (found[i] - kept_[i]) * (found[i] - kept_[i]);
    size += kept_[i] * kept_[i];
  }
  return mechanics.sum(difference) > singular::turn * singular::turn * mechanics.sum(size);
}

/// Projects the end onto the constraints, whose K determines the motion again.
StepResult Extrapolation::stabilize_end(Mechanics& mechanics, const IntegrationOptions& options, const State& from,
                                        State* to) {
  StepResult result;
  if (result.outcome = mechanics.linearise(to->t, to->x.data()); !result.outcome.ok()) return result;
  kept_ = to->v;
  result = stabilize(mechanics, options, to, MovedVelocity::IsError);
  if (result.outcome.ok() && turns_away(mechanics, to->v)) {
    result.outcome = {Status::Singular, "constraints depend on each other near t = " + text(from.t) +
                                            ", and no motion goes on smoothly from there"};
  }
  return result;
}

StepResult Extrapolation::step(Mechanics& mechanics, const IntegrationOptions& options, const State& before,
                               const State& from, const How& how, State* to) {
  follow(before, from, how.follows_quintic, to);
  const double p = from.t - before.t, h = to->t - from.t;
  StepResult result;
  if (how.ends_at_singularity) {
    mechanics.prescribe(to->t, to->x.data(), to->v.data());
    if (options.stabilisation == Stabilisation::Projection) {
      // The K of `from` corrects what the polynomial missed, and moves little along the direction that vanishes here.
      kept_ = to->x;
      const ProjectionReport positions = mechanics.project_positions(to->t, to->x.data(), Turn::Small);
      if (!positions.outcome.ok()) to->x = kept_;
    }
    to->power = from.power;
    to->report = from.report;
    to->reactions = from.reactions;
    result.is_stabilized = false;
  } else {
    result = stabilize_end(mechanics, options, from, to);
    if (!result.outcome.ok()) return result;
  }
  result.is_interpolated = false;
  const StepErrors errors{x_error_.data(), v_error_.data(), from.x.data(), from.v.data(), to->x.data(), to->v.data()};
  result.error = larger(result.error, mechanics.error_ratios(from.t, errors, options.atol, options.rtol).largest());

  // Weights of the parabola through the powers at u = -1, at 0 and at the end
  const double w_before = -h * h / (6.0 * p * (p + h)), w_from = (h + 3.0 * p) / (6.0 * p),
               w_to = (2.0 * h + 3.0 * p) / (6.0 * (p + h));
  to->work = from.work;
  to->work.add(h * w_before, before.power);
  to->work.add(h * w_from, from.power);
  to->work.add(h * w_to, to->power);
  return result;
}

}  // namespace tanor::detail
