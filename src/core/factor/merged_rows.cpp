#include <algorithm>
#include <cmath>
#include <utility>

#include "factor/sparse_qr.hpp"

/// \file The QR factorization of orders that make no fill.
namespace tanor::detail {

namespace {

struct RotatedEntry {
  int column;
  double value;
};

/// The rows of R.
class RotatedRows {
 public:
  using Row = std::vector<RotatedEntry>;

  explicit RotatedRows(std::size_t num_columns) : rows_(num_columns) {}

  /// Rotates a row of C, with increasing columns, into the rows of R that begin where it does, one after the other
  /// until nothing is left of it. `row` becomes scratch.
  void merge(Row* row) {
    while (!row->empty()) {
      Row& there = rows_[static_cast<std::size_t>(row->front().column)];
      if (there.empty()) return there.assign(row->begin(), row->end());
      rotate(row, &there);
    }
  }
  Row& operator[](std::size_t column) { return rows_[column]; }

 private:
  /// Takes the first entry of `row` into that of a row of R. Both get the columns of both.
  void rotate(Row* row, Row* there) {
    const RotatedEntry *a = there->data(), *const end_a = a + there->size();
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
    there->assign(upper_.begin(), upper_.end());
    std::swap(*row, rest_);
  }

  Row upper_, rest_;
  std::vector<Row> rows_;  // [column at which it begins]
};

}  // namespace

TriangularFactor merge_rows(const SparseColumns& C, double tolerance) {
  const SparseColumns by_row = transpose(C);
  // The rows of C are merged in the order of their last columns, so that they get no columns before these are there.
  const Groups<int> by_last_column(C.num_columns(), [&](const auto& add) {
    for (std::size_t row = 0; row < by_row.num_columns(); ++row)
      if (!by_row.rows_of(row).empty()) add(by_row.rows_of(row).back(), static_cast<int>(row));
  });
  RotatedRows merged(C.num_columns());
  RotatedRows::Row entries;
  for (const int row : by_last_column.entries) {
    entries.clear();
    for_each_entry(by_row, row, [&](int column, double value) { entries.push_back({column, value}); });
    merged.merge(&entries);
  }
  TriangularFactor R;
  SparseColumns rows;
  rows.num_rows = static_cast<int>(C.num_columns());
  R.independent.reserve(C.num_columns());
  for (std::size_t j = 0; j < C.num_columns(); ++j) {
    RotatedRows::Row& row = merged[j];
    if (!row.empty() && std::abs(row.front().value) > tolerance) {
      R.independent.push_back(static_cast<int>(j));
      for (const auto& [column, value] : row) rows.append(column, value);
      rows.end_column();
      continue;
    }
    // The row of a column that is left out belongs to the other columns.
    R.dependent.push_back(static_cast<int>(j));
    if (row.empty()) continue;
    row.erase(row.begin());
    merged.merge(&row);
  }
  R.set_rows(rows);
  return R;
}

}  // namespace tanor::detail
