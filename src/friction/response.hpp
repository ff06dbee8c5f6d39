#pragma once

namespace tanor {

/// How the reactions of a constrained system answer to forces at its contacts: S has its factor, so one call is one
/// solve. Forces come as parts, tau = sum of x_p e_p (see FrictionLaws).
///
///   lambda(x) = -S^-1 (b + K'M^-1 tau(x)),   b = phi + K'M^-1 f                    (*)
class Response {
 public:
  virtual ~Response() = default;

  /// lambda [rows] for x [parts].
  virtual void find_multipliers(const double* x, double* lambda) = 0;
  /// Its change -S^-1 K'M^-1 tau(x).
  virtual void find_change(const double* x, double* lambda) = 0;
};

}  // namespace tanor
