#pragma once

#include <cstddef>

/// \file Points that follow one another, eight side by side. See instruction_sets.hpp.
namespace tanor {

/// Largest |x_i|^2 of `count` points; NaN where any number is not finite.
double largest_square(const double* x, std::size_t count);
/// Largest |x_i - y_i|^2 likewise.
double largest_squared_distance(const double* x, const double* y, std::size_t count);

/// y_i := factor_i x_i; y may be x. Returns the largest |y_i|^2 likewise.
double scale(const double* x, const double* factors, std::size_t count, double* y);

}  // namespace tanor
