#include "motion/rounding.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "base/numbers.hpp"
#include "base/text.hpp"

namespace tanor::detail {

namespace {

/// Returns -1 or 1, always the same for the same i, so that no pattern of the system coincides with it.
double sign_of(std::size_t i) {
  // The finalizer of splitmix64 (Steele, Lea & Flood 2014)
  std::uint64_t z = (static_cast<std::uint64_t>(i) + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return (z >> 63) != 0 ? 1.0 : -1.0;
}

}  // namespace

Rounding::Rounding(const IntegrationOptions& options, Mechanics& mechanics)
    : options_(options),
      mechanics_(mechanics),
      groups_(options.stabilisation == Stabilisation::Projection ? mechanics.rounding_groups() : nullptr),
      num_groups_(groups_ != nullptr ? groups_->num_groups() : 0),
      is_measured_(groups_ != nullptr && mechanics.any(num_groups_ > 0)),
      may_jump_(mechanics.unseen_forces() != nullptr && mechanics.any(mechanics.unseen_forces()->may_jump())),
      whole_(num_groups_, 0.0),
      along_(num_groups_, 0.0),
      is_due_(is_measured_ ? 1.0 : 0.0),
      now_(num_groups_) {}

void Rounding::note_step(const State& from) {
  constexpr double steps_between = 64.0, clearly = 10.0;
  if (excess_ > clearly) {
    if (exceeding_.count++ == 0.0) exceeding_.since = from.t;
    exceeding_.sum_of_excesses += excess_;
  }
  ++num_steps_;
  rejected_ = {};
  caution_ = std::max(1.0, 0.99 * caution_);
  if (is_measured_ && num_steps_ - measured_at_ >= steps_between) is_due_ = 1.0;
}

/// Takes note of a rejected step. If the error of a shorter step did not fall with its order, and rounding is a good
/// part of it, rounding is larger than was measured. One rejection tells nothing about rounding if there was little.
void Rounding::note_rejection(double h, double error, int order) {
  if (!is_measured_) return;
  if (excess_ > 0.0 || rejected_.h > 0.0) is_due_ = 1.0;
  constexpr double good_part = 0.1;
  const bool has_fallen = error < rejected_.error * std::pow(h / rejected_.h, 0.5 * order);
  if (excess_ > good_part && rejected_.h > h && !has_fallen) caution_ = std::min(2.0 * caution_, most_caution);
  rejected_ = {h, error};
}

/// Finds a(x + dx, v + dv) with |dx| = eps |x| and |dv| = eps |v|, whose signs are those of sample k or opposite.
/// Returns false if there are no accelerations; the step itself reports that.
bool Rounding::accelerate_beside(const State& from, std::size_t k, double side) {
  auto& [t, x, v, a] = beside_;
  const std::size_t n = from.x.size(), first = 2 * n * k;
  t = from.t;
  for (std::vector<double>* array : {&x, &v, &a}) array->resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = from.x[i] + side * eps * sign_of(first + 2 * i) * std::abs(from.x[i]);
    v[i] = from.v[i] + side * eps * sign_of(first + 2 * i + 1) * std::abs(from.v[i]);
  }
  mechanics_.prescribe(t, x.data(), v.data());
  return mechanics_.accelerations({t, x.data(), v.data()}, options_.request(Gradients::Evaluate), a.data()).ok();
}

/// Returns the largest difference of the accelerations beside.
double Rounding::largest_difference(const State& from) const {
  double largest = 0.0;
  for (std::size_t i = 0; i < from.a.size(); ++i) largest = larger(largest, std::abs(beside_.a[i] - from.a[i]));
  return mechanics_.largest(largest);
}

/// Measures da, how accelerations beside differ. A force that jumps at x does so on one side of it alone, so the
/// smaller one of two opposite differences is rounding.
Outcome Rounding::measure(const State& from) {
  if (is_due_ == 0.0) return {};
  is_due_ = 0.0;
  measured_at_ = num_steps_;
  const auto sample = static_cast<std::size_t>(num_samples_++);
  const auto measure_beside = [&] {
    bool is_known = accelerate_beside(from, sample, 1.0);
    if (is_known && may_jump_) {
      const double difference = largest_difference(from);
      std::swap(beside_.a, other_);
      is_known = accelerate_beside(from, sample, -1.0);
      if (!(largest_difference(from) < difference)) std::swap(beside_.a, other_);
    }
    if (is_known && mechanics_.linearise(from.t, from.x.data()).ok()) take_sample(from);
  };
  return solve_aside(mechanics_, options_, from, std::cref(measure_beside), &aside_);
}

/// Finds the levels from da. The part of da that breaks constraints is projected away at the end of a step.
/// The part along them is what the projection leaves of v + s da, less v, where s makes s da as large as v.
void Rounding::take_sample(const State& from) {
  const std::size_t n = from.x.size();
  double fastest = 0.0;
  for (std::size_t i = 0; i < n; ++i) fastest = std::max(fastest, std::abs(from.v[i]));
  const double largest = largest_difference(from);
  fastest = mechanics_.largest(fastest);
  if (!(largest > 0.0 && std::isfinite(largest))) return;
  const double s = (fastest > 0.0 ? fastest : 1.0) / largest;
  for (std::size_t i = 0; i < n; ++i) beside_.v[i] = from.v[i] + s * (beside_.a[i] - from.a[i]);
  if (!mechanics_.project_velocities(from.t, from.x.data(), beside_.v.data()).outcome.ok()) return;
  // One sample may be small by chance, so that levels fall slowly.
  const auto note = [&](double unit, std::vector<double>* levels) {
    for (std::size_t k = 0; k < num_groups_; ++k) (*levels)[k] = std::max(now_[k] / unit, 0.9 * (*levels)[k]);
  };
  groups_->largest_differences(beside_.a.data(), from.a.data(), now_);
  note(1.0, &whole_);
  groups_->largest_differences(beside_.v.data(), from.v.data(), now_);
  note(s, &along_);
}

void Rounding::allow(const State& from, double h, const RoundingGain& gain) {
  if (!is_measured_) return;
  const StepTarget target{h, options_.atol, options_.rtol, from.x.data(), from.v.data()};
  excess_ =
      mechanics_.largest(groups_->allow_rounding({whole_, along_}, {caution_ * gain.factor, gain.is_damped}, target));
}

std::string Rounding::explain() const {
  constexpr double some = 0.05;  // part of the steps
  if (!(exceeding_.count > some * num_steps_)) return {};
  const auto [met, wanted] =
      texts_apart(std::array{options_.rtol * exceeding_.sum_of_excesses / exceeding_.count, options_.rtol});
  return "forces round to more than the tolerance from t = " + text(exceeding_.since) + " on: steps meet rtol " + met +
         ", not " + wanted;
}

void Rounding::exchange_memory(Memory& memory) {
  if (!is_measured_) return;
  memory.exchange(is_due_, num_samples_, num_steps_, measured_at_, caution_, rejected_.h, rejected_.error,
                  exceeding_.count, exceeding_.sum_of_excesses, exceeding_.since, whole_, along_);
}

}  // namespace tanor::detail
