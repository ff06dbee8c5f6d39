#include "factor/multifrontal.hpp"

#include <algorithm>
#include <utility>

#include "base/check.hpp"
#include "factor/front_kernels.hpp"

namespace tanor {

namespace {

using tanor_kernels::front_width;

std::size_t round_up(std::size_t count) {
  return (count + front_width - 1) / front_width * front_width;
}

}  // namespace

Multifrontal::Multifrontal(const TrianglePattern& lower, Supernodes supernodes) : supernodes_(std::move(supernodes)) {
  std::size_t panel = 0, largest = 0;
  for (std::size_t s = 0; s + 1 < supernodes_.first_column.size(); ++s) {
    const auto first = static_cast<std::size_t>(supernodes_.first_column[s]);
    const std::size_t columns = static_cast<std::size_t>(supernodes_.first_column[s + 1]) - first;
    const std::size_t rows = supernodes_.rows_start[s + 1] - supernodes_.rows_start[s];
    Front front{.first_column = first,
                .columns = columns,
                .rows = rows,
                .stride = round_up(rows),
                .panel = panel,
                .update = 0,
                .update_stride = round_up(rows - columns)};
    panel += front.stride * columns;
    largest = std::max(largest, front.stride);
    fronts_.push_back(front);
  }
  panels_.resize(panel + front_width);
  pivots_.resize(lower.size());
  inverse_pivots_.resize(lower.size());
  y_.resize(largest + front_width);
  find_parents();
  find_order();
  place_updates();
  find_rows_in_parents();
  find_entries(lower);
}

/// Finds the parent: the front whose columns hold the first row below.
void Multifrontal::find_parents() {
  std::vector<int> front_of(pivots_.size());
  for (std::size_t s = 0; s < fronts_.size(); ++s)
    std::fill_n(front_of.begin() + supernodes_.first_column[s], fronts_[s].columns, static_cast<int>(s));
  for (std::size_t s = fronts_.size(); s-- > 0;) {
    Front& front = fronts_[s];
    if (front.rows == front.columns) continue;
    const int row = supernodes_.rows[supernodes_.rows_start[s] + front.columns];
    front.parent = front_of[static_cast<std::size_t>(row)];
    Front& parent = fronts_[static_cast<std::size_t>(front.parent)];
    front.depth = parent.depth + 1;  // parents come later, and are met first here
    front.next_sibling = parent.first_child;
    parent.first_child = static_cast<int>(s);
  }
}

/// Orders fronts depth first, so that the update that stands on a stack longest is needed last.
void Multifrontal::find_order() {
  std::vector<int> next(fronts_.size());
  for (std::size_t s = 0; s < fronts_.size(); ++s) next[s] = fronts_[s].first_child;
  for (std::size_t root = 0; root < fronts_.size(); ++root) {
    if (fronts_[root].parent >= 0) continue;
    for (int s = static_cast<int>(root); s >= 0;) {
      int& child = next[static_cast<std::size_t>(s)];
      if (child >= 0) {
        s = std::exchange(child, fronts_[static_cast<std::size_t>(child)].next_sibling);
        continue;
      }
      order_.push_back(s);
      s = fronts_[static_cast<std::size_t>(s)].parent;
    }
  }
}

void Multifrontal::place_updates() {
  std::size_t top[2] = {0, 0}, highest[2] = {0, 0};
  for (const int s : order_) {
    Front& front = fronts_[static_cast<std::size_t>(s)];
    const std::size_t here = front.depth % 2;
    front.update = top[here];
    top[here] += front.update_stride * (front.rows - front.columns);
    highest[here] = std::max(highest[here], top[here]);
    // The updates of the children go; the one that was placed first stands lowest.
    for (int child = front.first_child; child >= 0; child = fronts_[static_cast<std::size_t>(child)].next_sibling)
      top[1 - here] = std::min(top[1 - here], fronts_[static_cast<std::size_t>(child)].update);
  }
  for (std::size_t k = 0; k < 2; ++k) updates_[k].resize(highest[k] + front_width);
}

void Multifrontal::find_rows_in_parents() {
  rows_in_parent_.resize(supernodes_.rows.size());
  for (std::size_t s = 0; s < fronts_.size(); ++s) {
    if (fronts_[s].parent < 0) continue;
    const auto parent = static_cast<std::size_t>(fronts_[s].parent);
    std::size_t at = supernodes_.rows_start[parent];
    for (std::size_t k = supernodes_.rows_start[s] + fronts_[s].columns; k < supernodes_.rows_start[s + 1]; ++k) {
      while (at < supernodes_.rows_start[parent + 1] && supernodes_.rows[at] != supernodes_.rows[k]) ++at;
      ensure(at < supernodes_.rows_start[parent + 1], "a parent's front has all rows of its children's updates");
      rows_in_parent_[k] = static_cast<int>(at - supernodes_.rows_start[parent]);
    }
  }
}

void Multifrontal::find_entries(const TrianglePattern& lower) {
  std::vector<int> place(lower.size(), -1);
  entry_row_.resize(lower.rows.size());
  for (std::size_t s = 0; s < fronts_.size(); ++s) {
    const Front& front = fronts_[s];
    for (std::size_t k = 0; k < front.rows; ++k)
      place[static_cast<std::size_t>(supernodes_.rows[supernodes_.rows_start[s] + k])] = static_cast<int>(k);
    for (std::size_t j = front.first_column; j < front.first_column + front.columns; ++j) {
      for (auto e = static_cast<std::size_t>(lower.start[j]); e < static_cast<std::size_t>(lower.start[j + 1]); ++e)
        entry_row_[e] = place[static_cast<std::size_t>(lower.rows[e])];
    }
  }
}

/// Assembles a front from the columns of S and the updates of its children.
void Multifrontal::assemble(const Front& front, const TrianglePattern& lower, const double* values) {
  double* const panel = panels_.data() + front.panel;
  std::fill_n(panel, front.stride * front.columns, 0.0);
  std::fill_n(update(front), front.update_stride * (front.rows - front.columns), 0.0);
  for (std::size_t j = 0; j < front.columns; ++j) {
    const std::size_t column = front.first_column + j;
    double* const to = panel + j * front.stride;
    for (auto e = static_cast<std::size_t>(lower.start[column]); e < static_cast<std::size_t>(lower.start[column + 1]);
         ++e)
      to[entry_row_[e]] = values[e];
  }
  for (int child = front.first_child; child >= 0; child = fronts_[static_cast<std::size_t>(child)].next_sibling)
    add_update(fronts_[static_cast<std::size_t>(child)], static_cast<std::size_t>(child), front);
}

void Multifrontal::add_update(const Front& child, std::size_t s, const Front& front) {
  const std::size_t count = child.rows - child.columns;
  const int* const rows = rows_in_parent_.data() + supernodes_.rows_start[s] + child.columns;
  const double* from = update(child);
  double *const panel = panels_.data() + front.panel, *const rest = update(front);
  for (std::size_t j = 0; j < count; ++j, from += child.update_stride) {
    const auto column = static_cast<std::size_t>(rows[j]);
    // Row 0 of the front, in its panel or above its update.
    double* const to = column < front.columns
                           ? panel + column * front.stride
                           : rest + static_cast<std::ptrdiff_t>((column - front.columns) * front.update_stride) -
                                 static_cast<std::ptrdiff_t>(front.columns);
    for (std::size_t i = j; i < count; ++i) to[rows[i]] += from[i];
  }
}

std::size_t Multifrontal::factorize(const TrianglePattern& lower, const double* values) {
  for (const int s : order_) {
    const Front& front = fronts_[static_cast<std::size_t>(s)];
    assemble(front, lower, values);
    double* const panel = panels_.data() + front.panel;
    const std::size_t done = tanor_kernels::factorize_panel(front.columns, front.stride, panel);
    if (done < front.columns) return front.first_column + done;
    for (std::size_t j = 0; j < front.columns; ++j) {
      const double pivot = panel[j * (front.stride + 1)];
      pivots_[front.first_column + j] = pivot;
      inverse_pivots_[front.first_column + j] = 1.0 / pivot;
    }
    tanor_kernels::subtract_square(front.rows - front.columns, front.columns, panel + front.columns, front.stride,
                                   update(front), front.update_stride);
  }
  return pivots_.size();
}

void Multifrontal::solve(double* x) {
  const auto gather = [&](std::size_t s, const Front& front) {
    const int* const rows = supernodes_.rows.data() + supernodes_.rows_start[s];
    for (std::size_t i = 0; i < front.rows; ++i) y_[i] = x[rows[i]];
    for (std::size_t i = front.rows; i < front.stride; ++i) y_[i] = 0.0;
    return rows;
  };
  for (std::size_t s = 0; s < fronts_.size(); ++s) {
    const Front& front = fronts_[s];
    const int* const rows = gather(s, front);
    tanor_kernels::substitute_forwards(front.columns, front.stride, panels_.data() + front.panel,
                                       inverse_pivots_.data() + front.first_column, y_.data());
    for (std::size_t i = 0; i < front.rows; ++i) x[rows[i]] = y_[i];
  }
  for (std::size_t s = fronts_.size(); s-- > 0;) {
    const Front& front = fronts_[s];
    (void)gather(s, front);
    tanor_kernels::substitute_backwards(front.columns, front.stride, panels_.data() + front.panel,
                                        inverse_pivots_.data() + front.first_column, y_.data());
    std::copy_n(y_.begin(), front.columns, x + front.first_column);
  }
}

}  // namespace tanor
