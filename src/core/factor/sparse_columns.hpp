#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace tanor::detail {

/// Sparse num_rows x d matrix by columns. The entries of column j are start[j] … start[j + 1] - 1, each row once.
struct SparseColumns {
  int num_rows = 0;
  std::vector<int> start{0};
  std::vector<int> rows;
  std::vector<double> values;

  std::size_t num_columns() const { return start.size() - 1; }
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

}  // namespace tanor::detail
