#pragma once

#include <vector>

#include "schur/tree_kernels.hpp"

namespace tanor::detail {

/// The numbers that the branches of trees and the trunks that they hang on exchange: [inner point] for the points of
/// trunks and the roots of branches. Those of other points mean nothing.
struct TreePoints {
  std::vector<trees::Mobility<Vec3>> mobility;  ///< mobility after all eliminations so far
  std::vector<double> s;                        ///< [3n] dw that eliminated rods make
  std::vector<double> dw;                       ///< [3n] first K lambda, then M^-1 K lambda

  explicit TreePoints(std::size_t num_points) : mobility(num_points), s(3 * num_points), dw(3 * num_points) {}
};

}  // namespace tanor::detail
