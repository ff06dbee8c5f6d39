#include "picture/canvas.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace tanor::picture {

namespace {

constexpr int fine = 3;  // samples along a side of a pixel
constexpr float nothing = std::numeric_limits<float>::infinity();
constexpr float sheet = 0.09f, line = 0.28f;  // part of a sample that a surface covers, and a line on it

/// Shades a colour with light from above and the left. A surface that faces the eye keeps its colour, so that colours
/// can be read; one that faces the light is a little whiter.
Rgb light(Rgb colour, Vec3 normal) {
  constexpr Vec3 lamp{-0.34, 0.55, -0.763};  // turned: depth grows away from the eye
  constexpr double ambient = 0.38, straight = 0.763, shine = 0.55;
  const double part =
      (ambient + (1.0 - ambient) * std::max(0.0, dot(normal, lamp))) / (ambient + (1.0 - ambient) * straight);
  if (part <= 1.0) return static_cast<float>(part) * colour;
  const double towards = (part - 1.0) / 0.17;  // 0: the eye, 1: the lamp
  return mix(colour, {1.0f, 1.0f, 1.0f}, static_cast<float>(shine * std::min(1.0, towards * towards)));
}

/// Returns the first intersection of a ray with a ball.
std::optional<double> meet(const Ray& ray, Vec3 center, double radius) {
  // |o + s d - c|^2 = r^2
  const Vec3 from = ray.origin - center;
  const double a = squared(ray.direction), b = dot(ray.direction, from), c = squared(from) - radius * radius;
  const double root = b * b - a * c;
  if (root < 0.0) return {};
  return (-b - std::sqrt(root)) / a;
}

/// Terms that are the same for all rays to a cone: axis d = b - a.
struct ConeTerms {
  Vec3 d;
  double dd, slope, hy;
  explicit ConeTerms(const Cone& cone)
      : d(cone.b - cone.a), dd(squared(d)), slope(cone.radius_a - cone.radius_b), hy(dd + slope * slope) {}
};

}  // namespace

Canvas::Canvas(const Camera& camera, int width, int first_row, int last_row)
    : camera_(camera),
      width_(width),
      first_row_(first_row),
      rows_(last_row - first_row),
      columns_(fine * width),
      depths_(static_cast<std::size_t>(columns_) * fine * static_cast<std::size_t>(rows_), nothing),
      colours_(depths_.size(), ground) {}

/// Calls visit(sample, ray) for the samples inside some bounds.
template <class Visit>
void Canvas::visit(const std::array<double, 4>& bounds, const Visit& visit) {
  // std::fmin and std::fmax ignore NaN, so that shapes at undefined positions have no samples.
  const auto clip = [](double place, int most) {
    return static_cast<int>(std::fmax(0.0, std::fmin(std::floor(place), static_cast<double>(most))));
  };
  const int left = clip(fine * bounds[0], columns_), right = clip(fine * bounds[1] + 1.0, columns_);
  const int top = clip(fine * (bounds[2] - first_row_), fine * rows_);
  const int bottom = clip(fine * (bounds[3] - first_row_) + 1.0, fine * rows_);
  for (int row = top; row < bottom; ++row) {
    for (int column = left; column < right; ++column)
      visit(static_cast<std::size_t>(row) * columns_ + column,
            camera_.ray((column + 0.5) / fine, first_row_ + (row + 0.5) / fine));
  }
}

/// Paints a shape. No part of it is less deep than `nearest`; hidden samples are skipped at little cost, so near shapes
/// should come first.
template <class Intersect>
void Canvas::paint(const std::array<double, 4>& bounds, double nearest, Rgb colour, const Intersect& intersect) {
  visit(bounds, [&](std::size_t sample, const Ray& ray) {
    if (static_cast<double>(depths_[sample]) <= nearest) return;
    const std::optional<Hit> hit = intersect(ray);
    if (!hit || !(hit->depth > 0.0) || hit->depth >= static_cast<double>(depths_[sample])) return;
    depths_[sample] = static_cast<float>(hit->depth);
    colours_[sample] = light(colour, hit->normal);
  });
}

void Canvas::add(const Ball& ball) {
  paint(camera_.bound(ball.center, ball.radius), ball.center.z - ball.radius, ball.colour,
        [&](const Ray& ray) -> std::optional<Hit> {
          const std::optional<double> depth = meet(ray, ball.center, ball.radius);
          if (!depth) return {};
          return Hit{*depth, (1.0 / ball.radius) * (ray.origin + *depth * ray.direction - ball.center)};
        });
}

void Canvas::add(const Cone& cone) {
  const ConeTerms terms(cone);
  if (!(terms.dd > 0.0)) return;
  const Vec3 d = terms.d;
  const double dd = terms.dd, slope = terms.slope, hy = terms.hy;
  const std::array<double, 4> p = camera_.bound(cone.a, cone.radius_a), q = camera_.bound(cone.b, cone.radius_b);
  const std::array bounds{std::min(p[0], q[0]), std::max(p[1], q[1]), std::min(p[2], q[2]), std::max(p[3], q[3])};
  const double nearest = std::min(cone.a.z, cone.b.z) - std::max(cone.radius_a, cone.radius_b);
  paint(bounds, nearest, cone.colour, [&](const Ray& ray) -> std::optional<Hit> {
    const Vec3 from = ray.origin - cone.a, e = ray.direction;
    const double along = dot(from, d), rise = dot(e, d), straight = dot(e, from);
    std::optional<Hit> hit;
    const auto take = [&](double depth, Vec3 normal) {
      if (depth > 0.0 && (!hit || depth < hit->depth)) hit = Hit{depth, (1.0 / norm(normal)) * normal};
    };
    // The ends satisfy (p - a).d = 0 or d^2, and lie no farther from the axis than the radius.
    const auto try_end = [&](double height, double radius, Vec3 center, Vec3 normal) {
      const double depth = (height - along) / rise;
      if (radius > 0.0 && rise != 0.0 && squared(ray.origin + depth * e - center) <= radius * radius)
        take(depth, normal);
    };
    try_end(0.0, cone.radius_a, cone.a, -d);
    try_end(dd, cone.radius_b, cone.b, d);
    // The side satisfies d^4 |p - a|^2 - y^2 (d^2 + slope^2) + d^2 r_a (2 slope y - d^2 r_a) = 0 with y = (p - a).d.
    const double k2 = dd * dd * squared(e) - rise * rise * hy;
    const double k1 = dd * dd * straight - along * rise * hy + dd * cone.radius_a * slope * rise;
    const double k0 =
        dd * dd * squared(from) - along * along * hy + dd * cone.radius_a * (2.0 * slope * along - dd * cone.radius_a);
    const double root = k1 * k1 - k2 * k0;
    if (root >= 0.0 && k2 != 0.0) {
      for (const double sign : {-1.0, 1.0}) {
        const double depth = (-k1 + sign * std::sqrt(root)) / k2, y = along + depth * rise;
        if (y < 0.0 || y > dd) continue;
        take(depth, dd * (dd * (from + depth * e) + slope * cone.radius_a * d) - hy * y * d);
      }
    }
    return hit;
  });
}

void Canvas::finish(double haze, double radius) {
  // Samples deeper than their surroundings are darkened by the part of these that is in front, up to a few beads.
  const int reach = std::max(fine, fine * width_ / 500);
  const std::array<std::array<int, 2>, 8> around{
      {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {-1, 1}, {1, -1}, {1, 1}}};
  constexpr float dark = 0.5f;
  const auto room = static_cast<float>(6.0 * radius);
  const auto begin = static_cast<float>(camera_.nearest());
  // A motion that is nearly flat does not fade.
  const auto depth_of_all = static_cast<float>(std::max(0.5, camera_.farthest() - camera_.nearest()));
  const int rows = fine * rows_;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const std::size_t sample = static_cast<std::size_t>(row) * columns_ + column;
      const float depth = depths_[sample];
      if (depth == nothing) continue;
      float hidden = 0.0f;
      for (const auto& [x, y] : around) {
        const int r = std::clamp(row + y * reach, 0, rows - 1), c = std::clamp(column + x * reach, 0, columns_ - 1);
        hidden += std::clamp((depth - depths_[static_cast<std::size_t>(r) * columns_ + c]) / room, 0.0f, 1.0f);
      }
      Rgb& colour = colours_[sample];
      colour = (1.0f - dark * hidden / 8.0f) * colour;
      colour = mix(colour, ground, static_cast<float>(haze) * std::clamp((depth - begin) / depth_of_all, 0.0f, 1.0f));
    }
  }
}

/// Returns half the width of a line that is drawn on a surface.
double Canvas::half_line(double depth) const {
  return 0.6 * camera_.pixel(depth) * std::max(1.0, width_ / 1000.0);
}

/// Returns the part of a sample that a surface covers at a point: little, and more on one of its lines.
float Canvas::cover(const Surface& surface, Vec3 place, Vec3 direction) const {
  constexpr double lines = 12.0;  // for a turn and along a side
  const double half_width = half_line(place.z);
  const Vec3 e = (1.0 / norm(direction)) * direction, from = place - surface.center;
  const Vec3 &u = surface.axes[0], &v = surface.axes[1], &w = surface.axes[2];
  // A line of a coordinate that grows along t must have the same apparent width everywhere. A pixel covers |t - n
  // (e.t)/(e.n)| of the coordinate.
  const auto is_near_line = [&](double turns, double length, Vec3 t, Vec3 n) {
    constexpr double steepest = 5.0;
    const Vec3 seen = t - (dot(e, t) / dot(e, n)) * n;
    const double away = std::abs(turns * lines - std::round(turns * lines)) / lines * length;
    return away < half_width * std::min(steepest, norm(seen));
  };
  bool is_line = false;
  if (squared(w) > 0.0) {
    const double turn = 2.0 * std::numbers::pi;
    const double x = dot(from, u) / squared(u), y = dot(from, v) / squared(v), z = dot(from, w) / squared(w);
    const double ring = std::hypot(x, y);
    const auto unit = [](Vec3 a) { return (1.0 / norm(a)) * a; };
    const Vec3 n = unit((x / squared(u)) * u + (y / squared(v)) * v + (z / squared(w)) * w);
    const Vec3 round = -y * u + x * v, down = z * (x * u + y * v) + (-ring * ring) * w;
    is_line = ring > 1e-9 && (is_near_line(std::atan2(y, x) / turn, turn * norm(round), unit(round), n) ||
                              is_near_line(std::atan2(ring, z) / turn, turn * norm(down) / ring, unit(down), n));
  } else {
    const Vec3 n = cross(u, v);
    const auto along = [&](Vec3 side) {
      return is_near_line(0.5 * (dot(from, side) / squared(side) + 1.0), 2.0 * norm(side), (1.0 / norm(side)) * side,
                          (1.0 / norm(n)) * n);
    };
    is_line = along(u) || along(v);
  }
  return is_line ? line : sheet;
}

void Canvas::add(const Surface& surface) {
  const Vec3 &u = surface.axes[0], &v = surface.axes[1], &w = surface.axes[2];
  const bool is_flat = surface.is_flat();
  const Vec3 normal = cross(u, v);
  visit(camera_.bound(surface.center, surface.reach()), [&](std::size_t sample, const Ray& ray) {
    const Vec3 from = ray.origin - surface.center, e = ray.direction;
    std::array<double, 2> depths{-1.0, -1.0};
    if (is_flat) {
      const double depth = -dot(from, normal) / dot(e, normal);
      const Vec3 p = from + depth * e;
      if (std::abs(dot(p, u)) <= squared(u) && std::abs(dot(p, v)) <= squared(v)) depths[0] = depth;
    } else {
      // The surface is a ball of radius 1 in the coordinates along its axes.
      const auto inside = [&](Vec3 p) {
        return Vec3{dot(p, u) / squared(u), dot(p, v) / squared(v), dot(p, w) / squared(w)};
      };
      const Vec3 o = inside(from), d = inside(e);
      const double a = squared(d), b = dot(o, d), root = b * b - a * (squared(o) - 1.0);
      if (root >= 0.0) depths = {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a};
    }
    float part = 0.0f;
    for (const double depth : depths)
      if (depth > 0.0 && depth < static_cast<double>(depths_[sample]))
        part = 1.0f - (1.0f - part) * (1.0f - cover(surface, ray.origin + depth * e, e));
    if (part > 0.0f) colours_[sample] = mix(colours_[sample], guide_colour, part);
  });
}

void Canvas::add(const Triangle& triangle) {
  const Vec3 a = triangle.corners[0], normal = cross(triangle.corners[1] - a, triangle.corners[2] - a);
  if (!(squared(normal) > 0.0)) return;
  visit(camera_.bound(triangle.center(), triangle.reach()), [&](std::size_t sample, const Ray& ray) {
    const double depth = dot(a - ray.origin, normal) / dot(ray.direction, normal);
    if (!(depth > 0.0 && depth < static_cast<double>(depths_[sample]))) return;
    const Vec3 place = ray.origin + depth * ray.direction;
    const double half_width = half_line(place.z);
    bool is_line = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 from = triangle.corners[k], side = triangle.corners[(k + 1) % 3] - from;
      const Vec3 inwards = cross(normal, side);
      const double away = dot(place - from, inwards);
      if (away < 0.0) return;
      is_line = is_line || (triangle.is_line[k] && away < half_width * norm(inwards));
    }
    colours_[sample] = mix(colours_[sample], guide_colour, is_line ? line : sheet);
  });
}

void Canvas::resolve(int first, int last, std::uint32_t* picture) const {
  const auto byte = [](float part) {
    return static_cast<std::uint32_t>(std::lround(255.0f * std::fmax(0.0f, std::fmin(part / (fine * fine), 1.0f))));
  };
  for (int y = first; y < last; ++y) {
    for (int x = 0; x < width_; ++x) {
      Rgb sum;
      for (int k = 0; k < fine; ++k)
        for (int i = 0; i < fine; ++i)
          sum = sum + colours_[static_cast<std::size_t>(fine * (y - first_row_) + k) * columns_ + fine * x + i];
      picture[static_cast<std::size_t>(y) * width_ + x] =
          0xff000000u | byte(sum.r) << 16 | byte(sum.g) << 8 | byte(sum.b);
    }
  }
}

}  // namespace tanor::picture
