#include "picture/guide_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

#include <tanor/kinds/line_frame.hpp>

#include "picture/implicit_surface.hpp"

namespace tanor::picture {

namespace {

constexpr double turn = 2.0 * std::numbers::pi;

Vec3 unit(Vec3 v) {
  return (1.0 / norm(v)) * v;
}

/// Returns two unit vectors orthogonal to a direction and to one another.
std::array<Vec3, 2> frame_around(Vec3 direction) {
  const auto [e1, e2] = line_frame(Vector3{direction.x, direction.y, direction.z});
  return {make_vec3(e1), make_vec3(e2)};
}

/// Transforms a position, m, into one of the picture.
Vec3 turned(const GuideSpace& space, Vec3 place) {
  return space.camera.turn((1.0 / space.size) * (place - space.middle));
}
Vec3 turned_side(const GuideSpace& space, Vec3 side) {
  return space.camera.turn_direction((1.0 / space.size) * side);
}

void add_curve(const std::vector<Vec3>& places, const GuideSpace& space, Shapes* shapes) {
  constexpr double radius = 0.0018;
  for (std::size_t k = 0; k + 1 < places.size(); ++k) {
    const Vec3 a = turned(space, places[k]), b = turned(space, places[k + 1]);
    const double thick = std::max(radius, 0.7 * space.camera.pixel(a.z));
    shapes->cones.push_back({a, b, thick, thick, guide_colour});
    shapes->balls.push_back({a, thick, guide_colour});
  }
}

void add_surface(Vec3 center, const std::array<Vec3, 3>& axes, const GuideSpace& space, Shapes* shapes) {
  shapes->surfaces.push_back(
      {turned(space, center), {turned_side(space, axes[0]), turned_side(space, axes[1]), turned_side(space, axes[2])}});
}

void add_helix(std::span<const double> n, const GuideSpace& space, Shapes* shapes) {
  const Vec3 origin = load(n.data(), 0), axis = unit(load(n.data(), 1));
  const double radius = n[6], pitch = n[7], phase = n[8];
  const auto [e1, e2] = frame_around(axis);
  const double height = dot(axis, space.middle - origin), reach = 0.5 * space.size;
  constexpr double parts_of_a_turn = 48.0;
  const auto count = static_cast<std::size_t>(
      std::min(space.most_parts, std::ceil(parts_of_a_turn * std::max(1.0, 2.0 * reach / std::abs(pitch)))));
  std::vector<Vec3> places;
  for (std::size_t k = 0; k <= count; ++k) {
    const double z = height + reach * (2.0 * static_cast<double>(k) / static_cast<double>(count) - 1.0);
    const double angle = phase + turn * z / pitch;
    places.push_back(origin + z * axis + radius * std::cos(angle) * e1 + radius * std::sin(angle) * e2);
  }
  add_curve(places, space, shapes);
}

void add_circle(Vec3 center, Vec3 normal, double radius, const GuideSpace& space, Shapes* shapes) {
  const int parts = static_cast<int>(std::min(144.0, space.most_parts));
  const auto [u, v] = frame_around(normal);
  std::vector<Vec3> places;
  for (int k = 0; k <= parts; ++k)
    places.push_back(center + radius * std::cos(turn * k / parts) * u + radius * std::sin(turn * k / parts) * v);
  add_curve(places, space, shapes);
}

void add_cord(Vec3 a, Vec3 b, double radius, const GuideSpace& space, Shapes* shapes) {
  const Vec3 p = turned(space, a), q = turned(space, b);
  const double thick = std::max(radius, 0.7 * space.camera.pixel(p.z));
  shapes->cones.push_back({p, q, thick, thick, support_colour});
}

/// Adds a rope, the line of a formula or a spring. Each sheave is a wheel in the plane of the rope there.
void add_tie(const report::Guide& tie, const GuideSpace& space, Shapes* shapes) {
  constexpr int arcs = 32;
  bool is_slack = false;
  const std::vector<Vector3> course = report::find_course(tie, space.positions, space.gravity, &is_slack);
  const double cord = (is_slack ? 0.12 : 0.28) * space.bead, wheel = 2.0 * space.bead * space.size;
  const auto at = [&](std::size_t k) { return make_vec3(course[k]); };
  for (std::size_t k = 0; k + 1 < course.size(); ++k) add_cord(at(k), at(k + 1), cord, space, shapes);
  if (course.empty()) return;
  const std::size_t sheaves = tie.kind == "rope" ? 0 : static_cast<std::size_t>(tie.numbers[0]);
  for (std::size_t k = 1; k <= sheaves; ++k) {
    const Vec3 middle = at(k), along = at(k - 1) - middle,
               other = (k == 1 ? at(course.size() - 2) : at(course.size() - 1)) - middle;
    if (!(squared(along) > 0.0)) continue;
    const Vec3 u = unit(along), across = other - dot(other, u) * u;
    const Vec3 v = squared(across) > 1e-12 * squared(along) ? unit(across) : frame_around(u)[0];
    const auto rim = [&](int arc) {
      return middle + wheel * std::cos(turn * arc / arcs) * u + wheel * std::sin(turn * arc / arcs) * v;
    };
    for (int arc = 0; arc < arcs; ++arc) add_cord(rim(arc), rim(arc + 1), cord, space, shapes);
  }
}

void add_formula(std::span<const double> n, const GuideSpace& space, Shapes* shapes) {
  const std::optional<ImplicitFunction> xi = ImplicitFunction::read(n);
  if (!xi) return;
  for (const SurfacePart& part : polygonise(*xi, space.middle, 0.5 * space.size)) {
    const auto& [a, b, c] = part.corners;
    shapes->triangles.push_back({{turned(space, a), turned(space, b), turned(space, c)}, part.is_line});
  }
}

}  // namespace

void add_guide(const report::Guide& guide, const GuideSpace& space, Shapes* shapes) {
  const std::vector<double>& n = guide.numbers;
  const auto at = [&](std::size_t first) { return Vec3{n[first], n[first + 1], n[first + 2]}; };
  if (guide.kind == "plane") {
    // The plane is normal.r = offset; draw it around the projection of the middle.
    const Vec3 normal = at(0);
    const Vec3 foot = space.middle + ((n[3] - dot(normal, space.middle)) / squared(normal)) * normal;
    const double side = 0.38 * space.size;
    const auto [u, v] = frame_around(normal);
    add_surface(foot, {side * u, side * v, Vec3{}}, space, shapes);
  } else if (guide.kind == "sphere") {
    add_surface(at(0), {Vec3{n[3], 0, 0}, {0, n[3], 0}, {0, 0, n[3]}}, space, shapes);
  } else if (guide.kind == "ellipsoid") {
    const Vec3 e = unit(at(6)), h = at(9), f = unit(h - dot(h, e) * e);
    add_surface(at(0), {n[3] * e, n[4] * f, n[5] * cross(e, f)}, space, shapes);
  } else if (guide.kind == "line") {
    const Vec3 along = unit(at(3)), near = at(0) + dot(along, space.middle - at(0)) * along;
    add_curve({near - 0.5 * space.size * along, near + 0.5 * space.size * along}, space, shapes);
  } else if (guide.kind == "circle") {
    add_circle(at(0), at(3), n[6], space, shapes);
  } else if (guide.kind == "helix") {
    add_helix(n, space, shapes);
  } else if (guide.kind == "formula") {
    add_formula(n, space, shapes);
  } else if (guide.kind == "cell") {
    const std::vector<Vector3> ends = report::find_edges(guide);
    for (std::size_t k = 0; k < ends.size(); k += 2)
      add_curve({make_vec3(ends[k]), make_vec3(ends[k + 1])}, space, shapes);
  } else if (report::has_course(guide)) {
    add_tie(guide, space, shapes);
  }
}

void add_path(const std::vector<Vector3>& path, const GuideSpace& space, Shapes* shapes) {
  std::vector<Vec3> places;
  for (const Vector3& place : path) places.push_back(make_vec3(place));
  add_curve(places, space, shapes);
}

}  // namespace tanor::picture
