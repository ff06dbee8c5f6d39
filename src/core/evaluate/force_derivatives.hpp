#pragma once

#include <vector>

#include "base/block3.hpp"

namespace tanor::detail {

/// The arrays to which df/dr and df/dv are written. Those of points are [moving point], those of couplings are in the
/// order of `Forces::list_couplings`, and those of influences in the order of `Forces::list_influences`.
struct ForceDerivatives {
  Block3 *point_positions, *point_velocities;        ///< df_i/dr_i and df_i/dv_i without those of couplings
  Block3 *coupling_positions, *coupling_velocities;  ///< force on j in r_j and v_j, see Coupling
  Block3* influence_positions;                       ///< force on a point in the position of another one
  Block3* influence_velocities = nullptr;            ///< and in its velocity; null: not wanted
};

/// Storage for all of these arrays.
struct DerivativeBlocks {
  std::vector<Block3> point_positions, point_velocities, coupling_positions, coupling_velocities, influence_positions,
      influence_velocities;

  DerivativeBlocks(std::size_t num_points, std::size_t num_couplings, std::size_t num_influences)
      : point_positions(num_points),
        point_velocities(num_points),
        coupling_positions(num_couplings),
        coupling_velocities(num_couplings),
        influence_positions(num_influences),
        influence_velocities(num_influences) {}
  operator ForceDerivatives() {  // NOLINT(google-explicit-constructor): where they are written
    return {point_positions.data(),     point_velocities.data(),    coupling_positions.data(),
            coupling_velocities.data(), influence_positions.data(), influence_velocities.data()};
  }
};

/// Appends, for each tuple k of p points, the influences on point(k, i) of point(k, j) for all i != j.
template <class Point>
void append_influences(std::size_t size, std::size_t p, const Point& point, std::vector<Influence>* list) {
  for (std::size_t k = 0; k < size; ++k) {
    for (std::size_t ij = 0; ij < p * p; ++ij) {
      if (ij / p != ij % p) list->push_back({point(k, ij / p), point(k, ij % p)});
    }
  }
}

}  // namespace tanor::detail
