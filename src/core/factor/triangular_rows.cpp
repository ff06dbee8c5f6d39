#include "factor/triangular_rows.hpp"

#include <numeric>

namespace tanor::detail {

void TriangularRows::write_columns(std::size_t num_columns_of_C, TriangularFactor* R) const {
  std::vector<int> place(num_columns_of_C, -1);
  for (std::size_t k = 0; k < R->rank(); ++k) place[static_cast<std::size_t>(R->independent[k])] = static_cast<int>(k);
  R->start.assign(R->rank() + 1, 0);
  for (const int column : columns) {
    if (const int k = place[static_cast<std::size_t>(column)]; k >= 0) ++R->start[static_cast<std::size_t>(k) + 1];
  }
  std::partial_sum(R->start.begin(), R->start.end(), R->start.begin());
  R->rows.resize(static_cast<std::size_t>(R->start.back()));
  R->values.resize(R->rows.size());
  std::vector<int> next(R->start.begin(), R->start.end() - 1);
  // Rows come in order, so the diagonal entry is the last one of its column.
  for (std::size_t row = 0; row < R->rank(); ++row) {
    for (int entry = start[row]; entry < start[row + 1]; ++entry) {
      const int k = place[static_cast<std::size_t>(columns[static_cast<std::size_t>(entry)])];
      if (k < 0) continue;
      const auto slot = static_cast<std::size_t>(next[static_cast<std::size_t>(k)]++);
      R->rows[slot] = static_cast<int>(row);
      R->values[slot] = values[static_cast<std::size_t>(entry)];
    }
  }
}

}  // namespace tanor::detail
