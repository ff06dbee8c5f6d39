#include "dynamics/projector.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.hpp"

namespace tanor::detail {

namespace {

constexpr double rounding = 1e-9;  // largest relative violation of velocities that counts as rounding

}  // namespace

Projector::Projector(Workspace& work, Linearization& linearization, Residuals& residuals, Contacts* contacts)
    : work_(work),
      model_(work.model()),
      linearization_(linearization),
      residuals_(residuals),
      contacts_(contacts),
      is_factor_cheap_(work.team().is_alone() && linearization.summary().factor.is_cheap()),
      rows_(model_.num_rows()) {}

// ---- positions ----

ProjectionReport Projector::project_positions(double t, double* r, Turn turn) {
  // A smaller violation takes one or two iterations along any K.
  constexpr double far = 1e-10;
  return iterate_positions(t, r, nullptr, nullptr, turn == Turn::Large && is_factor_cheap_ ? far : infinity, 0.0);
}

/// Projects by chord iterations along M^-1 K of the last configuration, or of that at r if the violation is above
/// `far`. `sum` holds a guess of the multipliers and receives their sum. If it is given, K is never evaluated anew,
/// since all multipliers belong to one K.
ProjectionReport Projector::iterate_positions(double t, double* r, const PointSource* source, double* sum, double far,
                                              double tolerance) {
  work_.set_time(t);
  ProjectionReport report;
  if (!work_.has_rows()) {
    bring(model_.parallel, source, 0, model_.num_points());
    return report;
  }
  if (contacts_ != nullptr) contacts_->carry_places(t);
  const double target = std::max(1e-13, tolerance), largest_left = std::max(1e-12, tolerance);
  if (const auto by_islands = linearization_.project_positions(target, r, source, sum)) {
    report.iterations = by_islands->iterations;
    report.violation = by_islands->violation;
    if (report.violation <= target) return report;
    if (!work_.scales.are_one()) report.violation = evaluate_values(r);  // fills `rows_`
    if (beyond_rounding(r, report.violation, target, 1.0) == 0.0) return report;
  }
  return project_along_chord(model_, *this, {target, largest_left, far}, t, r, sum, std::move(report));
}

/// Solves S mu = -xi, then r += M^-1 K mu.
void Projector::correct_positions(double* r, double* sum) {
  linearization_.correct(rows_.data(), r, sum);
}

/// Writes xi into `rows_`. Returns the largest |xi|/length, or the largest |T'(r - p)| of a held contact over the
/// length around it, if that is larger.
double Projector::evaluate_values(const double* r) {
  const double largest = linearization_.evaluate_values(r, rows_.data());
  if (contacts_ == nullptr || contacts_->shares_loads()) return largest;
  return larger(largest, contacts_->largest_violation(rows_.data()));
}

/// Names the row with the largest |xi| in `rows_`.
Outcome Projector::explain_stall(double t, double violation) const {
  Team& team = work_.team();
  const auto worst =
      std::max_element(rows_.begin(), rows_.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  const auto row = static_cast<std::size_t>(worst - rows_.begin());
  const double size = rows_.empty() ? 0.0 : std::abs(*worst);
  const bool is_here = size == team.largest(size) && !rows_.empty();
  const std::string place = team.first_text(is_here ? work_.name_row(row) : std::string()) + " at t = " + text(t) +
                            ", violation " + text(violation);
  if (team.any(is_here && row >= model_.numbering.first_idle_row())) {
    return {Status::Contradictory, "what is prescribed at supports breaks " + place};
  }
  // The independent rows are satisfied, but rows that depend on them are not.
  const std::vector<double>& lengths = work_.scales.lengths();
  const Dependences& dependences = linearization_.dependences();
  const double active = dependences.largest_active(rows_, lengths);
  if (active < 1e-3 * dependences.largest_dependent(rows_, lengths)) {
    const std::vector<double> nothing(work_.scales.size(), 0.0);
    if (Outcome outcome = dependences.explain_contradiction(t, rows_, nothing, 1e-9, Dimension::Length); !outcome.ok())
      return outcome;
  }
  constexpr double poor = 1e-6;
  const double condition = linearization_.reciprocal_condition();
  const std::string why = condition < poor ? "; S has the reciprocal condition " + text(condition) + " there" : "";
  return {Status::NotConverged, "projection onto the constraints stalls; the worst is " + place + why};
}

// ---- velocities ----

ProjectionReport Projector::project_velocities(double t, const double* r, double* v, double* sum, double speed) {
  work_.set_time(t);
  ProjectionReport report;
  if (!work_.has_rows()) return report;
  constexpr double target = 1e-13;
  const double least_speed = speed > 0.0 ? speed : work_.scales.least_speed();
  if (const auto by_islands = linearization_.project_velocities(target * least_speed, r, v, sum)) {
    report.iterations = by_islands->iterations;
    report.violation = by_islands->violation / least_speed;
    if (report.violation <= target) return report;
  }
  // Sticking contacts must be at rest exactly, so that no rounding adds up to a creep.
  bool must_correct_first = work_.constraints.tangents().num_sticking() > 0;
  const auto measure = [&] {
    const double rate = linearization_.evaluate_rates(r, v, rows_.data());
    return report.violation = speed > 0.0 ? rate / speed : residuals_.relative_rates(rows_, rate);
  };
  const auto is_enough = [&](double violation) {
    const bool must_correct = std::exchange(must_correct_first, false);
    return !std::isfinite(violation) || (violation <= target && !must_correct);
  };
  // Solve S nu = -(K'v + xi_t), then v += M^-1 K nu. The problem is linear in v. With the factor at r one solve is
  // exact up to rounding, and others only refine.
  const Refinement passes{rows_.data(), v, sum, 4, 100};
  const Dependences& dependences = linearization_.dependences();
  for (bool has_decided = false;; has_decided = true) {
    report.iterations += linearization_.refine(passes, measure, is_enough);
    if (!std::isfinite(report.violation)) {
      report.outcome = model_.not_finite(t);
      return report;
    }
    if (!dependences.is_found() || has_decided || report.violation <= rounding) return report;
    // A dependent row is violated, so it has become independent, or contradicts the others.
    if (!linearization_.decide_rank_again(r)) {
      report.outcome =
          dependences.explain_contradiction(t, rows_, work_.scales.speeds(), rounding, Dimension::Velocity);
      return report;
    }
  }
}

}  // namespace tanor::detail
