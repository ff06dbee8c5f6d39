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
  /// helix o, axis, radius, pitch, phase | formula t, which step is xi, then each step of an Expression: operation, a,
  /// b, constant (of a variable: 0 to 3 for x, y, z, t). One number: it has no picture.
  std::vector<double> numbers;
};

inline bool has_picture(const Guide& guide) {
  return guide.numbers.size() > 1;
}

/// Guides of constraints and coordinates at time t, in their order, at most `most` of them: at every time the same
/// ones. Radii, offsets and phases that the system leaves to the start are those of its positions at t_start. Points
/// with a number each have a guide each.
std::vector<Guide> place_guides(const System& system, double t_start, double t, std::size_t most = 64);

/// Groups whose guides have no picture: formulas of several points, angles, pulleys and the like.
std::vector<Guide> list_guides_without_picture(const System& system);

/// "saddle (formula)"
std::string name_guide(const Guide& guide);

/// Points that a constraint other than a rod, coordinates or a support holds: guides act on these.
std::vector<bool> find_held_points(const System& system);

}  // namespace tanor::report
