#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <tanor/system.hpp>

namespace tanor::report {

/// A surface or curve that points are held on, as a view draws it.
struct Guide {
  std::string kind, name;
  /// What places it at one time, m but for directions, the turns of a helix and its phase (rad):
  /// plane n, offset | sphere c, R | line o, d | circle c, n, R | ellipsoid c, radii, axis, second axis |
  /// helix o, axis, radius, pitch, phase.
  std::vector<double> numbers;
};

/// A state that decides radii, offsets and phases which a scene leaves to the start.
struct GuideStart {
  double time = 0.0;              ///< s
  std::vector<double> positions;  ///< 3n, m
};

/// Guides of constraints and coordinates at time t, in their order, at most `most` of them: at every time the same
/// ones. Points with a number each have a guide each.
std::vector<Guide> place_guides(const System& system, double t, const GuideStart& start, std::size_t most);

/// Names of the groups whose guides have no picture: formulas, angles, pulleys and the like.
std::vector<std::string> list_guides_without_picture(const System& system);

/// Points that a constraint other than a rod, coordinates or a support holds: guides act on these.
std::vector<bool> find_held_points(const System& system);

}  // namespace tanor::report
