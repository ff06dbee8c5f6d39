#include "dynamics/tangent_dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/numbers.hpp"
#include "base/stopwatch.hpp"
#include "schur/refinement.hpp"

namespace tanor::detail {

TangentDynamics::TangentDynamics(Workspace& work, TangentLinearization& linearization)
    : work_(work),
      model_(work.model()),
      linearization_(linearization),
      has_closed_form_(work.coordinates.has_closed_form()) {
  for (std::vector<double>* array : {&last_q_, &last_q_dot_, &last_q_ddot_, &columns_})
    array->resize(work.coordinates.num_coordinates());
  for (std::vector<double>* array : {&w_, &w0_, &points_}) array->resize(3 * model_.num_points(), 0.0);
}

Outcome TangentDynamics::solve(const Kinematics& at, const Request& request, const AccelerationOutput& to) {
  Outcome outcome = find(at, request, to.a);
  if (to.report != nullptr) {
    *to.report = report_;
    to.report->reciprocal_condition = linearization_.reciprocal_condition();
  }
  if (to.power != nullptr && outcome.ok()) *to.power = find_power();
  if (to.reactions != nullptr && outcome.ok()) {
    to.reactions->lambda = friction_found_.lambda;
    to.reactions->friction = friction_found_.friction;
    std::swap(to.reactions->w, w_);  // w_ is scratch from here on
    w_.resize(3 * model_.num_points());
    to.reactions->knows_w0 = false;
  }
  return outcome;
}

Outcome TangentDynamics::find(const Kinematics& at, const Request& request, double* q_ddot) {
  const auto [t, q, q_dot] = at;
  ++work_.counters.evaluations;
  const bool is_exact = model_.is_exact_for(request);
  const bool has_closed_form = !is_exact && friction_ == nullptr && has_closed_form_;
  if (has_closed_form && solve_in_closed_form(at, q_ddot)) {
    remember(at);
    return {};
  }
  double scale = 0.0;
  {
    const Stopwatch watch(&work_.times.evaluate);
    linearization_.evaluate(t, q, q_dot, true);
    scale = larger(work_.evaluate_free(t, linearization_.r().data(), linearization_.v().data(), w0_.data()),
                   model_.largest_norm(linearization_.psi().data()));
  }
  if (!std::isfinite(scale)) return work_.not_finite(t, linearization_.r().data());
  if (Outcome outcome = find_friction(t, request); !outcome.ok()) return outcome;
  add_friction(friction_found_, w0_.data());
  report_.residual = 0.0;
  report_.refinements = 0;
  if (Outcome outcome = linearization_.factorize(t); !outcome.ok()) return outcome;
  refine(scale, is_exact, q_ddot);
  remember(at);
  std::copy(q_ddot, q_ddot + size(), last_q_ddot_.begin());
  return std::isfinite(report_.residual) ? Outcome{} : work_.not_finite(t, linearization_.r().data());
}

/// Refines in w: rho = A'(M w - f) from w = psi on, q_ddot -= H^-1 rho, w likewise. A well conditioned H needs no
/// second pass, since its error over the largest acceleration is at most good_enough(false).
void TangentDynamics::refine(double scale, bool exact, double* q_ddot) {
  const Stopwatch watch(&work_.times.solve);
  const double enough = exact ? 4.0 * eps : good_enough(false);
  std::fill(q_ddot, q_ddot + size(), 0.0);
  w_ = linearization_.psi();
  const double first = correct(q_ddot);
  report_.residual = eps / linearization_.reciprocal_condition();
  double correction = std::numeric_limits<double>::infinity();  // the first correction is all of w and does not count
  report_.refinements = refine_solution(
      RefinementLimits{4}, [&] { return correction; }, [&](double) { return report_.residual <= enough; },
      [&](int) {
        correction = correct(q_ddot);
        report_.residual = relative_correction(correction, scale);
      });
  if (const double last = report_.refinements > 0 ? correction : first; !std::isfinite(last)) report_.residual = last;
}

/// Solves in closed form where every member moves a point of its own. Returns false if H looks singular, or A'M
/// (w - w0) may be too large.
bool TangentDynamics::solve_in_closed_form(const Kinematics& at, double* q_ddot) {
  const auto [t, q, q_dot] = at;
  const Vec3* const uniform = model_.uniform_free();
  const Stopwatch watch(&work_.times.solve);
  if (uniform == nullptr) {
    linearization_.evaluate(t, q, q_dot, false);
    (void)work_.evaluate_free(t, linearization_.r().data(), linearization_.v().data(), w0_.data());
  } else {
    linearization_.prescribe(t);
  }
  work_.write_support_accelerations(t, w_.data());
  const double condition =
      work_.coordinates.accelerate(model_.parallel, q, q_dot, w0_.data(), uniform, q_ddot, w_.data());
  report_.residual = eps * condition;
  report_.refinements = 0;
  if (!(report_.residual <= good_enough(false))) return false;
  ++work_.counters.factorizations;
  ++work_.counters.solves;
  linearization_.leave_out_blocks(1.0 / condition);
  return true;
}

void TangentDynamics::complete() {
  if (linearization_.has_blocks()) return;
  const Stopwatch watch(&work_.times.evaluate);
  const double now = work_.time();
  linearization_.evaluate(t_, last_q_.data(), last_q_dot_.data(), true);
  (void)work_.evaluate_free(t_, linearization_.r().data(), linearization_.v().data(), w0_.data());
  linearization_.factorize_again();
  (void)work_.coordinates.accelerate(model_.parallel, last_q_.data(), last_q_dot_.data(), w0_.data(), nullptr,
                                     last_q_ddot_.data(), points_.data());
  if (now != t_) work_.set_time(now);
}

void TangentDynamics::complete(Reactions* found) {
  complete();
  found->w0 = w0_;
  found->knows_w0 = true;
}

void TangentDynamics::remember(const Kinematics& at) {
  t_ = at.t;
  std::copy(at.x, at.x + size(), last_q_.begin());
  std::copy(at.v, at.v + size(), last_q_dot_.begin());
}

/// Returns the largest ratio of the last correction of w to the accelerations of its neighbourhood. `correction` and
/// `scale` are the largest of all points.
double TangentDynamics::relative_correction(double correction, double scale) const {
  if (!(scale > 0.0)) return 0.0;
  if (work_.scales.are_one()) return correction / scale;
  const std::vector<double> changes = work_.largest_norms(points_.data()), free = work_.largest_norms(w0_.data()),
                            psi = work_.largest_norms(linearization_.psi().data());
  double worst = 0.0;
  for (std::size_t k = 0; k < changes.size(); ++k) {
    const double own = std::max(free[k], psi[k]);
    if (changes[k] > 0.0) worst = larger(worst, own > 0.0 ? changes[k] / own : 1.0);
  }
  return worst;
}

Outcome TangentDynamics::find_friction(double t, const Request& request) {
  if (friction_ == nullptr) return {};
  friction_w_.resize(w0_.size());
  return friction_->accelerations({t, linearization_.r().data(), linearization_.v().data()}, request.evaluated_anew(),
                                  {friction_w_.data(), nullptr, &report_, &friction_found_});
}

/// Adds M^-1 tau to w0.
void TangentDynamics::add_friction(const Reactions& found, double* w0) {
  if (friction_ == nullptr) return;
  tau_.resize(w0_.size());
  friction_->write_friction(found, tau_.data());
  for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) w0[i] += model_.inverse_mass[i / 3] * tau_[i];
}

void TangentDynamics::write_place_along(double h, double* r) {
  complete();
  std::vector<double> q(size()), rates(3 * model_.num_points());
  for (std::size_t j = 0; j < size(); ++j) q[j] = last_q_[j] + h * last_q_dot_[j] + 0.5 * h * h * last_q_ddot_[j];
  work_.set_time(t_ + h);
  work_.prescribe_all(t_ + h, r, rates.data());
  work_.coordinates.evaluate(model_.parallel, q.data(), last_q_dot_.data(), r, nullptr, nullptr, nullptr);
}

/// Computes q_ddot -= H^-1 A'(M w - f), and w likewise. Returns the largest change of w.
double TangentDynamics::correct(double* q_ddot) {
  const Parallel& parallel = model_.parallel;
  ++work_.counters.solves;
  parallel.for_ranges(model_.num_moving(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      store(points_.data(), i, model_.mass[i] * (load(w_.data(), i) - load(w0_.data(), i)));
    }
  });
  linearization_.apply_transposed(points_.data(), columns_.data());
  linearization_.solve_negative(columns_.data());
  for (std::size_t j = 0; j < size(); ++j) q_ddot[j] += columns_[j];
  linearization_.apply(columns_.data(), points_.data());
  return parallel.max_over_ranges(model_.num_moving(), [&](std::size_t begin, std::size_t end) {
    double worst = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 change = load(points_.data(), i);
      store(w_.data(), i, load(w_.data(), i) + change);
      worst = larger(worst, dot(change, change));
    }
    return std::sqrt(worst);
  });
}

Power TangentDynamics::find_power() {
  if (!has_work()) return {};
  complete();
  // M^-1 eta = w - w0
  for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) points_[i] = w_[i] - w0_[i];
  const double *const r = linearization_.r().data(), *const v = linearization_.v().data();
  Power result = work_.power(work_.power_of_reactions(points_.data(), v), {t_, r, v});
  if (friction_ == nullptr) return result;
  for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) result.friction += tau_[i] * v[i];
  return result;
}

void TangentDynamics::write_friction(const Reactions& found, double* tau) const {
  if (friction_ != nullptr) return friction_->write_friction(found, tau);
  std::fill(tau, tau + 3 * model_.num_points(), 0.0);
}

void TangentDynamics::write_reactions(const Kinematics& at, const Reactions& found, double* eta) {
  const double* w0 = found.w0.data();
  if (!found.knows_w0) {
    linearization_.evaluate(at.t, at.x, at.v, false);
    (void)work_.evaluate_free(at.t, linearization_.r().data(), linearization_.v().data(), points_.data());
    add_friction(found, points_.data());
    w0 = points_.data();
  }
  // eta = M w - f (24). The reactions of coordinates at their supports are opposite to those at their points.
  std::fill(eta, eta + 3 * model_.num_points(), 0.0);
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    store(eta, i, model_.mass[i] * (load(found.w.data(), i) - load(w0, i)));
  }
  work_.coordinates.add_support_reactions(eta);
}

/// Exchanges the memory of friction.
void TangentDynamics::exchange_memory(Memory& memory) {
  if (friction_ != nullptr) friction_->exchange_memory(memory);
}

}  // namespace tanor::detail
