#pragma once

#include <cstddef>

/// \file What is largest among points that follow one another, eight side by side. See instruction_sets.hpp.
namespace tanor_kernels {

/// Largest |x_i|^2 of `count` points; NaN where any number is not finite.
double largest_square(const double* x, std::size_t count);
/// Largest |x_i - y_i|^2 likewise.
double largest_squared_distance(const double* x, const double* y, std::size_t count);

}  // namespace tanor_kernels
