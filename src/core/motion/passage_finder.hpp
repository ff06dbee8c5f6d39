#pragma once

#include <functional>
#include <vector>

#include "motion/dense_output.hpp"
#include "motion/scheme.hpp"

namespace tanor::detail {

/// Finds where singular values of K change sign inside a step, on the dense output of its scheme.
class PassageFinder {
 public:
  PassageFinder(const IntegrationOptions& options, Mechanics& mechanics) : options_(options), mechanics_(mechanics) {}

  /// The stretch to search: the step from the fraction `begin` on, in so many pieces. The two ends of a piece must
  /// reveal a passage in it, for which K may turn too far in the whole step. `regular` is the reciprocal condition of S
  /// far from singular configurations.
  struct Stretch {
    double begin;
    int pieces;
    double regular;
  };
  /// Calls note(t) for each passage while the mechanics is linearised near it. K must be remembered at the beginning of
  /// the step, and the mechanics must have solved at `to`, where it is again afterwards.
  void find(RankMonitor& monitor, DenseOutput dense, const State& to, const Stretch& stretch,
            const std::function<void(double t)>& note);

 private:
  Outcome go_inside(DenseOutput* dense, double fraction);
  double narrow(RankMonitor& monitor, DenseOutput* dense, double low, double high, double value_high, double regular);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  std::vector<double> x_, v_, a_;  // state inside the step
};

}  // namespace tanor::detail
