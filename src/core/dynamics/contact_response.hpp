#pragma once

namespace tanor::detail {

/// The response of multipliers and accelerations to a right-hand side at the linearized configuration: S x = -b,
/// dw = M^-1 K x. Contacts need to know no more of the system around them.
class ContactResponse {
 public:
  virtual ~ContactResponse() = default;

  /// Computes x = -S^-1 b, both [rows], by one solve with the factor of S, without refinement.
  virtual void solve_once(const double* b, double* x) = 0;
  /// Computes the same refined to rounding, and dw [3n] unless it is null.
  virtual void solve_refined(const double* b, double* x, double* dw) = 0;
  /// Replaces x [rows] by the multipliers of least norm with the same reactions, where constraints depend on each
  /// other.
  virtual void minimize_multiplier_norm(double* x) = 0;
};

}  // namespace tanor::detail
