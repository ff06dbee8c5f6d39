#include "dynamics/nearest_point.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "base/numbers.hpp"

namespace tanor::detail {

/// Reaches some configuration on xi = 0 from anywhere, by Newton's method in limited moves, then by chord iterations
/// for the last digits.
ProjectionReport NearestPoint::reach_constraints(double t, double* r) {
  work_.set_time(t);
  constexpr int most_iterations = 100;
  constexpr double near = 1e-3;
  std::vector<double> next;  // allocated when needed, since large systems mostly start near enough
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const double violation = work_.constraints.evaluate_values(model_.parallel, r, rows_.data());
    if (violation <= near || !std::isfinite(violation)) break;
    if (Outcome outcome = linearization_.update(t, r); !outcome.ok())
      return {std::move(outcome), 0.0, violation, iteration};
    next.assign(r, r + 3 * model_.num_points());
    linearization_.correct(rows_.data(), next.data());
    // A full step may overshoot, so no point moves by more than a quarter of its neighbourhood at once.
    for (std::size_t i = 0; i < 3 * model_.num_points(); ++i) next[i] -= r[i];
    const std::vector<double> moves = work_.largest_norms(next.data());
    for (std::size_t i = 0; i < model_.num_moving(); ++i) {
      const std::size_t k = work_.scales.of_point(i);
      add_to(r, i, std::min(1.0, 0.25 * work_.scales.length(k) / moves[k]) * load(next.data(), i));
    }
  }
  if (Outcome outcome = linearization_.update(t, r); !outcome.ok()) return {std::move(outcome)};
  return projector_.project_positions(t, r);
}

/// Reaches xi = 0, from a bent configuration if none is reached from r itself. Then the place to be near lies far
/// below, so that what hangs does so nearly as at rest.
ProjectionReport NearestPoint::reach_from_bent(double t, double* r, std::vector<double>* wanted) {
  constexpr double depth = 10.0;  // relative to the scene's size
  const std::vector<double> given = *wanted;
  std::vector<double> fall;
  ProjectionReport report = reach_constraints(t, r);
  constexpr int most_trials = 4;
  for (int trial = 0; trial < most_trials; ++trial) {
    const Status status = report.outcome.status;
    if (status != Status::Contradictory && status != Status::NotConverged && status != Status::Singular) break;
    std::ranges::copy(given, r);
    if (!bend(t, trial, &fall, r).ok()) break;
    ProjectionReport bent = reach_constraints(t, r);
    if (!bent.outcome.ok()) continue;
    for (std::size_t i = 0; i < fall.size(); ++i) (*wanted)[i] += depth * model_.scene_size * fall[i];
    return bent;
  }
  return report;
}

/// Moves the points the way they would fall, in further trials also irregularly by a tenth of that, along directions to
/// which no row answers to first order. The largest move of a neighbourhood is that by which its shortest row finds
/// room for what the worst one lacks, xi = (move/length)^2 length/2, and four times as much from the third trial on.
Outcome NearestPoint::bend(double t, int trial, std::vector<double>* fall, double* r) {
  const double unevenness = trial > 0 ? 0.1 : 0.0, irregular_step = 2.3 + 0.4 * trial,
               factor = std::pow(4.0, std::max(0, trial - 1));
  const std::size_t size = 3 * model_.num_points();
  const std::vector<double> at_rest(size, 0.0);
  std::vector<double> d(size, 0.0), lengths(model_.num_rows()), lacking(model_.num_rows()), rates(model_.num_rows());
  const double largest = work_.evaluate_free(t, r, at_rest.data(), d.data());
  const bool falls = largest > 0.0 && std::isfinite(largest);
  fall->assign(size, 0.0);
  for (std::size_t i = 0; i < size; ++i) {
    const bool moves = i < 3 * model_.num_moving();
    if (moves && falls) (*fall)[i] = d[i] / largest;
    d[i] = moves ? (*fall)[i] + (falls ? unevenness : 1.0) * irregular(i, irregular_step) : 0.0;
  }
  if (Outcome outcome = linearization_.update(t, r); !outcome.ok()) return outcome;
  linearization_.apply_transposed(d.data(), nullptr, rows_.data());
  linearization_.correct(rows_.data(), d.data());

  work_.constraints.measure(r, at_rest.data(), lacking.data(), rates.data());
  work_.constraints.write_lengths(lengths.data());
  std::vector<double> worst(work_.scales.size(), 0.0), shortest(work_.scales.size(), model_.scene_size);
  for (std::size_t a = 0; a < model_.num_rows(); ++a) {
    const std::size_t k = work_.scales.of_row(a);
    worst[k] = larger(worst[k], lacking[a]);
    shortest[k] = std::min(shortest[k], lengths[a]);
  }
  const std::vector<double> moves = work_.largest_norms(d.data());
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const std::size_t k = work_.scales.of_point(i);
    if (moves[k] > 0.0)
      add_to(r, i, std::min(1.0, factor * std::sqrt(2.0 * worst[k])) * shortest[k] / moves[k] * load(d.data(), i));
  }
  return {};
}

/// Computes d = (I - M^-1 K S^-1 K')(r* - r), minus the gradient of |r - r*|^2/2 on xi = 0, all in the M-norm.
Outcome NearestPoint::find_slope(const std::vector<double>& wanted, double t, const double* r, double* d) {
  if (Outcome outcome = linearization_.update(t, r); !outcome.ok()) return outcome;
  for (std::size_t i = 0; i < 3 * model_.num_points(); ++i) d[i] = wanted[i] - r[i];
  linearization_.apply_transposed(d, nullptr, rows_.data());
  linearization_.correct(rows_.data(), d);
  return {};
}

/// Returns true if the rest d is small beside the displacement of each neighbourhood, its length, and the rounding of
/// its positions.
bool NearestPoint::is_nearest(const double* r, const std::vector<double>& wanted, const double* d) const {
  std::vector<double> way(r, r + 3 * model_.num_points());
  for (std::size_t i = 0; i < 3 * model_.num_points(); ++i) way[i] -= wanted[i];
  const std::vector<double> left = work_.largest_norms(d), ways = work_.largest_norms(way.data()),
                            places = work_.largest_norms(r);
  for (std::size_t k = 0; k < left.size(); ++k) {
    const double nearly_0 = std::max({1e-10 * ways[k], 1e-13 * work_.scales.length(k), 4.0 * eps * places[k]});
    if (!(left[k] <= nearly_0)) return false;
  }
  return true;
}

/// Returns a'M b over the moving points.
double NearestPoint::product(const double* a, const double* b) const {
  return model_.parallel.sum(model_.num_moving(),
                             [&](std::size_t i) { return model_.mass[i] * dot(load(a, i), load(b, i)); });
}

ProjectionReport NearestPoint::find(double t, double* r) {
  if (model_.num_rows() == 0) return {};
  std::vector<double> wanted(r, r + 3 * model_.num_points());
  ProjectionReport report = reach_from_bent(t, r, &wanted);
  if (!report.outcome.ok() || std::ranges::equal(wanted, std::span(r, wanted.size()))) return report;

  // Descend along xi = 0. Full steps serve where r* is near. Where the curvature of the constraints matters, the step
  // length is that of Barzilai & Borwein (1988), s's/s'y with the last move s and the change y of the gradient.
  constexpr int most_iterations = 1000;
  constexpr double slack = 1.0 + 1e-11;  // the distance contains the rounding of xi = 0
  const auto distance = [&](const double* x) {
    return model_.parallel.sum(model_.num_moving(), [&](std::size_t i) {
      const Vec3 away = load(x, i) - load(wanted.data(), i);
      return model_.mass[i] * dot(away, away);
    });
  };
  std::vector<double> d(wanted.size()), trial, trial_d;
  if (report.outcome = find_slope(wanted, t, r, d.data()); !report.outcome.ok()) return report;
  double length = 1.0;
  for (; report.iterations < most_iterations && length > 1e-9; ++report.iterations) {
    if (is_nearest(r, wanted, d.data())) break;
    for (std::vector<double>* array : {&trial, &trial_d}) array->resize(wanted.size());
    for (std::size_t i = 0; i < 3 * model_.num_points(); ++i) trial[i] = r[i] + length * d[i];
    const ProjectionReport reached = projector_.project_positions(t, trial.data());
    const bool is_nearer = reached.outcome.ok() && distance(trial.data()) <= slack * distance(r);
    if (!is_nearer || !find_slope(wanted, t, trial.data(), trial_d.data()).ok()) {
      length *= 0.25;
      continue;
    }
    report.violation = reached.violation;
    for (std::size_t i = 0; i < 3 * model_.num_points(); ++i) {
      d[i] -= trial_d[i];
      r[i] = trial[i] - r[i];
    }
    const double curvature = product(r, d.data());
    length = curvature > 0.0 ? product(r, r) / curvature : 1.0;
    std::copy(trial.begin(), trial.end(), r);
    d = trial_d;
  }
  return report;
}

}  // namespace tanor::detail
