#include "factor/sparse_columns.hpp"

#include <numeric>

namespace tanor::detail {

SparseColumns columns_of(const SparseColumns& A, std::span<const int> wanted) {
  SparseColumns result;
  result.num_rows = A.num_rows;
  for (const int j : wanted) {
    for_each_entry(A, j, [&](int row, double value) {
      result.rows.push_back(row);
      result.values.push_back(value);
    });
    result.start.push_back(static_cast<int>(result.rows.size()));
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

}  // namespace tanor::detail
