#include "report/motion_extent.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "base/vec3.hpp"

namespace tanor::report {

namespace {

constexpr double typical = 0.97;          // part of the forces for which arrows are scaled
constexpr double typical_tension = 0.99;  // of those that pull, and of those that push, for colours
constexpr double rounding = 1e-6;         // of a force or tension, relative to the typical largest one
constexpr double typical_arrow = 0.13;    // length of a typical largest force, relative to the motion
constexpr double longest_arrow = 1.5;     // relative to that one

/// Returns the least number above which no more than the other part of them is, and puts it there.
double quantile(std::span<double> numbers, double part) {
  if (numbers.empty()) return 0.0;
  const auto place =
      numbers.begin() + static_cast<std::ptrdiff_t>(std::ceil(part * static_cast<double>(numbers.size()))) - 1;
  std::nth_element(numbers.begin(), place, numbers.end());
  return *place;
}

Vector3 row(const std::vector<double>& numbers, std::size_t k) {
  return {numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]};
}

double distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

void take(const Vector3& place, double radius, MotionExtent* extent) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    extent->least[axis] = std::min(extent->least[axis], place[axis] - radius);
    extent->most[axis] = std::max(extent->most[axis], place[axis] + radius);
  }
}

/// Finds the farthest positions in directions that cover the sphere evenly (Fibonacci lattice).
class Outline {
 public:
  Outline() {
    constexpr int count = 64;
    const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
    for (int k = 0; k < count; ++k) {
      const double z = 1.0 - (2.0 * k + 1.0) / count, ring = std::sqrt(1.0 - z * z);
      directions_.push_back({ring * std::cos(golden * k), ring * std::sin(golden * k), z});
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const double sign : {-1.0, 1.0}) directions_.emplace_back()[axis] = sign;
    heights_.assign(directions_.size(), -std::numeric_limits<double>::infinity());
    places_.resize(directions_.size());
  }

  void take(const Vector3& place, double radius = 0.0) {
    for (std::size_t k = 0; k < directions_.size(); ++k) {
      const Vector3& d = directions_[k];
      const double height = place[0] * d[0] + place[1] * d[1] + place[2] * d[2] + radius;
      if (!(height > heights_[k])) continue;
      heights_[k] = height;
      places_[k] = {place[0] + radius * d[0], place[1] + radius * d[1], place[2] + radius * d[2]};
    }
  }
  const std::vector<Vector3>& places() const { return places_; }

 private:
  std::vector<Vector3> directions_, places_;
  std::vector<double> heights_;
};

/// Adds the sheaves of ropes, and round guides and cells as a whole, unless the motion covers only a small part of
/// them.
void take_guides(const StoredFrame& frame, double size, MotionExtent* extent, Outline* outline) {
  const auto take_place = [&](const Vector3& place, double radius = 0.0) {
    take(place, radius, extent);
    outline->take(place, radius);
  };
  for (const Guide& guide : frame.guides) {
    const auto& [kind, name, n, gone] = guide;
    if (kind == "tie" || kind == "rope")
      for (const Vector3& place : find_course(guide, frame.positions, frame.gravity)) take_place(place);
    const std::vector<Vector3> ends = kind == "cell" ? find_edges(guide) : std::vector<Vector3>();
    if (!ends.empty() && distance(ends.front(), ends.back()) <= 4.0 * size)
      for (const Vector3& end : ends) take_place(end);
    const double radius = kind == "sphere"      ? n[3]
                          : kind == "circle"    ? n[6]
                          : kind == "ellipsoid" ? std::max({n[3], n[4], n[5]})
                                                : 0.0;
    if (radius > 0.0 && radius <= 2.0 * size) take_place({n[0], n[1], n[2]}, radius);
  }
}

/// Collects where supports are, which have the same rows in all frames.
void collect_supports(const std::vector<StoredFrame>& frames, double size, MotionExtent* extent, Outline* outline) {
  constexpr std::size_t most = 500;
  constexpr double rest = 1e-6;
  for (std::size_t k = 0; k < frames[0].num_points() && extent->supports.size() < most; ++k) {
    if (!frames[0].is_support[k]) continue;
    SupportPath path{.point = k};
    for (const StoredFrame& frame : frames) {
      if (k >= frame.num_points() || !frame.is_support[k]) continue;
      const Vector3 place = row(frame.positions, k);
      if (path.places.empty() || distance(place, path.places.back()) > rest * size) path.places.push_back(place);
    }
    path.pivot = find_pivot(path.places, 2.0 * size);
    if (path.pivot) {
      take(*path.pivot, 0.0, extent);
      outline->take(*path.pivot);
    }
    extent->supports.push_back(std::move(path));
  }
}

/// Rounds a number up to two digits. A larger one by rounding is no larger one.
double round_up(double number) {
  if (!(number > 0.0)) return 0.0;
  const double unit = std::pow(10.0, std::floor(std::log10(number)) - 1.0);
  return std::ceil(number / unit * (1.0 - rounding)) * unit;
}

void measure_rods(const std::vector<StoredFrame>& frames, MotionExtent* extent) {
  std::vector<double> tensions, lengths;
  for (const StoredFrame& frame : frames) {
    tensions.insert(tensions.end(), frame.tensions.begin(), frame.tensions.end());
    for (const auto& [i, j] : frame.rods) lengths.push_back(distance(row(frame.positions, i), row(frame.positions, j)));
  }
  extent->tensions = choose_tension_scale(std::move(tensions));
  extent->rod_length = quantile(lengths, 0.5);
}

/// Calls take(position, force, is_friction) for every known force of guides, supports and friction.
template <class Take>
void visit_forces(const std::vector<StoredFrame>& frames, const Take& take) {
  for (const StoredFrame& frame : frames) {
    for (const std::vector<double>* forces : {&frame.guide_forces, &frame.friction_forces})
      for (std::size_t k = 0; 3 * k < forces->size(); ++k)
        if (const Vector3 force = row(*forces, k); std::isfinite(distance(force, {})))
          take(row(frame.positions, k), force, forces == &frame.friction_forces);
  }
}

/// Measures the forces, without the rounding errors of points at which no force acts.
void measure_forces(const std::vector<StoredFrame>& frames, double size, MotionExtent* extent) {
  double largest = extent->tensions.end();
  visit_forces(frames,
               [&](const Vector3&, const Vector3& force, bool) { largest = std::max(largest, distance(force, {})); });
  std::vector<double> normal, friction;
  visit_forces(frames, [&](const Vector3&, const Vector3& force, bool is_friction) {
    const double newtons = distance(force, {});
    if (newtons > rounding * largest) (is_friction ? friction : normal).push_back(newtons);
  });
  extent->has_friction = !friction.empty();
  extent->largest_force = std::max(quantile(normal, typical), quantile(friction, typical));
  if (!(extent->largest_force > 0.0)) return;
  extent->arrow = typical_arrow * size / extent->largest_force;
  extent->longest_arrow = longest_arrow * typical_arrow * size;
  Outline tips;
  visit_forces(frames, [&](const Vector3& place, const Vector3& force, bool) {
    const double newtons = distance(force, {});
    if (!(newtons > rounding * largest)) return;
    const double part = std::min(extent->arrow, extent->longest_arrow / newtons);
    tips.take({place[0] + part * force[0], place[1] + part * force[1], place[2] + part * force[2]});
  });
  extent->tips = tips.places();
}

}  // namespace

std::optional<Vector3> find_pivot(std::span<const Vector3> places, double most) {
  using namespace detail;
  constexpr std::size_t few = 5;  // places that lie on a circle by themselves, and one more
  constexpr double least_sagitta = 0.02, roundness = 1e-3;
  if (places.size() < few) return std::nullopt;
  const Vec3 a = make_vec3(places[0]);
  const auto from = [&](const Vector3& place) { return make_vec3(place) - a; };
  const Vec3 u = from(std::ranges::max(places, {}, [&](const Vector3& place) { return squared(from(place)); }));
  const Vec3 v =
      from(std::ranges::max(places, {}, [&](const Vector3& place) { return squared(cross(u, from(place))); }));
  const Vec3 n = cross(u, v);
  if (!(norm(n) > least_sagitta * squared(u))) return std::nullopt;
  // The circle through 0, u and v has its middle at (u^2 v x n + v^2 n x u)/(2 n^2).
  const Vec3 middle = 0.5 / squared(n) * (squared(u) * cross(v, n) + squared(v) * cross(n, u));
  const double radius = norm(middle), allowed = roundness * radius;
  const bool is_circle = radius <= most && std::ranges::all_of(places, [&](const Vector3& place) {
                           const Vec3 at = from(place) - middle;
                           return std::abs(norm(at) - radius) <= allowed && std::abs(dot(at, n)) <= allowed * norm(n);
                         });
  const Vec3 pivot = a + middle;
  return is_circle ? std::optional(Vector3{pivot.x, pivot.y, pivot.z}) : std::nullopt;
}

TensionScale choose_tension_scale(std::vector<double> tensions) {
  std::erase_if(tensions, [](double tension) { return !std::isfinite(tension); });
  const auto middle = std::partition(tensions.begin(), tensions.end(), [](double tension) { return tension < 0.0; });
  for (double& tension : tensions) tension = std::abs(tension);
  const double least = quantile({tensions.begin(), middle}, typical_tension),
               most = quantile({middle, tensions.end()}, typical_tension);
  const double end = round_up(std::max(least, most));
  // Tensions within rounding are no pushes or pulls.
  return {.least = least > rounding * most ? -end : 0.0, .most = most > rounding * least ? end : 0.0};
}

MotionExtent measure_motion(const std::vector<StoredFrame>& frames) {
  constexpr double all = std::numeric_limits<double>::infinity();
  MotionExtent extent{.least = {all, all, all}, .most = {-all, -all, -all}};
  Outline outline;
  for (const StoredFrame& frame : frames) {
    for (std::size_t k = 0; k < frame.num_points(); ++k) {
      take(row(frame.positions, k), 0.0, &extent);
      outline.take(row(frame.positions, k));
    }
  }
  const double size = distance(extent.least, extent.most);
  for (const StoredFrame& frame : frames) take_guides(frame, size, &extent, &outline);
  collect_supports(frames, size, &extent, &outline);
  extent.outline = outline.places();
  measure_rods(frames, &extent);
  const double diagonal = distance(extent.least, extent.most);
  measure_forces(frames, diagonal > 0.0 ? diagonal : 1.0, &extent);
  return extent;
}

}  // namespace tanor::report
