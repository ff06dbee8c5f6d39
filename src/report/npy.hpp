#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "report/output_file.hpp"

/// Writes NumPy's file format for one array: '<f8', C order, version 1.0 (numpy.lib.format). scene/npy.hpp reads it.
namespace tanor::report {

/// Writes `numbers` as rows of `columns` numbers; with one column the array is a plain vector.
void write_npy(OutputFile* file, std::span<const double> numbers, std::size_t columns = 1);
void write_npy(const std::filesystem::path& path, std::span<const double> numbers, std::size_t columns = 1);
/// The same of any shape.
void write_npy(OutputFile* file, std::span<const double> numbers, const std::vector<std::size_t>& shape);

/// Writes a vector of booleans, '|b1'.
void write_npy_booleans(const std::filesystem::path& path, const std::vector<bool>& values);

}  // namespace tanor::report
