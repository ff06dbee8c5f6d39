#pragma once

#include <vector>

#include <tanor/system.hpp>

namespace tanor {

/// Moving points that constraints, coordinates and springs join, directly or by others, are one neighbourhood; supports
/// join nothing. What is small in a neighbourhood is small beside its own length: another one, however far, fast or
/// heavy, has no say.
struct Neighbourhoods {
  std::vector<Index> of_point;  ///< [user's point]; -1: a support
  /// [neighbourhood], m: the diagonal of the box around its points, the supports that hold it and the centres that
  /// guide it. Where that is no length, sigma of its pair forces; else 1, or the size of the scene where that is less.
  std::vector<double> length;

  std::size_t size() const { return length.size(); }
};

/// Where the system stands, centres at t.
Neighbourhoods find_neighbourhoods(const System& system, double t);

/// Diagonal of the bounding box of the initial positions, m (1 for a single place): the length scale of a scene.
double scene_size(const System& system);

}  // namespace tanor
