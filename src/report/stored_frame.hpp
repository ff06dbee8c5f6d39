#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "report/guides.hpp"

namespace tanor::report {

/// m, and m/s of velocities; squares of distances are numbers.
inline constexpr double largest_place = 1e150;

/// One instant of a motion as it is read back from a folder of results: rows of m points, where the ends of periodic
/// rods follow the points that a run shows, and of R rods.
struct StoredFrame {
  double time = 0.0;                              ///< s
  std::vector<double> positions;                  ///< 3m, m
  std::vector<double> velocities;                 ///< 3m, m/s
  std::vector<bool> is_support;                   ///< m
  std::vector<std::array<std::int32_t, 2>> rods;  ///< rows of their ends
  std::vector<double> tensions;                   ///< R, N
  std::vector<double> guide_forces;               ///< 3m, N: what guides and supports do; empty where no point is held
  std::vector<double> friction_forces{};          ///< 3m, N; empty where there is no friction
  std::vector<Guide> guides;
  Vector3 gravity{};  ///< m/s^2; 0: there is none

  std::size_t num_points() const { return is_support.size(); }
};

}  // namespace tanor::report
