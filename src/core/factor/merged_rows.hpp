#pragma once

#include <vector>

#include "base/vec3.hpp"
#include "factor/sparse_qr.hpp"

namespace tanor::detail {

/// Sparse matrix by columns whose rows come in triples, one triple a point. The entries of column j are start[j] …
/// start[j + 1] - 1, each point once.
struct PointColumns {
  struct Entry {
    int point;
    Vec3 value;  ///< in rows 3 point … 3 point + 2
  };
  int num_points = 0;
  std::vector<int> start{0};
  std::vector<Entry> entries;

  std::size_t num_columns() const { return start.size() - 1; }
  SparseColumns expand() const;
};

/// Computes the QR factorization of C in the given order of its columns, row by row, by plane rotations (A. George, M.
/// T. Heath 1980), which keep the digits of rows of very different sizes. It is meant for orders that make no fill
/// (chains, trees). There it is five times as fast as factorize_by_fronts, which first looks for an order and for
/// supernodes. A column that is less than `tolerance` away from those before it is left out; what is left of its row is
/// rotated into the rows behind it (M. T. Heath 1982).
TriangularFactor merge_rows(const PointColumns& C, double tolerance);

}  // namespace tanor::detail
