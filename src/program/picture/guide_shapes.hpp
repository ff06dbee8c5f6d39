#pragma once

#include <span>
#include <vector>

#include "picture/shapes.hpp"

namespace tanor::picture {

/// The region in which guides are drawn: unbounded ones extend around the middle as far as the size.
struct GuideSpace {
  Vec3 middle;
  double size;  ///< m
  const Camera& camera;
  double most_parts;                  ///< straight parts of a curve
  std::span<const double> positions;  ///< m, of the frame
  double bead;                        ///< radius, relative to the size
  Vector3 gravity{};                  ///< m/s^2, along which slack ropes sag
};

/// Adds the picture of a plane, sphere, ellipsoid, line, circle, helix, surface of a formula, tie or cell; other kinds
/// have none.
void add_guide(const report::Guide& guide, const GuideSpace& space, Shapes* shapes);

/// Adds the path of a support that moves.
void add_path(const std::vector<Vector3>& path, const GuideSpace& space, Shapes* shapes);

}  // namespace tanor::picture
