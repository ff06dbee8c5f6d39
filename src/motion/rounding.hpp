#pragma once

#include <string>
#include <vector>

#include "motion/scheme.hpp"

namespace tanor {

/// The rounding of accelerations on the way of one motion. Positions and velocities are known to eps |x| and eps |v|:
/// what accelerations make of a change by as much no step can know better, be it by stiff springs, by light points
/// between heavy ones or far from the origin. A tolerance below it is not met by shorter steps, whose number grows
/// while their errors add up: `Mechanics::error_ratios` allows for it, so that steps are held where it begins.
class Rounding {
 public:
  Rounding(const IntegrationOptions& options, Mechanics& mechanics);

  /// A step from here was rejected for its error; the estimate falls with that order.
  void note_rejection(double h, double error, int order);
  /// A step from `from` was taken.
  void note_step(const State& from);
  /// Says why the motion is less exact than asked for: which tolerance steps meet, and since when; empty: they meet
  /// theirs.
  std::string explain() const;

  /// Measures rounding before a step from `from`, which has its acceleration. The mechanics is linearised there, and
  /// stays so.
  Outcome measure(const State& from);
  /// Allows for it in a step of length h from there.
  void allow(const State& from, double h, const RoundingGain& gain);

  /// Nothing where rounding is not asked for.
  void exchange_memory(Memory& memory);

 private:
  void take_sample(const State& from);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  RoundingGroups* const groups_;  // null: rounding is not asked for
  std::size_t num_groups_;
  std::vector<double> whole_, along_;  // see RoundingLevels
  struct {
    double h = 0.0, error = 0.0;
  } rejected_;            // the last one from here
  double caution_ = 1.0;  // levels are taken so many times as large, at most …
  static constexpr double most_caution = 16.0;
  double excess_ = 0.0;  // over the tolerance, at the last `allow`; 0: no matter
  // Of the steps whose tolerance was clearly less
  double num_exceeding_ = 0.0, sum_of_excesses_ = 0.0, since_ = 0.0;
  double is_due_;  // not 0: to be measured before the next step
  double num_samples_ = 0.0, num_steps_ = 0.0, measured_at_ = 0.0;
  std::vector<double> x_, v_, a_, now_;  // scratch
};

}  // namespace tanor
