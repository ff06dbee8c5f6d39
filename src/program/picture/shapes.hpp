#pragma once

#include <vector>

#include "picture/canvas.hpp"
#include "picture/draw.hpp"

namespace tanor::picture {

/// The units of a motion in its pictures. Lengths are relative to the size of the motion, the diagonal of its box.
struct Scale {
  double size = 1.0;          ///< m
  Vec3 middle;                ///< m, middle of the box
  std::vector<Vec3> outline;  ///< positions that must be in the picture, with the arrows, from the middle
  report::TensionScale tensions;
  double arrow = 0.0;  ///< length of an arrow of 1 N
  double bead = 0.0;   ///< radius
  double rod = 0.0;    ///< radius
};
Scale choose_scale(const Picture& picture);

/// Chooses the direction from which the motion is seen.
Eye choose_eye(const Picture& picture);

/// All shapes of a picture, turned as the camera sees them.
struct Shapes {
  std::vector<Ball> balls;
  std::vector<Cone> cones;
  std::vector<Surface> surfaces;
  std::vector<Triangle> triangles;
  std::size_t left_out = 0;  ///< guides; each costs all samples that it covers, even where it is hidden
};
Shapes build_shapes(const Picture& picture, const Scale& scale, const Camera& camera);

}  // namespace tanor::picture
