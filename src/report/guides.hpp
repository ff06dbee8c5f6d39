#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <tanor/system.hpp>

namespace tanor::report {

/// A surface or curve that points are held on, as a view draws it.
struct Guide {
  std::string kind, name;
  /// Geometry at one time, in m except directions, and the turns and the phase (rad) of a helix:
  /// plane n, offset | sphere c, R | line o, d | circle c, n, R | ellipsoid c, radii, axis, second axis |
  /// helix o, axis, radius, pitch, phase | formula t, index of the step that is xi, then each step of an Expression:
  /// operation, a, b, constant (of a variable: 0 to 3 for x, y, z, t). A single number means that the guide has no
  /// picture.
  std::vector<double> numbers;
};

inline bool has_picture(const Guide& guide) {
  return guide.numbers.size() > 1;
}

/// Returns the guides of constraints and coordinates at time t, in their order and at most `most` of them, the same
/// ones at every time. Radii, offsets and phases that the system leaves to the start come from its positions at
/// t_start. Points with individual numbers have a guide each.
std::vector<Guide> place_guides(const System& system, double t_start, double t, std::size_t most = 64);

/// Returns the groups whose guides have no picture: formulas of several points, angles, pulleys and the like.
std::vector<Guide> list_guides_without_picture(const System& system);

/// Returns "saddle (formula)".
std::string name_guide(const Guide& guide);

/// Returns true for each point that a support, coordinates or a constraint other than a rod holds: guides act on these.
std::vector<bool> find_held_points(const System& system);

}  // namespace tanor::report
