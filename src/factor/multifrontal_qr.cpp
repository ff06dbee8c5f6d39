#include "factor/multifrontal_qr.hpp"

#include <algorithm>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "base/counts.hpp"
#include "base/groups.hpp"
#include "factor/column_order.hpp"
#include "factor/reflection_kernels.hpp"
#include "factor/supernodes.hpp"
#include "factor/triangular_rows.hpp"

namespace tanor {

namespace {

struct RowEntry {
  int column;  // where it stands in the order of elimination
  double value;
};

/// C row by row, columns in the order of elimination. An empty order: as they stand.
Groups<RowEntry> group_by_row(const SparseColumns& C, std::span<const int> order) {
  return {static_cast<std::size_t>(C.num_rows), [&](const auto& add) {
            for (std::size_t k = 0; k < C.num_columns(); ++k) {
              const std::size_t j = order.empty() ? k : static_cast<std::size_t>(order[k]);
              for (auto e = static_cast<std::size_t>(C.start[j]); e < static_cast<std::size_t>(C.start[j + 1]); ++e)
                add(C.rows[e], RowEntry{static_cast<int>(k), C.values[e]});
            }
          }};
}

bool have_same_columns(std::span<const RowEntry> a, std::span<const RowEntry> b) {
  return std::ranges::equal(a, b, {}, &RowEntry::column, &RowEntry::column);
}

std::vector<int> find_order(const SparseColumns& C) {
  const Groups<RowEntry> by_row = group_by_row(C, {});
  std::vector<int> columns;
  columns.reserve(by_row.entries.size());
  for (const RowEntry& entry : by_row.entries) columns.push_back(entry.column);
  return order_columns(C.num_columns(), by_row.start, columns);
}

/// A pattern whose factor is that of C'C in the order of elimination, with fewer entries: a row of C joins the column
/// at which it begins with its others, and the elimination of that one joins those.
TrianglePattern join_first_columns(std::size_t num_columns, const Groups<RowEntry>& by_row) {
  Groups<int> below(num_columns, [&](const auto& add) {
    for (std::size_t row = 0; row < by_row.size(); ++row) {
      if (row > 0 && have_same_columns(by_row[row], by_row[row - 1])) continue;
      for (const RowEntry& entry : by_row[row]) add(by_row[row].front().column, entry.column);
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

class FrontalQr {
 public:
  FrontalQr(const SparseColumns& C, double tolerance)
      : tolerance_(std::max(tolerance, 0.0)),
        num_columns_(C.num_columns()),
        order_(find_order(C)),
        by_row_(group_by_row(C, order_)),
        supernodes_(find_supernodes(join_first_columns(num_columns_, by_row_))),
        place_(num_columns_),
        first_child_(supernodes_.size(), -1),
        next_sibling_(supernodes_.size(), -1),
        rests_(supernodes_.size()) {
    check_count(supernodes_.num_stored(), "C of " + std::to_string(num_columns_) + " columns", "nonzeros of R");
    by_first_column_ = Groups<int>(num_columns_, [&](const auto& add) {
      for (std::size_t row = 0; row < by_row_.size(); ++row)
        if (!by_row_[row].empty()) add(by_row_[row].front().column, static_cast<int>(row));
    });
    supernode_of_.resize(num_columns_);
    for (std::size_t s = 0; s < supernodes_.size(); ++s)
      std::fill(supernode_of_.begin() + supernodes_.first_column[s],
                supernode_of_.begin() + supernodes_.first_column[s + 1], static_cast<int>(s));
  }

  TriangularFactor factorize() {
    for (std::size_t s = 0; s < supernodes_.size(); ++s) {
      columns_ = std::span(supernodes_.rows)
                     .subspan(supernodes_.rows_start[s], supernodes_.rows_start[s + 1] - supernodes_.rows_start[s]);
      own_ = static_cast<std::size_t>(supernodes_.first_column[s + 1] - supernodes_.first_column[s]);
      for (std::size_t k = 0; k < columns_.size(); ++k) place_[static_cast<std::size_t>(columns_[k])] = k;
      sort_rows(s);
      fill_front(s);
      scratch_.resize(4 * front_.stride);
      row_at_.resize(columns_.size());
      const std::size_t end = kernels::reduce_rows(front_, own_, tolerance_, scratch_.data(), row_at_.data());
      const std::size_t rank = append_rows();
      if (end > rank) keep_rest(s, rank, end);
    }
    std::ranges::sort(R_.dependent);
    rows_.write_columns(num_columns_, &R_);
    return std::move(R_);
  }

 private:
  /// Rows that a front leaves over: a trapezoid over its columns behind its own ones.
  struct Rest {
    std::vector<std::size_t> first;  // [row] the column at which it begins, among those of the rest; increasing
    std::vector<double> values;      // column by column, first.size() each
  };

  std::span<const int> columns_of_rest(std::size_t s) const {
    const auto own = static_cast<std::size_t>(supernodes_.first_column[s + 1] - supernodes_.first_column[s]);
    return std::span(supernodes_.rows)
        .subspan(supernodes_.rows_start[s] + own, supernodes_.rows_start[s + 1] - supernodes_.rows_start[s] - own);
  }

  template <class Visit>
  void for_each_child(std::size_t s, const Visit& visit) const {
    for (int child = first_child_[s]; child >= 0; child = next_sibling_[static_cast<std::size_t>(child)])
      visit(static_cast<std::size_t>(child));
  }

  /// Calls visit(place) with the front's column at which each row begins, always in the same order.
  template <class Visit>
  void for_each_first_place(std::size_t s, const Visit& visit) const {
    for (std::size_t k = 0; k < own_; ++k) {
      const auto column = static_cast<std::size_t>(columns_[k]);
      for (std::size_t i = 0; i < by_first_column_[column].size(); ++i) visit(k);
    }
    for_each_child(s, [&](std::size_t child) {
      const std::span<const int> columns = columns_of_rest(child);
      for (const std::size_t first : rests_[child].first) visit(place_[static_cast<std::size_t>(columns[first])]);
    });
  }

  /// Finds where the rows stand that begin at each column.
  void sort_rows(std::size_t s) {
    height_.assign(columns_.size(), 0);
    for_each_first_place(s, [&](std::size_t place) { ++height_[place]; });
    std::partial_sum(height_.begin(), height_.end(), height_.begin());
    next_row_.assign(columns_.size(), 0);
    std::copy(height_.begin(), height_.end() - 1, next_row_.begin() + 1);
  }

  void fill_front(std::size_t s) {
    const std::size_t rows = height_.back(), stride = rows + kernels::rows_read_beyond;
    values_.assign(stride * columns_.size(), 0.0);
    front_ = {rows, columns_.size(), stride, values_.data(), height_.data()};
    for (std::size_t k = 0; k < own_; ++k) {
      for (const int row : by_first_column_[static_cast<std::size_t>(columns_[k])]) {
        double* const to = values_.data() + next_row_[k]++;
        for (const auto& [column, value] : by_row_[static_cast<std::size_t>(row)])
          to[place_[static_cast<std::size_t>(column)] * stride] = value;
      }
    }
    for_each_child(s, [&](std::size_t child) {
      Rest& rest = rests_[child];
      const std::span<const int> columns = columns_of_rest(child);
      target_.clear();
      for (const std::size_t first : rest.first)
        target_.push_back(next_row_[place_[static_cast<std::size_t>(columns[first])]]++);
      std::size_t begun = 0;
      for (std::size_t k = 0; k < columns.size(); ++k) {
        while (begun < target_.size() && rest.first[begun] <= k) ++begun;
        const double* const from = rest.values.data() + k * target_.size();
        double* const to = values_.data() + place_[static_cast<std::size_t>(columns[k])] * stride;
        for (std::size_t i = 0; i < begun; ++i) to[target_[i]] = from[i];
      }
      rest = {};
    });
  }

  /// Appends the rows that begin at the front's own columns to R. Returns how many there are.
  std::size_t append_rows() {
    std::size_t rank = 0;
    for (std::size_t c = 0; c < own_; ++c) {
      const int column = order_[static_cast<std::size_t>(columns_[c])];
      if (row_at_[c] < 0) {
        R_.dependent.push_back(column);
        continue;
      }
      ++rank;
      R_.independent.push_back(column);
      for (std::size_t k = c; k < columns_.size(); ++k) {
        const double value = values_[k * front_.stride + static_cast<std::size_t>(row_at_[c])];
        if (value != 0.0) rows_.append(order_[static_cast<std::size_t>(columns_[k])], value);
      }
      rows_.end_row();
    }
    return rank;
  }

  void keep_rest(std::size_t s, std::size_t rank, std::size_t end) {
    Rest& rest = rests_[s];
    for (std::size_t c = own_; c < columns_.size(); ++c) {
      if (row_at_[c] >= 0) rest.first.push_back(c - own_);
      const double* const from = values_.data() + c * front_.stride;
      rest.values.insert(rest.values.end(), from + rank, from + end);
    }
    const auto parent = static_cast<std::size_t>(supernode_of_[static_cast<std::size_t>(columns_[own_])]);
    next_sibling_[s] = std::exchange(first_child_[parent], static_cast<int>(s));
  }

  const double tolerance_;
  const std::size_t num_columns_;
  const std::vector<int> order_;  // [place in the elimination] -> column of C
  const Groups<RowEntry> by_row_;
  const Supernodes supernodes_;
  Groups<int> by_first_column_;                  // rows of C
  std::vector<int> supernode_of_;                // [place in the elimination]
  std::vector<std::size_t> place_;               // place in the elimination -> column of the front at hand
  std::vector<int> first_child_, next_sibling_;  // of supernodes whose rests wait
  std::vector<Rest> rests_;                      // [supernode]
  TriangularFactor R_;
  TriangularRows rows_;

  // The front at hand.
  std::span<const int> columns_;
  std::size_t own_ = 0;
  kernels::RowFront front_;
  std::vector<double> values_, scratch_;
  std::vector<std::size_t> height_, next_row_, target_;
  std::vector<int> row_at_;
};

}  // namespace

TriangularFactor factorize_by_fronts(const SparseColumns& C, double tolerance) {
  return FrontalQr(C, tolerance).factorize();
}

}  // namespace tanor
