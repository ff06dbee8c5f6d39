#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <tanor/time_function.hpp>

namespace tanor::scene {

/// A periodic cell with edges a = (xx, 0, 0), b = (xy, yy, 0), c = (xz, yz, zz); an edge of length 0 is not periodic.
struct Cell {
  double xx = 0.0, yy = 0.0, zz = 0.0;  ///< m
  double xy = 0.0, xz = 0.0, yz = 0.0;  ///< m, tilt

  /// Returns n_a a + n_b b + n_c c.
  Vector3 shift(const std::array<std::int64_t, 3>& images) const;
  /// Returns the images n that make |d - shift(n)| smallest, for distances below half the cell.
  std::array<std::int64_t, 3> nearest_images(Vector3 d) const;
};

/// Moves atoms by whole cells until the bonds are short: each molecule grows from its first atom along its bonds.
/// Returns the shift that each bond still needs to make r_j - r_i + offset short; it is 0 except for bonds that close a
/// loop through a periodic face.
std::vector<Vector3> join_molecules(const Cell& cell, const std::vector<std::array<std::int32_t, 2>>& bonds,
                                    std::vector<Vector3>* positions);

}  // namespace tanor::scene
