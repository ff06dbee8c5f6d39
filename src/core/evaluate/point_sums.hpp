#pragma once

#include <cstddef>

#include "base/parallel.hpp"
#include "base/vec3.hpp"

/// \file Sums over points, in eight lanes side by side. In one lane alone each addition would wait for the one before
/// it, which takes four times as long as the memory. The order of additions does not depend on the number of threads.
namespace tanor::detail {

/// Returns the sum of m v.v, twice the kinetic energy. `mass` [count], `v` [3 count].
double sum_squares(const Parallel& parallel, std::size_t count, const double* mass, const double* v);

/// Returns the sum of m r. A uniform field g has the potential energy -g.(this). `mass` [count], `r` [3 count].
Vec3 sum_moments(const Parallel& parallel, std::size_t count, const double* mass, const double* r);

}  // namespace tanor::detail
