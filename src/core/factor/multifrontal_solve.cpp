#include <algorithm>

#include "factor/front_kernels.hpp"
#include "factor/multifrontal.hpp"
#include "plan/thresholds.hpp"

/// \file The substitutions L y = x from the leaves to the roots and L' x = y back. A task leaves what its parents' task
/// needs in a vector of its own, so that sums do not depend on which task comes first.
namespace tanor::detail {

/// Finds where the rows of a sequence stand while it is solved: its own columns in `z_`, the rows above in the vectors
/// of its roots.
void Multifrontal::find_places() {
  const std::size_t n = pivots_.size();
  places_ = supernodes_.rows;
  std::vector<int> root_of(tree_.fronts.size()), owner(n, -1), place(n);
  for (auto s = tree_.order.rbegin(); s != tree_.order.rend(); ++s) {  // parents before children
    const auto k = static_cast<std::size_t>(*s);
    const Front& front = tree_.fronts[k];
    const bool is_root = front.is_shared() || front.parent < 0;
    const int root = root_of[k] = is_root ? *s : root_of[static_cast<std::size_t>(front.parent)];
    for (std::size_t i = front.columns; i < front.rows; ++i) {
      const auto row = static_cast<std::size_t>(supernodes_.rows_of(k)[i]);
      if (is_root) {
        owner[row] = root;
        place[row] = static_cast<int>(n + front.vector + i);
      }
      if (owner[row] == root) places_[supernodes_.rows_start[k] + i] = place[row];
    }
  }
}

/// Sets y of a front to x of its columns, plus what its children leave for it.
void Multifrontal::start_vector(const Front& front, const double* x) {
  const double* const vectors = z_.data() + pivots_.size();
  double* const y = z_.data() + pivots_.size() + front.vector;
  std::copy_n(x + front.first_column, front.columns, y);
  std::fill(y + front.columns, y + front.stride, 0.0);
  tree_.for_children(front, [&](std::size_t c, const Front& child) {
    const int* const rows = rows_in_parent_.data() + supernodes_.rows_start[c] + child.columns;
    const double* const left = vectors + child.vector + child.columns;
    for (std::size_t i = 0; i < child.below(); ++i) y[rows[i]] += left[i];
  });
}

/// Copies the values that a front's rows below its columns have got from above.
void Multifrontal::fetch_from_above(std::size_t s) {
  const Front& front = tree_.fronts[s];
  double* const y = z_.data() + pivots_.size() + front.vector;
  const std::span<const int> rows = supernodes_.rows_of(s);
  for (std::size_t i = front.columns; i < front.rows; ++i) y[i] = z_[static_cast<std::size_t>(rows[i])];
}

void Multifrontal::forwards_in_sequence(std::size_t sequence, const double* x, Workspace& workspace) {
  const std::size_t begin = tree_.sequence_start[sequence], end = tree_.sequence_start[sequence + 1];
  for (std::size_t k = begin; k < end; ++k) {
    const Front& front = tree_.fronts[static_cast<std::size_t>(tree_.order[k])];
    std::copy_n(x + front.first_column, front.columns, z_.data() + front.first_column);
    if (front.is_shared()) {
      double* const y = z_.data() + pivots_.size() + front.vector;
      std::fill(y + front.columns, y + front.stride, 0.0);
    }
  }
  double *const y = workspace.y.data(), *const z = z_.data();
  for (std::size_t k = begin; k < end; ++k) {
    const auto s = static_cast<std::size_t>(tree_.order[k]);
    const Front& front = tree_.fronts[s];
    if (is_kept(front)) continue;
    const double* const panel = panels_.data() + front.panel;
    const int* const places = places_.data() + supernodes_.rows_start[s];
    for (std::size_t i = 0; i < front.rows; ++i) y[i] = z[places[i]];
    for (std::size_t i = front.rows; i < front.stride; ++i) y[i] = 0.0;
    kernels::substitute_forwards(front.columns, front.stride, front.stride, panel,
                                 inverse_pivots_.data() + front.first_column, ahead_, y);
    for (std::size_t i = 0; i < front.rows; ++i) z[places[i]] = y[i];
  }
}

void Multifrontal::backwards_in_sequence(std::size_t sequence, double* x, Workspace& workspace) {
  double *const y = workspace.y.data(), *const z = z_.data();
  for (std::size_t k = tree_.sequence_start[sequence + 1]; k-- > tree_.sequence_start[sequence];) {
    const auto s = static_cast<std::size_t>(tree_.order[k]);
    const Front& front = tree_.fronts[s];
    if (is_kept(front)) continue;
    const double* const panel = panels_.data() + front.panel;
    if (front.is_shared()) fetch_from_above(s);
    const int* const places = places_.data() + supernodes_.rows_start[s];
    for (std::size_t i = 0; i < front.rows; ++i) y[i] = z[places[i]];
    for (std::size_t i = front.rows; i < front.stride; ++i) y[i] = 0.0;
    kernels::substitute_backwards(front.columns, front.stride, front.stride, panel,
                                  inverse_pivots_.data() + front.first_column, ahead_, y);
    std::copy_n(y, front.columns, z + front.first_column);
    std::copy_n(y, front.columns, x + front.first_column);
  }
}

/// Returns where the products of a tile stand until the diagonal tile of its columns adds them.
double* Multifrontal::partial_sums(const Front& front, std::size_t row, std::size_t column) {
  const std::size_t rows = (front.stride + FrontTree::tile - 1) / FrontTree::tile;
  return z_.data() + pivots_.size() + front.vector + front.stride + FrontTree::tile * (column * rows + row);
}

void Multifrontal::forwards(const FrontTask& task, const double* x, Workspace& workspace) {
  const auto number = static_cast<std::size_t>(task.front);
  if (task.kind == FrontTask::Kind::Sequence) return forwards_in_sequence(number, x, workspace);
  if (task.kind == FrontTask::Kind::Join) return;
  const Front& front = tree_.fronts[number];
  double* const y = z_.data() + pivots_.size() + front.vector;
  const double* const panel = panels_.data() + front.panel;
  const double* const inverse_pivots = inverse_pivots_.data() + front.first_column;
  const bool is_first = task.row == 0 && task.column == 0;
  if (is_first) start_vector(front, x);
  if (is_first && is_kept(front)) std::copy_n(y, front.columns, z_.data() + front.first_column);
  if (is_kept(front)) return;
  if (task.kind == FrontTask::Kind::Whole)
    return kernels::substitute_forwards(front.columns, front.stride, front.stride, panel, inverse_pivots, ahead_, y);
  const Tile tile = tile_of(task, front);
  const std::size_t rows = tile.end_row - tile.row, columns = tile.end_column - tile.column, first = tile.column;
  const double* const numbers = panel + first * front.stride + tile.row;
  if (task.row == task.column) {
    kernels::substitute_forwards(columns, rows, front.stride, numbers, inverse_pivots + first, 0, y + first);
  } else {
    kernels::subtract_product(columns, rows, front.stride, numbers, y + first, y + tile.row);
  }
}

void Multifrontal::backwards(const FrontTask& task, double* x, Workspace& workspace) {
  const auto number = static_cast<std::size_t>(task.front);
  if (task.kind == FrontTask::Kind::Sequence) return backwards_in_sequence(number, x, workspace);
  if (task.kind == FrontTask::Kind::Join) return fetch_from_above(number);
  const Front& front = tree_.fronts[number];
  if (is_kept(front)) return;
  double* const y = z_.data() + pivots_.size() + front.vector;
  const double* const panel = panels_.data() + front.panel;
  const double* const inverse_pivots = inverse_pivots_.data() + front.first_column;
  const auto keep = [&](std::size_t first, std::size_t count) {
    std::copy_n(y + first, count, z_.data() + front.first_column + first);
    std::copy_n(y + first, count, x + front.first_column + first);
  };
  if (task.kind == FrontTask::Kind::Whole) {
    fetch_from_above(number);
    kernels::substitute_backwards(front.columns, front.stride, front.stride, panel, inverse_pivots, ahead_, y);
    return keep(0, front.columns);
  }
  const Tile tile = tile_of(task, front);
  const std::size_t rows = tile.end_row - tile.row, columns = tile.end_column - tile.column, first = tile.column;
  const double* const numbers = panel + first * front.stride + tile.row;
  if (task.row > task.column) {
    return kernels::find_products(columns, rows, front.stride, numbers, y + tile.row,
                                  partial_sums(front, task.row, task.column));
  }
  for (std::size_t row = task.row + 1; row * FrontTree::tile < front.stride; ++row) {
    const double* const sums = partial_sums(front, row, task.column);
    for (std::size_t j = 0; j < columns; ++j) y[first + j] -= sums[j];
  }
  kernels::substitute_backwards(columns, rows, front.stride, numbers, inverse_pivots + first, 0, y + first);
  keep(first, columns);
}

bool Multifrontal::solves_by_threads() const {
  return static_cast<double>(panels_.size()) >= plan::numbers_worth_threads;
}

/// Returns how many threads a solve is worth.
int Multifrontal::threads_of_solve(int threads) {
  if (!solves_by_threads()) threads = 1;
  reserve(threads);
  return threads;
}

void Multifrontal::eliminate(double* x, int threads) {
  tree_.solve.run(threads_of_solve(threads), TaskGraph::Direction::Forwards,
                  [&](const FrontTask& task, std::size_t thread) { forwards(task, x, workspaces_[thread]); });
  const std::size_t first_kept = pivots_.size() - num_kept_;
  std::copy_n(z_.data() + first_kept, num_kept_, x + first_kept);
}

void Multifrontal::substitute(double* x, int threads) {
  const std::size_t first_kept = pivots_.size() - num_kept_;
  std::copy_n(x + first_kept, num_kept_, z_.data() + first_kept);
  tree_.solve.run(threads_of_solve(threads), TaskGraph::Direction::Backwards,
                  [&](const FrontTask& task, std::size_t thread) { backwards(task, x, workspaces_[thread]); });
}

void Multifrontal::solve_packs(double* x, std::size_t groups) const {
  // Columns stand in the order of elimination, children before parents.
  const std::size_t size = kernels::front_width * pivots_.size();
  const auto for_groups = [&](const auto& substitute, std::size_t s) {
    const Front& front = tree_.fronts[s];
    for (double* own = x; own != x + groups * size; own += size)
      substitute(front.columns, front.rows, front.stride, panels_.data() + front.panel,
                 inverse_pivots_.data() + front.first_column, supernodes_.rows_of(s).data(), own);
  };
  for (std::size_t s = 0; s < tree_.fronts.size(); ++s) for_groups(kernels::substitute_pack_forwards, s);
  for (std::size_t s = tree_.fronts.size(); s-- > 0;) for_groups(kernels::substitute_pack_backwards, s);
}

}  // namespace tanor::detail
