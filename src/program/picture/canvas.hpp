#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "picture/camera.hpp"
#include "report/colours.hpp"

namespace tanor::picture {

using report::ground, report::ink, report::bead_colour, report::support_colour, report::normal_colour,
    report::tangent_colour, report::guide_colour, report::unknown_colour, report::earth_colour;
using report::Rgb, report::mix, report::colour_of;

/// A ball; all positions here are turned.
struct Ball {
  Vec3 center;
  double radius;
  Rgb colour;
};

/// A cone with flat ends: a rod if both radii are equal, the head of an arrow if one is 0.
struct Cone {
  Vec3 a, b;
  double radius_a, radius_b;
  Rgb colour;
};

/// A transparent surface with lines on it: an ellipsoid with its half axes, or a parallelogram with two half sides (its
/// third axis is 0).
struct Surface {
  Vec3 center;
  Vec3 axes[3];

  bool is_flat() const { return squared(axes[2]) == 0.0; }
  /// Returns a radius around the center that contains all parts.
  double reach() const {
    return is_flat() ? norm(axes[0]) + norm(axes[1]) : std::max({norm(axes[0]), norm(axes[1]), norm(axes[2])});
  }
};

/// A transparent part of a curved surface, with lines along some edges, each from a corner to the next.
struct Triangle {
  std::array<Vec3, 3> corners;
  std::array<bool, 3> is_line;

  Vec3 center() const { return (1.0 / 3.0) * (corners[0] + corners[1] + corners[2]); }
  /// Returns a radius around the center that contains all corners.
  double reach() const {
    const Vec3 c = center();
    return std::max({norm(corners[0] - c), norm(corners[1] - c), norm(corners[2] - c)});
  }
};

/// Rows of a picture, in which each pixel has several samples with their depths.
class Canvas {
 public:
  Canvas(const Camera& camera, int width, int first_row, int last_row);

  void add(const Ball& ball);
  void add(const Cone& cone);
  /// Shades what is behind an edge, and fades distant parts into the ground by `haze`, 0 … 1. `radius` is that of a
  /// bead.
  void finish(double haze, double radius);
  /// Adds a transparent surface; must be called after `finish`, because surfaces hide nothing.
  void add(const Surface& surface);
  void add(const Triangle& triangle);
  /// Writes the rows first … last - 1 of a picture with pixels 0xffrrggbb.
  void resolve(int first, int last, std::uint32_t* picture) const;

 private:
  struct Hit {
    double depth;
    Vec3 normal;
  };
  template <class Intersect>
  void paint(const std::array<double, 4>& bounds, double nearest, Rgb colour, const Intersect& intersect);
  template <class Visit>
  void visit(const std::array<double, 4>& bounds, const Visit& visit);
  double half_line(double depth) const;
  float cover(const Surface& surface, Vec3 place, Vec3 direction) const;

  const Camera& camera_;
  int width_, first_row_, rows_;  ///< pixels
  int columns_;                   ///< samples in a row of samples
  std::vector<float> depths_;
  std::vector<Rgb> colours_;
};

}  // namespace tanor::picture
