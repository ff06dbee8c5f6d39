#include "motion/vanishing_arms.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/text.hpp"

namespace tanor::detail {

namespace {

constexpr std::size_t num_places = 5;  // at which a step shows whether an arm may vanish in it
/// An arm vanishes that gets shorter than this part of its length where the step begins. A step that resolves a narrow
/// passage begins nearer to it.
constexpr double vanishes = 1e-6;
// Lengths over the distance of their ends from the origin.
constexpr double arm_rounding = 1e-12;  // to which states are projected
constexpr double unresolved = 1e-9;     // rounding turns the direction of so short an arm, and steps stall
constexpr double never = std::numeric_limits<double>::max();

/// Returns the first positive root of d + v t + a t^2/2 with d > 0, in the form without cancellation; infinity if there
/// is none.
double first_root(double d, double v, double a) {
  const double under = v * v - 2.0 * a * d, root = std::sqrt(std::max(under, 0.0));
  const double first = v < 0.0 ? 2.0 * d / (root - v) : -(root + v) / a;
  return under >= 0.0 && first >= 0.0 ? first : std::numeric_limits<double>::infinity();
}

}  // namespace

/// A step on which arms are evaluated.
struct VanishingArms::Path {
  VanishingArms& self;
  const State &from, &to;
  DenseOutput* dense;

  const std::vector<Vec3>& at(double fraction) const {
    if (fraction == 0.0) return self.evaluate(from.at());
    if (fraction == 1.0) return self.evaluate(to.at());
    (void)dense->evaluate(self.mechanics_.parallel(), fraction, self.x_.data(), self.v_.data());  // nothing is prepared
    self.mechanics_.prescribe(dense->time(fraction), self.x_.data(), self.v_.data());
    return self.evaluate({dense->time(fraction), self.x_.data(), self.v_.data()});
  }
};

VanishingArms::VanishingArms(const IntegrationOptions& options, Mechanics& mechanics)
    : mechanics_(mechanics), miss_(std::max(arm_rounding, 100.0 * options.rtol)) {}

void VanishingArms::watch(Arms arms) {
  arms_ = std::move(arms);
  vectors_.resize(arms_.count);
  is_empty_ = !mechanics_.any(arms_.count > 0);
  for (std::vector<double>* array : {&x_, &v_}) array->resize(is_empty_ ? 0 : mechanics_.size());
}

const std::vector<Vec3>& VanishingArms::evaluate(const Kinematics& at) {
  arms_.evaluate(at, vectors_.data());
  return vectors_;
}

std::optional<VanishingArms::Found> VanishingArms::find(Scheme& scheme, const State& from, const State& to) {
  DenseOutput dense(scheme, from, to, !scheme.interpolates_at_once());
  const Path path{*this, from, to, &dense};
  samples_.resize(num_places);
  for (std::size_t i = 0; i < num_places; ++i)
    samples_[i] = path.at(static_cast<double>(i) / static_cast<double>(num_places - 1));
  Found first{never, {}, {}};
  for (std::size_t k = 0; k < arms_.count; ++k) {
    double least = norm(samples_[0][k]), chord = 0.0;
    for (std::size_t i = 1; i < num_places; ++i) {
      least = std::min(least, norm(samples_[i][k]));
      chord = std::max(chord, norm(samples_[i][k] - samples_[i - 1][k]));
    }
    const double given = when_given_ends(k, from.t, to.t - from.t);
    if (given < first.time) first = {given, k, 1.0 / norm(samples_[0][k]) * samples_[0][k]};
    if (given < never || least > chord) continue;
    if (const auto found = examine(path, k); found && found->time < first.time) first = *found;
  }
  mechanics_.prescribe(to.t, x_.data(), v_.data());
  return agree(first);
}

bool VanishingArms::are_short(const State& from, const State& to) {
  constexpr double wide = 2.0;
  const double h = to.t - from.t;
  samples_.resize(num_places);
  const std::vector<Vec3>&begin = samples_[0] = evaluate(from.at()),
        &ahead = samples_[1] = evaluate_ahead(from, h, 0.0), &end = samples_[2] = evaluate(to.at());
  bool is_short = false;
  for (std::size_t k = 0; k < arms_.count && !is_short; ++k)
    is_short = norm(begin[k]) <= std::max(wide * std::max(norm(ahead[k] - begin[k]), norm(end[k] - begin[k])),
                                          unresolved * arms_.size(from.at(), k));
  return mechanics_.any(is_short);
}

/// Returns the first arm of all processes; nothing if there is none.
std::optional<VanishingArms::Found> VanishingArms::agree(const Found& first) {
  const double time = mechanics_.smallest(first.time);
  if (time == never) return {};
  return first.time == time ? first : Found{time, {}, {}};
}

/// Returns the length below which arm k vanishes, m, if it has this length at a state.
double VanishingArms::nearest(const State& from, std::size_t k, double length) const {
  return vanishes * length + miss_ * arms_.size(from.at(), k);
}

/// Follows one arm along its direction where the step begins. It has vanished where only its rounding is left at the
/// end.
std::optional<VanishingArms::Found> VanishingArms::examine(const Path& path, std::size_t k) {
  const Vec3 begin = samples_.front()[k];
  const double length = norm(begin);
  if (!(length > 0.0)) return {};
  const Vec3 direction = 1.0 / length * begin;
  const auto along = [&](double s) { return dot(path.at(s)[k], direction); };
  std::array<double, RootIsolation::places.size()> values{};
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = along(RootIsolation::places[i]);
  const double resolution = time_resolution(path.to.t, path.to.t - path.from.t) / (path.to.t - path.from.t);
  isolation_.isolate(values, along, {0.0, resolution});
  const auto samples = isolation_.samples();
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    if (!(samples[i].value > 0.0 && samples[i + 1].value <= 0.0)) continue;
    const double root = isolation_.find_root(i, along);
    if (norm(path.at(root)[k]) <= nearest(path.from, k, length)) return Found{path.dense->time(root), k, direction};
  }
  if (norm(samples_.back()[k]) <= arm_rounding * arms_.size(path.to.at(), k)) return Found{path.to.t, k, direction};
  return {};
}

/// Returns the time at which the length that arm k is given vanishes, at most `within` after t; `never` if it does not.
double VanishingArms::when_given_ends(std::size_t k, double t, double within) const {
  double before = t, after = t + within;
  if (arms_.given_length(after, k) > 0.0) return never;
  for (double middle = 0.5 * (before + after); before < middle && middle < after; middle = 0.5 * (before + after))
    (arms_.given_length(middle, k) > 0.0 ? before : after) = middle;
  return after;
}

/// Evaluates the arms at x + by_v v + by_a a.
const std::vector<Vec3>& VanishingArms::evaluate_ahead(const State& state, double by_v, double by_a) {
  for (std::size_t i = 0; i < x_.size(); ++i) x_[i] = state.x[i] + by_v * state.v[i] + by_a * state.a[i];
  return evaluate({state.t, x_.data(), state.v.data()});
}

double VanishingArms::time_left(const Found& arm, const State& state, bool knows_acceleration) {
  double left = 0.0;
  if (arm.own) {
    const std::size_t k = *arm.own;
    const double d = dot(evaluate(state.at())[k], arm.direction);
    const double v = dot(evaluate_ahead(state, 1.0, 0.0)[k], arm.direction) - d;
    const double a = knows_acceleration ? dot(evaluate_ahead(state, 0.0, 1.0)[k], arm.direction) - d : 0.0;
    const bool is_given = std::isfinite(arms_.given_length(state.t, k));
    left = is_given ? arm.time - state.t : d > 0.0 ? std::min(first_root(d, v, a), never) : -never;
  }
  return arm.own ? mechanics_.largest(left) : mechanics_.largest(-never);
}

bool VanishingArms::is_unresolved(const Found& arm, const State& state) {
  const bool is_own = arm.own && norm(evaluate(state.at())[*arm.own]) <= unresolved * arms_.size(state.at(), *arm.own);
  return mechanics_.any(is_own);
}

double VanishingArms::rounding_of_time(const Found& arm, const State& state) {
  double own = 0.0;
  if (arm.own) {
    const std::size_t k = *arm.own;
    const double d = dot(evaluate(state.at())[k], arm.direction);
    const double v = dot(evaluate_ahead(state, 1.0, 0.0)[k], arm.direction) - d;
    own = arm_rounding * arms_.size(state.at(), k) / std::max(std::abs(v), std::numeric_limits<double>::min());
  }
  return mechanics_.largest(own);
}

std::optional<VanishingArms::Found> VanishingArms::find_ahead(const State& state, bool knows_acceleration,
                                                              double within) {
  samples_.resize(num_places);
  const std::vector<Vec3>&now = samples_[0] = evaluate(state.at()),
        &by_v = samples_[1] = evaluate_ahead(state, 1.0, 0.0),
        &by_a = samples_[2] = evaluate_ahead(state, 0.0, knows_acceleration ? 1.0 : 0.0);
  Found first{never, {}, {}};
  for (std::size_t k = 0; k < now.size(); ++k) {
    const double length = norm(now[k]);
    if (!(length > 0.0)) continue;
    const Vec3 direction = 1.0 / length * now[k], v = by_v[k] - now[k], a = by_a[k] - now[k];
    if (const double given = when_given_ends(k, state.t, within); given < first.time) first = {given, k, direction};
    if (std::isfinite(arms_.given_length(state.t, k))) continue;
    const double t = first_root(length, dot(v, direction), dot(a, direction));
    if (t > within && length > unresolved * arms_.size(state.at(), k)) continue;
    if (!(t < never) || norm(now[k] + t * v + 0.5 * t * t * a) > nearest(state, k, length)) continue;
    if (state.t + t < first.time) first = {state.t + t, k, direction};
  }
  return agree(first);
}

Outcome VanishingArms::explain(const Found& arm, double t) const {
  const std::string name = arm.own ? arms_.name(*arm.own) : "a length that must stay positive, on another rank,";
  return {Status::Singular, name + " has run out at t = " + text(t)};
}

}  // namespace tanor::detail
