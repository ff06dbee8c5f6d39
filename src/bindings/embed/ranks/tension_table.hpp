#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "embed/ranks/atoms.hpp"

namespace tanor::embed {

/// Tensions as hosts want local data, with a row for each bond of this rank's islands.
class TensionTable {
 public:
  static constexpr int num_columns = 4;  // both tags, type, tension

  void fill(std::span<const Bond> bonds, std::span<const double> tensions) {
    numbers_.resize(num_columns * bonds.size());
    rows_.resize(bonds.size());
    for (std::size_t k = 0; k < bonds.size(); ++k) {
      double* const row = rows_[k] = &numbers_[num_columns * k];
      row[0] = bonds[k].a;
      row[1] = bonds[k].b;
      row[2] = bonds[k].type;
      row[3] = tensions[k];
    }
  }
  double** rows() { return rows_.data(); }
  int num_rows() const { return static_cast<int>(rows_.size()); }

 private:
  std::vector<double> numbers_;
  std::vector<double*> rows_;
};

}  // namespace tanor::embed
