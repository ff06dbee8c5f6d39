#pragma once

#include <cstddef>
#include <vector>

#include "factor/supernodes.hpp"

namespace tanor {

/// L L' = S by the multifrontal method (Duff & Reid 1983; Liu 1992). Each supernode has a front, a dense lower triangle
/// of its rows,
///
///   [ L11    ]   its columns, from S and the updates of its children
///   [ L21  U ]   U = updates of its children - L21 L21',   for its parent
///
/// CHOLMOD's supernodal numeric factorization enters several parallel regions for each supernode and BLAS for each
/// small block. That is three quarters of its time on nets.
class Multifrontal {
 public:
  /// `lower` is the lower triangle of S in the order of elimination.
  explicit Multifrontal(const TrianglePattern& lower) : Multifrontal(lower, find_supernodes(lower)) {}
  Multifrontal(const TrianglePattern& lower, Supernodes supernodes);

  /// Factorizes the values that stand beside the pattern's rows. Returns the column whose pivot is not positive, or n.
  std::size_t factorize(const TrianglePattern& lower, const double* values);
  /// Diagonal of L, [n].
  const std::vector<double>& pivots() const { return pivots_; }
  /// x := S^-1 x, [n].
  void solve(double* x);

 private:
  struct Front {
    std::size_t first_column, columns, rows, stride;  // stride: of its panel [rows, columns]
    std::size_t panel;                                // its place in `panels_`
    std::size_t update, update_stride;                // its place in `updates_[depth % 2]`
    std::size_t depth = 0;
    int parent = -1, first_child = -1, next_sibling = -1;
  };

  void find_parents();
  void find_order();
  void place_updates();
  void find_rows_in_parents();
  void find_entries(const TrianglePattern& lower);
  void assemble(const Front& front, const TrianglePattern& lower, const double* values);
  void add_update(const Front& child, std::size_t s, const Front& front);
  double* update(const Front& front) { return updates_[front.depth % 2].data() + front.update; }

  Supernodes supernodes_;
  std::vector<Front> fronts_;                    // [supernode]
  std::vector<int> order_;                       // children before parents
  std::vector<int> rows_in_parent_;              // beside supernodes_.rows
  std::vector<int> entry_row_;                   // [entry of S] its row in the front
  std::vector<double> panels_;                   // L
  std::vector<double> updates_[2];               // stacks: a front's is never in that of its children
  std::vector<double> pivots_, inverse_pivots_;  // [n]
  std::vector<double> y_;                        // scratch of the largest front
};

}  // namespace tanor
