#pragma once

/// \file Random systems with an admissible state: what properties are tried on.

#include <cstdint>
#include <vector>

#include <tanor/dynamics.hpp>

#include "reference.hpp"

namespace tanor {

struct RandomSystem {
  System system;
  double t = 0.0;                             ///< xi(r, t) = 0 and K'v + xi_t = 0 up to rounding
  std::vector<double> positions, velocities;  ///< there, 3n
};

struct RandomSystemOptions {
  bool time_dependent = true;  ///< moving supports, geometry and lengths that depend on time
  bool forces = true;
  double most_rows = 0.8;  ///< number of equations, at most this part of the moving coordinates
};

/// Points at least 0.4 apart, masses e^-2 to e^2, up to 3 supports, constraints of all kinds that hold at the positions
/// and whose gradients are independent (each keeps 5 % of its length orthogonal to the others, in the metric of M^-1).
RandomSystem make_random_system(std::size_t num_points, std::uint32_t seed, const RandomSystemOptions& options = {});

/// Keeps only the constraints that act between points, rods and angles: no place is special to them.
RandomSystem without_guides(RandomSystem random);

/// Inside a RapidCheck property: any system of up to 30 points; a failure shrinks to fewer points.
RandomSystem any_system(const RandomSystemOptions& options = {});

}  // namespace tanor
