#pragma once

namespace tanor {

/// How the reactions of a constrained system answer to forces at its contacts: S has its factor, so one call is one
/// solve.
///
///   lambda(tau) = -S^-1 (b + K'M^-1 tau),   b = phi + K'M^-1 f                    (*)
class Response {
 public:
  virtual ~Response() = default;

  /// lambda [rows] for tau [3 contacts].
  virtual void find_multipliers(const double* tau, double* lambda) = 0;
  /// Its change -S^-1 K'M^-1 tau.
  virtual void find_change(const double* tau, double* lambda) = 0;
};

}  // namespace tanor
