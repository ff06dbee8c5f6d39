#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/stopwatch.hpp"
#include "base/text.hpp"
#include "dynamics/normal_form.hpp"

/// \file Projections of NormalForm: chord iterations after a step, the nearest place from far away.
namespace tanor {

namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double friction_is_settled = 1e-11;  // relative
constexpr int most_friction_iterations = 100;
constexpr double rounding = 1e-9;  // of velocities, relative; more is no rounding

}  // namespace

/// |xi|/length cannot be smaller than the rounding of the positions: eps |r|/L, where that is largest.
double NormalForm::rounding_floor(const double* r) const {
  return 4.0 * eps * std::max(1.0, model_.largest_norm(r) / model_.smallest_length);
}

ProjectionReport NormalForm::project_positions(double t, double* r, Turn turn) {
  // Less than this takes one or two iterations along any slope.
  constexpr double far = 1e-10;
  return iterate_onto_positions(t, r, nullptr, turn == Turn::Large && linearises_cheaply_ ? far : infinity);
}

ProjectionReport NormalForm::project_step(double t, double h, double* r, double* step_velocity) {
  // The sum of the multipliers is h^2 times a smooth function of time (half of lambda): extrapolated from the last two
  // steps it saves iterations, the solution is the same.
  StepMultipliers& step = step_multipliers_;
  const double scale = h * h;
  if (const std::size_t frames = model_.constraints.frames(); frames != step.frames) {
    std::fill(step.last.begin(), step.last.end(), 0.0);
    std::fill(step.before.begin(), step.before.end(), 0.0);
    step.frames = frames;
  }
  // Over the square of a short step they are rounding, as where one was cut at an event.
  constexpr double short_step = 0.1;
  const bool can_guess = std::min(step.last_h, step.before_h) >= short_step * std::abs(h);
  model_.parallel.for_ranges(num_rows(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) {
      step.sum[a] = can_guess ? scale * (2.0 * step.last[a] - step.before[a]) : 0.0;
    }
  });
  if (redundancy_.is_found()) step_start_.assign(r, r + size());
  if (!is_of_schur_) {  // they take the guess by themselves
    model_.gather.add_scaled(model_.parallel, blocks_.data(), step.sum.data(), model_.inverse_mass.data(),
                             model_.num_moving(), r);
  }

  ProjectionReport report = iterate_onto_positions(t, r, step.sum.data());
  if (!report.outcome.ok() && redundancy_.is_found()) {
    // Rows that depended when K was seen last may be independent where the step begins.
    if (!decide_rank_again(step_start_.data())) return project_singular_step(t, h, r, step_velocity);
    std::copy(step_start_.begin(), step_start_.end(), r);
    std::fill(step.sum.begin(), step.sum.end(), 0.0);
    report = iterate_onto_positions(t, r, step.sum.data());
  }
  if (!report.outcome.ok()) return report;  // a failed step leaves no trace in the next guess
  step.before_h = std::exchange(step.last_h, std::abs(h));

  model_.parallel.for_ranges(num_rows(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) {
      step.before[a] = step.last[a];
      step.last[a] = step.sum[a] / scale;
      step.sum[a] /= h;
    }
  });
  // The velocity takes the same multipliers: no digits cancel in (r - r0)/h.
  if (is_of_schur_) {
    schur_->add_reactions(model_.parallel, blocks_.data(), step.sum.data(), step_velocity);
  } else {
    model_.gather.add_scaled(model_.parallel, blocks_.data(), step.sum.data(), model_.inverse_mass.data(),
                             model_.num_moving(), step_velocity);
  }
  return steps_with_friction() ? settle_step_friction(t, h, r, step_velocity, report) : report;
}

/// The step's own multipliers, lambda = 2 sum/h^2, say what its friction is: (43), each iteration one projection from
///
///   r += h^2/2 M^-1 dtau,   v1/2 += h/2 M^-1 dtau
ProjectionReport NormalForm::settle_step_friction(double t, double h, double* r, double* step_velocity,
                                                  ProjectionReport report) {
  StepMultipliers& step = step_multipliers_;
  for (int k = 0; k < most_friction_iterations; ++k) {
    for (std::size_t a = 0; a < num_rows(); ++a) rows_[a] = 2.0 * step.last[a];
    const Stopwatch watch(&model_.times.friction);
    const double change = friction_->change_to(rows_.data(), 0.5 * h, step_velocity);
    friction_->add_change(0.5 * h * h, r);
    if (change <= friction_is_settled) return report;
    ++model_.counters.friction_iterations;
    std::fill(step.sum.begin(), step.sum.end(), 0.0);
    const ProjectionReport again = iterate_onto_positions(t, r, step.sum.data());
    report.iterations += again.iterations;
    report.violation = again.violation;
    if (report.outcome = again.outcome; !report.outcome.ok()) return report;
    for (std::size_t a = 0; a < num_rows(); ++a) {
      step.last[a] += step.sum[a] / (h * h);
      step.sum[a] /= h;
    }
    model_.gather.add_scaled(model_.parallel, blocks_.data(), step.sum.data(), model_.inverse_mass.data(),
                             model_.num_moving(), step_velocity);
  }
  report.outcome = friction_stalls(t);
  return report;
}

/// Away from a place where K has less rank than around it: its range does not lead onto xi = 0, Newton's own does.
ProjectionReport NormalForm::project_singular_step(double t, double h, double* r, double* step_velocity) {
  std::copy(step_start_.begin(), step_start_.end(), r);
  if (Outcome outcome = linearise(t, r); !outcome.ok()) return {std::move(outcome)};
  ProjectionReport report = project_positions(t, r);
  if (!report.outcome.ok()) return report;
  for (std::size_t i = 0; i < size(); ++i) step_velocity[i] += (r[i] - step_start_[i]) / h;
  return report;
}

/// Chord iterations along M^-1 K of the last linearisation, or the one at r where the violation is above `far`; adds up
/// the multipliers where wanted (and then the slope is never renewed, since they belong to one K).
ProjectionReport NormalForm::iterate_onto_positions(double t, double* r, double* sum, double far) {
  model_.set_time(t);
  ProjectionReport report;
  if (num_rows() == 0) return report;
  if (contacts_ != nullptr) contacts_->carry_places(t);
  constexpr double target = 1e-13, largest_left = 1e-12;
  constexpr int most_iterations = 100;
  double before = infinity, left_before = infinity;
  bool linearised_here = false, decided_here = false;
  if (is_of_schur_) {
    project_islands(target, r, sum, &report);
    if (report.violation <= target || beyond_rounding(r, report.violation, target, 1.0) == 0.0) return report;
  }
  for (;; ++report.iterations) {
    report.violation = evaluate_values(r);
    if (!std::isfinite(report.violation)) {
      report.outcome = model_.not_finite(t);
      return report;
    }
    if (report.violation <= target) return report;
    bool stalls = report.violation > 0.3 * before, stands = report.violation > 0.99 * before;
    if (stalls) {
      // Some neighbourhood may be at its rounding while others are on their way.
      const double left = beyond_rounding(r, report.violation, target, 1.0);
      if (left == 0.0) return report;
      stalls = left > 0.3 * left_before || left == report.violation;
      stands = stalls && left > 0.99 * std::min(before, left_before);
      left_before = left;
    }
    const bool hopeless = stands && (linearised_here || sum != nullptr);
    if (report.iterations == most_iterations || hopeless) {
      const double left_over = beyond_rounding(r, report.violation, largest_left, 2.0);
      // Rows that depended when K was seen last may be independent here.
      if (left_over > 0.0 && sum == nullptr && !decided_here) {
        decided_here = true;
        before = left_before = infinity;
        if (decide_rank_again(r)) continue;
      }
      if (left_over > 0.0) report.outcome = explain_stall(t, report.violation);
      return report;
    }
    const bool is_far = report.iterations == 0 && report.violation > far;
    if ((stalls || is_far) && sum == nullptr) {
      // The chord's slope is too old: Newton's own.
      if (report.outcome = linearise(t, r); !report.outcome.ok()) return report;
      linearised_here = true;
    }
    before = report.violation;
    // S mu = -xi, r += M^-1 K mu
    correct(rows_.data(), r);
    if (sum != nullptr) {
      model_.parallel.for_ranges(num_rows(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t a = begin; a < end; ++a) sum[a] += rows_[a];
      });
    }
  }
}

ProjectionReport NormalForm::project_velocities(double t, const double* r, double* v) {
  return iterate_onto_velocities(t, r, v, nullptr);
}

/// The same with the multipliers of the second half of a step, lambda = 2 nu/h.
ProjectionReport NormalForm::project_step_velocities(double t, double h, const double* r, double* v) {
  if (!steps_with_friction()) return project_velocities(t, r, v);
  std::vector<double>& sum = step_multipliers_.sum;
  std::fill(sum.begin(), sum.end(), 0.0);
  ProjectionReport report;
  for (int k = 0; k < most_friction_iterations; ++k) {
    const ProjectionReport again = iterate_onto_velocities(t, r, v, sum.data());
    report.iterations += again.iterations;
    report.violation = again.violation;
    if (report.outcome = again.outcome; !report.outcome.ok()) return report;
    for (std::size_t a = 0; a < num_rows(); ++a) rows_[a] = 2.0 / h * sum[a];
    const Stopwatch watch(&model_.times.friction);
    if (friction_->change_to(rows_.data(), 0.5 * h, v) <= friction_is_settled) return report;
    ++model_.counters.friction_iterations;
  }
  report.outcome = friction_stalls(t);
  return report;
}

/// Some contact slides under a law that reads multipliers.
bool NormalForm::steps_with_friction() const {
  return friction_ != nullptr && friction_->depends_on_multipliers();
}

Outcome NormalForm::friction_stalls(double t) const {
  return {Status::NotConverged, "friction at t = " + text(t) + ": the iteration for the step's multipliers stalls"};
}

/// Adds up the multipliers where wanted.
ProjectionReport NormalForm::iterate_onto_velocities(double t, const double* r, double* v, double* sum) {
  model_.set_time(t);
  ProjectionReport report;
  if (num_rows() == 0) return report;
  constexpr double target = 1e-13;
  // What sticks stands still: there is no rounding that may add up to a creep.
  const bool holds_contacts = friction_ != nullptr && friction_->num_sticking() > 0;
  double before = infinity, least = infinity;
  int since_least = 0;
  bool decided_here = false;
  if (is_of_schur_ && sum == nullptr) {
    project_island_velocities(target, r, v, &report);
    if (report.violation <= target) return report;
  }
  for (;; ++report.iterations) {
    const double rate = evaluate_rates(r, v);
    report.violation = relative_rates(rate);
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
    const bool stands = is_compliant() ? since_least == patience : !(report.violation < 0.5 * before);
    if (is_done || report.iterations == (is_compliant() ? most_conjugate : 4) || stands) {
      if (!redundancy_.is_found() || decided_here || report.violation <= rounding) return report;
      // A dependent row stays behind: it became independent, or contradicts the others.
      decided_here = true;
      if (!decide_rank_again(r)) {
        report.outcome = explain_contradiction(t, rows_, model_.scales.speeds(), rounding, " m/s");
        return report;
      }
    }
    before = report.violation;
    // S nu = -(K'v + xi_t), v += M^-1 K nu
    correct_conjugately(report.iterations == 0, rows_.data(), v);
    for (std::size_t a = 0; sum != nullptr && a < num_rows(); ++a) sum[a] += rows_[a];
  }
}

/// Some place on xi = 0, from anywhere: Newton's method in small moves, the last digits by chord iterations.
ProjectionReport NormalForm::reach_constraints(double t, double* r) {
  model_.set_time(t);
  constexpr int most_iterations = 100;
  constexpr double near = 1e-3;
  std::vector<double> next;  // big systems mostly start near enough
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const double violation = model_.constraints.evaluate_values(model_.parallel, r, rows_.data());
    if (violation <= near || !std::isfinite(violation)) break;
    if (Outcome outcome = linearise(t, r); !outcome.ok()) return {std::move(outcome), 0.0, violation, iteration};
    next.assign(r, r + size());
    correct(rows_.data(), next.data());
    // A full step may overshoot: at most a quarter of the neighbourhood at once.
    for (std::size_t i = 0; i < size(); ++i) next[i] -= r[i];
    const std::vector<double> moves = model_.largest_norms(next.data());
    for (std::size_t i = 0; i < model_.num_moving(); ++i) {
      const std::size_t k = model_.scales.of_point(i);
      add_to(r, i, std::min(1.0, 0.25 * model_.scales.length(k) / moves[k]) * load(next.data(), i));
    }
  }
  if (Outcome outcome = linearise(t, r); !outcome.ok()) return {std::move(outcome)};
  return project_positions(t, r);
}

/// d = (I - M^-1 K S^-1 K')(r* - r): minus the slope of |r - r*|^2/2 on xi = 0, all in the M-norm.
Outcome NormalForm::slope_towards(const std::vector<double>& wanted, double t, const double* r, double* d) {
  if (Outcome outcome = linearise(t, r); !outcome.ok()) return outcome;
  for (std::size_t i = 0; i < size(); ++i) d[i] = wanted[i] - r[i];
  model_.constraints.apply_transposed(model_.parallel, blocks_.data(), d, nullptr, rows_.data());
  correct(rows_.data(), d);
  return {};
}

/// What is left to go is little beside the way that each neighbourhood went, its length, and the rounding of places.
bool NormalForm::is_nearest(const double* r, const std::vector<double>& wanted, const double* d) const {
  std::vector<double> way(r, r + size());
  for (std::size_t i = 0; i < size(); ++i) way[i] -= wanted[i];
  const std::vector<double> left = model_.largest_norms(d), ways = model_.largest_norms(way.data()),
                            places = model_.largest_norms(r);
  for (std::size_t k = 0; k < left.size(); ++k) {
    const double nearly_0 = std::max({1e-10 * ways[k], 1e-13 * model_.scales.length(k), 4.0 * eps * places[k]});
    if (!(left[k] <= nearly_0)) return false;
  }
  return true;
}

ProjectionReport NormalForm::project_far(double t, double* r) {
  if (num_rows() == 0) return {};
  const std::vector<double> wanted(r, r + size());
  ProjectionReport report = reach_constraints(t, r);
  if (!report.outcome.ok()) return report;

  // Down the slope along xi = 0; full steps where r* is near, step lengths of Barzilai & Borwein (1988) where the
  // curvature of the constraints counts: s's/s'y with s the last move and y the change of the slope.
  constexpr int most_iterations = 1000;
  constexpr double slack = 1.0 + 1e-11;  // rounding of xi = 0 shows in the distance
  const auto product = [&](const auto& a, const auto& b) {
    return model_.parallel.sum(model_.num_moving(),
                               [&](std::size_t i) { return model_.mass[i] * dot(load(&a[0], i), load(&b[0], i)); });
  };
  const auto distance = [&](const double* x) {
    return model_.parallel.sum(model_.num_moving(), [&](std::size_t i) {
      const Vec3 away = load(x, i) - load(wanted.data(), i);
      return model_.mass[i] * dot(away, away);
    });
  };
  std::vector<double> d(size()), trial, trial_d;
  if (report.outcome = slope_towards(wanted, t, r, d.data()); !report.outcome.ok()) return report;
  double length = 1.0;
  for (; report.iterations < most_iterations && length > 1e-6; ++report.iterations) {
    if (is_nearest(r, wanted, d.data())) break;
    for (std::vector<double>* array : {&trial, &trial_d}) array->resize(size());
    for (std::size_t i = 0; i < size(); ++i) trial[i] = r[i] + length * d[i];
    const ProjectionReport reached = project_positions(t, trial.data());
    const bool is_nearer = reached.outcome.ok() && distance(trial.data()) <= slack * distance(r);
    if (!is_nearer || !slope_towards(wanted, t, trial.data(), trial_d.data()).ok()) {
      length *= 0.25;
      continue;
    }
    report.violation = reached.violation;
    for (std::size_t i = 0; i < size(); ++i) {
      d[i] -= trial_d[i];
      r[i] = trial[i] - r[i];
    }
    const double curvature = product(r, d);
    length = curvature > 0.0 ? product(r, r) / curvature : 1.0;
    std::copy(trial.begin(), trial.end(), r);
    d = trial_d;
  }
  return report;
}

}  // namespace tanor
