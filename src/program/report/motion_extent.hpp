#pragma once

#include <optional>
#include <span>
#include <vector>

#include "report/vtp_reader.hpp"

namespace tanor::report {

/// The tensions over which the colours of a motion extend, N, in its page as in its pictures.
struct TensionScale {
  double least = 0.0;  ///< -end(), or 0 if no rod pushes
  double most = 0.0;   ///< end(), or 0 if no rod pulls

  double end() const { return most > -least ? most : -least; }  ///< 0 without rods
  /// Returns the same colours with another end, N.
  TensionScale with_end(double end) const { return {least < 0.0 ? -end : 0.0, most > 0.0 || least == 0.0 ? end : 0.0}; }
};

/// Key of summary.json under which a run with a page writes both numbers, for its pictures.
inline constexpr const char* tension_colours_key = "tension_colours";

/// Chooses the scale for the tensions of all rods at many instants, N; those that are not finite do not count. At most
/// 1 % of those that pull, and of those that push, are beyond its end, so that a few large ones do not grey the others.
/// The end is rounded up to two digits.
TensionScale choose_tension_scale(std::vector<double> tensions);

/// Returns the middle of the circle on which places lie, the pivot of a crank, if they lie on one of at most a radius.
std::optional<Vector3> find_pivot(std::span<const Vector3> places, double most);

/// Places of a support at the frames until it is let go, m; one place of a support that stands.
struct SupportPath {
  std::size_t point = 0;
  std::vector<Vector3> places{};
  std::optional<Vector3> pivot{};
};

/// Common properties of all pictures of one motion, so that they can be compared side by side.
struct MotionExtent {
  Vector3 least{}, most{};              ///< box around all points, and around round guides that are not much larger, m
  std::vector<Vector3> outline{};       ///< farthest positions in all directions, m: they must be in a picture
  TensionScale tensions{};              ///< of all rods
  double largest_force = 0.0;           ///< N, of guides, supports and friction, without the extreme 3 %
  double arrow = 0.0;                   ///< m, of a force of 1 N
  double longest_arrow = 0.0;           ///< m, at which arrows are cut
  std::vector<Vector3> tips{};          ///< m, farthest ends of arrows in all directions: they must be in a picture
  bool has_friction = false;            ///< true if friction acts somewhere
  double rod_length = 0.0;              ///< median, m; 0 without rods
  std::vector<SupportPath> supports{};  ///< the first 500
};

/// Measures the frames of a motion; there must be at least one.
MotionExtent measure_motion(const std::vector<StoredFrame>& frames);

}  // namespace tanor::report
