/// \file What a step may pass unseen: two points that meet and part between the looks of its scheme, or come much
/// nearer there than at any of them. Forces that the looks have seen at half their size or more are the business of
/// the scheme's own error estimate.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "evaluate/pair_field.hpp"

namespace tanor {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double seen_enough = 2.0;  // a force over the largest one at the looks

double squared(Vec3 a) {
  return dot(a, a);
}

/// Where on the chord from d to d + e the origin is nearest, as a fraction.
double nearest_fraction(Vec3 d, Vec3 e) {
  const double length2 = squared(e);
  return length2 > 0.0 ? std::clamp(-dot(d, e) / length2, 0.0, 1.0) : 0.0;
}

}  // namespace

/// Where two points are nearest, or the origin in the motion of one relative to the other.
struct PairField::Encounter {
  double r = infinity, s = 0.0;  // m, and the fraction of the step
  double speed = 0.0;            // m/s there
};

double PairField::find_passage(const Parallel& parallel, const PointPath& path, std::span<const double> masses) {
  const Reach reach = measure_reach(parallel, path);
  if (!(reach.move > 0.0)) return 1.0;
  // Fixed steps are looked at only where they are long, and so few.
  constexpr double short_move = 0.05;
  if (!path.follows_tolerance && reach.move < short_move * std::min(cutoff_, std::sqrt(sigma2_))) return 1.0;
  const Vec3 edges = box_.edges();
  for (const double edge : {edges.x, edges.y, edges.z}) {
    if (edge > 0.0 && reach.move > edge) return 0.5 * edge / reach.move;
  }
  const NeighbourLists* const near = find_near(parallel, path.positions[0], reach.move);
  if (near == nullptr) return 0.5;

  std::atomic<double> part = 1.0;
  near->for_each_point(parallel, [&](std::size_t i, std::span<const Index> neighbours) {
    const auto others = std::upper_bound(neighbours.begin(), neighbours.end(), static_cast<Index>(i));
    for (auto j = others; j != neighbours.end(); ++j) {
      const double found = find_passage_of_pair(path, reach, i, static_cast<std::size_t>(*j), masses);
      for (double known = part; found < known && !part.compare_exchange_weak(known, found);) {
      }
    }
  });
  return part;
}

PairField::Reach PairField::measure_reach(const Parallel& parallel, const PointPath& path) const {
  const double length = path.h / static_cast<double>(path.num_pieces());
  const auto measure = [&](auto&& value_of) {
    return parallel.max_over_ranges(points_.size(), [&](std::size_t begin, std::size_t end) {
      double most = 0.0;
      for (std::size_t k = begin; k < end; ++k) {
        for (std::size_t piece = 0; piece < path.num_pieces(); ++piece)
          most = larger(most, value_of(points_[k], piece));
      }
      return most;
    });
  };
  // 4/27 (|a| + |b|) <= 8/27 max(|a|, |b|), whose root is taken once
  const double bend2 = measure([&](Index i, std::size_t piece) {
    const Vec3 e = load(path.positions[piece + 1], i) - load(path.positions[piece], i);
    return std::max(squared(length * load(path.velocities[piece], i) - e),
                    squared(length * load(path.velocities[piece + 1], i) - e));
  });
  const double move2 = measure([&](Index i, std::size_t piece) {
    return squared(load(path.positions[piece + 1], i) - load(path.positions[0], i));
  });
  const double bend = 8.0 / 27.0 * std::sqrt(bend2);
  return {std::sqrt(move2) + bend, bend};
}

/// More than some hundred partners a point in long lists; then points would be spread evenly.
bool PairField::are_too_many(double radius) const {
  constexpr std::size_t few_points = 1000;
  constexpr double most_spacings = 3.0;
  if (begins_.size() <= few_points) return false;
  Vec3 low = begins_[0], high = begins_[0];
  for (const Vec3& r : begins_) {
    low = {std::min(low.x, r.x), std::min(low.y, r.y), std::min(low.z, r.z)};
    high = {std::max(high.x, r.x), std::max(high.y, r.y), std::max(high.z, r.z)};
  }
  double volume = 1.0, dimensions = 0.0;
  for (const double extent : {high.x - low.x, high.y - low.y, high.z - low.z}) {
    if (!(extent > 0.0)) continue;
    volume *= extent;
    dimensions += 1.0;
  }
  const double spacing = std::pow(volume / static_cast<double>(begins_.size()), 1.0 / std::max(dimensions, 1.0));
  return radius > most_spacings * spacing;
}

/// Lists of all pairs that may count while no point goes farther than `move` from r: without a cutoff those that may
/// halve their distance. Null: there would be too many.
const NeighbourLists* PairField::find_near(const Parallel& parallel, const double* r, double move) {
  begins_.resize(points_.size());
  parallel.for_ranges(points_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) begins_[i] = load(r, points_[i]);
  });
  if (neighbours_) {
    if (neighbours_->cover(parallel, begins_, move)) return &*neighbours_;
    if (4.0 * move < neighbours_->skin()) {
      neighbours_->make(parallel, begins_, neighbours_->skin());
      return &*neighbours_;
    }
  }
  // d > 2 x (2 move) to begin with: more than half of it is left.
  const double reach = neighbours_ ? move : 2.0 * move, skin = 6.0 * reach;  // for some two steps
  if (far_->cover(parallel, begins_, reach)) return &*far_;
  if (are_too_many(skin)) return nullptr;
  far_->make(parallel, begins_, skin);
  return &*far_;
}

double PairField::force_at(double r) const {
  if (r >= cutoff_) return 0.0;
  if (!neighbours_) return std::abs(strength_) / r;
  const double s2 = sigma2_ / (r * r), s6 = s2 * s2 * s2;
  return 24.0 * epsilon_ * s6 * std::abs(2.0 * s6 - 1.0) / r;
}

/// At distances from the nearest to the farthest.
double PairField::largest_force(double nearest, double farthest) const {
  if (nearest >= cutoff_) return 0.0;
  double force = std::max(force_at(nearest), force_at(std::min(farthest, std::nextafter(cutoff_, 0.0))));
  const double most_attraction = std::pow(26.0 / 7.0, 1.0 / 6.0) * std::sqrt(sigma2_);
  if (neighbours_ && nearest < most_attraction && most_attraction < farthest)
    force = std::max(force, force_at(most_attraction));
  return force;
}

/// Each image of j that comes near, where the box is not large beside the step.
double PairField::find_passage_of_pair(const PointPath& path, const Reach& reach, std::size_t i, std::size_t j,
                                       std::span<const double> masses) const {
  const Vec3 d = begins_[j] - begins_[i], nearest = box_.nearest_image(d);
  const double far = cutoff_ + 2.0 * reach.move;
  std::array<int, 3> images{};
  const std::array<double, 3> edges{box_.edges().x, box_.edges().y, box_.edges().z};
  for (std::size_t k = 0; k < 3; ++k)
    images[k] = edges[k] > 0.0 ? static_cast<int>(std::floor(far / edges[k] + 0.5)) : 0;
  double part = 1.0;
  for (int a = -images[0]; a <= images[0]; ++a) {
    for (int b = -images[1]; b <= images[1]; ++b) {
      for (int c = -images[2]; c <= images[2]; ++c) {
        const Approach approach{i, j, nearest + Vec3{a * edges[0], b * edges[1], c * edges[2]} - d};
        if (may_pass(path, approach, 2.0 * reach.sagitta)) part = std::min(part, examine(path, approach, masses));
      }
    }
  }
  return part;
}

/// By chords, and how far paths may leave them at most; first of all points, then of these two.
bool PairField::may_pass(const PointPath& path, const Approach& approach, double sagitta_of_all) const {
  const Index i = points_[approach.i], j = points_[approach.j];
  const auto place = [&](std::size_t k) {
    return load(path.positions[k], j) - load(path.positions[k], i) + approach.shift;
  };
  const std::size_t pieces = path.num_pieces();
  const Vec3 begin = place(0);
  Vec3 from = begin, to = begin;
  double near2 = infinity;
  for (std::size_t k = 0; k < pieces; ++k, from = to) {
    to = place(k + 1);
    const Vec3 e = to - from;
    near2 = std::min(near2, squared(from + nearest_fraction(from, e) * e));
  }
  const double seen2 = std::min(squared(begin), squared(to)), cutoff2 = cutoff_ * cutoff_;
  // With z = r_cutoff^2 - r^2 forces grow no faster than z where z is small, and like a power of r elsewhere: less than
  // twofold.
  const auto may = [&](double sagitta) {
    if (!neighbours_) return std::sqrt(near2) - sagitta < std::sqrt(seen2) / seen_enough;
    if (near2 >= (cutoff_ + sagitta) * (cutoff_ + sagitta)) return false;
    const double seen = std::max(cutoff2 - seen2, 0.0);
    const double growth = seen < 0.05 * cutoff2 ? 0.5 : 0.2;
    return !(seen2 - near2 + 2.0 * sagitta * cutoff_ <= growth * seen);
  };
  if (!may(sagitta_of_all)) return false;
  if (pieces > 1) return true;
  const Vec3 e = to - begin;
  const Vec3 first = path.h * (load(path.velocities[0], j) - load(path.velocities[0], i)) - e;
  const Vec3 last = path.h * (load(path.velocities[1], j) - load(path.velocities[1], i)) - e;
  return may(4.0 / 27.0 * (norm(first) + norm(last)));
}

PointPath::Place PairField::relative(const PointPath& path, const Approach& approach, double s) const {
  const PointPath::Place i = path.at(points_[approach.i], s), j = path.at(points_[approach.j], s);
  return {j.r - i.r + approach.shift, j.v - i.v};
}

/// Halves [a, b] while the path may be near and bends; then Newton's method on d.d' = 0.
void PairField::narrow(const PointPath& path, const Approach& approach, double a, double b, int depth,
                       Encounter* nearest) const {
  constexpr double straight = 0.02;  // |sagitta| over the chord
  const PointPath::Place from = relative(path, approach, a), to = relative(path, approach, b);
  const Vec3 e = to.r - from.r;
  const double bend = sagitta(from, to, (b - a) * path.h), u = nearest_fraction(from.r, e);
  if (norm(from.r + u * e) - bend >= std::min(nearest->r, cutoff_)) return;
  if (depth > 0 && bend > straight * norm(e)) {
    const double middle = 0.5 * (a + b);
    narrow(path, approach, a, middle, depth - 1, nearest);
    narrow(path, approach, middle, b, depth - 1, nearest);
    return;
  }
  double s = a + u * (b - a);
  for (int iteration = 0; iteration < 5; ++iteration) {
    const auto [d, v] = relative(path, approach, s);
    if (const double r = norm(d); r < nearest->r) *nearest = {r, s, norm(v)};
    if (!(squared(v) > 0.0)) return;
    s = std::clamp(s - dot(d, v) / (squared(v) * path.h), a, b);
  }
}

PairField::Encounter PairField::find_nearest(const PointPath& path, const Approach& approach, double a,
                                             double b) const {
  constexpr int most_halvings = 12;
  Encounter nearest;
  for (const double s : {a, b}) {
    const auto [d, v] = relative(path, approach, s);
    if (const double r = norm(d); r < nearest.r) nearest = {r, s, norm(v)};
  }
  // In one piece of the path after the other.
  const auto pieces = static_cast<double>(path.num_pieces());
  for (double s = a; s < b;) {
    const double end = std::min(b, (std::floor(s * pieces * (1.0 + 1e-12)) + 1.0) / pieces);
    narrow(path, approach, s, end, most_halvings, &nearest);
    s = end;
  }
  return nearest;
}

/// A push that nobody saw would move the point by more than the tolerance.
bool PairField::misses(const PointPath& path, std::size_t i, double impulse, std::span<const double> masses) const {
  if (i >= num_moving_) return false;
  const Index point = points_[i];
  const double r = std::max(norm(load(path.positions.front(), point)), norm(load(path.positions.back(), point)));
  const double v = std::max(norm(load(path.velocities.front(), point)), norm(load(path.velocities.back(), point)));
  const double change = impulse / masses[static_cast<std::size_t>(point)];
  return change > path.atol + path.rtol * v || change * path.h > path.atol + path.rtol * r;
}

double PairField::examine(const PointPath& path, const Approach& approach, std::span<const double> masses) const {
  double seen = 0.0;
  for (const double s : path.looks) seen = std::max(seen, force_at(norm(relative(path, approach, s).r)));
  if (largest_force(find_nearest(path, approach, 0.0, 1.0).r, infinity) <= seen_enough * seen) return 1.0;
  for (std::size_t look = 0; look + 1 < path.looks.size(); ++look) {
    const double a = path.looks[look], b = path.looks[look + 1];
    const Encounter nearest = find_nearest(path, approach, a, b);
    const double farthest =
        std::max(norm(relative(path, approach, a).r), norm(relative(path, approach, b).r));
    const double force = largest_force(nearest.r, farthest);
    if (!(force > seen_enough * seen)) continue;
    // It lasts while they pass each other within the range; without a cutoff, where the force is a third of this.
    const auto passing = [&](double range) {
      return 2.0 * std::sqrt(std::max(range * range - nearest.r * nearest.r, 0.0)) / (nearest.speed * path.h);
    };
    const double lasts = std::min(b - a, passing(std::min(cutoff_, 3.0 * nearest.r)));
    const double impulse = force * lasts * path.h;
    if (!misses(path, approach.i, impulse, masses) && !misses(path, approach.j, impulse, masses)) continue;
    // The next step ends where the force begins, or, where it has begun, on the way to its largest value.
    const double begins = std::max(nearest.s - 0.5 * passing(std::min(cutoff_, 2.0 * nearest.r)), 0.0);
    const double rises = nearest.s - begins;
    return begins > 4.0 * rises ? begins - 0.01 * rises : begins + 0.25 * rises;
  }
  return 1.0;
}

}  // namespace tanor
