#pragma once

#include <string>

#include "picture/style.hpp"
#include "report/motion_extent.hpp"
#include "report/stored_frame.hpp"

namespace tanor::picture {

struct Picture {
  report::StoredFrame frame;
  report::MotionExtent extent;
  Style style;
};

/// A picture as a PNG file, and what its colours and arrows mean.
struct Drawn {
  std::string png;
  double tension_scale = 0.0;  ///< N, end of the colours; 0: no rod is shown
  double arrow = 0.0;          ///< N, of the arrow beside the picture; 0: there is none
  std::size_t left_out = 0;    ///< guides behind so many others that nothing would be seen
};

/// Throws std::runtime_error where cairo cannot make the picture.
///
/// It lies in a module of its own (`tanor_picture`), so that runs need not load cairo and what that needs.
Drawn draw(const Picture& picture);

/// The name by which the program finds the module's function, and its type; `trouble`: why there is no picture.
inline constexpr const char* draw_symbol = "tanor_draw_picture";
using DrawFunction = void(const Picture& picture, Drawn* drawn, std::string* trouble);

}  // namespace tanor::picture
