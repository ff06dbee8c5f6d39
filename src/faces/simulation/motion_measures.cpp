#include "simulation/motion_measures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <span>
#include <string>

#include "base/checksum.hpp"
#include "base/numbers.hpp"
#include "base/text.hpp"
#include "base/vec3.hpp"
#include "base/with_unit.hpp"

namespace tanor {
using namespace detail;

double EnergyReport::drift_relative() const {
  const double drift =
      now - start - work_of_supports - work_of_forces - work_of_potentials - work_of_friction - work_of_impacts;
  return scale > 0.0 ? drift / scale : 0.0;
}

namespace {

constexpr double rounding_of_energies = 1e8 * std::numeric_limits<double>::epsilon();
/// A kinetic energy of so many times all that there was to feed it comes from nowhere.
constexpr double surge = 100.0;

}  // namespace

void MotionMeasures::begin() {
  has_pairs_ = form_.any(work_.forces.has_pairs());
  const Energy energy = form_.energy(state_.t, state_.x.data(), state_.v.data());
  report_.energy.start = energy.kinetic + energy.potential;
  note(energy);
  report_.energy.potential_at_start = energy.potential;
  report_.energy.scale = std::max(
      rounding_of_energies * (std::abs(energy.potential) + energy_of_a_fall() + energy_of_a_move()), energy.kinetic);
  supply_ = report_.energy.scale;
  warn_of_tolerance();
  report_.violation.position = form_.largest(work_.position_violation(state_.t, points_.r.data()));
  report_.violation.velocity = form_.largest(work_.velocity_violation(state_.t, points_.r.data(), points_.v.data()));
  report_.violation.acceleration = state_.report.residual;
  report_.last_violation = report_.violation;
}

void MotionMeasures::note(const Energy& energy) {
  report_.energy.kinetic = energy.kinetic;
  report_.energy.potential = energy.potential;
  report_.energy.now = energy.kinetic + energy.potential;
}

void MotionMeasures::resume() {
  warns_of_drift_ = is_drifting() && report_.accuracy_warning == explain_drift();
  supply_ = report_.energy.scale;
}

/// Takes the violations from the projections; without projections they are measured here.
void MotionMeasures::measure_violations(const StepResult& step) {
  double position = step.position_violation, velocity = step.velocity_violation;
  if (options_.stabilisation == Stabilisation::None || !step.is_stabilized) {
    write_points();
    position = form_.largest(work_.position_violation(state_.t, points_.r.data()));
    velocity = form_.largest(work_.velocity_violation(state_.t, points_.r.data(), points_.v.data()));
  }
  report_.last_violation.position = position;
  report_.last_violation.velocity = velocity;
  report_.violation.position = std::max(report_.violation.position, position);
  report_.violation.velocity = std::max(report_.violation.velocity, velocity);
}

void MotionMeasures::take(const StepResult& step, bool is_sound) {
  ++report_.steps;
  report_.time = state_.t;
  measure_violations(step);
  if (step.is_stabilized && integration_.knows_acceleration()) measure_acceleration();
  const Energy energy = form_.energy(state_.t, state_.x.data(), state_.v.data());
  note(energy);
  report_.energy.work_of_supports = state_.work.supports;
  report_.energy.work_of_forces = state_.work.forces;
  report_.energy.work_of_potentials = state_.work.potentials;
  report_.energy.work_of_friction = state_.work.friction;
  report_.energy.work_of_impacts = state_.work.impacts;
  report_.energy.scale = std::max(
      {report_.energy.scale, energy.kinetic, std::abs(energy.potential - report_.energy.potential_at_start),
       rounding_of_energies * std::abs(energy.potential), std::abs(state_.work.supports), std::abs(state_.work.forces),
       std::abs(state_.work.potentials), std::abs(state_.work.friction), std::abs(state_.work.impacts)});
  supply_ = std::max({supply_, report_.energy.potential_at_start - energy.potential, state_.work.supports,
                      state_.work.forces, state_.work.potentials, state_.work.friction});
  if (energy.kinetic > surge * supply_) {
    ++surges_;
    supply_ = energy.kinetic;
  }
  if (model_.has_friction()) measure_friction(is_sound);
  watch_accuracy();
  report_.counters = work_.counters;
  report_.times = work_.times;
}

/// The kinetic energy is at most the sum of what was there at the start, what the potential has given up, and the works
/// of supports, forces, potentials and friction. Steps that pass over a force may miss its work once. Where the energy
/// grows so much again and again, steps are unstable, and nothing of the motion is left.
Outcome MotionMeasures::check_growth() const {
  constexpr int most_surges = 2;
  if (integration_.scheme().is_adaptive() || surges_ <= most_surges) return {};
  return {Status::NotFinite, "steps of a fixed length are unstable: the kinetic energy has grown to " +
                                 with_unit(text(report_.energy.kinetic), model_.system.units.energy) + " at t = " +
                                 text(state_.t) + ", and comes from nowhere; shorten the step, or take method radau5"};
}

/// Takes over K'w + phi of the state's accelerations.
void MotionMeasures::measure_acceleration() {
  report_.last_violation.acceleration = state_.report.residual;
  report_.violation.acceleration = std::max(report_.violation.acceleration, state_.report.residual);
}

/// Returns the energies of a motion through the length and at the speed of each neighbourhood, J.
double MotionMeasures::energy_of_a_fall() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const double speed = work_.scales.speed(work_.scales.of_point(i));
    sum += 0.5 * model_.mass[i] * speed * speed;
  }
  return form_.sum(sum);
}

/// Returns by how much the potential changes at the start if each point is moved by a hundredth of its neighbourhood's
/// length, J. Stiff energies may cancel each other at rest.
double MotionMeasures::energy_of_a_move() {
  if (has_pairs_) return 0.0;
  constexpr double part = 0.01;
  moved_ = points_.r;
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const double length = work_.scales.length(work_.scales.of_point(i));
    add_to(moved_.data(), static_cast<Index>(i), part * length * direction_of(i));
  }
  const double change = change_of_potential();
  if (!integration_.scheme().is_adaptive()) moved_ = {};  // fixed steps ask for no other move
  return change;
}

/// Returns the change of the potential from the points to `moved_`, J; 0 if it has no value there. Do not call it with
/// pair forces, whose lists would have to be made anew and which are soft beside stiff energies.
double MotionMeasures::change_of_potential() {
  form_.fetch_guests(moved_.data(), nullptr);
  const double moved = form_.potential(state_.t, moved_.data());
  const double here = form_.potential(state_.t, points_.r.data());
  const double change = std::abs(moved - here);
  return std::isfinite(change) ? change : 0.0;
}

/// Returns an irregular direction for a moving point, with components in [-1, 1] that depend only on where the point
/// was given, so that they are the same for any distribution of points over ranks.
Vec3 MotionMeasures::direction_of(std::size_t i) const {
  constexpr std::uint64_t most = std::uint64_t{1} << 24;
  Checksum sum;
  sum.add(std::span(model_.system.positions).subspan(3 * static_cast<std::size_t>(model_.numbering.user_point[i]), 3));
  const std::size_t first = 3 * static_cast<std::size_t>(sum.value() % most);
  return {irregular(first), irregular(first + 1), irregular(first + 2)};
}

/// Warns of an absolute tolerance that leaves a neighbourhood less than four digits.
void MotionMeasures::warn_of_tolerance() {
  constexpr double coarse = 1e-4;
  if (!integration_.scheme().is_adaptive() || !(options_.atol > 0.0)) return;
  double smallest = std::numeric_limits<double>::max();
  for (std::size_t k = 0; k + 1 < work_.scales.size(); ++k) smallest = std::min(smallest, work_.scales.length(k));
  const double length = form_.smallest(smallest);
  if (!(options_.atol > coarse * length)) return;
  const std::string& unit = model_.system.units.length;
  report_.accuracy_warning = "the absolute tolerance, " + with_unit(text(options_.atol), unit) + ", is " +
                             text(options_.atol / length) + " of the size of what moves, " +
                             with_unit(text(length), unit) + "; left out, it is 1e-10 of that size";
}

/// Returns true if the energy misses `drift`, J, which is more than velocities and positions within some thousand
/// tolerances explain, as at the start of a motion or at rest.
bool MotionMeasures::is_beyond_tolerances(double drift) {
  constexpr double tolerances = 1e4;
  if (!integration_.scheme().is_adaptive()) return drift > 0.0;
  // The sum below is at least this, from the part rtol v of dv alone.
  if (drift <= tolerances * options_.rtol * 2.0 * report_.energy.kinetic) return false;
  write_points();
  double sum = 0.0;
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const double speed = norm(load(points_.v.data(), i)), atol = work_.scales.velocity_tolerance(options_.atol, i);
    // The terms are m v dv and m a dr.
    const double of_velocity = (speed + tolerances * atol) * (atol + options_.rtol * speed);
    const double acceleration = work_.scales.accelerations()[i];
    const double dr = work_.scales.position_tolerance(options_.atol, i);
    sum += tolerances * model_.mass[i] * (of_velocity + acceleration * dr);
  }
  sum = form_.sum(sum);
  if (has_pairs_ || drift <= sum) return drift > sum;
  // The change of potential adds dr'W dr/2 of stiff forces, also where forces balance.
  moved_ = points_.r;
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const double dr = work_.scales.position_tolerance(options_.atol, i);
    add_to(moved_.data(), static_cast<Index>(i), tolerances * dr * direction_of(i));
  }
  return drift > sum + change_of_potential();
}

/// Warns if steps cannot follow the motion, which shows in a fixed step that turns it far or in a drift of the energy.
void MotionMeasures::watch_accuracy() {
  constexpr double longest_turn = 0.4;
  std::string& warning = report_.accuracy_warning;
  if (!warning.empty() && !warns_of_drift_) return;
  const double turn = integration_.scheme().is_adaptive() ? 0.0 : integration_.turn();
  watch_drift(turn);
  const bool is_too_long = turn > longest_turn;
  warns_of_drift_ = !is_too_long && is_drifting();
  if (is_too_long)
    warning = "steps may be too long: one turns the motion by " + text(turn) + " at t = " + text(state_.t);
  else if (warns_of_drift_)
    warning = explain_drift();
  else
    warning.clear();
}

void MotionMeasures::watch_drift(double turn) {
  const bool is_adaptive = integration_.scheme().is_adaptive();
  EnergyReport& energy = report_.energy;
  const double drift = std::abs(energy.drift_relative()) * energy.scale;
  if (!(drift > energy.largest_drift) || !(is_adaptive || turn > 0.0) || !is_beyond_tolerances(drift)) return;
  energy.largest_drift = drift;
  energy.largest_drift_time = state_.t;
}

/// Compares the drift with all energy that has flowed so far.
bool MotionMeasures::is_drifting() const {
  constexpr double largest_drift = 1e-2, least_drift = 1e-4, drift_of_rtol = 1e4;
  const bool is_adaptive = integration_.scheme().is_adaptive();
  const double allowed =
      is_adaptive ? std::clamp(drift_of_rtol * options_.rtol, least_drift, largest_drift) : largest_drift;
  return report_.energy.largest_drift > allowed * report_.energy.scale;
}

std::string MotionMeasures::explain_drift() const {
  const EnergyReport& energy = report_.energy;
  return std::string(integration_.scheme().is_adaptive() ? "the tolerance may be missed: "
                                                         : "steps may be too long: ") +
         "the energy drifts by " + text(energy.largest_drift / energy.scale) +
         " of its scale at t = " + text(energy.largest_drift_time);
}

/// Measures friction at a step's end; iterations are counted wherever friction was found.
void MotionMeasures::measure_friction(bool is_sound) {
  const FrictionReport& last = state_.report.friction;
  FrictionSummary& all = report_.friction;
  all.solves = work_.counters.friction_solves;
  const auto iterations = static_cast<double>(work_.counters.friction_iterations);
  all.iterations_mean = all.solves > 0 ? iterations / static_cast<double>(all.solves) : 0.0;
  all.iterations_max = std::max(all.iterations_max, last.iterations);
  all.contraction_max = std::max(all.contraction_max, last.contraction);
  all.residual_max = std::max(all.residual_max, last.residual);
  all.method_used = std::max(all.method_used, last.method_used);
  const bool is_first = all.uniqueness == Uniqueness::NotAsked;
  if (is_first || std::isnan(last.error_bound) || last.error_bound > all.error_bound)
    all.error_bound = last.error_bound;
  if (last.uniqueness > all.uniqueness) all.uniqueness_reason = last.uniqueness_reason;
  all.uniqueness = std::max(all.uniqueness, last.uniqueness);
  if (is_sound && last.uniqueness == Uniqueness::Several && all.several++ == 0) all.first_several = state_.t;
}

void MotionMeasures::write_points() {
  form_.write_points(state_.at(), state_.a.data(), state_.reactions, points_.r.data(), points_.v.data(),
                     points_.w.data());
}

}  // namespace tanor
