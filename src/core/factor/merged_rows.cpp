#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "factor/sparse_qr.hpp"

/// \file The QR factorization of orders that make no fill.
namespace tanor::detail {

namespace {

struct RotatedEntry {
  int column;
  double value;
};

/// The rows of R. They stand in one array, where a row that grows moves to the end.
class RotatedRows {
 public:
  RotatedRows(std::size_t num_columns, std::size_t num_entries) : rows_(num_columns) {
    entries_.reserve(2 * num_entries);
  }

  /// Rotates a row of C, with increasing columns, into the rows of R that begin where it does, one after the other
  /// until nothing is left of it. `row` becomes scratch.
  void merge(std::vector<RotatedEntry>* row) {
    while (!row->empty()) {
      Row& there = rows_[static_cast<std::size_t>(row->front().column)];
      if (there.size == 0) return keep(*row, &there);
      rotate(row, &there);
      keep(upper_, &there);
    }
  }
  std::span<const RotatedEntry> operator[](std::size_t column) const {
    return std::span(entries_).subspan(rows_[column].first, rows_[column].size);
  }
  void clear(std::size_t column) { rows_[column].size = 0; }

 private:
  struct Row {
    std::size_t first = 0, size = 0, capacity = 0;
  };

  void keep(const std::vector<RotatedEntry>& row, Row* there) {
    there->size = row.size();
    if (row.size() <= there->capacity) {
      std::ranges::copy(row, entries_.begin() + static_cast<std::ptrdiff_t>(there->first));
    } else {
      there->first = entries_.size();
      there->capacity = row.size();
      entries_.insert(entries_.end(), row.begin(), row.end());
    }
  }

  /// Takes the first entry of `row` into that of a row of R, which becomes `upper_`. Both get the columns of both.
  void rotate(std::vector<RotatedEntry>* row, Row* there) {
    const RotatedEntry *a = entries_.data() + there->first, *const end_a = a + there->size;
    const RotatedEntry *b = row->data(), *const end_b = b + row->size();
    // [upper; rest] = [c s; -s c] [a; b]
    const double length = std::sqrt(a->value * a->value + b->value * b->value);
    const double inverse = length > 0.0 ? 1.0 / length : 0.0;
    const double c = length > 0.0 ? a->value * inverse : 1.0, s = b->value * inverse;
    upper_.clear();
    rest_.clear();
    upper_.push_back({a->column, length > 0.0 ? length : a->value});
    for (++a, ++b; a != end_a || b != end_b;) {
      const int column = b == end_b || (a != end_a && a->column < b->column) ? a->column : b->column;
      const double x = a != end_a && a->column == column ? (a++)->value : 0.0;
      const double y = b != end_b && b->column == column ? (b++)->value : 0.0;
      upper_.push_back({column, c * x + s * y});
      rest_.push_back({column, c * y - s * x});
    }
    std::swap(*row, rest_);
  }

  std::vector<RotatedEntry> entries_, upper_, rest_;
  std::vector<Row> rows_;  // [column at which it begins]
};

/// Merges the rows of C in the order of their last columns, so that they get no columns before these are there.
RotatedRows merge_all_rows(const SparseColumns& C) {
  const SparseColumns by_row = transpose(C);
  const Groups<int> by_last_column(C.num_columns(), [&](const auto& add) {
    for (std::size_t row = 0; row < by_row.num_columns(); ++row)
      if (!by_row.rows_of(row).empty()) add(by_row.rows_of(row).back(), static_cast<int>(row));
  });
  RotatedRows R(C.num_columns(), C.rows.size());
  std::vector<RotatedEntry> entries;
  for (const int row : by_last_column.entries) {
    entries.clear();
    for_each_entry(by_row, row, [&](int column, double value) { entries.push_back({column, value}); });
    R.merge(&entries);
  }
  return R;
}

}  // namespace

TriangularFactor merge_rows(const SparseColumns& C, double tolerance) {
  RotatedRows merged = merge_all_rows(C);
  TriangularFactor R;
  SparseColumns rows;
  rows.num_rows = static_cast<int>(C.num_columns());
  std::vector<RotatedEntry> rest;
  R.independent.reserve(C.num_columns());
  for (std::size_t j = 0; j < C.num_columns(); ++j) {
    const std::span<const RotatedEntry> row = merged[j];
    if (!row.empty() && std::abs(row.front().value) > tolerance) {
      R.independent.push_back(static_cast<int>(j));
      for (const auto& [column, value] : row) rows.append(column, value);
      rows.end_column();
      continue;
    }
    // The row of a column that is left out belongs to the other columns.
    R.dependent.push_back(static_cast<int>(j));
    if (row.empty()) continue;
    rest.assign(row.begin() + 1, row.end());
    merged.clear(j);
    merged.merge(&rest);
  }
  R.set_rows(rows);
  return R;
}

}  // namespace tanor::detail
