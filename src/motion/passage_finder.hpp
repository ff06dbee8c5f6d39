#pragma once

#include <functional>
#include <vector>

#include "motion/dense_output.hpp"
#include "motion/scheme.hpp"

namespace tanor {

/// Finds where singular values of K go through 0 inside a step, on the dense output of its scheme.
class PassageFinder {
 public:
  PassageFinder(const IntegrationOptions& options, Mechanics& mechanics) : options_(options), mechanics_(mechanics) {}

  /// What is looked through: the step from the fraction `begin` on, in so many pieces. The ends of a piece have to tell
  /// whether it holds a passage, and K may have turned too far in the whole step. `regular`: the reciprocal condition
  /// of S far from singular configurations.
  struct Stretch {
    double begin;
    int pieces;
    double regular;
  };
  /// Calls note(t) for each passage, where the mechanics was linearised last beside it. K is remembered at the
  /// beginning of the step, and the mechanics has solved at `to`, where it stands again afterwards.
  void find(RankMonitor& monitor, DenseOutput dense, const State& to, const Stretch& stretch,
            const std::function<void(double t)>& note);

 private:
  Outcome go_inside(DenseOutput* dense, double fraction);
  double narrow(RankMonitor& monitor, DenseOutput* dense, double low, double high, double value_high, double regular);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  std::vector<double> x_, v_, a_;  // inside the step
};

}  // namespace tanor
