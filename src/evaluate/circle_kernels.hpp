#pragma once

#include <cstddef>

#include "base/vec3.hpp"
#include "evaluate/place.hpp"

/// \file Points on circles that stay where they are: loops in lanes. See instruction_sets.hpp.
namespace tanor::circles {

/// r = center + cos q a + sin q b, |a| = |b| = R; each array [k].
struct Circles {
  const double *ax, *ay, *az, *bx, *by, *bz;
  const Vec3* center;
};

/// Points that are worked on at once.
inline constexpr std::size_t chunk_size = 64;

/// Of at most `chunk_size` points at (q, q_dot) [k].
void place(const Circles& circles, std::size_t count, const double* q, const double* q_dot, Place<1>* places);

/// dr/dq.(w - w0) = 0 with the same w0 for all: q_ddot [k] and w; NaN where some number is no number, else 0.
double accelerate(const Circles& circles, std::size_t count, const double* q, const double* q_dot, Vec3 w0,
                  double* q_ddot, Vec3* w);

}  // namespace tanor::circles
