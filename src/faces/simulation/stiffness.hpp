#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <tanor/system.hpp>

#include "dynamics/decisions.hpp"

namespace tanor::detail {

/// How fast the stiffest spring or damper of a system responds, compared with its slow motion; found from the
/// description alone.
struct Stiffness {
  double rate = 0.0;     ///< 1/s, bound of the frequencies of springs and the decay rates of dampers
  std::string spring{};  ///< the spring that has it, "springs0[17]"
  double shortest = std::numeric_limits<double>::infinity();  ///< m, length of a rod or spring
  double fall = 0.0;                                          ///< m/s^2, of gravity
  double speed = 0.0;                                         ///< m/s, the largest one
  bool has_pairs = false;                                     ///< pair forces, whose stiffness is not known

  /// Returns the rate of falling and swinging over the shortest rod or spring, 1/s; 0 if it is unknown.
  double slow_rate() const { return std::max(std::sqrt(fall / shortest), speed / shortest); }
};

Stiffness measure_stiffness(const System& system);
/// Returns that of all processes' parts together. Collective.
Stiffness measure_stiffness(const System& own, Decisions& all);

}  // namespace tanor::detail
