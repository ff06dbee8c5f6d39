#pragma once

#include <array>
#include <optional>

namespace tanor::picture {

enum class Projection { Auto, Perspective, Orthographic };

/// The style of a picture. Options without a value are chosen: a view from a corner in perspective, or, if the motion
/// is in a plane, a straight view without perspective.
struct Style {
  int width = 1600, height = 1000;  ///< pixels
  Projection projection = Projection::Auto;
  std::optional<std::array<double, 3>> from{};    ///< from the middle to the eye
  std::optional<std::array<double, 2>> angles{};  ///< degrees: around the vertical from the front, and above it
  std::optional<double> tension_scale{};          ///< N, end of the colours
  bool shows_points = true, shows_rods = true, shows_guides = true, shows_legend = true;
  bool shows_normal = true, shows_tangent = true;  ///< reactions: of guides and supports, and of friction
};

}  // namespace tanor::picture
