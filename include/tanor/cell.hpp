#pragma once

#include <array>

#include <tanor/time_function.hpp>

namespace tanor {

/// A periodic cell with edges a = (xx, 0, 0), b = (xy, yy, 0), c = (xz, yz, zz) from its origin; an edge of length 0 is
/// not periodic.
struct Cell {
  double xx = 0.0, yy = 0.0, zz = 0.0;  ///< m
  double xy = 0.0, xz = 0.0, yz = 0.0;  ///< m, tilt
  Vector3 origin{};                     ///< m, corner from which the edges start

  bool is_periodic() const { return xx > 0.0 || yy > 0.0 || zz > 0.0; }
  bool is_periodic_everywhere() const { return xx > 0.0 && yy > 0.0 && zz > 0.0; }
  bool is_tilted() const { return xy != 0.0 || xz != 0.0 || yz != 0.0; }
  /// Returns the volume, m^3; 0 unless all three edges repeat.
  double volume() const { return xx * yy * zz; }

  friend bool operator==(const Cell&, const Cell&) = default;
};

}  // namespace tanor
