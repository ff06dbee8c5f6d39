#include "ranks/cut_projector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/numbers.hpp"
#include "base/text.hpp"

namespace tanor::detail {

CutProjector::CutProjector(Workspace& work, CutLinearization& linearization)
    : work_(work),
      model_(work.model()),
      linearization_(linearization),
      rows_(model_.num_rows()),
      move_(3 * model_.num_points()) {}

double CutProjector::evaluate_free(const Kinematics& at, double* w) {
  const double largest = work_.evaluate_free(at.t, at.x, at.v, w);
  linearization_.guests().fetch(w);
  return largest;
}

Outcome CutProjector::free_accelerations(const Kinematics& at, const Request&, double* a) {
  const double largest = linearization_.agreement().largest(evaluate_free(at, a));
  return std::isfinite(largest) ? Outcome{} : model_.not_finite(at.t);
}

// ---- positions ----

ProjectionReport CutProjector::iterate_positions(double t, double* r, double* sum) {
  constexpr double target = 1e-13, largest_left = 1e-12, far = std::numeric_limits<double>::infinity();
  work_.set_time(t);
  return project_along_chord(model_, *this, {target, largest_left, far}, t, r, sum, {});
}

double CutProjector::evaluate_values(const double* r) {
  return linearization_.agreement().largest(work_.constraints.evaluate_values(model_.parallel, r, rows_.data()));
}

double CutProjector::beyond_rounding(const double* r, double violation, double allowed, double times) {
  const double own = 4.0 * eps * std::max(1.0, model_.largest_norm(r) / model_.smallest_length);
  const double rounding = linearization_.agreement().largest(own);
  return violation <= std::max(allowed, times * rounding) ? 0.0 : violation;
}

/// The rows of lines are evaluated again, in the frames that were chosen with K.
Outcome CutProjector::linearise_at(double t, const double* r) {
  Outcome outcome = linearization_.update(t, r);
  if (outcome.ok()) (void)evaluate_values(r);
  return outcome;
}

void CutProjector::correct_positions(double* r, double* sum) {
  linearization_.correct(rows_.data(), r);
  for (std::size_t a = 0; sum != nullptr && a < rows_.size(); ++a) sum[a] += rows_[a];
}

Outcome CutProjector::explain_stall(double t, double violation) const {
  return {Status::NotConverged,
          "projection onto the constraints stalls at t = " + text(t) + ", violation " + text(violation)};
}

/// Projects along the gradients of the step's beginning. The velocity takes the same multipliers.
ProjectionReport CutProjector::project_step(double t, double h, const PointSource& source, double* x,
                                            double* step_velocity) {
  bring(model_.parallel, &source, 0, model_.num_moving());
  step_sum_.assign(model_.num_rows(), 0.0);
  ProjectionReport report = iterate_positions(t, x, step_sum_.data());
  if (!report.outcome.ok() || step_velocity == nullptr) return report;
  linearization_.write_reactions(step_sum_.data(), move_.data());
  for (std::size_t i = 0; i < move_.size(); ++i) step_velocity[i] += move_[i] / h;
  return report;
}

// ---- velocities ----

ProjectionReport CutProjector::project_velocities(double t, const double* r, double* v) {
  constexpr double target = 1e-13;
  constexpr int most_iterations = 4;
  work_.set_time(t);
  ProjectionReport report;
  double before = std::numeric_limits<double>::infinity();
  for (;; ++report.iterations) {
    const double rate =
        linearization_.agreement().largest(work_.constraints.evaluate_rates(model_.parallel, r, v, rows_.data()));
    report.violation = rate / least_speed_;
    if (!std::isfinite(rate)) {
      report.outcome = model_.not_finite(t);
      return report;
    }
    // The problem is linear in v: one solve is exact up to rounding, further solves only refine.
    const bool stands = !(report.violation < 0.5 * before);
    if (report.violation <= target || report.iterations == most_iterations || stands) return report;
    before = report.violation;
    linearization_.correct(rows_.data(), v);  // S nu = -(K'v + xi_t), v += M^-1 K nu
  }
}

}  // namespace tanor::detail
