#pragma once

#include <cstddef>

#include "base/vec3.hpp"
#include "evaluate/place.hpp"

/// \file Points on circles that stay where they are: loops in lanes. See instruction_sets.hpp.
namespace tanor_kernels::circles {

using tanor::Place, tanor::Vec3;

/// r = center + cos q a + sin q b, |a| = |b| = R
struct Circle {
  Vec3 a, b, center;
};

/// Places that are worked on at once.
inline constexpr std::size_t chunk_size = 64;

/// Of at most `chunk_size` points at (q, q_dot) [k].
void place(const Circle* circles, std::size_t count, const double* q, const double* q_dot, Place<1>* places);

}  // namespace tanor_kernels::circles

namespace tanor {
namespace circles = tanor_kernels::circles;
}
