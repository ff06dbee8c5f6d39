#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <vector>

#include "base/huge_pages.hpp"
#include "factor/front_kernels.hpp"
#include "factor/front_tree.hpp"
#include "factor/supernodes.hpp"

namespace tanor::detail {

/// Factorizes L L' = S by the multifrontal method (Duff & Reid 1983; Liu 1992). A supernode has a front of its rows,
///
///   [ L11    ]   its columns, from S and the updates of its children
///   [ L21  U ]   U = updates of its children - L21 L21',   for its parent
///
/// Some last rows, G, may be kept for the caller. The last front is then assembled and handed over:
///
///   [ S_II  S_IG ]     L L' = S_II,   C = S_GG - S_GI S_II^-1 S_IG   (Schur complement)
///   [ S_GI  S_GG ]
///
/// Only S_II has to be positive definite. The parts of a matrix on several machines are summed in C; what a part
/// contributes to the kept rows may be singular by itself.
///
/// Any number of threads gives the same bits, because the pattern (FrontTree) decides what is computed and in which
/// order children are added. The first call with more threads than before allocates memory for them.
class Multifrontal {
 public:
  /// `lower` is the lower triangle of S in the order of elimination, the kept rows last.
  explicit Multifrontal(const TrianglePattern& lower, std::size_t num_kept = 0);

  /// Factorizes the values that stand beside the pattern's rows. The kept rows have no part in the quality.
  [[nodiscard]] Cholesky::Quality factorize(const double* values, int threads = 1);
  /// True if several threads take less time than one for a factorization, or for a solve.
  bool factorizes_by_threads() const;
  bool solves_by_threads() const;
  /// Returns the diagonal of L, [n].
  const std::vector<double>& pivots() const { return pivots_; }
  /// Solves in place: x := S^-1 x, [n], where no rows are kept.
  void solve(double* x, int threads = 1) {
    eliminate(x, threads);
    substitute(x, threads);
  }
  /// Solves for many right-hand sides, eight side by side in each of `groups` arrays x [groups][n, 8]. Each number of L
  /// is fetched once for all of them. Different threads may do this at the same time.
  void solve_packs(double* x, std::size_t groups) const;
  /// The two halves of a solve, called one after the other. `eliminate` takes b and leaves b_G - S_GI S_II^-1 b_I, the
  /// right side of C x_G, in the kept rows. `substitute` takes x_G there and leaves x.
  void eliminate(double* x, int threads = 1) { pass(TaskGraph::Direction::Forwards, x, threads); }
  void substitute(double* x, int threads = 1) { pass(TaskGraph::Direction::Backwards, x, threads); }

  std::size_t num_kept() const { return num_kept_; }
  std::size_t num_eliminated() const { return pivots_.size() - num_kept_; }
  /// Numbers of C's lower triangle, and the triangle itself, column after column.
  std::size_t complement_size() const { return num_kept_ * (num_kept_ + 1) / 2; }
  void write_complement(double* packed) const;

  /// Returns how many numbers are stored for L; `num_beside` counts those of updates and vectors beside it.
  std::size_t num_stored() const { return panels_.size(); }
  std::size_t num_beside() const;

 private:
  /// The scratch memory of one thread.
  struct Workspace {
    LargeArray<double> stacks[2], y;             // y of the front that a solve is at
    std::vector<kernels::ChildUpdate> children;  // of the front that is worked on
  };
  using Tile = kernels::Tile;

  void find_rows_in_parents();
  void find_entries(const TrianglePattern& lower);
  void reserve(int threads);

  bool is_kept(const Front& front) const { return front.first_column + num_kept_ >= pivots_.size(); }
  /// Returns the tile of a task in the panel, or in so many rows and columns: all of them in a front without tiles.
  static Tile tile_of(const FrontTask& task, const Front& front) {
    return tile_of(task, front, front.stride, front.columns);
  }
  static Tile tile_of(const FrontTask& task, const Front& front, std::size_t rows, std::size_t columns) {
    if (!front.is_tiled) return {0, rows, 0, columns};
    const std::size_t row = FrontTree::tile * task.row, column = FrontTree::tile * task.column;
    return {row, std::min(row + FrontTree::tile, rows), column, std::min(column + FrontTree::tile, columns)};
  }
  kernels::Panel panel_of(const Front& front, const Tile& tile) const {
    return {tile.end_column - tile.column, tile.end_row - tile.row, front.stride,
            panels_.data() + front.panel + tile.column * front.stride + tile.row,
            inverse_pivots_.data() + front.first_column + tile.column};
  }
  kernels::Triangle update(const Front& front, Workspace& workspace) {
    LargeArray<double>& home = front.home == Front::Home::Stack    ? workspace.stacks[front.depth % 2]
                               : front.home == Front::Home::Panels ? panels_
                                                                   : arena_;
    return {home.data() + front.update, front.update_stride};
  }
  /// Returns the numbers of a front, with the updates of its children until those of another front are asked for.
  kernels::FrontNumbers numbers_of(const Front& front, Workspace& workspace) {
    workspace.children.clear();
    tree_.for_children(front, [&](std::size_t c, const Front& child) {
      const std::size_t first = supernodes_.rows_start[c] + child.columns;
      workspace.children.push_back({rows_in_parent_.data() + first, run_end_.data() + first, update(child, workspace),
                                    child.rows_in_panel, child.below()});
    });
    return {front.columns, front.stride, panels_.data() + front.panel, update(front, workspace), workspace.children};
  }

  void factorize_tile(const FrontTask& task, const double* values, Workspace& workspace);
  void take_entries(const Front& front, const double* values, const Tile& tile);
  void fail(std::size_t column);

  void pass(TaskGraph::Direction direction, double* x, int threads);
  void forwards(const FrontTask& task, double* x, Workspace& workspace);
  void backwards(const FrontTask& task, double* x, Workspace& workspace);
  double* vector(const Front& front) { return vectors_.data() + front.vector; }
  double* left_over(const Front& front, Workspace& workspace);
  void start_vector(const Front& front, const double* x, Workspace& workspace, double* y);
  void fetch_from_above(std::size_t s, const double* x, double* y) const;
  double* partial_sums(const Front& front, std::size_t row, std::size_t column);

  std::size_t num_kept_;
  Supernodes supernodes_;
  FrontTree tree_;
  std::vector<int> rows_in_parent_, run_end_;    // beside supernodes_.rows
  std::vector<int> start_, entry_row_;           // [column] its first entry of S; [entry] its row in the front
  LargeArray<double> panels_;                    // L; before that, updates of fronts further down
  LargeArray<double> arena_;                     // updates that find no room in the panels
  std::vector<Workspace> workspaces_;            // [thread]
  std::vector<double> pivots_, inverse_pivots_;  // [n]
  std::vector<double> vectors_;                  // y of shared fronts in a solve
  std::size_t ahead_;                            // numbers of L that a solve fetches before they are needed
  std::atomic<std::size_t> failed_{0};           // first column without a positive pivot
};

}  // namespace tanor::detail
