#include <algorithm>

#include "factor/front_kernels.hpp"
#include "factor/multifrontal.hpp"
#include "plan/thresholds.hpp"

/// \file The substitutions L y = x from the leaves to the roots and L' x = y back. A front leaves what its parent
/// needs where that alone adds it up, so that sums do not depend on which task comes first.
namespace tanor::detail {

/// Returns where a front leaves what its rows below its columns get, for its parent.
double* Multifrontal::left_over(const Front& front, Workspace& workspace) {
  return front.is_shared() ? vector(front) + front.columns : workspace.stacks[front.depth % 2].data() + front.update;
}

/// Sets y of a front to x of its columns, plus what its children leave for it.
void Multifrontal::start_vector(const Front& front, const double* x, Workspace& workspace, double* y) {
  std::copy_n(x + front.first_column, front.columns, y);
  std::fill(y + front.columns, y + front.stride, 0.0);
  tree_.for_children(front, [&](std::size_t c, const Front& child) {
    const int* const rows = rows_in_parent_.data() + supernodes_.rows_start[c] + child.columns;
    const double* const left = left_over(child, workspace);
    for (std::size_t i = 0; i < child.below(); ++i) y[rows[i]] += left[i];
  });
}

/// Copies the values that a front's rows below its columns have got from above.
void Multifrontal::fetch_from_above(std::size_t s, const double* x, double* y) const {
  const std::span<const int> rows = supernodes_.rows_below(s);
  y += tree_.fronts[s].columns;
  for (std::size_t i = 0; i < rows.size(); ++i) y[i] = x[rows[i]];
}

/// Returns where the products of a tile stand until the diagonal tile of its columns adds them.
double* Multifrontal::partial_sums(const Front& front, std::size_t row, std::size_t column) {
  const std::size_t rows = (front.stride + FrontTree::tile - 1) / FrontTree::tile;
  return vector(front) + front.stride + FrontTree::tile * (column * rows + row);
}

void Multifrontal::forwards(const FrontTask& task, double* x, Workspace& workspace) {
  if (task.kind == FrontTask::Kind::Join) return;
  const Front& front = tree_.fronts[task.front];
  double* const y = front.is_tiled ? vector(front) : workspace.y.data();
  const bool is_first = task.row == 0 && task.column == 0;
  if (is_first) start_vector(front, x, workspace, y);
  if (is_first && is_kept(front)) std::copy_n(y, front.columns, x + front.first_column);
  if (is_kept(front)) return;
  const Tile tile = tile_of(task, front);
  const kernels::Panel panel = panel_of(front, tile);
  if (task.row > task.column) return kernels::subtract_product(panel, y + tile.column, y + tile.row);
  kernels::substitute_forwards(panel, front.is_tiled ? 0 : ahead_, y + tile.column);
  if (front.is_tiled) return;
  std::copy_n(y, front.columns, x + front.first_column);
  std::copy_n(y + front.columns, front.below(), left_over(front, workspace));
}

void Multifrontal::backwards(const FrontTask& task, double* x, Workspace& workspace) {
  const Front& front = tree_.fronts[task.front];
  if (task.kind == FrontTask::Kind::Join) return fetch_from_above(task.front, x, vector(front));
  if (is_kept(front)) return;
  double* const y = front.is_tiled ? vector(front) : workspace.y.data();
  if (!front.is_tiled) {
    std::copy_n(x + front.first_column, front.columns, y);
    fetch_from_above(task.front, x, y);
    std::fill(y + front.rows, y + front.stride, 0.0);
  }
  const Tile tile = tile_of(task, front);
  const kernels::Panel panel = panel_of(front, tile);
  if (task.row > task.column)
    return kernels::find_products(panel, y + tile.row, partial_sums(front, task.row, task.column));
  double* const own = y + tile.column;
  for (std::size_t row = task.row + 1; front.is_tiled && row * FrontTree::tile < front.stride; ++row) {
    const double* const sums = partial_sums(front, row, task.column);
    for (std::size_t j = 0; j < panel.columns; ++j) own[j] -= sums[j];
  }
  kernels::substitute_backwards(panel, front.is_tiled ? 0 : ahead_, own);
  std::copy_n(own, panel.columns, x + front.first_column + tile.column);
}

bool Multifrontal::solves_by_threads() const {
  return static_cast<double>(panels_.size()) >= plan::numbers_worth_threads;
}

/// Does one pass of a solve with as many threads as it is worth.
void Multifrontal::pass(TaskGraph::Direction direction, double* x, int threads) {
  if (!solves_by_threads()) threads = 1;
  reserve(threads);
  tree_.run(threads, direction, [&](const FrontTask& task, std::size_t thread) {
    if (task.kind == FrontTask::Kind::UpdateTile) return;
    direction == TaskGraph::Direction::Forwards ? forwards(task, x, workspaces_[thread])
                                                : backwards(task, x, workspaces_[thread]);
  });
}

void Multifrontal::solve_packs(double* x, std::size_t groups) const {
  // Columns stand in the order of elimination, children before parents.
  const std::size_t size = kernels::front_width * pivots_.size();
  const auto for_groups = [&](const auto& substitute, std::size_t s) {
    const Front& front = tree_.fronts[s];
    for (double* own = x; own != x + groups * size; own += size)
      substitute(panel_of(front, {0, front.rows, 0, front.columns}), supernodes_.rows_of(s).data(), own);
  };
  for (std::size_t s = 0; s < tree_.fronts.size(); ++s) for_groups(kernels::substitute_pack_forwards, s);
  for (std::size_t s = tree_.fronts.size(); s-- > 0;) for_groups(kernels::substitute_pack_backwards, s);
}

}  // namespace tanor::detail
