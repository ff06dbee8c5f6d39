#include "factor/multifrontal.hpp"

#include <algorithm>
#include <utility>

#include "base/check.hpp"
#include "factor/front_kernels.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

using kernels::front_width;

Multifrontal::Multifrontal(const TrianglePattern& lower, Supernodes supernodes, std::size_t num_kept)
    : supernodes_(std::move(supernodes)), num_kept_(num_kept), tree_(supernodes_) {
  panels_.resize(tree_.panels_size + front_width);
  arena_.resize(tree_.arena_size + front_width);
  pivots_.resize(lower.size());
  inverse_pivots_.resize(lower.size());
  z_.resize(lower.size() + tree_.vectors_size + front_width);
  ahead_ = panels_.size() > plan::numbers_beyond_cache ? plan::numbers_fetched_ahead : 0;
  find_rows_in_parents();
  find_entries(lower);
  find_places();
  reserve(1);
}

void Multifrontal::find_rows_in_parents() {
  rows_in_parent_.resize(supernodes_.rows.size());
  run_end_.resize(supernodes_.rows.size());
  for (std::size_t s = 0; s < tree_.fronts.size(); ++s) {
    if (tree_.fronts[s].parent < 0) continue;
    const auto parent = static_cast<std::size_t>(tree_.fronts[s].parent);
    std::size_t at = supernodes_.rows_start[parent];
    for (std::size_t k = supernodes_.rows_start[s] + tree_.fronts[s].columns; k < supernodes_.rows_start[s + 1]; ++k) {
      while (at < supernodes_.rows_start[parent + 1] && supernodes_.rows[at] != supernodes_.rows[k]) ++at;
      ensure(at < supernodes_.rows_start[parent + 1], "a parent's front has all rows of its children's updates");
      rows_in_parent_[k] = static_cast<int>(at - supernodes_.rows_start[parent]);
    }
    const std::size_t first = supernodes_.rows_start[s] + tree_.fronts[s].columns, end = supernodes_.rows_start[s + 1];
    for (std::size_t k = end; k-- > first;) {
      const bool goes_on = k + 1 < end && rows_in_parent_[k + 1] == rows_in_parent_[k] + 1;
      run_end_[k] = goes_on ? run_end_[k + 1] : static_cast<int>(k + 1 - first);
    }
  }
}

void Multifrontal::find_entries(const TrianglePattern& lower) {
  std::vector<int> place(lower.size(), -1);
  entry_row_.resize(lower.rows.size());
  for (std::size_t s = 0; s < tree_.fronts.size(); ++s) {
    const Front& front = tree_.fronts[s];
    for (std::size_t k = 0; k < front.rows; ++k) place[static_cast<std::size_t>(rows_of(s)[k])] = static_cast<int>(k);
    for (std::size_t j = front.first_column; j < front.first_column + front.columns; ++j) {
      for (auto e = static_cast<std::size_t>(lower.start[j]); e < static_cast<std::size_t>(lower.start[j + 1]); ++e)
        entry_row_[e] = place[static_cast<std::size_t>(lower.rows[e])];
    }
  }
}

void Multifrontal::reserve(int threads) {
  while (workspaces_.size() < static_cast<std::size_t>(threads)) {
    Workspace& workspace = workspaces_.emplace_back();
    for (std::size_t k = 0; k < 2; ++k) workspace.stacks[k].resize(tree_.stack_size[k] + front_width);
    workspace.y.resize(tree_.largest_stride + front_width);
    workspace.children.reserve(tree_.most_children);
  }
}

std::size_t Multifrontal::num_beside() const {
  std::size_t result = arena_.size() + z_.size();
  for (const Workspace& workspace : workspaces_)
    result += workspace.stacks[0].size() + workspace.stacks[1].size() + workspace.y.size();
  return result;
}

/// Fills a part of a front's columns with the columns of S.
void Multifrontal::take_entries(const Front& front, const Entries& entries, const Tile& tile) {
  double* const panel = panels_.data() + front.panel;
  const std::size_t end_row = tile.first_row + tile.rows, end_column = tile.first_column + tile.columns;
  const bool is_whole = tile.rows == front.stride && tile.columns == front.columns;
  const auto take = [&](const auto& is_of_tile) {
    for (std::size_t j = tile.first_column; j < end_column; ++j) {
      double* const to = panel + j * front.stride;
      const auto start = static_cast<std::size_t>(entries.lower.start[front.first_column + j]);
      const auto end = static_cast<std::size_t>(entries.lower.start[front.first_column + j + 1]);
      for (std::size_t e = start; e < end; ++e) {
        const auto row = static_cast<std::size_t>(entry_row_[e]);
        if (is_of_tile(row)) to[row] = entries.values[e];
      }
    }
  };
  if (is_whole) {
    std::fill_n(panel, front.columns * front.stride, 0.0);
    take([](std::size_t) { return true; });
  } else {
    for (std::size_t j = tile.first_column; j < end_column; ++j)
      std::fill_n(panel + j * front.stride + tile.first_row, tile.rows, 0.0);
    take([&](std::size_t row) { return row >= tile.first_row && row < end_row; });
  }
}

/// Fills a tile of a front's columns with the columns of S and the updates of its children.
void Multifrontal::assemble(const Front& front, const Entries& entries, const Tile& tile, Workspace& workspace) {
  take_entries(front, entries, tile);
  tree_.for_children(front, [&](std::size_t c, const Front& child) {
    const kernels::RowsInParent in_parent = rows_in_parent(c);
    const int *const rows = in_parent.rows, *const last = rows + child.below();
    const auto place = [&](std::size_t row) {
      return static_cast<std::size_t>(std::lower_bound(rows, last, static_cast<int>(row)) - rows);
    };
    kernels::add_to_panel({place(tile.first_column), place(tile.first_column + tile.columns), place(tile.first_row),
                           place(tile.first_row + tile.rows)},
                          in_parent, update(child, workspace), panels_.data() + front.panel, front.stride);
  });
}

void Multifrontal::keep_pivots(const Front& front, std::size_t first, std::size_t end) {
  const double* const panel = panels_.data() + front.panel;
  for (std::size_t j = first; j < end; ++j) {
    const double pivot = panel[j * (front.stride + 1)];
    pivots_[front.first_column + j] = pivot;
    inverse_pivots_[front.first_column + j] = 1.0 / pivot;
  }
}

/// Keeps the first of all columns that fail. Later columns in the order of elimination are skipped, earlier ones are
/// not, so the result does not depend on what other threads have found.
void Multifrontal::fail(std::size_t column) {
  std::size_t first = failed_.load(std::memory_order_relaxed);
  while (column < first && !failed_.compare_exchange_weak(first, column, std::memory_order_relaxed)) {
  }
}

void Multifrontal::factorize_front(std::size_t s, const Entries& entries, Workspace& workspace) {
  const Front& front = tree_.fronts[s];
  if (failed_.load(std::memory_order_relaxed) < front.first_column) return;
  const Tile whole{0, front.stride, 0, front.columns};
  if (is_kept(front)) return assemble(front, entries, whole, workspace);
  take_entries(front, entries, whole);
  workspace.children.clear();
  tree_.for_children(front, [&](std::size_t c, const Front& child) {
    workspace.children.push_back({rows_in_parent(c), update(child, workspace), child.rows_in_panel, child.below()});
  });
  const std::size_t done =
      kernels::eliminate_front({front.columns, front.stride, front.below(), panels_.data() + front.panel,
                                update(front, workspace), workspace.children});
  if (done < front.columns) return fail(front.first_column + done);
  keep_pivots(front, 0, front.columns);
}

/// Computes a tile of L: the entries there, minus the products of the tiles on its left, divided by the diagonal tile.
void Multifrontal::factorize_tile(const FrontTask& task, const Entries& entries, Workspace& workspace) {
  const Front& front = tree_.fronts[static_cast<std::size_t>(task.front)];
  const std::size_t first_row = FrontTree::tile * task.row, first_column = FrontTree::tile * task.column;
  const Tile tile{first_row, std::min(FrontTree::tile, front.stride - first_row), first_column,
                  std::min(FrontTree::tile, front.columns - first_column)};
  if (failed_.load(std::memory_order_relaxed) < front.first_column + first_column + tile.columns) return;
  assemble(front, entries, tile, workspace);
  if (is_kept(front)) return;
  double* const panel = panels_.data() + front.panel;
  double* const columns = panel + first_column * front.stride;
  const bool is_diagonal = task.row == task.column;
  kernels::subtract_block({tile.rows, tile.columns, is_diagonal}, first_column, panel + first_row, panel + first_column,
                          front.stride, columns + first_row, front.stride);
  if (!is_diagonal) {
    return kernels::divide_block(tile.columns, tile.rows, columns + first_column, front.stride, columns + first_row);
  }
  const std::size_t done = kernels::factorize_panel(tile.columns, tile.rows, front.stride, columns + first_column);
  if (done < tile.columns) return fail(front.first_column + first_column + done);
  keep_pivots(front, first_column, first_column + tile.columns);
}

/// Computes a tile of U: -L21 L21' plus the updates of the children.
void Multifrontal::update_tile(const FrontTask& task, Workspace& workspace) {
  const Front& front = tree_.fronts[static_cast<std::size_t>(task.front)];
  if (failed_.load(std::memory_order_relaxed) < front.first_column + front.columns) return;
  const std::size_t first_row = FrontTree::tile * task.row, first_column = FrontTree::tile * task.column;
  const std::size_t end_row = std::min(first_row + FrontTree::tile, front.update_stride);
  const std::size_t end_column = std::min(first_column + FrontTree::tile, front.below());
  const double* const below = panels_.data() + front.panel + front.columns;
  const kernels::Triangle rest = update(front, workspace);
  for (std::size_t j = first_column; j < end_column; j += kernels::Triangle::width) {
    const std::size_t from = task.row == task.column ? j : first_row;  // rows above the block's diagonal are not stored
    const std::size_t columns = std::min(kernels::Triangle::width, end_column - j);
    kernels::subtract_block({end_row - from, columns, task.row == task.column, true}, front.columns, below + from,
                            below + j, front.stride, rest.column(j) + from, rest.stride_of(j));
  }
  tree_.for_children(front, [&](std::size_t c, const Front& child) {
    const kernels::RowsInParent in_parent = rows_in_parent(c);
    const int *const rows = in_parent.rows, *const last = rows + child.below();
    const auto place = [&](std::size_t row) {
      return static_cast<std::size_t>(std::lower_bound(rows, last, static_cast<int>(front.columns + row)) - rows);
    };
    kernels::add_to_update({place(first_column), place(end_column), place(first_row), place(end_row)}, in_parent,
                           update(child, workspace), front.columns, rest);
  });
}

void Multifrontal::run(const FrontTask& task, const Entries& entries, Workspace& workspace) {
  const auto front = static_cast<std::size_t>(task.front);
  switch (task.kind) {
    case FrontTask::Kind::Sequence:
      for (std::size_t k = tree_.sequence_start[front]; k < tree_.sequence_start[front + 1]; ++k)
        factorize_front(static_cast<std::size_t>(tree_.order[k]), entries, workspace);
      return;
    case FrontTask::Kind::Whole:
      return factorize_front(front, entries, workspace);
    case FrontTask::Kind::PanelTile:
      return factorize_tile(task, entries, workspace);
    case FrontTask::Kind::UpdateTile:
      return update_tile(task, workspace);
    case FrontTask::Kind::Join:
      return;
  }
}

bool Multifrontal::factorizes_by_threads() const {
  return tree_.cost >= plan::flops_worth_threads;
}

std::size_t Multifrontal::factorize(const TrianglePattern& lower, const double* values, int threads) {
  if (!factorizes_by_threads()) threads = 1;
  reserve(threads);
  failed_.store(pivots_.size(), std::memory_order_relaxed);
  const Entries entries{lower, values};
  tree_.factor_graph.run(threads, TaskGraph::Direction::Forwards, [&](int task, int thread) {
    run(tree_.factor_tasks[static_cast<std::size_t>(task)], entries, workspaces_[static_cast<std::size_t>(thread)]);
  });
  return failed_.load(std::memory_order_relaxed);
}

}  // namespace tanor::detail
