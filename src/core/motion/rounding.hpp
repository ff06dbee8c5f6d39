#pragma once

#include <string>
#include <vector>

#include "motion/aside.hpp"
#include "motion/scheme.hpp"

namespace tanor::detail {

/// Measures the rounding of accelerations during one motion. Positions and velocities are known to eps |x| and eps |v|.
/// No step can know accelerations better than such changes alter them, be it by stiff springs, by light points between
/// heavy ones or far from the origin. Shorter steps do not meet a tolerance below that, since their number grows while
/// their errors add up. `Mechanics::error_ratios` allows for rounding, so that steps do not shrink below the length
/// where it begins.
class Rounding {
 public:
  Rounding(const IntegrationOptions& options, Mechanics& mechanics);

  /// Takes note of a step that was rejected for its error; the estimate falls with that order.
  void note_rejection(double h, double error, int order);
  /// Takes note that a step from `from` was taken.
  void note_step(const State& from);
  /// Tells why the motion is less exact than asked for: which tolerance the steps meet, and since when. Returns an
  /// empty string if they meet theirs.
  std::string explain() const;

  /// Measures rounding before a step from `from`, which has its acceleration. The mechanics must be linearised there,
  /// and stays so.
  Outcome measure(const State& from);
  /// Allows for rounding in a step of length h from there.
  void allow(const State& from, double h, const RoundingGain& gain);

  /// Returns the memory of what is solved aside, for others.
  AsideMemory* aside() { return &aside_; }

  /// Exchanges nothing if rounding is not measured.
  void exchange_memory(Memory& memory);

 private:
  bool accelerate_beside(const State& from, std::size_t k, double side);
  double largest_difference(const State& from) const;
  void take_sample(const State& from);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  RoundingGroups* const groups_;  // null if rounding is not measured
  std::size_t num_groups_;
  bool is_measured_;  // on some process
  bool may_jump_;
  std::vector<double> whole_, along_;  // see RoundingLevels
  struct {
    double h = 0.0, error = 0.0;
  } rejected_;            // last rejected step from the present state
  double caution_ = 1.0;  // factor on the levels, at most …
  static constexpr double most_caution = 16.0;
  double excess_ = 0.0;  // rounding over the tolerance at the last `allow`; 0 if negligible
  // Steps whose rounding clearly exceeded the tolerance: count, sum of the excesses, time of the first
  struct {
    double count = 0.0, sum_of_excesses = 0.0, since = 0.0;
  } exceeding_;
  double is_due_;  // not 0 if rounding is to be measured before the next step
  double num_samples_ = 0.0, num_steps_ = 0.0, measured_at_ = 0.0;
  struct {
    double t = 0.0;
    std::vector<double> x, v, a;
  } beside_;                         // a sample
  std::vector<double> other_, now_;  // scratch
  AsideMemory aside_;
};

}  // namespace tanor::detail
