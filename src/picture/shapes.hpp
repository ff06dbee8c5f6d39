#pragma once

#include <vector>

#include "picture/canvas.hpp"
#include "picture/draw.hpp"

namespace tanor::picture {

/// What the numbers of a motion mean in its pictures. Lengths are in parts of the size of the motion, the diagonal of
/// its box.
struct Scale {
  double size = 1.0;          ///< m
  Vec3 middle;                ///< m, of the box
  std::vector<Vec3> outline;  ///< what must be in the picture, from the middle: the arrows too
  double tension = 0.0;       ///< N, end of the colours
  double arrow = 0.0;         ///< length of an arrow of 1 N
  double bead = 0.0;          ///< radius
  double rod = 0.0;           ///< radius
};
Scale choose_scale(const Picture& picture);

/// From where the motion is seen.
Eye choose_eye(const Picture& picture);

/// All that stands in a picture, turned as the camera sees it.
struct Shapes {
  std::vector<Ball> balls;
  std::vector<Cone> cones;
  std::vector<Surface> surfaces;
  std::vector<Triangle> triangles;
  std::size_t left_out = 0;  ///< guides: each costs all samples that it covers, however little is seen of it
};
Shapes build_shapes(const Picture& picture, const Scale& scale, const Camera& camera);

}  // namespace tanor::picture
