#pragma once

#include <cstddef>
#include <vector>

#include "factor/sparse_qr.hpp"

namespace tanor::detail {

/// R11 of a TriangularFactor row by row, as a QR finds it. Rows may have entries at dependent columns too.
struct TriangularRows {
  std::vector<int> start{0};
  std::vector<int> columns;  ///< columns of C
  std::vector<double> values;

  void append(int column, double value) {
    columns.push_back(column);
    values.push_back(value);
  }
  void end_row() { start.push_back(static_cast<int>(columns.size())); }
  /// Writes the columns of R, whose independent columns are already known.
  void write_columns(std::size_t num_columns_of_C, TriangularFactor* R) const;
};

}  // namespace tanor::detail
