#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/lane_parts.hpp"
#include "schur/schur_solver.hpp"

namespace tanor::detail::lanes {

/// Includes a diagonal over its pivot in the largest one. A pivot that is 0, negative or NaN makes it infinite.
template <class Lane>
[[gnu::always_inline]] inline void include(const Lane& ratio, Lane* largest) {
  const Lane checked = ratio > 0.0 ? ratio : Lane{} + HUGE_VAL;
  *largest = checked > *largest ? checked : *largest;
}

/// The largest numbers that were found in each lane.
struct Findings {
  Pack<> largest_inverse = Pack<>{} + 1.0;  ///< S_aa over the pivots; infinite if one of these is not positive
  Largest right_side, residual, own_residual;

  /// Includes the largest |b| and residual of one island in each lane of a part.
  template <class Lanes, class Lane>
  [[gnu::always_inline]] void include(const Lanes& part, const Lane& largest_b, const Lane& largest_left) {
    const Lane own = largest_left / (largest_b + std::numeric_limits<double>::min());
    using One = Seen<Lanes::width>;
    One{largest_b, 0.0 * largest_b}.write(part, &right_side);
    One{largest_left, 0.0 * largest_left}.write(part, &residual);
    One{own, 0.0 * own}.write(part, &own_residual);
  }
  /// Returns the worst of all lanes.
  Elimination read() const {
    double inverse = 1.0;
    for (std::size_t lane = 0; lane < num_lanes; ++lane) inverse = std::max(inverse, largest_inverse[lane]);
    return {1.0 / inverse, right_side.read(), residual.read(), own_residual.read()};
  }
};

}  // namespace tanor::detail::lanes
