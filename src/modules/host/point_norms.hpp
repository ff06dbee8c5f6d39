#pragma once

#include <cstddef>

/// \file Norms of packed points, eight side by side. See instruction_sets.hpp.
namespace tanor::detail {

/// Returns the largest |x_i|^2 of `count` points, or NaN if any number is not finite.
double largest_square(const double* x, std::size_t count);
/// Returns the largest |x_i - y_i|^2 likewise.
double largest_squared_distance(const double* x, const double* y, std::size_t count);

/// Copies `count` points to y. Returns their largest |x_i|^2 likewise.
double copy(const double* x, std::size_t count, double* y);
/// Sets y_i to factor_i x_i, where y may be x. Returns the largest |y_i|^2 likewise.
double scale(const double* x, const double* factors, std::size_t count, double* y);

}  // namespace tanor::detail
