#pragma once

#include <vector>

#include "base/groups.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Computes ln det S of S = K'M^-1K and its gradient,
///
///   d(ln det S)/dr = 2 tr(S^-1 K'M^-1 dK/dr) = sum of 2 Hess(xi_a) M^-1 K Z_a over the rows a,   Z = S^-1
///
/// by S = LDL' in the inner order of rows, which makes no fill for trees. Z is needed only where L has entries
/// (Takahashi, Fagan and Chen 1973), since Hess(xi_a) meets only rows that share a moving point with row a.
class SchurDeterminant {
 public:
  /// The workspace outlives it. The constructor plans the elimination.
  explicit SchurDeterminant(const Workspace& work);

  /// Returns ln det S for K in blocks, or minus infinity if `dependent_row()` depends on others to rounding.
  double evaluate(const double* blocks);
  std::size_t dependent_row() const { return dependent_row_; }
  /// Returns the gradient [3n] at the last `evaluate`, whose positions r and K are given.
  const std::vector<double>& find_gradient(const double* r, const double* blocks);
  const std::vector<double>& gradient() const { return gradient_; }  ///< found last

 private:
  struct Entry {
    Index row, block;
    double sign;
  };
  std::span<const Index> below(std::size_t column) const { return pattern_[column]; }
  std::size_t place(std::size_t column, Index row) const;
  void plan_pattern();
  void assemble(const double* blocks);
  void invert();

  const Workspace& work_;
  const Model& model_;
  Groups<Entry> by_point_;                                // moving points alone
  Groups<Index> pattern_;                                 // [column] rows of L below the diagonal, ascending
  std::vector<double> lower_, diagonal_;                  // L and D; S before the elimination
  std::vector<double> inverse_lower_, inverse_diagonal_;  // Z, where L has entries
  std::size_t dependent_row_ = 0;
  std::vector<double> gradient_;
};

}  // namespace tanor::detail
