#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "picture/camera.hpp"
#include "picture/draw.hpp"

namespace tanor::picture {

/// The arrangement of the picture, pixels.
struct Layout {
  double font = 0.0;  ///< size of the letters
  Area motion;
};
/// `has_colours`: there are words beside the motion.
Layout arrange(const Picture& picture, bool has_colours);

/// The content of the legend.
struct Key {
  report::TensionScale tensions;                 ///< N, from one end of the bar to the other
  double arrow = 0.0, arrow_pixels = 0.0;        ///< N, and the length of its arrow; 0 if there are no arrows
  bool has_less = false, has_more = false;       ///< tensions beyond the ends of the bar
  bool has_unknown = false;                      ///< rods whose tension is not known
  bool has_normal = false, has_tangent = false;  ///< arrows of guides and supports, and of friction
  std::string force_unit{};
};

/// Adds time, colour bar and arrow to a picture with pixels 0xffrrggbb, and returns it as a PNG file.
std::string finish_picture(const Picture& picture, const Layout& layout, const Key& key,
                           std::vector<std::uint32_t>* pixels);

}  // namespace tanor::picture
