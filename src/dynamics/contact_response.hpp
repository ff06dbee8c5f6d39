#pragma once

namespace tanor {

/// How multipliers and accelerations answer to a right-hand side at the configuration that is linearized: S x = -b,
/// dw = M^-1 K x. What contacts need to know of the system around them.
class ContactResponse {
 public:
  virtual ~ContactResponse() = default;

  /// x = -S^-1 b, both [rows], by one solve with the factor of S; as accurate as that.
  virtual void solve_once(const double* b, double* x) = 0;
  /// The same refined to rounding, and dw [3n] unless it is null.
  virtual void solve_refined(const double* b, double* x, double* dw) = 0;
  /// Where constraints depend on each other: x := the multipliers [rows] of the same reactions with the least norm.
  virtual void minimize_multiplier_norm(double* x) = 0;
};

}  // namespace tanor
