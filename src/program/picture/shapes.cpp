#include "picture/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "picture/guide_shapes.hpp"

namespace tanor::picture {

namespace {

constexpr double least_arrow = 0.004;
constexpr double largest_bead = 0.015;
constexpr double dash = 16.0;    // length of two dashes and their gaps, in radii of the rod
constexpr int most_dashes = 50;  // pairs of a rod

Vec3 point(const std::vector<double>& rows, std::size_t k) {
  return load(rows.data(), k);
}

/// Returns a position relative to the middle in units of the motion's size.
Vec3 scaled(const Scale& scale, Vec3 place) {
  return (1.0 / scale.size) * (place - scale.middle);
}

void add_rods(const Picture& picture, const Scale& scale, const Camera& camera, Shapes* shapes) {
  const report::StoredFrame& frame = picture.frame;
  for (std::size_t k = 0; k < frame.rods.size(); ++k) {
    const auto [i, j] = frame.rods[k];
    const Vec3 a = camera.turn(scaled(scale, point(frame.positions, i))),
               b = camera.turn(scaled(scale, point(frame.positions, j)));
    const double radius = std::max(scale.rod, 0.7 * camera.pixel(0.5 * (a.z + b.z)));
    // A rod of unknown tension is dashed: every other piece is left out, and there is one at either end and in the
    // middle.
    const int pieces = std::isfinite(frame.tensions[k])
                           ? 1
                           : 1 + 4 * static_cast<int>(std::clamp(norm(b - a) / (dash * radius), 1.0,
                                                                 static_cast<double>(most_dashes)));
    for (int piece = 0; piece < pieces; piece += 2) {
      const auto at = [&](int end) { return a + (static_cast<double>(end) / pieces) * (b - a); };
      shapes->cones.push_back(
          {at(piece), at(piece + 1), radius, radius, colour_of(frame.tensions[k], scale.tensions.end())});
    }
  }
}

/// Returns the radius of the ball at a turned position.
double find_radius(Vec3 place, bool is_support, const Scale& scale, const Camera& camera) {
  return std::max(scale.bead, camera.pixel(place.z)) * (is_support ? 1.35 : 1.0);
}

void add_points(const Picture& picture, const Scale& scale, const Camera& camera, Shapes* shapes) {
  const report::StoredFrame& frame = picture.frame;
  for (std::size_t k = 0; k < frame.num_points(); ++k) {
    const Vec3 place = camera.turn(scaled(scale, point(frame.positions, k)));
    const bool is_support = frame.is_support[k];
    const double radius = find_radius(place, is_support, scale, camera);
    shapes->balls.push_back({place, radius, is_support ? support_colour : bead_colour});
  }
}

constexpr std::array<Vec3, 3> axes{Vec3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/// Returns the axis along which nothing moves, the last one if there are several.
std::optional<std::size_t> find_thin_axis(const Picture& picture) {
  constexpr double flat = 0.02;
  const Vec3 extent = make_vec3(picture.extent.most) - make_vec3(picture.extent.least);
  const std::array<double, 3> sides{extent.x, extent.y, extent.z};
  for (std::size_t k = 3; k-- > 0;)
    if (sides[k] < flat * norm(extent)) return k;
  return std::nullopt;
}

/// Returns the direction against gravity. Without gravity it is z, or y if the motion is in the plane of x and y.
Vec3 find_up(const Picture& picture) {
  const Vec3 gravity = make_vec3(picture.frame.gravity);
  if (squared(gravity) > 0.0) return (-1.0 / norm(gravity)) * gravity;
  return find_thin_axis(picture) == 2u ? axes[1] : axes[2];
}

constexpr double height_of_ground = 2.8, width_of_ground = 2.1;  // in radii of a bead

/// Calls take(point, place, foot) for every support that stands on the ground beneath it.
template <class Take>
void visit_ground(const Picture& picture, const Scale& scale, const Take& take) {
  if (!picture.style.shows_points) return;
  const Vec3 down = (-height_of_ground * scale.bead) * find_up(picture);
  for (const report::SupportPath& path : picture.extent.supports) {
    const Vec3 place = scaled(scale, make_vec3(path.places[0]));
    if (path.places.size() == 1) take(path.point, place, place + down);
  }
}

void add_ground(const Picture& picture, const Scale& scale, const Camera& camera, Shapes* shapes) {
  visit_ground(picture, scale, [&](std::size_t support, Vec3 place, Vec3 foot) {
    if (!picture.frame.is_support[support]) return;  // it was let go
    shapes->cones.push_back({camera.turn(place), camera.turn(foot), 0.0, width_of_ground * scale.bead, earth_colour});
  });
}

/// Adds an arrow that begins beside a point, so that the ball there hides none of it. It has a shaft and a head, which
/// takes almost half of a short arrow. The shaft of an arrow that is cut has a gap.
void add_arrow(Vec3 place, double radius, Vec3 arrow, double longest, double thickness, Rgb colour, Shapes* shapes) {
  const bool is_cut = norm(arrow) > longest;
  if (is_cut) arrow = (longest / norm(arrow)) * arrow;
  const double length = norm(arrow);
  if (length < least_arrow) return;
  const Vec3 foot = place + (radius / length) * arrow;
  const double head = std::min(3.4 * thickness, 0.45 * length);
  const Vec3 neck = foot + ((length - head) / length) * arrow, tip = foot + arrow;
  // Short arrows are thinner, but at most by half, so that they stay visible.
  const double shaft = 0.32 * thickness * std::max(0.5, head / (3.4 * thickness));
  const Vec3 gap = (is_cut ? 0.5 : 1.0) * (neck - foot), after = (is_cut ? 0.65 : 1.0) * (neck - foot);
  shapes->cones.push_back({foot, foot + gap, shaft, shaft, colour});
  if (is_cut) shapes->cones.push_back({foot + after, neck, shaft, shaft, colour});
  shapes->cones.push_back({neck, tip, 3.1 * shaft, 0.0, colour});
}

void add_forces(const Picture& picture, const std::vector<double>& forces, Rgb colour, const Scale& scale,
                const Camera& camera, Shapes* shapes) {
  const double thickness = std::clamp(scale.bead, 0.004, largest_bead);
  for (std::size_t k = 0; 3 * k < forces.size(); ++k) {
    const Vec3 force = point(forces, k);
    if (!std::isfinite(squared(force))) continue;
    const Vec3 place = camera.turn(scaled(scale, point(picture.frame.positions, k)));
    const double radius =
        picture.style.shows_points ? find_radius(place, picture.frame.is_support[k], scale, camera) : 0.0;
    add_arrow(place, radius, camera.turn_direction(scale.arrow * force), picture.extent.longest_arrow / scale.size,
              thickness, colour, shapes);
  }
}

/// Returns the part of the picture inside bounds (left, right, top, bottom).
double measure_cover(const std::array<double, 4>& bounds, const Style& style) {
  const auto inside = [](double low, double high, double most) {
    return std::fmax(0.0, std::fmin(high, most) - std::fmax(low, 0.0)) / most;
  };
  return inside(bounds[0], bounds[1], style.width) * inside(bounds[2], bounds[3], style.height);
}

/// Adds the guides. The parts of curves, and the covers of the picture, are bounded so that many guides take seconds
/// only.
void add_guides(const Picture& picture, const Scale& scale, const Camera& camera, Shapes* shapes) {
  constexpr double parts_of_all = 2e5, least_parts = 8.0, most_parts = 6000.0;
  constexpr double most_covers = 16.0, weight_of_surface = 4.0;
  const std::vector<report::Guide>& guides = picture.frame.guides;
  const double share = std::floor(parts_of_all / std::max(1.0, static_cast<double>(guides.size())));
  const GuideSpace space{
      scale.middle, scale.size,           camera, std::clamp(share, least_parts, most_parts), picture.frame.positions,
      scale.bead,   picture.frame.gravity};
  for (const auto& [support, places, pivot] : picture.extent.supports) {
    if (places.size() == 1 || !picture.frame.is_support[support]) continue;
    add_path(places, space, shapes);
    if (!pivot) continue;
    const Vec3 a = camera.turn(scaled(scale, make_vec3(*pivot))),
               b = camera.turn(scaled(scale, point(picture.frame.positions, support)));
    shapes->cones.push_back({a, b, 0.5 * scale.rod, scale.rod, support_colour});
  }
  constexpr std::size_t most_numbers = 8'000;  // of formulas, each of which is evaluated thousands of times
  double covers = 0.0;
  std::size_t numbers = 0;
  for (const report::Guide& guide : guides) {
    if (!report::has_picture(guide)) continue;
    numbers += guide.kind == "formula" ? guide.numbers.size() : 0;
    if (covers >= most_covers || numbers > most_numbers) {
      ++shapes->left_out;
      continue;
    }
    const std::size_t first_cone = shapes->cones.size(), first_surface = shapes->surfaces.size(),
                      first_triangle = shapes->triangles.size();
    add_guide(guide, space, shapes);
    for (std::size_t k = first_cone; k < shapes->cones.size(); ++k) {
      const Cone& cone = shapes->cones[k];
      const auto p = camera.bound(cone.a, cone.radius_a), q = camera.bound(cone.b, cone.radius_b);
      covers += measure_cover({std::min(p[0], q[0]), std::max(p[1], q[1]), std::min(p[2], q[2]), std::max(p[3], q[3])},
                              picture.style);
    }
    for (std::size_t k = first_surface; k < shapes->surfaces.size(); ++k) {
      const Surface& surface = shapes->surfaces[k];
      covers += weight_of_surface * measure_cover(camera.bound(surface.center, surface.reach()), picture.style);
    }
    for (std::size_t k = first_triangle; k < shapes->triangles.size(); ++k) {
      const Triangle& triangle = shapes->triangles[k];
      covers += measure_cover(camera.bound(triangle.center(), triangle.reach()), picture.style);
    }
  }
}

}  // namespace

Scale choose_scale(const Picture& picture) {
  const report::MotionExtent& extent = picture.extent;
  const auto points = static_cast<double>(picture.frame.num_points());
  Scale scale;
  const double diagonal = norm(make_vec3(extent.most) - make_vec3(extent.least));
  scale.size = diagonal > 0.0 ? diagonal : 1.0;
  scale.middle = 0.5 * (make_vec3(extent.least) + make_vec3(extent.most));
  for (const Vector3& place : extent.outline) scale.outline.push_back(scaled(scale, make_vec3(place)));
  const bool shows_forces = picture.style.shows_normal || (picture.style.shows_tangent && extent.has_friction);
  if (shows_forces) scale.arrow = extent.arrow / scale.size;
  if (picture.style.shows_rods && !picture.frame.rods.empty()) {
    scale.tensions = extent.tensions;
    if (const auto& end = picture.style.tension_scale) scale.tensions = extent.tensions.with_end(*end);
  }
  scale.bead =
      std::min(largest_bead, extent.rod_length > 0.0 ? 0.3 * extent.rod_length / scale.size : 0.12 / std::sqrt(points));
  scale.rod = 0.6 * scale.bead;
  // The motion stays in the middle where it would be without the ground.
  visit_ground(picture, scale, [&](std::size_t, Vec3 place, Vec3 foot) {
    for (const Vec3 end : {foot, 2.0 * place - foot}) scale.outline.push_back(end);
  });
  if (scale.arrow > 0.0)
    for (const Vector3& tip : extent.tips) scale.outline.push_back(scaled(scale, make_vec3(tip)));
  return scale;
}

Eye choose_eye(const Picture& picture) {
  const Style& style = picture.style;
  const std::optional<std::size_t> thin = find_thin_axis(picture);
  Vec3 up = find_up(picture);
  const Vec3 sideways = std::abs(up.x) < 0.7 ? axes[0] : axes[1];
  Vec3 right = sideways - dot(sideways, up) * up;
  right = (1.0 / norm(right)) * right;
  const Vec3 front = cross(right, up);

  Eye eye;
  const bool is_straight = thin && std::abs(dot(axes[*thin], up)) < 0.7;
  if (style.from) {
    eye.back = make_vec3(*style.from);
  } else if (style.angles) {
    const double around = (*style.angles)[0] * std::numbers::pi / 180.0,
                 above = (*style.angles)[1] * std::numbers::pi / 180.0;
    eye.back = std::cos(above) * (std::cos(around) * front + std::sin(around) * right) + std::sin(above) * up;
  } else if (is_straight) {
    eye.back = (*thin == 1 ? -1.0 : 1.0) * axes[*thin];
  } else {
    eye.back = front + 0.55 * right + 0.4 * up;
  }
  eye.back = (1.0 / norm(eye.back)) * eye.back;
  if (std::abs(dot(eye.back, up)) > 0.999) up = -(eye.back.x + eye.back.y + eye.back.z > 0.0 ? 1.0 : -1.0) * front;
  eye.right = cross(up, eye.back);
  eye.right = (1.0 / norm(eye.right)) * eye.right;
  eye.up = cross(eye.back, eye.right);
  eye.is_perspective = style.projection == Projection::Auto ? !(is_straight && !style.from && !style.angles)
                                                            : style.projection == Projection::Perspective;
  return eye;
}

Shapes build_shapes(const Picture& picture, const Scale& scale, const Camera& camera) {
  const Style& style = picture.style;
  Shapes shapes;
  if (style.shows_rods) add_rods(picture, scale, camera, &shapes);
  if (style.shows_points) add_points(picture, scale, camera, &shapes);
  add_ground(picture, scale, camera, &shapes);
  if (style.shows_normal) add_forces(picture, picture.frame.guide_forces, normal_colour, scale, camera, &shapes);
  if (style.shows_tangent) add_forces(picture, picture.frame.friction_forces, tangent_colour, scale, camera, &shapes);
  if (style.shows_guides) add_guides(picture, scale, camera, &shapes);
  // Sort from front to back, and in the order of the scene at equal depths.
  std::ranges::stable_sort(shapes.balls, {}, [](const Ball& ball) { return ball.center.z; });
  std::ranges::stable_sort(shapes.cones, {}, [](const Cone& cone) { return cone.a.z + cone.b.z; });
  return shapes;
}

}  // namespace tanor::picture
