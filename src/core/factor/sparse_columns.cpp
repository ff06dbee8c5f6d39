#include "factor/sparse_columns.hpp"

#include <numeric>

namespace tanor::detail {

SparseColumns columns_of(const SparseColumns& A, std::span<const int> wanted) {
  SparseColumns result;
  result.num_rows = A.num_rows;
  for (const int j : wanted) {
    for_each_entry(A, j, [&](int row, double value) { result.append(row, value); });
    result.end_column();
  }
  return result;
}

SparseColumns transpose(const SparseColumns& A) {
  SparseColumns result;
  result.num_rows = static_cast<int>(A.num_columns());
  result.start.assign(static_cast<std::size_t>(A.num_rows) + 2, 0);
  for (const int row : A.rows) ++result.start[static_cast<std::size_t>(row) + 2];
  std::partial_sum(result.start.begin(), result.start.end(), result.start.begin());
  result.rows.resize(A.rows.size());
  result.values.resize(A.rows.size());
  for (int j = 0; j < result.num_rows; ++j) {
    for_each_entry(A, j, [&](int row, double value) {
      const auto place = static_cast<std::size_t>(result.start[static_cast<std::size_t>(row) + 1]++);
      result.rows[place] = j;
      result.values[place] = value;
    });
  }
  result.start.pop_back();
  return result;
}

std::vector<double> normalize_columns(SparseColumns* A) {
  std::vector<double> lengths;
  for (std::size_t j = 0; j < A->num_columns(); ++j) {
    const std::span<double> column(A->values.begin() + A->start[j], A->values.begin() + A->start[j + 1]);
    double square = 0.0;
    for (const double value : column) square += value * value;
    lengths.push_back(square > 0.0 ? std::sqrt(square) : 1.0);
    for (double& value : column) value /= lengths.back();
  }
  return lengths;
}

}  // namespace tanor::detail
