#pragma once

#include <string>

#include "picture/style.hpp"
#include "report/motion_extent.hpp"
#include "report/vtp_reader.hpp"

namespace tanor::picture {

struct Picture {
  report::StoredFrame frame;
  report::MotionExtent extent;
  Style style;
};

/// A picture as a PNG file, and what its colours and arrows mean.
struct Drawn {
  std::string png;
  double tension_scale = 0.0;  ///< N, end of the colours; 0 if no rod is shown
  double arrow = 0.0;          ///< N, of the arrow beside the picture; 0 if there is none
  std::size_t left_out = 0;    ///< guides that are not drawn because too many others cover the picture
};

/// Draws a picture. Throws std::runtime_error if cairo cannot make it.
///
/// This function is in a separate module (`tanor_picture`), so that runs need not load cairo and its dependencies.
Drawn draw(const Picture& picture);

/// Name by which the program finds the module's function, and its type; `trouble` says why there is no picture.
inline constexpr const char* draw_symbol = "tanor_draw_picture";
using DrawFunction = void(const Picture& picture, Drawn* drawn, std::string* trouble);

}  // namespace tanor::picture
