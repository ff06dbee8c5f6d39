#pragma once

#include "motion/scheme.hpp"

namespace tanor::detail {

/// Interpolates inside the last step of a scheme. The two states and what the scheme keeps of the step have to stay as
/// they are.
class DenseOutput {
 public:
  /// If `by_ends` is true, interpolates from the two end states only, whichever scheme made the step. The mechanics
  /// then stays where it is.
  DenseOutput(Scheme& scheme, const State& from, const State& to, bool by_ends = false)
      : scheme_(scheme), from_(from), to_(to), by_ends_(by_ends) {}

  /// Returns true if the mechanics may have been moved.
  bool has_moved() const { return is_prepared_; }
  double time(double fraction) const { return from_.t + fraction * (to_.t - from_.t); }

  /// Writes x and v at `time(fraction)`, `size()` numbers each. The first call may move the mechanics.
  Outcome evaluate(const Parallel& parallel, double fraction, double* x, double* v) {
    if (by_ends_) {
      scheme_.Scheme::interpolate(parallel, from_, to_, fraction, x, v);
      return {};
    }
    if (!is_prepared_) {
      if (Outcome found = scheme_.prepare_inside(from_, to_); !found.ok()) return found;
      is_prepared_ = true;
    }
    scheme_.interpolate(parallel, from_, to_, fraction, x, v);
    return {};
  }

 private:
  Scheme& scheme_;
  const State &from_, &to_;
  bool by_ends_;
  bool is_prepared_ = false;
};

}  // namespace tanor::detail
