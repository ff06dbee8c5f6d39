#include <algorithm>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "base/counts.hpp"
#include "base/groups.hpp"
#include "factor/cholmod_common.hpp"
#include "factor/reflection_kernels.hpp"
#include "factor/sparse_qr.hpp"
#include "factor/supernodes.hpp"

/// \file The QR factorization by dense fronts.
namespace tanor::detail {

namespace {

/// Returns [place in the elimination] -> column of C, in an order of little fill with each subtree of the column
/// elimination tree together: COLAMD (T. A. Davis, J. R. Gilbert, S. I. Larimore, E. G. Ng, ACM TOMS 30, 2004).
std::vector<int> find_order(const SparseColumns& C) {
  std::vector<int> order(C.num_columns());
  std::iota(order.begin(), order.end(), 0);
  if (C.rows.empty()) return order;
  const SparseColumns by_row = transpose(C);
  const TrianglePattern rows{by_row.start, by_row.rows};
  cholmod_sparse transposed = cholmod_view(rows, 0);
  transposed.nrow = C.num_columns();
  CholmodCommon common;
  cholmod_colamd(&transposed, nullptr, 0, /*postorder=*/1, order.data(), &common.c);
  common.check();
  return order;
}

/// Returns a pattern whose factor is that of C'C in the order of elimination, but which has fewer entries. Each row of
/// C joins only its first column with its other columns; the elimination of the first column joins the others.
TrianglePattern join_first_columns(std::size_t num_columns, const SparseColumns& by_row) {
  Groups<int> below(num_columns, [&](const auto& add) {
    for (std::size_t row = 0; row < by_row.num_columns(); ++row) {
      const std::span<const int> columns = by_row.rows_of(row);
      if (row > 0 && std::ranges::equal(columns, by_row.rows_of(row - 1))) continue;
      for (const int column : columns) add(columns.front(), column);
    }
  });
  TrianglePattern pattern;
  for (std::size_t j = 0; j < num_columns; ++j) {
    const std::span own = below[j];
    std::ranges::sort(own);
    pattern.rows.push_back(static_cast<int>(j));
    for (const int row : own) {
      if (row != pattern.rows.back()) pattern.rows.push_back(row);
    }
    pattern.start.push_back(static_cast<int>(pattern.rows.size()));
  }
  return pattern;
}

/// Says which columns and which rows of C meet in which front, and in which order. All of it follows from the pattern
/// of C. The rows of a supernode are the front's own columns, then the other columns that its rows have.
struct FrontPlan {
  std::size_t num_columns;
  std::vector<int> order;  // [place in the elimination] -> column of C
  SparseColumns by_row;    // C' with columns in the order of elimination
  Supernodes supernodes;
  Groups<int> by_first_column;  // the rows of C that begin at each column
  Groups<int> children;         // [supernode]

  explicit FrontPlan(const SparseColumns& C)
      : num_columns(C.num_columns()),
        order(find_order(C)),
        by_row(transpose(columns_of(C, order))),
        supernodes(find_supernodes(join_first_columns(num_columns, by_row))),
        by_first_column(num_columns,
                        [&](const auto& add) {
                          for (std::size_t row = 0; row < by_row.num_columns(); ++row)
                            if (const auto columns = by_row.rows_of(row); !columns.empty())
                              add(columns.front(), static_cast<int>(row));
                        }),
        children(supernodes.size(), [&](const auto& add) {
          for (std::size_t s = supernodes.size(); s-- > 0;)
            if (supernodes.parent[s] >= 0) add(supernodes.parent[s], static_cast<int>(s));
        }) {
    check_count(supernodes.num_stored(), "C of " + std::to_string(num_columns) + " columns", "nonzeros of R");
  }
};

/// The rows that a front leaves over for its parent, as a trapezoid over the columns behind its own ones.
struct Rest {
  std::vector<std::size_t> first;  // [row] first column among those of the rest; increasing
  std::vector<double> values;      // column by column, first.size() each
};

/// The current front: rows of C and of rests, gathered and reduced. Its memory is used again for the next front.
class GatheredFront {
 public:
  explicit GatheredFront(const FrontPlan& plan) : plan_(plan), place_(plan.num_columns) {}

  /// Gathers the rows of front s. It takes the rests [supernode] of its children.
  void fill(std::size_t s, std::vector<Rest>* rests) {
    columns_ = plan_.supernodes.rows_of(s);
    own_ = plan_.supernodes.num_columns(s);
    for (std::size_t k = 0; k < columns_.size(); ++k) place_[static_cast<std::size_t>(columns_[k])] = k;
    sort_rows(s, *rests);
    const std::size_t rows = height_.back(), stride = rows + kernels::rows_read_beyond;
    values_.assign(stride * columns_.size(), 0.0);
    front_ = {rows, columns_.size(), stride, values_.data(), height_.data()};
    fill_own_rows();
    for (const int child : plan_.children[s]) {
      const auto k = static_cast<std::size_t>(child);
      fill_rest(plan_.supernodes.rows_below(k), std::exchange((*rests)[k], {}));
    }
  }

  /// Reduces the front to a trapezoid. Returns the row after its last one.
  std::size_t reduce(double tolerance) {
    scratch_.resize(4 * front_.stride);
    row_at_.resize(columns_.size());
    return kernels::reduce_rows(front_, own_, tolerance, scratch_.data(), row_at_.data());
  }

  /// Appends the rows that begin at the front's own columns to R. Returns how many there are.
  std::size_t append_rows(TriangularFactor* R, SparseColumns* rows) const {
    std::size_t rank = 0;
    for (std::size_t c = 0; c < own_; ++c) {
      const int column = plan_.order[static_cast<std::size_t>(columns_[c])];
      if (row_at_[c] < 0) {
        R->dependent.push_back(column);
        continue;
      }
      ++rank;
      R->independent.push_back(column);
      for (std::size_t k = c; k < columns_.size(); ++k) {
        const double value = values_[k * front_.stride + static_cast<std::size_t>(row_at_[c])];
        if (value != 0.0) rows->append(plan_.order[static_cast<std::size_t>(columns_[k])], value);
      }
      rows->end_column();
    }
    return rank;
  }

  /// Returns the rows [rank, end), which begin behind the front's own columns.
  Rest rest(std::size_t rank, std::size_t end) const {
    Rest rest;
    for (std::size_t c = own_; c < columns_.size(); ++c) {
      if (row_at_[c] >= 0) rest.first.push_back(c - own_);
      const double* const from = values_.data() + c * front_.stride;
      rest.values.insert(rest.values.end(), from + rank, from + end);
    }
    return rest;
  }

 private:
  /// Finds where the rows stand that begin at each column.
  void sort_rows(std::size_t s, const std::vector<Rest>& rests) {
    height_.assign(columns_.size(), 0);
    for (std::size_t k = 0; k < own_; ++k)
      height_[k] = plan_.by_first_column[static_cast<std::size_t>(columns_[k])].size();
    for (const int child : plan_.children[s]) {
      const std::span<const int> columns = plan_.supernodes.rows_below(static_cast<std::size_t>(child));
      for (const std::size_t first : rests[static_cast<std::size_t>(child)].first)
        ++height_[place_[static_cast<std::size_t>(columns[first])]];
    }
    std::partial_sum(height_.begin(), height_.end(), height_.begin());
    next_row_.assign(columns_.size(), 0);
    std::copy(height_.begin(), height_.end() - 1, next_row_.begin() + 1);
  }

  void fill_own_rows() {
    for (std::size_t k = 0; k < own_; ++k) {
      for (const int row : plan_.by_first_column[static_cast<std::size_t>(columns_[k])]) {
        double* const to = values_.data() + next_row_[k]++;
        for_each_entry(plan_.by_row, row, [&](int column, double value) {
          to[place_[static_cast<std::size_t>(column)] * front_.stride] = value;
        });
      }
    }
  }

  void fill_rest(std::span<const int> columns, const Rest& rest) {
    target_.clear();
    for (const std::size_t first : rest.first)
      target_.push_back(next_row_[place_[static_cast<std::size_t>(columns[first])]]++);
    std::size_t begun = 0;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      while (begun < target_.size() && rest.first[begun] <= k) ++begun;
      const double* const from = rest.values.data() + k * target_.size();
      double* const to = values_.data() + place_[static_cast<std::size_t>(columns[k])] * front_.stride;
      for (std::size_t i = 0; i < begun; ++i) to[target_[i]] = from[i];
    }
  }

  const FrontPlan& plan_;
  std::span<const int> columns_;
  std::size_t own_ = 0;             // number of own columns, which come first
  std::vector<std::size_t> place_;  // place in the elimination -> column of the front
  kernels::RowFront front_;
  std::vector<double> values_, scratch_;
  std::vector<std::size_t> height_, next_row_;  // [column]
  std::vector<std::size_t> target_;             // [row of a rest]
  std::vector<int> row_at_;                     // [column] the row that begins there, or -1
};

}  // namespace

TriangularFactor factorize_by_fronts(const SparseColumns& C, double tolerance) {
  const FrontPlan plan(C);
  std::vector<Rest> rests(plan.supernodes.size());
  GatheredFront front(plan);
  TriangularFactor R;
  SparseColumns rows;
  rows.num_rows = static_cast<int>(plan.num_columns);
  for (std::size_t s = 0; s < plan.supernodes.size(); ++s) {
    front.fill(s, &rests);
    const std::size_t end = front.reduce(std::max(tolerance, 0.0));
    const std::size_t rank = front.append_rows(&R, &rows);
    if (end > rank) rests[s] = front.rest(rank, end);
  }
  std::ranges::sort(R.dependent);
  R.set_rows(rows);
  return R;
}

}  // namespace tanor::detail
