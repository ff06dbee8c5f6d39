#include "dynamics/forward_dynamics.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "dynamics/light_points.hpp"

namespace tanor::detail {

ForwardDynamics::ForwardDynamics(Workspace& work, Linearization& linearization, Residuals& residuals,
                                 Contacts* contacts)
    : work_(work),
      model_(work.model()),
      linearization_(linearization),
      residuals_(residuals),
      contacts_(contacts),
      has_idle_rows_(work.team().any(model_.numbering.first_idle_row() < model_.num_rows())),
      found_{std::vector<double>(model_.num_rows()), std::vector<double>(model_.num_rows()),
             std::vector<double>(3 * model_.num_points())},
      rows_(model_.num_rows()) {}

Outcome ForwardDynamics::solve(const Kinematics& at, const Request& request, std::span<const char> are_counted,
                               const AccelerationOutput& to) {
  w_ = to.a;
  Outcome outcome = find(at, request, are_counted);
  if (to.report != nullptr) {
    *to.report = report_;
    to.report->reciprocal_condition = linearization_.reciprocal_condition();
  }
  if (to.power != nullptr && outcome.ok()) *to.power = find_power(at);
  if (to.reactions != nullptr && outcome.ok()) {
    to.reactions->lambda = found_.lambda;
    to.reactions->refinements = report_.refinements;
    if (contacts_ != nullptr) contacts_->write_contacts(found_.lambda.data(), &to.reactions->friction);
  }
  return outcome;
}

Outcome ForwardDynamics::find(const Kinematics& at, const Request& request, std::span<const char> are_counted) {
  exact_ = model_.is_exact_for(request);
  residuals_.begin_instant();
  const UniquenessCheck check{request.verification != Verification::None, request.refuses_several, are_counted};
  const auto complete = [&] { return find_friction(at, check); };              // tau, then f + tau for f (43)
  Outcome outcome = linearization_.solve(at, request, complete, w_, &found_);  // S lambda = -b (31)
  report_.residual = found_.residual;
  report_.refinements = found_.refinements;
  if (!outcome.ok() || found_.is_complete) return outcome;
  refine();
  report_.refinements = std::max(report_.refinements, found_.refinements);
  improve_friction();
  if (outcome = verify(at, check.is_wanted); !outcome.ok()) return outcome;  // K'w + phi = 0
  // w = w0 + M^-1 K lambda (23), (25)
  model_.add_to_moving(found_.dw.data(), w_);
  work_.team().add_to_guests(found_.dw.data(), w_);
  if (FactorReuse* const reuse = linearization_.reuse()) reuse->note(at.t, found_.lambda);
  return {};
}

Power ForwardDynamics::find_power(const Kinematics& at) {
  Power result = work_.power(work_.power_of_reactions(found_.dw.data(), at.v), at);
  if (contacts_ == nullptr) return result;
  result.friction = contacts_->power(found_.lambda.data(), at.v);
  // A part of the power of M^-1 K lambda belongs to contacts that stick.
  if (model_.is_rheonomic()) result.supports -= contacts_->held_power(found_.lambda.data(), at.v);
  return result;
}

/// Checks rows that join supports alone. They take no part in S, so the prescribed motion must satisfy them by itself.
Outcome ForwardDynamics::check_idle_rows(double t) const {
  constexpr double allowed = 1e-8;
  for (std::size_t a = model_.numbering.first_idle_row(); a < model_.num_rows(); ++a) {
    // b is phi + K'w0 with the accelerations of the supports in w0.
    if (std::abs(found_.b[a]) <= allowed * found_.scale) continue;
    return {Status::Contradictory,
            work_.name_row(a) + " joins supports alone, and their prescribed motion breaks it at t = " + text(t) +
                " (by " + text(found_.b[a]) + " on the acceleration level)"};
  }
  return {};
}

// ---- multipliers ----

/// Solves S lambda = -b and computes dw = M^-1 K lambda, refined.
void ForwardDynamics::find_multipliers() {
  linearization_.solve_once(found_.b.data(), found_.lambda.data(), found_.dw.data());
  refine();
}

/// Refines in w: rho = K'dw + b = K'w + phi, lambda -= S^-1 rho, dw -= M^-1 K S^-1 rho. Reports |rho| over its scale.
void ForwardDynamics::refine() {
  const Dependences& dependences = linearization_.dependences();
  double largest = 0.0;
  const auto measure = [&] {
    largest = linearization_.apply_transposed(found_.dw.data(), found_.b.data(), rows_.data());
    report_.residual = residuals_.relative_residual(problem(), rows_, largest);
    // The residual of dependent rows cannot be reduced, so refinement looks at the other rows.
    if (!dependences.is_found()) return report_.residual;
    return dependences.largest_active(rows_, residuals_.measure_accelerations(problem()));
  };
  // The residual must be small beside all accelerations and beside those of its own neighbourhood.
  constexpr double little = 1e-12;
  const auto is_enough = [&](double residual) {
    const bool is_little = largest <= good_enough(exact_) * found_.scale && residual <= little;
    return is_little || residual <= good_enough(exact_);
  };
  const auto is_done = [&](double residual) {
    return is_enough(residual) || residuals_.are_rounding(problem(), rows_, found_.dw.data());
  };
  Refinement passes{rows_.data(), found_.dw.data(), found_.lambda.data(), 5, 50};
  report_.refinements = linearization_.refine(passes, measure, is_done);
  // The noise of points without mass hides what other points still lack.
  constexpr int most_rounds = 4;
  passes.is_continued = true;
  for (int round = 1; work_.team().is_alone() && !is_enough(report_.residual); ++round) {
    if (!settle_light_points(model_, linearization_.blocks().data(), rows_.data(), found_.dw.data())) break;
    passes.most_passes = passes.most_where_shared = round < most_rounds ? 1 : 0;
    if (linearization_.refine(passes, measure, is_enough) == 0) break;
  }
  // Friction depends on the multipliers; if they are not unique, those of the least norm serve.
  if (contacts_ != nullptr) dependences.minimize_norm(found_.lambda.data());
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
Outcome ForwardDynamics::find_friction(const Kinematics& at, const UniquenessCheck& check) {
  if (contacts_ != nullptr) residuals_.measure_accelerations(problem());
  Outcome idle;
  if (has_idle_rows_) idle = work_.team().together([&] { return check_idle_rows(at.t); });
  if (!idle.ok() || contacts_ == nullptr) return idle;
  const auto [t, r, v] = at;
  // The null space turns with K, so the rank is decided again.
  if (!work_.constraints.gradients_are_constant()) (void)linearization_.decide_rank_again(r);
  Outcome outcome =
      contacts_->find({t, r, v, linearization_.blocks().data()}, check, found_.lambda.data(), w_, found_.b.data());
  report_.friction = contacts_->report();
  return outcome;
}

/// Repeats the solve from lambda if tau(lambda) differs from the friction that lambda was found with.
void ForwardDynamics::improve_friction() {
  if (contacts_ == nullptr) return;
  if (contacts_->improve(found_.lambda.data(), w_, found_.b.data())) {
    find_multipliers();
    contacts_->measure(found_.lambda.data());
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
  if (const auto improved = linearization_.improve_factor(t, r)) {
    if (!improved->ok()) return *improved;
    find_multipliers();
    if (report_.residual <= rounding) return {};
  }
  const Dependences& dependences = linearization_.dependences();
  std::vector<double> xi(model_.num_rows());
  const double violation = work_.team().largest(work_.constraints.evaluate_values(model_.parallel, r, xi.data()));
  const double allowed = std::max(rounding, spread * violation);
  const std::vector<double>& accelerations = residuals_.measure_accelerations(problem());
  const auto are_fine = [&] {
    return dependences.largest_active(rows_, accelerations) <= rounding &&
           dependences.largest_dependent(rows_, accelerations) <= allowed;
  };
  if (are_fine()) return {};

  if (linearization_.decide_rank_again(r)) {
    find_multipliers();
    if (are_fine()) return {};
  }
  if (dependences.is_found()) {
    Outcome outcome = dependences.explain_contradiction(t, found_.b, accelerations, allowed, Dimension::Acceleration);
    if (!outcome.ok()) return outcome;
  }
  if (violation > rounding) return {};  // the rank has no meaning off the constraints, so the step's error decides
  linearization_.decide_rank_of_poor_parts(r, rows_, accelerations, rounding);
  find_multipliers();
  constexpr double hopeless = 1e-3;
  if (are_fine() || report_.residual <= hopeless) return {};
  return {Status::Singular, "the accelerations at t = " + text(t) + " miss the constraints by " +
                                text(report_.residual) + " of themselves: masses are too unequal for double precision"};
}

}  // namespace tanor::detail
