#pragma once

#include <vector>

#include <tanor/system.hpp>

namespace tanor::detail {

/// Sets of moving points that constraints, coordinates and springs join, directly or through others; supports join
/// nothing. Errors in a neighbourhood are measured against its own length: another neighbourhood, however far, fast or
/// heavy, has no influence.
struct Neighbourhoods {
  std::vector<Index> of_point;  ///< [user's point]; -1 for a support
  /// [neighbourhood], m: the diagonal of the box around its points, the supports that hold it and the centres that
  /// guide it. If that is no length, it is sigma of its pair forces, else 1 or the size of the scene, whichever is
  /// less.
  std::vector<double> length;

  std::size_t size() const { return length.size(); }
};

/// Finds the neighbourhoods at the system's start positions, with centres at t.
Neighbourhoods find_neighbourhoods(const System& system, double t);

/// Returns the diagonal of the bounding box of the initial positions, m (1 for a single place): the length scale of a
/// scene.
double scene_size(const System& system);

}  // namespace tanor::detail
