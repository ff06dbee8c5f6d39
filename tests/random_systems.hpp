#pragma once

/// \file Random systems with an admissible state, on which properties are tested.

#include <cstdint>
#include <vector>

#include <tanor/dynamics.hpp>

#include "reference.hpp"

namespace tanor {

struct RandomSystem {
  System system;
  double t = 0.0;                             ///< time at which xi(r, t) = 0 and K'v + xi_t = 0 up to rounding
  std::vector<double> positions, velocities;  ///< at t, 3n
};

struct RandomSystemOptions {
  bool time_dependent = true;  ///< moving supports, geometry and lengths that depend on time
  bool forces = true;
  double most_rows = 0.8;  ///< the largest number of equations, as a part of the moving coordinates
};

/// Makes points at least 0.4 apart, masses from e^-2 to e^2, up to 3 supports, and constraints of all kinds that hold
/// at the positions and whose gradients are independent. Each gradient keeps 5 % of its length orthogonal to the
/// others, in the metric of M^-1.
RandomSystem make_random_system(std::size_t num_points, std::uint32_t seed, const RandomSystemOptions& options = {});

/// Keeps only the constraints that act between points, which are rods and angles. No place is special to them.
RandomSystem without_guides(RandomSystem random);

/// Draws any system of up to 30 points inside a RapidCheck property. A failure shrinks to fewer points.
RandomSystem any_system(const RandomSystemOptions& options = {});

}  // namespace tanor
