#pragma once

#include <cstddef>
#include <vector>

#include "factor/cholesky.hpp"

namespace tanor::detail {

/// Incomplete factorization U'D U ~ S, where U is a unit triangle on the pattern of S: Cholesky's method without fill
/// (J. A. Meijerink, H. A. van der Vorst 1977). It is exact if the elimination in the given order makes no fill, as
/// along chains and trees.
class IncompleteCholesky {
 public:
  /// Takes the pattern of the upper triangle by columns.
  explicit IncompleteCholesky(TrianglePattern upper);

  double* values() { return values_.data(); }  ///< beside the pattern's rows; to be filled before `factorize`

  /// Factorizes the values. If a pivot falls too low, the whole diagonal is raised (T. A. Manteuffel 1980). Returns
  /// false if that did not help.
  [[nodiscard]] bool factorize();

  /// Computes x = -D (U'D U)^-1 D b [n] with D = diag(scale). x may be b.
  void solve_negative(const double* scale, const double* b, double* x) const;

 private:
  bool try_factorize(double raise);

  TrianglePattern pattern_;
  std::vector<double> values_, upper_, scaled_;  // [slot] S; U; U'D
  std::vector<double> inverse_pivots_;
};

}  // namespace tanor::detail
