#pragma once

#include <cstddef>

#include "base/vec3.hpp"
#include "evaluate/place.hpp"

/// \file Loops in lanes over points on circles that stay where they are. See instruction_sets.hpp.
namespace tanor::detail::circles {

/// Circles r = center + cos q a + sin q b with |a| = |b| = R. Each array is [k].
struct Circles {
  const double *ax, *ay, *az, *bx, *by, *bz;
  const Vec3* center;
};

/// The largest number of points that are worked on at once.
inline constexpr std::size_t chunk_size = 64;

/// Writes the places of at most `chunk_size` points at (q, q_dot) [k].
void place(const Circles& circles, std::size_t count, const double* q, const double* q_dot, Place<1>* places);

/// Solves dr/dq.(w - w0) = 0 with the same w0 for all points, and writes q_ddot [k] and w [k]. Returns NaN if some
/// number is not finite, else 0.
double accelerate(const Circles& circles, std::size_t count, const double* q, const double* q_dot, Vec3 w0,
                  double* q_ddot, Vec3* w);

}  // namespace tanor::detail::circles
