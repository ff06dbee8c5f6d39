#include "dynamics/projector.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"

namespace tanor {

namespace {

constexpr double rounding = 1e-9;  // of velocities, relative; more is no rounding

}  // namespace

Projector::Projector(Workspace& work, Linearization& linearization, Residuals& residuals, ContactState* contacts)
    : work_(work),
      model_(work.model()),
      linearization_(linearization),
      residuals_(residuals),
      contacts_(contacts),
      rows_(model_.num_rows()) {}

// ---- positions ----

ProjectionReport Projector::project_positions(double t, double* r, Turn turn) {
  // Less than this takes one or two iterations along any slope.
  constexpr double far = 1e-10;
  return iterate_positions(t, r, nullptr, nullptr, turn == Turn::Large && linearization_.is_cheap() ? far : infinity,
                           0.0);
}

/// This is what the iterations have come to.
struct Projector::Progress {
  double before = infinity, left_before = infinity;  // violation one iteration ago, and what of it was no rounding
  bool stalls = false, stands = false;               // the violation hardly falls; it does not fall at all
  bool linearised_here = false, decided_here = false;
};

/// Chord iterations along M^-1 K of the last configuration, or of the one at r where the violation is above `far`.
/// `sum` is their guess and becomes the sum of the multipliers; then the slope is never renewed, since they belong to
/// one K.
ProjectionReport Projector::iterate_positions(double t, double* r, const PointSource* source, double* sum, double far,
                                              double tolerance) {
  work_.set_time(t);
  ProjectionReport report;
  if (model_.num_rows() == 0) {
    bring(model_.parallel, source, 0, model_.num_points());
    return report;
  }
  if (contacts_ != nullptr && contacts_->num_switches > 0) contacts_->places.carry(t);
  const double target = std::max(1e-13, tolerance), largest_left = std::max(1e-12, tolerance);
  constexpr int most_iterations = 100;
  const Projection by_islands = linearization_.project_positions(target, r, source, sum);
  report.iterations = by_islands.iterations;
  report.violation = by_islands.violation;
  if (report.violation <= target) return report;
  if (std::isfinite(report.violation) && residuals_.beyond_rounding(r, report.violation, target, 1.0) == 0.0)
    return report;
  for (Progress progress;; ++report.iterations) {
    report.violation = evaluate_values(r);
    if (!std::isfinite(report.violation)) {
      report.outcome = model_.not_finite(t);
      return report;
    }
    if (report.violation <= target || is_rounding(r, report.violation, target, &progress)) return report;
    const bool hopeless = progress.stands && (progress.linearised_here || sum != nullptr);
    if (report.iterations == most_iterations || hopeless) {
      const double left_over = residuals_.beyond_rounding(r, report.violation, largest_left, 2.0);
      if (left_over > 0.0 && sum == nullptr && decide_rank_again(r, &progress)) continue;
      if (left_over > 0.0) report.outcome = explain_stall(t, report.violation);
      return report;
    }
    const bool is_far = report.iterations == 0 && report.violation > far;
    if ((progress.stalls || is_far) && sum == nullptr) {
      // The chord's slope is too old: Newton's own.
      if (report.outcome = linearization_.update(t, r); !report.outcome.ok()) return report;
      progress.linearised_here = true;
    }
    progress.before = report.violation;
    // S mu = -xi, r += M^-1 K mu
    linearization_.correct(rows_.data(), r);
    if (sum != nullptr) add_rows_to(sum);
  }
}

/// Compares a violation with that of the iteration before. True: all that is left of it is rounding.
bool Projector::is_rounding(const double* r, double violation, double target, Progress* progress) {
  progress->stalls = violation > 0.3 * progress->before;
  progress->stands = violation > 0.99 * progress->before;
  if (!progress->stalls) return false;
  // Some neighbourhood may be at its rounding while others are on their way.
  const double left = residuals_.beyond_rounding(r, violation, target, 1.0);
  if (left == 0.0) return true;
  progress->stalls = left > 0.3 * progress->left_before || left == violation;
  progress->stands = progress->stalls && left > 0.99 * std::min(progress->before, progress->left_before);
  progress->left_before = left;
  return false;
}

/// Rows that depended when K was seen last may be independent here. True, once: they are.
bool Projector::decide_rank_again(const double* r, Progress* progress) {
  if (progress->decided_here) return false;
  progress->decided_here = true;
  progress->before = progress->left_before = infinity;
  return linearization_.decide_rank_again(r);
}

void Projector::add_rows_to(double* sum) const {
  model_.parallel.for_ranges(model_.num_rows(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) sum[a] += rows_[a];
  });
}

/// xi into `rows_`; returns the largest |xi|/length, and |T'(r - p)| over the length around a contact that is held.
double Projector::evaluate_values(const double* r) {
  const double largest = linearization_.evaluate_values(r, rows_.data());
  const RankRevealingFactor& factor = linearization_.rank_factor();
  if (contacts_ == nullptr || factor.is_compliant()) return largest;
  return larger(largest, contacts_->places.largest_violation(rows_.data(), factor.redundancy()));
}

/// Names the row that is farthest from 0 in `rows_` = xi.
Outcome Projector::explain_stall(double t, double violation) const {
  const auto worst =
      std::max_element(rows_.begin(), rows_.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  const auto row = static_cast<std::size_t>(worst - rows_.begin());
  const std::string place = work_.name_row(row) + " at t = " + text(t) + ", violation " + text(violation);
  if (row >= model_.numbering.first_idle_row()) {
    return {Status::Contradictory, "what is prescribed at supports breaks " + place};
  }
  // The independent rows are satisfied, what depends on them is not.
  const std::vector<double>& lengths = work_.scales.lengths();
  const RankRevealingFactor& factor = linearization_.rank_factor();
  if (factor.largest_active(rows_, lengths) < 1e-3 * factor.largest_dependent(rows_, lengths)) {
    const std::vector<double> nothing(work_.scales.size(), 0.0);
    if (Outcome outcome = factor.explain_contradiction(t, rows_, nothing, 1e-9, " m"); !outcome.ok()) return outcome;
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
  if (model_.num_rows() == 0) return report;
  constexpr double target = 1e-13;
  // What sticks stands still: there is no rounding that may add up to a creep.
  const bool holds_contacts = work_.constraints.tangents().num_sticking() > 0;
  double before = infinity, least = infinity;
  int since_least = 0;
  bool decided_here = false;
  const RankRevealingFactor& factor = linearization_.rank_factor();
  const double least_speed = speed > 0.0 ? speed : work_.scales.least_speed();
  const Projection by_islands = linearization_.project_velocities(target * least_speed, r, v, sum);
  report.iterations = by_islands.iterations;
  report.violation = by_islands.violation / least_speed;
  if (report.violation <= target) return report;
  for (;; ++report.iterations) {
    const double rate = linearization_.evaluate_rates(r, v, rows_.data());
    report.violation = speed > 0.0 ? rate / speed : residuals_.relative_rates(rows_, rate);
    if (!std::isfinite(rate)) {
      report.outcome = model_.not_finite(t);
      return report;
    }
    // Linear in v: with the factor at r one solve is exact up to rounding, more only refine.
    const bool is_done = report.violation <= target && !(holds_contacts && report.iterations == 0);
    // Conjugate residuals may rest for some steps.
    constexpr int most_conjugate = 100, patience = 5;
    since_least = report.violation < 0.5 * least ? 0 : since_least + 1;
    least = std::min(least, report.violation);
    const bool stands = factor.is_compliant() ? since_least == patience : !(report.violation < 0.5 * before);
    if (is_done || report.iterations == (factor.is_compliant() ? most_conjugate : 4) || stands) {
      if (!factor.redundancy().is_found() || decided_here || report.violation <= rounding) return report;
      // A dependent row stays behind: it became independent, or contradicts the others.
      decided_here = true;
      if (!linearization_.decide_rank_again(r)) {
        report.outcome = factor.explain_contradiction(t, rows_, work_.scales.speeds(), rounding, " m/s");
        return report;
      }
    }
    before = report.violation;
    // S nu = -(K'v + xi_t), v += M^-1 K nu
    linearization_.correct_conjugately(report.iterations == 0, rows_.data(), v);
    for (std::size_t a = 0; sum != nullptr && a < model_.num_rows(); ++a) sum[a] += rows_[a];
  }
}

}  // namespace tanor
