#pragma once

#include "picture/shapes.hpp"

namespace tanor::picture {

/// The region in which guides are drawn: unbounded ones extend around the middle as far as the size.
struct GuideSpace {
  Vec3 middle;
  double size;  ///< m
  const Camera& camera;
  double most_parts;  ///< straight parts of a curve
};

/// Adds the picture of a plane, sphere, ellipsoid, line, circle, helix or surface of a formula; other kinds have none.
void add_guide(const report::Guide& guide, const GuideSpace& space, Shapes* shapes);

}  // namespace tanor::picture
