#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <tanor/system.hpp>

namespace tanor {
struct Passage;
}
namespace tanor::report {

struct ShownParts;
struct RopeShape;

/// A surface or curve that points are held on, as a view draws it.
struct Guide {
  std::string kind, name;
  /// Geometry at one time, in m except directions, and the turns and the phase (rad) of a helix:
  /// plane n, offset | sphere c, R | line o, d | circle c, n, R | ellipsoid c, radii, axis, second axis |
  /// helix o, axis, radius, pitch, phase | formula t, index of the step that is xi, then each step of an Expression:
  /// operation, a, b, constant (of a variable: 0 to 3 for x, y, z, t) | tie, spring number of its sheaves, these, then
  /// the rows of its points among those of the frame | rope length, coefficients of its segments, the rows of its
  /// points | cell origin, its three edges. A single number means that the guide has no picture.
  std::vector<double> numbers;
  double gone = std::numeric_limits<double>::quiet_NaN();  ///< since when it holds no longer, s; NaN where it holds
};

/// Returns true for what is drawn along its course from point to point.
inline bool has_course(const Guide& guide) {
  return guide.kind == "tie" || guide.kind == "spring" || guide.kind == "rope";
}

inline bool has_picture(const Guide& guide) {
  return guide.numbers.size() > 1;
}

/// Returns the guides of constraints and coordinates at time t, in their order and at most 64 of them, the same ones at
/// every time. Radii, offsets and phases that the system leaves to the start come from its positions at t_start. Points
/// with individual numbers have a guide each; a sphere and a plane that hold the same points are the circle in which
/// they meet, until one of them goes. `left_out` takes the number of the others.
std::vector<Guide> place_guides(const System& system, double t_start, double t, std::span<const Passage> passages = {},
                                std::size_t* left_out = nullptr);

/// Returns a coil of square turns along the way from a place to another one, as springs are drawn.
inline std::vector<Vector3> make_coil(const Vector3& a, const Vector3& b) {
  constexpr std::size_t parts = 16;
  const Vector3 d{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  std::size_t least = 0;
  for (const std::size_t axis : {1u, 2u})
    if (std::abs(d[axis]) < std::abs(d[least])) least = axis;
  const std::size_t i = (least + 1) % 3, j = (least + 2) % 3;
  const double width = 0.05, length = std::hypot(d[0], d[1], d[2]), part = length > 0.0 ? width / length : 0.0;
  std::array<Vector3, 2> across{};  // d x e and d x (d x e)/|d| with e along the axis that d is least along
  across[0][i] = width * d[j];
  across[0][j] = -width * d[i];
  across[1][least] = -part * (d[i] * d[i] + d[j] * d[j]);
  across[1][i] = part * d[least] * d[i];
  across[1][j] = part * d[least] * d[j];
  std::vector<Vector3> places(parts + 1, a);
  for (std::size_t k = 1; k <= parts; ++k)
    for (std::size_t axis = 0; axis < 3; ++axis)
      places[k][axis] += d[axis] * static_cast<double>(k) / parts + (k == parts  ? 0.0
                                                                     : k % 4 < 2 ? across[k % 2][axis]
                                                                                 : -across[k % 2][axis]);
  return places;
}

/// Returns the ties as guides.
std::vector<Guide> list_ties(const ShownParts& shown, std::span<const Passage> passages = {});

/// Lets the longest segment of a rope sag along `down` if the rope is slack. `lengths` are its length, m, and the
/// coefficients of its segments. Returns true if it is slack.
inline bool let_sag(std::span<const double> lengths, const Vector3& down, std::vector<Vector3>* course) {
  constexpr int parts = 16;
  constexpr double rounding = 1e-9;
  double slack = lengths[0], chord = 0.0;
  std::size_t longest = 1;
  for (std::size_t k = 1; k < course->size(); ++k) {
    const Vector3 &a = (*course)[k - 1], &b = (*course)[k];
    const double size = std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    slack -= lengths[k] * size;
    if (size > chord) chord = size, longest = k;
  }
  const double steep = std::hypot(down[0], down[1], down[2]);
  if (!(slack > rounding * lengths[0])) return false;
  // 16 h^2 = (l^2 - c^2) (4 - c/l): a parabola of length l with the chord c hangs down by h; to 1 % where c is level
  const double length = chord + slack / lengths[longest],
               square = (length * length - chord * chord) * (4.0 - chord / length) / 16.0,
               sag = std::sqrt(square) / (steep > 0.0 ? steep : 1.0);
  const Vector3 along = steep > 0.0 ? down : Vector3{0.0, 0.0, -1.0}, a = (*course)[longest - 1],
                b = (*course)[longest];
  std::vector<Vector3> arc;
  for (int part = 1; part < parts; ++part) {
    const double s = static_cast<double>(part) / parts, low = 4.0 * s * (1.0 - s) * sag;
    Vector3& place = arc.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis) place[axis] = a[axis] + s * (b[axis] - a[axis]) + low * along[axis];
  }
  course->insert(course->begin() + static_cast<std::ptrdiff_t>(longest), arc.begin(), arc.end());
  return true;
}

/// Returns the places that a tie, rope or spring passes, from its first point to its last one; none if its numbers are
/// none. A slack rope sags along `down`, and `is_slack` tells so.
inline std::vector<Vector3> find_course(const Guide& tie, std::span<const double> positions, const Vector3& down = {},
                                        bool* is_slack = nullptr) {
  const std::vector<double>& n = tie.numbers;
  const auto num_points = static_cast<double>(positions.size() / 3), size = static_cast<double>(n.size());
  const bool is_rope = tie.kind == "rope";
  if (n.empty() || (is_rope ? n.size() < 4 || n.size() % 2 != 0 : !(n[0] >= 0.0 && 1.0 + 3.0 * n[0] < size))) return {};
  const std::size_t sheaves = is_rope ? 0 : static_cast<std::size_t>(n[0]),
                    first = is_rope ? n.size() / 2 : 1 + 3 * sheaves;
  std::vector<Vector3> course;
  for (std::size_t k = first; k < n.size(); ++k) {
    if (!(n[k] >= 0.0 && n[k] < num_points)) return {};
    const double* r = &positions[3 * static_cast<std::size_t>(n[k])];
    course.push_back({r[0], r[1], r[2]});
    for (std::size_t at = 1; k == first && at <= 3 * sheaves; at += 3) course.push_back({n[at], n[at + 1], n[at + 2]});
  }
  if (is_rope) {
    const bool sags = let_sag(std::span(n).first(first), down, &course);
    if (is_slack != nullptr) *is_slack = sags;
  }
  return tie.kind == "spring" && course.size() == 2 ? make_coil(course[0], course[1]) : course;
}

/// Returns the length of a rope of the shown ties at time t, m.
double find_rope_length(const System& system, const RopeShape& rope, double t_start, double t);

/// Returns the ends of the twelve edges of a cell, the first and the last of which are the ends of a diagonal.
inline std::vector<Vector3> find_edges(const Guide& cell) {
  const auto corner = [&n = cell.numbers](unsigned bits) {
    Vector3 place{n[0], n[1], n[2]};
    for (std::size_t k = 0; k < 9; ++k)
      if ((bits >> k / 3 & 1u) != 0) place[k % 3] += n[3 + k];
    return place;
  };
  std::vector<Vector3> ends;
  for (unsigned bits = 0; bits < 8; ++bits)
    for (const unsigned bit : {1u, 2u, 4u})
      if ((bits & bit) == 0) ends.insert(ends.end(), {corner(bits), corner(bits | bit)});
  return ends;
}

/// Kind of a Guide that stands for the others, whose single number is how many there are.
inline constexpr const char* of_others = "more";
/// Returns how many guides one stands for.
inline std::size_t count_of(const Guide& guide) {
  return guide.kind == of_others ? static_cast<std::size_t>(guide.numbers[0]) : 1;
}

/// Returns the groups whose guides have no picture: angles, linear equations, and formulas that are no expressions; and
/// the guides and ties for which there is no room.
std::vector<Guide> list_guides_without_picture(const System& system, const ShownParts& shown, double t_start);

/// Returns what a frame stores: the guides at time t, the ties, the cell of a sample that is periodic in all
/// directions, and those without a picture.
std::vector<Guide> list_guides(const System& system, const ShownParts& shown, const std::vector<Guide>& without_picture,
                               double t_start, double t, std::span<const Passage> passages = {});

/// Returns "saddle (formula)" or "6 more guides".
std::string name_guide(const Guide& guide);

/// Returns true for each point that a support, coordinates or a constraint other than a rod holds: guides act on these.
std::vector<bool> find_held_points(const System& system);

}  // namespace tanor::report
