#pragma once

#include <vector>

#include "base/groups.hpp"
#include "dynamics/workspace.hpp"
#include "host/row_sums.hpp"

namespace tanor {

/// Computes ln det S of S = K'M^-1K and its gradient,
///
///   d(ln det S)/dr = 2 tr(S^-1 K'M^-1 dK/dr),
///
/// by S = LDL' in the inner order of rows, which makes no fill for trees. Z = S^-1 is needed only where L has entries
/// (Takahashi, Fagan and Chen 1973), since no other entry of Z meets a derivative of K.
class SchurDeterminant {
 public:
  /// The workspace outlives it. The constructor plans the elimination.
  explicit SchurDeterminant(const Workspace& work);

  /// Returns ln det S for K in blocks, or minus infinity if `dependent_row()` depends on others to rounding.
  double evaluate(const double* blocks);
  std::size_t dependent_row() const { return dependent_row_; }
  bool has_gradient() const { return rods_.size() == model_.num_rows(); }
  /// Writes the gradient [3n] at the last `evaluate`. All constraints are rods, of `lengths` [d].
  void write_gradient(const double* blocks, const double* lengths, double* gradient);

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

  const Model& model_;
  std::vector<RodRow> rods_;
  Groups<Entry> by_point_;                                // moving points alone
  Groups<Index> pattern_;                                 // [column] rows of L below the diagonal, ascending
  std::vector<double> lower_, diagonal_;                  // L and D; S before the elimination
  std::vector<double> inverse_lower_, inverse_diagonal_;  // Z, where L has entries
  std::size_t dependent_row_ = 0;
};

}  // namespace tanor
