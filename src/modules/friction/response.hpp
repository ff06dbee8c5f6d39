#pragma once

namespace tanor::detail {

/// Finds how the reactions of a constrained system respond to forces at its contacts. S is factorized, so that one call
/// is one solve. Forces come as parts, tau = sum of x_p e_p (see FrictionLaws).
///
///   lambda(x) = -S^-1 (b + K'M^-1 tau(x)),   b = phi + K'M^-1 f                    (*)
class Response {
 public:
  virtual ~Response() = default;

  /// Finds lambda [rows] for x [parts].
  virtual void find_multipliers(const double* x, double* lambda) = 0;
  /// Finds the change -S^-1 K'M^-1 tau(x) of lambda.
  virtual void find_change(const double* x, double* lambda) = 0;
};

}  // namespace tanor::detail
