#pragma once

#include <filesystem>
#include <vector>

namespace tanor::scene {

/// Numbers of a file, row by row; all are finite.
struct NumberTable {
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;  ///< rows x columns

  double operator()(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// Reads a `.npy` file ('<f8', C order, one or two dimensions), or else comma-separated values. These may have a header
/// line; blank lines are skipped. Throws InputError that names file and line.
NumberTable read_number_table(const std::filesystem::path& file);

}  // namespace tanor::scene
