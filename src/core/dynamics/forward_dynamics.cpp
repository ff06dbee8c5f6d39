#include "dynamics/forward_dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/stopwatch.hpp"
#include "base/text.hpp"
#include "dynamics/light_points.hpp"
#include "schur/refinement.hpp"

namespace tanor::detail {

ForwardDynamics::ForwardDynamics(Workspace& work, Linearization& linearization, Residuals& residuals,
                                 Contacts* contacts)
    : work_(work),
      model_(work.model()),
      linearization_(linearization),
      residuals_(residuals),
      contacts_(contacts),
      lambda_(model_.num_rows(), 0.0),
      dw_(3 * model_.num_points(), 0.0),
      b_(model_.num_rows()),
      rows_(model_.num_rows()) {}

Outcome ForwardDynamics::solve(const Kinematics& at, const Request& request, std::span<const char> are_counted,
                               const AccelerationOutput& to) {
  Outcome outcome = find(at, request, are_counted, to.a);
  if (to.report != nullptr) {
    *to.report = report_;
    to.report->reciprocal_condition = linearization_.factor().reciprocal_condition();
  }
  if (to.power != nullptr && outcome.ok()) *to.power = find_power(at);
  if (to.reactions != nullptr && outcome.ok()) {
    to.reactions->lambda = lambda_;
    to.reactions->refinements = report_.refinements;
    if (contacts_ != nullptr) contacts_->write_contacts(lambda_.data(), &to.reactions->friction);
  }
  return outcome;
}

Outcome ForwardDynamics::find(const Kinematics& at, const Request& request, std::span<const char> are_counted,
                              double* w) {
  work_.set_time(at.t);
  ++work_.counters.evaluations;
  exact_ = model_.is_exact_for(request);
  FactorReuse* const reuse = linearization_.factor().reuse();
  if (reuse != nullptr) reuse->allow_error(exact_ ? 0.0 : request.allowed_error);
  if (request.gradients == Gradients::Evaluate) work_.constraints.choose_frames();
  // Special solvers do (31), (23) and (25) in one pass. The code below does the same step by step.
  if (auto found = solve_at_once(at, request, w)) return *std::move(found);

  const bool is_new = request.gradients == Gradients::Evaluate && linearization_.factor().is_needed();
  evaluate(at, request, is_new, w);  // w0 = M^-1 f, b = phi + K'w0, K
  if (!std::isfinite(problem_.scale)) return work_.not_finite(at.t, at.x);
  if (model_.num_rows() == 0) return {};
  if (is_new && linearization_.factor().solve_with_old_factor(at.t, b_.data(), &lambda_, dw_.data())) {
    add_reactions(w);
    return check_idle_rows(at.t);
  }
  if (is_new) {
    Outcome outcome = linearization_.factorize(at.t, at.x);  // S = K'M^-1K
    if (!outcome.ok()) return outcome;
  }
  if (Outcome outcome = check_idle_rows(at.t); !outcome.ok()) return outcome;
  const UniquenessCheck check{request.verification != Verification::None, request.refuses_several, are_counted};
  if (Outcome outcome = find_friction(at, check, w); !outcome.ok()) return outcome;  // tau, then f + tau for f (43)
  find_multipliers();                                                                // S lambda = -b (31)
  improve_friction(w);
  if (Outcome outcome = verify(at, check.is_wanted); !outcome.ok()) return outcome;  // K'w + phi = 0
  add_reactions(w);  // w = w0 + M^-1 eta, eta = K lambda (23), (25)
  if (reuse != nullptr) reuse->note(at.t, lambda_);
  return {};
}

Power ForwardDynamics::find_power(const Kinematics& at) {
  Power result = work_.power(work_.power_of_reactions(dw_.data(), at.v), at.x, at.v);
  if (contacts_ == nullptr) return result;
  result.friction = contacts_->power(lambda_.data(), at.v);
  // A part of the power of M^-1 K lambda belongs to contacts that stick.
  if (model_.is_rheonomic()) result.supports -= contacts_->held_power(lambda_.data(), at.v);
  return result;
}

/// Solves all in one pass by the composite. Returns nothing where the composite does not serve, where S looks singular,
/// or where K'w = -phi is not reached. Then the steps one by one decide.
std::optional<Outcome> ForwardDynamics::solve_at_once(const Kinematics& at, const Request& request, double* w) {
  const Gradients gradients = request.gradients;
  double scale = 0.0;
  const auto find_motion = [&]() -> FreeMotion {
    const Stopwatch watch(&work_.times.evaluate);
    if (request.given != nullptr) {
      work_.write_support_accelerations(at.t, w);
      return {.r = at.x, .v = at.v, .w0 = w, .source = request.given};
    }
    const Vec3* const uniform = model_.uniform_free();
    scale = uniform != nullptr ? work_.write_unconstrained(at.t, w) : evaluate_free(at, request, w);
    return {at.x, at.v, w, uniform};
  };
  const std::optional<Elimination> found =
      linearization_.factor().solve_at_once(gradients, find_motion, b_.data(), lambda_.data(), w);
  if (!found) return std::nullopt;
  const auto [t, r, v] = at;
  if (request.given != nullptr) scale = request.given->largest();
  scale = larger(scale, found->largest_right_side);
  residuals_.begin_instant();
  report_.residual = 0.0;
  report_.refinements = found->refinements;
  if (!std::isfinite(scale)) return work_.not_finite(t, r);
  report_.residual = found->residual / (scale > 0.0 ? scale : 1.0);
  // A residual that is small beside each island, or beside the slowest neighbourhood, is small beside each
  // neighbourhood.
  constexpr double little = 1e-12;
  const Scales& scales = work_.scales;
  const bool is_little =
      scales.are_one() || found->own_residual <= little || found->residual <= little * scales.least_acceleration();
  const bool is_fine = report_.residual <= good_enough(exact_) && is_little;
  if (is_fine && !model_.is_rheonomic()) return Outcome{};

  // Refinement and the power of the reactions need w0 and dw separately.
  linearization_.write_reactions(lambda_.data(), dw_.data());
  if (is_fine) return Outcome{};
  (void)evaluate_free(at, request, w);
  (void)linearization_.evaluate_right_side(r, v, w, false, b_.data());
  problem_ = {w, b_.data(), scale};
  refine();
  report_.refinements = std::max(report_.refinements, found->refinements);
  if (!(report_.residual <= doubtful_above)) {
    if (gradients == Gradients::Evaluate) linearization_.factor().refuse();
    return std::nullopt;
  }
  add_reactions(w);
  return Outcome{};
}

/// Writes w0 = M^-1 f into w. Returns the largest number.
double ForwardDynamics::evaluate_free(const Kinematics& at, const Request& request, double* w) {
  if (request.given == nullptr) return work_.evaluate_free(at.t, at.x, at.v, w);
  work_.write_support_accelerations(at.t, w);
  bring(model_.parallel, request.given, 0, model_.num_points());
  return request.given->largest();
}

/// Computes w0 = M^-1 f into w, b = phi + K'w0, and K if `with_gradients` is true.
void ForwardDynamics::evaluate(const Kinematics& at, const Request& request, bool with_gradients, double* w) {
  double scale = 0.0;
  {
    const Stopwatch watch(&work_.times.evaluate);
    scale = evaluate_free(at, request, w);
    scale = larger(scale, linearization_.evaluate_right_side(at.x, at.v, w, with_gradients, b_.data()));
  }
  report_.residual = 0.0;
  report_.refinements = 0;
  problem_ = {w, b_.data(), scale};
  residuals_.begin_instant();
  if (contacts_ != nullptr) residuals_.measure_accelerations(problem_);
}

/// Checks rows that join supports alone. They take no part in S, so the prescribed motion must satisfy them by itself.
Outcome ForwardDynamics::check_idle_rows(double t) const {
  constexpr double allowed = 1e-8;
  for (std::size_t a = model_.numbering.first_idle_row(); a < model_.num_rows(); ++a) {
    // b is phi + K'w0 with the accelerations of the supports in w0.
    if (std::abs(b_[a]) <= allowed * problem_.scale) continue;
    return {Status::Contradictory,
            work_.name_row(a) + " joins supports alone, and their prescribed motion breaks it at t = " + text(t) +
                " (by " + text(b_[a]) + " on the acceleration level)"};
  }
  return {};
}

// ---- multipliers ----

/// Solves S lambda = -b and computes dw = M^-1 K lambda, refined.
void ForwardDynamics::find_multipliers() {
  {
    const Stopwatch watch(&work_.times.solve);
    ++work_.counters.solves;
    linearization_.apply_factor(b_.data(), lambda_.data());  // (31)
    linearization_.write_reactions(lambda_.data(), dw_.data());
  }
  refine();
  // Friction depends on the multipliers; if they are not unique, those of the least norm serve.
  if (contacts_ != nullptr) linearization_.minimize_multiplier_norm(lambda_.data());
}

/// Refines in w: rho = K'dw + b = K'w + phi, lambda -= S^-1 rho, dw -= M^-1 K S^-1 rho. Reports |rho| over its scale.
void ForwardDynamics::refine() {
  const RankRevealingFactor& factor = linearization_.factor().all_rows();
  double largest = 0.0;
  const auto measure = [&] {
    largest = linearization_.apply_transposed(dw_.data(), b_.data(), rows_.data());
    report_.residual = residuals_.relative_residual(problem_, rows_, largest);
    // The residual of dependent rows cannot be reduced, so refinement looks at the other rows.
    if (!factor.redundancy().is_found()) return report_.residual;
    return factor.largest_active(rows_, residuals_.measure_accelerations(problem_));
  };
  // The residual must be small beside all accelerations and beside those of its own neighbourhood.
  constexpr double little = 1e-12;
  const auto is_enough = [&](double residual) {
    const bool is_little = largest <= good_enough(exact_) * problem_.scale && residual <= little;
    return is_little || residual <= good_enough(exact_);
  };
  const auto correct = [&](int pass) {
    linearization_.correct_conjugately(pass == 0, rows_.data(), dw_.data());
    for (std::size_t a = 0; a < rows_.size(); ++a) lambda_[a] += rows_[a];
  };
  report_.refinements = refine_solution(linearization_.acceleration_limits(), measure, is_enough, correct);
  // The noise of points without mass hides what other points still lack.
  constexpr int most_rounds = 4;
  for (int round = 0; round < most_rounds && !is_enough(report_.residual); ++round) {
    if (!settle_light_points(model_, linearization_.blocks().data(), rows_.data(), dw_.data())) return;
    if (is_enough(measure()) || round + 1 == most_rounds) return;
    correct(1);
    (void)measure();
  }
}

/// w = w0 + M^-1 K lambda (25)
void ForwardDynamics::add_reactions(double* w) const {
  model_.add_to_moving(dw_.data(), w);
}

void ForwardDynamics::write_reactions(const std::vector<double>& lambda, double* eta) {
  const double* rows = lambda.data();
  if (model_.numbering.has_contact_rows()) {
    // The multipliers of contacts that stick are friction, not reactions.
    rows_ = lambda;
    for (std::size_t a = 0; a < rows_.size(); ++a) {
      if (model_.numbering.is_contact_row(a)) rows_[a] = 0.0;
    }
    rows = rows_.data();
  }
  model_.gather.reactions(model_.parallel, linearization_.blocks().data(), rows, eta);
}

// ---- friction ----

/// Finds tau at lambda, beginning with the last one, and makes it a part of w0 and b = phi + K'w0.
Outcome ForwardDynamics::find_friction(const Kinematics& at, const UniquenessCheck& check, double* w) {
  if (contacts_ == nullptr) return {};
  const auto [t, r, v] = at;
  // The null space turns with K, so the rank is decided again.
  if (!work_.constraints.gradients_are_constant()) (void)linearization_.factor().decide_rank_again(r);
  Outcome outcome = contacts_->find({t, r, v, linearization_.blocks().data()}, check, lambda_.data(), w, b_.data());
  report_.friction = contacts_->report();
  return outcome;
}

/// Repeats the solve from lambda if tau(lambda) differs from the friction that lambda was found with.
void ForwardDynamics::improve_friction(double* w) {
  if (contacts_ == nullptr) return;
  if (contacts_->improve(lambda_.data(), w, b_.data())) {
    find_multipliers();
    contacts_->measure(lambda_.data());
  }
  report_.friction = contacts_->report();
  report_.friction.sticking_is_indeterminate = contacts_->shares_loads();
}

// ---- verification ----

Outcome ForwardDynamics::verify(const Kinematics& at, bool verifies_friction) {
  if (contacts_ != nullptr && verifies_friction) {
    if (Outcome outcome = contacts_->verify(at.t, &report_.friction); !outcome.ok()) return outcome;
  }
  if (report_.residual > doubtful_above) {
    if (Outcome outcome = reconsider_rank(at.t, at.x); !outcome.ok()) return outcome;
  }
  return std::isfinite(report_.residual) ? Outcome{} : work_.not_finite(at.t, at.x);
}

/// Decides what it means that K'w + phi is not 0 in all rows. Away from xi = 0 dependent rows may disagree. Otherwise
/// the rank has changed, the rows contradict each other, or S is too ill-conditioned.
Outcome ForwardDynamics::reconsider_rank(double t, const double* r) {
  /// The residual allowed in dependent rows for each unit of violation, since K differs from that on xi = 0.
  constexpr double spread = 1e3, rounding = doubtful_above;
  if (linearization_.factor().share_loads()) {
    find_multipliers();
    if (report_.residual <= rounding) return {};
  }
  const RankRevealingFactor& factor = linearization_.factor().all_rows();
  std::vector<double> xi(model_.num_rows());
  const double violation = work_.constraints.evaluate_values(model_.parallel, r, xi.data());
  const double allowed = std::max(rounding, spread * violation);
  const std::vector<double>& accelerations = residuals_.measure_accelerations(problem_);
  const auto are_fine = [&] {
    return factor.largest_active(rows_, accelerations) <= rounding &&
           factor.largest_dependent(rows_, accelerations) <= allowed;
  };
  if (are_fine()) return {};

  if (linearization_.factor().decide_rank_again(r)) {
    find_multipliers();
    if (are_fine()) return {};
  }
  if (factor.redundancy().is_found()) {
    Outcome outcome = factor.explain_contradiction(t, b_, accelerations, allowed, " m/s^2");
    if (!outcome.ok()) return outcome;
  }
  if (violation > rounding) return {};  // the rank has no meaning off the constraints, so the step's error decides
  linearization_.factor().decide_rank_of_poor_parts(r, rows_, accelerations, rounding);
  find_multipliers();
  constexpr double hopeless = 1e-3;
  if (are_fine() || report_.residual <= hopeless) return {};
  return {Status::Singular, "the accelerations at t = " + text(t) + " miss the constraints by " +
                                text(report_.residual) + " of themselves: masses are too unequal for double precision"};
}

}  // namespace tanor::detail
