#pragma once

#include <cstddef>
#include <vector>

#include "factor/cholesky.hpp"

namespace tanor {

/// Incomplete factorization U'D U ~ S, where U is a unit triangle on the pattern of S: Cholesky's method without its
/// fill (J. A. Meijerink, H. A. van der Vorst 1977). It is exact where the elimination in the given order makes no
/// fill, as along chains and trees. The constructor does the symbolic work once.
class IncompleteCholesky {
 public:
  /// Upper triangle by columns.
  explicit IncompleteCholesky(TrianglePattern upper);

  double* values() { return values_.data(); }  ///< beside the pattern's rows; to be filled before `factorize`

  /// Where a pivot falls too low, the whole diagonal is raised (T. A. Manteuffel 1980). Returns false where that did
  /// not help.
  [[nodiscard]] bool factorize();

  /// x = -D (U'D U)^-1 D b [n] with D = diag(scale). x may be b.
  void solve_negative(const double* scale, const double* b, double* x) const;

  /// Multiplications of a solve.
  double solve_products() const { return static_cast<double>(2 * pattern_.rows.size()); }

 private:
  bool try_factorize(double raise);

  /// u_ki and u_kj of a product u_ki d_k u_kj.
  struct Term {
    int left, right;
  };

  TrianglePattern pattern_;
  std::vector<double> values_, upper_, scaled_;  // [slot] S; U; U'D
  std::vector<double> inverse_pivots_;
  std::vector<Term> terms_;
  std::vector<int> terms_start_;  // [slot]
};

}  // namespace tanor
