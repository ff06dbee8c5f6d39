#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "base/groups.hpp"
#include "base/vec3.hpp"

namespace tanor::detail {

/// Sparse num_rows x d matrix by columns. The entries of column j are start[j] … start[j + 1] - 1, each row once.
struct SparseColumns {
  int num_rows = 0;
  std::vector<int> start{0};
  std::vector<int> rows;
  std::vector<double> values;

  std::size_t num_columns() const { return start.size() - 1; }
  std::span<const int> rows_of(std::size_t j) const {
    return std::span(rows).subspan(static_cast<std::size_t>(start[j]),
                                   static_cast<std::size_t>(start[j + 1] - start[j]));
  }
  /// Appends an entry to the column at the end, which `end_column` closes.
  void append(int row, double value) {
    rows.push_back(row);
    values.push_back(value);
  }
  void end_column() { start.push_back(static_cast<int>(rows.size())); }
  bool operator==(const SparseColumns&) const = default;
};

/// Calls visit(row, value) for each entry of column j.
template <class Visit>
void for_each_entry(const SparseColumns& A, int j, Visit&& visit) {
  for (int k = A.start[static_cast<std::size_t>(j)]; k < A.start[static_cast<std::size_t>(j) + 1]; ++k)
    visit(A.rows[static_cast<std::size_t>(k)], A.values[static_cast<std::size_t>(k)]);
}

/// Computes y += factor * (column j of A).
inline void add_column(const SparseColumns& A, int j, double factor, double* y) {
  for_each_entry(A, j, [&](int row, double value) { y[row] += factor * value; });
}

/// Returns (column j of A)' y.
inline double dot_column(const SparseColumns& A, int j, const double* y) {
  double sum = 0.0;
  for_each_entry(A, j, [&](int row, double value) { sum += value * y[row]; });
  return sum;
}

/// Returns some columns of A.
SparseColumns columns_of(const SparseColumns& A, std::span<const int> wanted);
SparseColumns transpose(const SparseColumns& A);
/// Scales all columns but those of zeros to unit length. Returns the lengths that they had, 1 for those of zeros.
std::vector<double> normalize_columns(SparseColumns* A);

/// The part of a column in the three rows of a point.
struct PointEntry {
  int point;
  Vec3 value;
};
/// Returns columns whose rows come in triples, one for each of some points. `list(add)` calls add(column, entry) for
/// each part of a column; it is called twice and must list the same parts both times. Parts of a column at one point
/// are added.
template <class List>
SparseColumns collect_columns(std::size_t num_columns, const List& list) {
  Groups<PointEntry> by_column(num_columns, list);
  SparseColumns C;
  C.rows.reserve(3 * by_column.entries.size());
  C.values.reserve(3 * by_column.entries.size());
  C.start.reserve(num_columns + 1);
  for (std::size_t j = 0; j < num_columns; ++j) {
    std::ranges::sort(by_column[j], {}, &PointEntry::point);
    for (const auto& [point, value] : by_column[j]) {
      const int first = 3 * point;
      if (static_cast<int>(C.rows.size()) > C.start.back() && C.rows.end()[-3] == first) {
        double* const there = &C.values.end()[-3];
        store(there, 0, load(there, 0) + value);
        continue;
      }
      C.rows.insert(C.rows.end(), {first, first + 1, first + 2});
      C.values.insert(C.values.end(), {value.x, value.y, value.z});
    }
    C.end_column();
  }
  return C;
}

}  // namespace tanor::detail
