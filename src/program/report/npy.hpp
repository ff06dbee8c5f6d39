#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "report/output_file.hpp"

/// Writes one array in NumPy's file format: '<f8', C order, version 1.0 (numpy.lib.format). scene/npy.hpp reads it.
namespace tanor::report {

/// Writes `numbers` as rows of `columns` numbers; with one column the array is a plain vector.
void write_npy(OutputFile* file, std::span<const double> numbers, std::size_t columns = 1);
void write_npy(const std::filesystem::path& path, std::span<const double> numbers, std::size_t columns = 1);
/// Writes an array of any shape.
void write_npy(OutputFile* file, std::span<const double> numbers, const std::vector<std::size_t>& shape);

/// Returns the header of an array of any shape; `type` is "<f8", "<i4", …, or the list of a structured one. The header
/// has at least `size` bytes, so that it can be replaced while the array grows.
std::string make_npy_header(std::string_view type, const std::vector<std::size_t>& shape, std::size_t size = 0);

/// Writes a vector of booleans, '|b1'.
void write_npy_booleans(const std::filesystem::path& path, const std::vector<bool>& values);

}  // namespace tanor::report
