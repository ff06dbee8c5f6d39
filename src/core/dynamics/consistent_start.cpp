#include "dynamics/consistent_start.hpp"

#include <algorithm>
#include <span>

#include "base/text.hpp"
#include "dynamics/nearest_point.hpp"
#include "dynamics/rod_lengths.hpp"

namespace tanor::detail {

/// Throws InputError naming the constraint that (r, v) violates most, if the violation is larger than what is
/// corrected.
void ConsistentStart::check(const double* r, const double* v) const {
  constexpr double allowed = 1e-3;
  if (model_.num_rows() == 0) return;
  std::vector<double> position(model_.num_rows()), velocity(model_.num_rows());
  work_.constraints.measure(r, v, position.data(), velocity.data());
  const auto worst_position = std::max_element(position.begin(), position.end());
  if (!(*worst_position <= allowed)) {
    throw InputError(
        "/motion/start",
        "the initial positions violate " + work_.name_row(static_cast<std::size_t>(worst_position - position.begin())) +
            " by " + text(*worst_position) +
            " of its length; at most 0.001 is corrected (\"start\": \"project\" finds the nearest admissible start)");
  }
  const Scales& scales = work_.scales;
  for (const OneSidedRow& each : model_.numbering.one_sided)
    velocity[static_cast<std::size_t>(each.row)] = 0.0;  // a gap may open or close
  std::vector<double> relative = velocity;
  for (std::size_t a = 0; a < relative.size(); ++a) relative[a] /= scales.speed(scales.of_row(a));
  const auto worst = static_cast<std::size_t>(std::max_element(relative.begin(), relative.end()) - relative.begin());
  if (!(relative[worst] <= allowed)) {
    throw InputError(
        "/motion/start",
        "the initial velocities violate " + work_.name_row(worst) + " by " + text(velocity[worst]) +
            ", the velocity scale is " + text(scales.speed(scales.of_row(worst))) +
            "; at most 0.001 of it is corrected (\"start\": \"project\" finds the nearest admissible start)");
  }
}

StartReport ConsistentStart::find(double t, double* r, double* v, StartMode mode) {
  work_.set_time(t);
  work_.prescribe_all(t, r, v);
  Team& team = work_.team();
  for (double* const points : {r, v}) team.fetch_guests(points);
  StartReport report;

  work_.measure_velocity_scale(t, r, v);
  if (!work_.has_rows()) return report;
  if (unilateral_ != nullptr) (void)unilateral_->close_touching(t, r, mode);

  if (mode == StartMode::Check) {
    (void)team.together([&] {
      check(r, v);
      return Outcome{};
    });
  }
  const std::vector<double> r_given(r, r + 3 * model_.num_points());
  ProjectionReport positions;
  const auto project = [&] {
    if (mode == StartMode::Project && team.is_alone()) {
      positions = NearestPoint(work_, linearization_, projector_).find(t, r);
    } else {
      positions.outcome = linearization_.update(t, r);
      if (positions.outcome.ok()) positions = projector_.project_positions(t, r);
    }
  };
  project();
  // A projection may break one-sided rows that were open.
  constexpr int most_rounds = 50;
  for (int round = 0; unilateral_ != nullptr && positions.outcome.ok() && round < most_rounds; ++round) {
    if (!unilateral_->close_touching(t, r, StartMode::Project)) break;
    project();
  }
  report.outcome = positions.outcome;
  if (!report.outcome.ok()) {
    if (Outcome lengths = check_rod_lengths(model_, t, r_given.data()); !lengths.ok()) report.outcome = lengths;
    return report;
  }
  report.position_correction = model_.largest_move(r, r_given.data());
  // Where nothing has moved, S is that of the given positions, from which the projection began.
  const bool has_moved = team.any(!std::ranges::equal(r_given, std::span(r, r_given.size())));
  if (unilateral_ != nullptr) unilateral_->open_moving(t, r, v);
  if (has_moved || unilateral_ != nullptr) report.outcome = linearization_.update(t, r);
  if (!report.outcome.ok()) return report;
  const std::vector<double> v_given(v, v + 3 * model_.num_points());
  report.outcome = projector_.project_velocities(t, r, v).outcome;
  report.velocity_correction = model_.largest_move(v, v_given.data());
  report.relative = std::max(work_.largest_move(r, r_given.data(), work_.scales.lengths()),
                             work_.largest_move(v, v_given.data(), work_.scales.speeds()));
  return report;
}

}  // namespace tanor::detail
