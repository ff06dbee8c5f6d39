#pragma once

#include <span>
#include <string>
#include <vector>

#include "assembly/reactions.hpp"
#include "dynamics/workspace.hpp"
#include "evaluate/constraint_series.hpp"
#include "evaluate/force_series.hpp"

namespace tanor {

/// The motion as a power series in time, with its multipliers:
///
///   r(t0 + s) = sum r_k s^k,   lambda(t0 + s) = sum lambda_k s^k
///   (k+1)(k+2) M r_{k+2} = f_k + sum over j = 0 … k of K_j lambda_{k-j}
///   coefficient k + 2 of xi = 0:   K_0'r_{k+2} = -(what the lower ones make)
///
/// The unknown lambda_k stands beside K_0 alone, so every order is one solve with the factor of S(r_0).
class MotionSeries {
 public:
  explicit MotionSeries(const Workspace& work);

  /// Why the system has no series; empty: it has.
  const std::string& obstacle() const;

  /// Begins at t, with room for coefficients 0 … order, whose first three are known.
  void begin(double t, std::span<double* const> coefficients);
  /// s: no series holds beyond it.
  double smooth_until() const;

  /// Order k >= 1: all of r_{k+2} but M^-1 K_0 lambda_k/((k+1)(k+2)), into coefficients[k + 2]; and minus what
  /// K_0'r_{k+2} has to be [d]. Orders follow one another; k = 0 prepares the others and finds nothing.
  void advance(int k, std::span<double* const> coefficients, const double* last_lambda, double* rows);

 private:
  const Model& model_;
  ConstraintSeries constraints_;
  ForceSeries forces_;
  ReactionGather gather_;  // blocks of constraints, those of forces behind them
  struct Support {
    VectorFunction displacement;
    std::vector<Index> points;  // inner
  };
  std::vector<Support> supports_;
  std::string obstacle_;
  double smooth_until_ = 0.0;
  std::size_t first_force_;  // block
  std::vector<double> blocks_, ones_;
};

}  // namespace tanor
