#pragma once

#include <vector>

#include "schur/tree_kernels.hpp"

namespace tanor {

/// How the branches of trees and the trunks that they hang on hear of each other: numbers [inner point] of the points
/// of trunks and of the roots of branches. Those of other points mean nothing.
struct TreePoints {
  std::vector<trees::Mobility<Vec3>> mobility;  ///< of all that is eliminated
  std::vector<double> s;                        ///< [3n] dw that eliminated rods make
  std::vector<double> dw;                       ///< [3n] first K lambda, then M^-1 K lambda

  explicit TreePoints(std::size_t num_points) : mobility(num_points), s(3 * num_points), dw(3 * num_points) {}
};

}  // namespace tanor
