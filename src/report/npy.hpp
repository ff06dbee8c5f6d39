#pragma once

#include <cstddef>
#include <filesystem>
#include <istream>
#include <span>
#include <string>
#include <vector>

#include "report/output_file.hpp"

/// NumPy's file format for one array: '<f8', C order, version 1.0 (numpy.lib.format).
namespace tanor::report {

struct NpyArray {
  std::vector<std::size_t> shape;
  std::vector<double> numbers;  ///< C order: the last index runs fastest
};

/// `numbers` as rows of `columns`; one column: a plain vector.
void write_npy(OutputFile* file, std::span<const double> numbers, std::size_t columns = 1);
void write_npy(const std::filesystem::path& path, std::span<const double> numbers, std::size_t columns = 1);

/// A vector of booleans, '|b1'.
void write_npy_booleans(const std::filesystem::path& path, const std::vector<bool>& values);

/// Reads one array of doubles and leaves the stream behind it. Throws InputError, `name` in its `where()`.
NpyArray read_npy(std::istream* stream, const std::string& name);
NpyArray read_npy(const std::filesystem::path& path);

}  // namespace tanor::report
