#include "friction/friction_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/stopwatch.hpp"
#include "base/text.hpp"

namespace tanor::detail {

namespace {

constexpr double poor_contraction = 0.1;  // contraction above which Newton's method is used instead

/// Returns the depth of Anderson's method. It is deep where contacts are few, so that they are solved like a linear
/// system. It is shallow where vectors are long, since they would cost more than the iterations that they save.
int anderson_depth(std::size_t num_contacts) {
  return num_contacts <= 1000 ? FixedPoint::most_depth : 3;
}

}  // namespace

FrictionSolver::FrictionSolver(Workspace& work, FrictionLaws& laws, FrictionMethod method, ContactResponse& response)
    : work_(work),
      model_(work.model()),
      tangents_(work.constraints.tangents()),
      method_(method),
      response_(response),
      laws_(laws),
      islands_(work),
      coupling_(work, laws_),
      scales_(work, laws_),
      fixed_point_(laws_, scales_, *this, model_.num_rows()),
      sliding_(work, laws_, islands_, *this),
      right_side_(model_.num_rows()),
      b_touched_(coupling_.num_touched_rows()),
      change_(model_.num_rows(), 0.0),
      lambda_(model_.num_rows()),
      now_{std::vector<double>(laws_.num_parts(), 0.0), std::vector<double>(3 * tangents_.size(), 0.0)},
      before_(now_) {}

// ---- the response of S ----

/// Sets x and tau to the friction at lambda.
void FrictionSolver::set_forces(const double* lambda) {
  laws_.evaluate(model_.parallel, lambda, now_.x.data());
  laws_.write_forces(now_.x.data(), now_.tau.data());
}

void FrictionSolver::set_right_side(const double* b) {
  std::copy(b, b + right_side_.size(), right_side_.begin());
  coupling_.gather(b, b_touched_.data());
}

/// Computes lambda = -S^-1 (b + K'M^-1 tau(x)).
void FrictionSolver::find_multipliers(const double* x, double* lambda) {
  coupling_.write(b_touched_.data(), x, right_side_.data());
  if (refines_)
    response_.solve_refined(right_side_.data(), lambda, nullptr);
  else
    response_.solve_once(right_side_.data(), lambda);
  response_.minimize_multiplier_norm(lambda);
}

/// Computes lambda = -S^-1 K'M^-1 tau(x).
void FrictionSolver::find_change(const double* x, double* lambda) {
  coupling_.write(nullptr, x, change_.data());
  response_.solve_once(change_.data(), lambda);
  response_.minimize_multiplier_norm(lambda);
}

// ---- one instant ----

void FrictionSolver::set_place(const ContactPlace& place) {
  laws_.set_state(model_.parallel, place.t, place.r, place.v, place.blocks);
  coupling_.set_place(place.blocks);
}

Outcome FrictionSolver::find(const ContactPlace& place, const double* b, const UniquenessCheck& check,
                             const double* lambda) {
  const Stopwatch watch(&work_.times.friction);
  set_place(place);
  set_right_side(b);
  report_ = {.contacts = tangents_.size()};
  amplification_ = std::numeric_limits<double>::quiet_NaN();
  report_.sticking = num_sticking();
  std::copy(lambda, lambda + lambda_.size(), lambda_.begin());
  if (depends_on_multipliers()) {
    ++work_.counters.friction_solves;
    Outcome outcome = iterate(place.t, check, lambda, lambda_.data());
    if (outcome.ok() && check.is_wanted && report_.uniqueness == Uniqueness::NotAsked)
      outcome = sliding_.verify_uniqueness(place.t, check, lambda_.data(), &report_, &amplification_);
    work_.counters.friction_iterations += static_cast<std::size_t>(report_.iterations);
    if (!outcome.ok()) return outcome;
  } else if (check.is_wanted) {
    report_.uniqueness = Uniqueness::Proven;  // a given force
    amplification_ = 1.0;
  }
  set_forces(lambda_.data());
  return std::isfinite(largest_of(now_.x)) ? Outcome{} : model_.not_finite(place.t);
}

void FrictionSolver::set_given(const ContactPlace& place, const double* lambda) {
  set_place(place);
  laws_.evaluate(model_.parallel, lambda, now_.x.data());
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    if (laws_.is_coulomb(c))
      std::fill_n(now_.x.data() + laws_.first_part(c), laws_.end_part(c) - laws_.first_part(c), 0.0);
  }
  laws_.write_forces(now_.x.data(), now_.tau.data());
}

bool FrictionSolver::converges(FrictionMethod method, double poor, const double* guess, double* lambda) {
  const Parallel& parallel = model_.parallel;
  const int depth = method == FrictionMethod::Anderson ? anderson_depth(tangents_.size()) : 0;
  const FixedPoint::Result result = method == FrictionMethod::Newton
                                        ? fixed_point_.solve_by_newton(parallel, lambda)
                                        : fixed_point_.iterate(parallel, depth, lambda, poor);
  report_.method_used = method;
  report_.iterations += result.iterations;
  report_.contraction = std::max(report_.contraction, result.contraction);
  if (!result.has_converged) std::copy(guess, guess + lambda_.size(), lambda);
  return result.has_converged;
}

Outcome FrictionSolver::iterate(double t, const UniquenessCheck& check, const double* guess, double* lambda) {
  const bool are_few = tangents_.size() <= most_contacts_counted;
  using enum FrictionMethod;
  struct Attempt {
    FrictionMethod of, method;
    bool for_few, for_many;  // contacts
    double poor = std::numeric_limits<double>::infinity();
  };
  // A step of Newton's method costs a few solves for few contacts, less than slow iterations.
  static constexpr Attempt attempts[]{
      {FixedPoint, FixedPoint, true, true}, {Auto, Anderson, true, false, poor_contraction},
      {Auto, Newton, true, false},          {Auto, Anderson, true, true},
      {Auto, Newton, false, true},          {Anderson, Anderson, true, true},
      {Newton, Newton, true, true},         {Newton, Anderson, false, true}};
  for (const auto& [of, method, for_few, for_many, poor] : attempts) {
    if (of == method_ && (are_few ? for_few : for_many) && converges(method, poor, guess, lambda)) return {};
  }
  if (method_ != FixedPoint) return sliding_.enumerate(t, check, lambda, &report_);
  return fail_friction(Status::NotConverged, t,
                       "the iteration of friction does not converge by itself (contraction " +
                           text(report_.contraction) + "); others may");
}

/// Applies Newton's method with refined solves. With an ill-conditioned S the rounding of a single solve exceeds the
/// tolerance of the law.
void FrictionSolver::refine(const double* b, const double* lambda) {
  set_right_side(b);
  refines_ = true;
  constexpr double wanted = 1e-15;
  std::copy(lambda, lambda + lambda_.size(), lambda_.begin());
  const FixedPoint::Result result = fixed_point_.solve_by_newton(model_.parallel, lambda_.data(), wanted);
  refines_ = false;
  if (result.has_converged) set_forces(lambda_.data());
}

void FrictionSolver::add(double sign, double* w0, double* b) const {
  coupling_.add_to_points(sign, now_.tau.data(), w0);
  coupling_.add_to_rows(sign, now_.x.data(), b);
}

double FrictionSolver::change_to(const double* lambda, double s, double* y) {
  std::swap(now_, before_);
  set_forces(lambda);
  add_change(s, y);
  return scales_.relative_change(now_.x, before_.x);
}

void FrictionSolver::add_change(double s, double* y) const {
  coupling_.add_change(s, now_.tau.data(), before_.tau.data(), y);
}

double FrictionSolver::measure(const double* lambda) {
  laws_.evaluate(model_.parallel, lambda, before_.x.data());
  report_.residual = scales_.relative_change(now_.x, before_.x);
  report_.error_bound = amplification_ * largest_difference(now_.x, before_.x);
  return report_.residual;
}

// ---- outputs ----

Vec3 FrictionSolver::force(std::size_t contact, const double* lambda) const {
  return tangents_.sticks(contact) ? laws_.held(contact, lambda) : load(now_.tau.data(), contact);
}

void FrictionSolver::write_contacts(const double* lambda, std::vector<double>* forces) const {
  forces->resize(3 * tangents_.size());
  for (std::size_t c = 0; c < tangents_.size(); ++c) store(forces->data(), c, force(c, lambda));
}

void FrictionSolver::write_given(double* tau) const {
  write_points(now_.tau.data(), tau);
}

void FrictionSolver::write_at(const double* lambda, double* tau) const {
  std::vector<double> x(now_.x.size()), forces(now_.tau.size());
  laws_.evaluate(model_.parallel, lambda, x.data());
  laws_.write_forces(x.data(), forces.data());
  write_points(forces.data(), tau);
}

void FrictionSolver::write_points(const double* forces, double* tau) const {
  std::fill_n(tau, 3 * model_.num_points(), 0.0);
  for (std::size_t c = 0; c < tangents_.size(); ++c) add_to(tau, tangents_[c].point, load(forces, c));
}

double FrictionSolver::power(const double* lambda, const double* v) const {
  double sum = 0.0;
  for (std::size_t c = 0; c < tangents_.size(); ++c) sum += dot(force(c, lambda), load(v, tangents_[c].point));
  return sum;
}

double FrictionSolver::held_power(const double* lambda, const double* v) const {
  double sum = 0.0;
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    if (tangents_.sticks(c)) sum += dot(laws_.held(c, lambda), load(v, tangents_[c].point));
  }
  return sum;
}

}  // namespace tanor::detail
