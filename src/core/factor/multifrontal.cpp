#include "factor/multifrontal.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "base/check.hpp"
#include "factor/front_kernels.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

using kernels::front_width;

Multifrontal::Multifrontal(const TrianglePattern& lower, std::size_t num_kept)
    : num_kept_(num_kept), supernodes_(find_supernodes(lower, num_kept)), tree_(supernodes_), start_(lower.start) {
  panels_.resize(tree_.panels_size + front_width);
  arena_.resize(tree_.arena_size + front_width);
  pivots_.resize(lower.size());
  inverse_pivots_.resize(lower.size());
  vectors_.resize(tree_.vectors_size + front_width);
  ahead_ = panels_.size() > plan::numbers_beyond_cache ? plan::numbers_fetched_ahead : 0;
  find_rows_in_parents();
  find_entries(lower);
  reserve(1);
}

void Multifrontal::find_rows_in_parents() {
  rows_in_parent_.resize(supernodes_.rows.size());
  run_end_.resize(supernodes_.rows.size());
  for (std::size_t s = 0; s < tree_.fronts.size(); ++s) {
    if (tree_.fronts[s].parent < 0) continue;
    const std::span<const int> there = supernodes_.rows_of(static_cast<std::size_t>(tree_.fronts[s].parent));
    const std::span<const int> below = supernodes_.rows_below(s);
    int* const in_parent = rows_in_parent_.data() + supernodes_.rows_start[s] + tree_.fronts[s].columns;
    int* const run_end = run_end_.data() + (in_parent - rows_in_parent_.data());
    auto at = there.begin();
    for (std::size_t k = 0; k < below.size(); ++k) {
      at = std::find(at, there.end(), below[k]);
      ensure(at != there.end(), "a parent's front has all rows of its children's updates");
      in_parent[k] = static_cast<int>(at - there.begin());
    }
    for (std::size_t k = below.size(); k-- > 0;) {
      const bool goes_on = k + 1 < below.size() && in_parent[k + 1] == in_parent[k] + 1;
      run_end[k] = goes_on ? run_end[k + 1] : static_cast<int>(k + 1);
    }
  }
}

void Multifrontal::find_entries(const TrianglePattern& lower) {
  std::vector<int> place(lower.size(), -1);
  entry_row_.resize(lower.rows.size());
  for (std::size_t s = 0; s < tree_.fronts.size(); ++s) {
    const std::span<const int> rows = supernodes_.rows_of(s);
    for (std::size_t k = 0; k < rows.size(); ++k) place[static_cast<std::size_t>(rows[k])] = static_cast<int>(k);
    const auto first = static_cast<std::size_t>(lower.start[tree_.fronts[s].first_column]);
    const auto end = static_cast<std::size_t>(lower.start[tree_.fronts[s].first_column + tree_.fronts[s].columns]);
    for (std::size_t e = first; e < end; ++e) entry_row_[e] = place[static_cast<std::size_t>(lower.rows[e])];
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
  std::size_t result = arena_.size() + vectors_.size();
  for (const Workspace& workspace : workspaces_)
    result += workspace.stacks[0].size() + workspace.stacks[1].size() + workspace.y.size();
  return result;
}

/// Fills a part of a front's columns with the columns of S.
void Multifrontal::take_entries(const Front& front, const double* values, const Tile& tile) {
  double* const panel = panels_.data() + front.panel;
  for (std::size_t j = tile.column; j < tile.end_column; ++j) {
    double* const to = panel + j * front.stride;
    std::fill(to + tile.row, to + tile.end_row, 0.0);
    const auto start = static_cast<std::size_t>(start_[front.first_column + j]);
    const auto end = static_cast<std::size_t>(start_[front.first_column + j + 1]);
    for (std::size_t e = start; e < end; ++e) {
      const auto row = static_cast<std::size_t>(entry_row_[e]);
      if (row >= tile.row && row < tile.end_row) to[row] = values[e];
    }
  }
}

/// Keeps the first of all columns that fail. Later columns in the order of elimination are skipped, earlier ones are
/// not, so the result does not depend on what other threads have found.
void Multifrontal::fail(std::size_t column) {
  std::size_t first = failed_.load(std::memory_order_relaxed);
  while (column < first && !failed_.compare_exchange_weak(first, column, std::memory_order_relaxed)) {
  }
}

/// Makes a tile of L or of the update, or both of all of a front without tiles.
void Multifrontal::factorize_tile(const FrontTask& task, const double* values, Workspace& workspace) {
  const Front& front = tree_.fronts[task.front];
  const bool is_of_update = task.kind == FrontTask::Kind::UpdateTile;
  const Tile panel = is_of_update ? Tile{} : tile_of(task, front);
  const Tile update =
      is_of_update || !front.is_tiled ? tile_of(task, front, front.update_stride, front.below()) : Tile{};
  const std::size_t end = front.first_column + (is_of_update ? front.columns : panel.end_column);
  if (failed_.load(std::memory_order_relaxed) < end) return;
  take_entries(front, values, panel);
  const kernels::FrontNumbers numbers = numbers_of(front, workspace);
  if (is_kept(front)) return kernels::add_updates(numbers, panel);
  const std::size_t done = kernels::eliminate(numbers, panel, update);
  if (done < panel.end_column) return fail(front.first_column + done);
  for (std::size_t j = panel.column; task.row == task.column && j < panel.end_column; ++j) {
    const double pivot = numbers.panel[j * (front.stride + 1)];
    pivots_[front.first_column + j] = pivot;
    inverse_pivots_[front.first_column + j] = 1.0 / pivot;
  }
}

bool Multifrontal::factorizes_by_threads() const {
  return tree_.cost >= plan::flops_worth_threads;
}

Cholesky::Quality Multifrontal::factorize(const double* values, int threads) {
  if (!factorizes_by_threads()) threads = 1;
  reserve(threads);
  failed_.store(pivots_.size(), std::memory_order_relaxed);
  tree_.run(threads, TaskGraph::Direction::Forwards, [&](const FrontTask& task, std::size_t thread) {
    if (task.kind != FrontTask::Kind::Join) factorize_tile(task, values, workspaces_[thread]);
  });
  const std::size_t done = failed_.load(std::memory_order_relaxed);
  if (done < num_eliminated()) return {false, done, 0.0};
  if (num_eliminated() == 0) return {};
  const auto first = pivots_.begin(), end = first + static_cast<std::ptrdiff_t>(num_eliminated());
  const auto [weakest, strongest] = std::minmax_element(first, end);
  const double ratio = *weakest / *strongest;
  return {true, static_cast<std::size_t>(weakest - first), ratio * ratio};
}

void Multifrontal::write_complement(double* packed) const {
  for (std::size_t j = 0; j < num_kept_; ++j) {
    const Front& front = tree_.fronts.back();
    packed = std::copy_n(panels_.data() + front.panel + j * (front.stride + 1), num_kept_ - j, packed);
  }
}

}  // namespace tanor::detail
