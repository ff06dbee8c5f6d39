/// \file Finds what a step may pass unseen: two points that meet and part between the looks of its scheme, or come much
/// nearer there than at any of them. Forces that the looks have seen at half their size or more are left to the
/// scheme's own error estimate.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>

#include "base/gauss_rule.hpp"
#include "base/instruction_sets.hpp"
#include "evaluate/locate_jump.hpp"
#include "evaluate/pair_field.hpp"

namespace tanor::detail {

namespace {

constexpr double seen_enough = 2.0;  // a force over the largest one at the looks

/// Returns the fraction of the chord from d to d + e at which the origin is nearest.
double nearest_fraction(Vec3 d, Vec3 e) {
  const double length2 = squared(e);
  return length2 > 0.0 ? std::clamp(-dot(d, e) / length2, 0.0, 1.0) : 0.0;
}

/// The bounds that sort pairs out, see PairField::Nearness.
struct Bounds {
  double cutoff2 = 0.0;  ///< m^2
  double outer2 = 0.0;   ///< m^2: pairs whose path may come within the cutoff have a chord as near as this
  double slack = 0.0;    ///< m^2: by so much more than on its chord z may grow on a path

  /// Returns by how much z = r_cutoff^2 - r^2 may grow so that forces grow less than twofold. They grow no faster than
  /// z where z is small, and like a power of r elsewhere.
  [[gnu::always_inline]] double allowed_growth(double seen2) const {
    const double seen = cutoff2 > seen2 ? cutoff2 - seen2 : 0.0, small = 0.025 * cutoff2;
    const double most = 0.5 * seen < small ? 0.5 * seen : small;
    return most > 0.2 * seen ? most : 0.2 * seen;
  }
};

/// Returns true if one of these pairs may pass unseen, by its chord d + u e, 0 <= u <= 1. Writes the least
/// |d^2 - r_cutoff^2| to `apart`, m^2. The loops run in lanes, without branches.
bool may_any_pass(const Bounds& bounds, const PeriodicBox& box, const std::vector<Vec3>& begins,
                  const std::vector<Vec3>& moves, std::size_t i, std::span<const Index> others, double* apart) {
  return dispatch([=, &bounds, &box, begins = begins.data(), moves = moves.data()] {
    constexpr double tiny = 1e-300;
    const Vec3 begin_i = begins[i], move_i = moves[i];
    double passes = 0.0, least = std::numeric_limits<double>::infinity();
#pragma omp simd reduction(max : passes) reduction(min : least)
    for (std::size_t k = 0; k < others.size(); ++k) {
      const auto j = static_cast<std::size_t>(others[k]);
      const Vec3 d = box.nearest_image(begins[j] - begin_i), e = moves[j] - move_i;
      const double begin2 = dot(d, d), along = dot(d, e), length2 = dot(e, e);
      const double from_cutoff = begin2 < bounds.cutoff2 ? bounds.cutoff2 - begin2 : begin2 - bounds.cutoff2;
      least = from_cutoff < least ? from_cutoff : least;
      const double end2 = begin2 + 2.0 * along + length2, seen2 = begin2 < end2 ? begin2 : end2;
      const double ahead = along < 0.0 ? -along : 0.0;
      const double part = ahead < length2 ? ahead : length2;  // part of the chord, times its squared length
      const double near2 = begin2 + part / (length2 + tiny) * (2.0 * along + part);
      const double excess = seen2 - near2 + bounds.slack - bounds.allowed_growth(seen2);  // in range: what passes
      const double found = near2 < bounds.outer2 ? excess : 0.0;
      const double outer_end2 = begin2 < end2 ? end2 : begin2, edge2 = far_apart2 * near2;
      const double changes = outer_end2 > (edge2 < bounds.cutoff2 ? edge2 : bounds.cutoff2) ? 1.0 : 0.0;
      const double counts = near2 < bounds.cutoff2 ? changes : 0.0;
      const double larger = found > counts ? found : counts;
      passes = passes > larger ? passes : larger;
    }
    *apart = least;
    return passes > 0.0;
  });
}

/// The largest squares of what points do in a cubic piece: their move since the step began, |H v - e| with the chord e,
/// and the move since the last step began.
struct Squares {
  double move = 0.0, bend = 0.0, travel = 0.0;  // m^2

  Squares joined(const Squares& other) const {
    return {std::max(move, other.move), std::max(bend, other.bend), std::max(travel, other.travel)};
  }
};
/// Measures how far points go in one cubic piece of this length. Sets `begins` to where they begin in the first piece,
/// and `moves` to where they are at its end beyond that.
Squares measure_chords(std::size_t first, std::size_t last, const Index* points, double length, bool is_first_piece,
                       const std::array<const double*, 4>& ends, Vec3* begins, Vec3* moves) {
  return dispatch([=, &ends]() -> Squares {
    const double *const r0 = ends[0], *const v0 = ends[1], *const r1 = ends[2], *const v1 = ends[3];
    double move2 = 0.0, bend2 = 0.0, travel2 = 0.0;
#pragma omp simd reduction(max : move2, bend2, travel2)
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = 3 * static_cast<std::size_t>(points[k]);
      const double x = r0[i], y = r0[i + 1], z = r0[i + 2];
      const double ex = r1[i] - x, ey = r1[i + 1] - y, ez = r1[i + 2] - z;
      const double ax = length * v0[i] - ex, ay = length * v0[i + 1] - ey, az = length * v0[i + 2] - ez;
      const double bx = length * v1[i] - ex, by = length * v1[i + 1] - ey, bz = length * v1[i + 2] - ez;
      const Vec3 old = begins[k], begin = is_first_piece ? Vec3{x, y, z} : old;
      const double tx = begin.x - old.x, ty = begin.y - old.y, tz = begin.z - old.z;
      const double mx = r1[i] - begin.x, my = r1[i + 1] - begin.y, mz = r1[i + 2] - begin.z;
      const double a2 = ax * ax + ay * ay + az * az, b2 = bx * bx + by * by + bz * bz;
      const double m2 = mx * mx + my * my + mz * mz, t2 = tx * tx + ty * ty + tz * tz;
      const double larger2 = a2 > b2 ? a2 : b2;
      move2 = m2 > move2 ? m2 : move2;
      bend2 = larger2 > bend2 ? larger2 : bend2;
      travel2 = t2 > travel2 ? t2 : travel2;
      begins[k] = begin;
      moves[k] = {mx, my, mz};
    }
    return {move2, bend2, travel2};
  });
}

}  // namespace

/// Sorts out, at the cost of one force evaluation, what nearly all pairs are: too far to meet, or as near at an end of
/// their chord as anywhere on it.
class PairField::Nearness {
 public:
  Nearness(PairField& field, const PointPath& path, const Reach& reach)
      : field_(field),
        path_(path),
        all_(bounds(2.0 * reach.sagitta)),
        far_(field.potential_.cutoff() + 2.0 * reach.move),
        travels_(reach.move + 20.0 * reach.sagitta) {
    // Each pair is examined by itself if the path has several pieces, if there is no cutoff, or if several images may
    // come near.
    by_chords_ = path.num_pieces() == 1 && field.neighbours_;
    for (const double edge : {field.box_.edges().x, field.box_.edges().y, field.box_.edges().z})
      by_chords_ = by_chords_ && !(edge > 0.0 && edge < 2.0 * far_);
  }

  /// Returns true if no pair of point i comes to its cutoff.
  bool is_quiet(std::size_t i) const {
    return by_chords_ && field_.quiet_.travelled + travels_ < field_.quiet_.until[i];
  }
  /// Returns true if point i may pass one of the others unseen.
  bool may_any_pass(std::size_t i, std::span<const Index> others) const {
    if (!by_chords_) return true;
    double apart = 0.0;
    if (detail::may_any_pass(all_, field_.box_, field_.begins_, field_.moves_, i, others, &apart)) return true;
    // Both points of a pair may go two fifths of the way to the cutoff.
    constexpr double most_way = 0.05;
    const double way = std::sqrt(all_.cutoff2 + apart) - field_.potential_.cutoff();
    field_.quiet_.until[i] = field_.quiet_.travelled + 0.4 * std::min(way, most_way * field_.potential_.cutoff());
    return false;
  }
  bool may_pass(const Approach& approach) const;

  /// Returns the distance beyond which points do not meet, m.
  double far() const { return far_; }

 private:
  Bounds bounds(double sagitta) const {
    const double cutoff = field_.potential_.cutoff();
    return {cutoff * cutoff, (cutoff + sagitta) * (cutoff + sagitta), 2.0 * sagitta * cutoff};
  }

  PairField& field_;
  const PointPath& path_;
  Bounds all_;
  double far_;      // m
  double travels_;  // m: an upper bound of the travel, by which chords, too, stay on one side of the cutoff
  bool by_chords_ = false;
};

double PairField::find_unseen(const Parallel& parallel, const PointPath& path, std::span<const double> masses) {
  const Reach reach = measure_reach(parallel, path);
  if (!(reach.move > 0.0)) return 1.0;
  // Fixed steps are examined only if they are long, so that few are.
  constexpr double short_move = 0.05;
  if (!path.follows_tolerance && reach.move < short_move * std::min(potential_.cutoff(), potential_.sigma()))
    return 1.0;
  const Vec3 edges = box_.edges();
  for (const double edge : {edges.x, edges.y, edges.z}) {
    if (edge > 0.0 && reach.move > edge) return 0.5 * edge / reach.move;
  }
  const NeighbourLists* const near = find_near(parallel, reach.move);
  if (near == nullptr) return 0.5;
  if ((near == &*far_) != quiet_.is_of_far || near->version() != quiet_.version) {
    quiet_.is_of_far = near == &*far_;
    quiet_.version = near->version();
    quiet_.until.assign(points_.size(), 0.0);
  }

  std::atomic<double> part = 1.0;
  const Nearness nearness(*this, path, reach);
  near->for_each_point(parallel, [&](std::size_t i, std::span<const Index> neighbours) {
    if (nearness.is_quiet(i)) return;
    const auto others = std::upper_bound(neighbours.begin(), neighbours.end(), static_cast<Index>(i));
    if (!nearness.may_any_pass(i, {others, neighbours.end()})) return;
    const auto visit = [&](const Approach& approach) {
      if (!nearness.may_pass(approach)) return;
      const double found = examine(path, approach, masses);
      for (double known = part; found < known && !part.compare_exchange_weak(known, found);) {
      }
    };
    for (auto j = others; j != neighbours.end(); ++j)
      for_each_image(i, static_cast<std::size_t>(*j), nearness.far(), std::cref(visit));
  });
  return part;
}

/// Measures how far points go, and keeps where they begin and how far each goes, side by side.
PairField::Reach PairField::measure_reach(const Parallel& parallel, const PointPath& path) {
  const double length = path.h / static_cast<double>(path.num_pieces());
  begins_.resize(points_.size());
  moves_.resize(points_.size());
  const auto join = [](const Squares& a, const Squares& b) { return a.joined(b); };
  const Squares squares = parallel.join_over_ranges(
      points_.size(), Squares{},
      [&](std::size_t begin, std::size_t end) {
        Squares most;
        for (std::size_t k = 0; k < path.num_pieces(); ++k)
          most = most.joined(
              measure_chords(begin, end, points_.data(), length, k == 0,
                             {path.positions[k], path.velocities[k], path.positions[k + 1], path.velocities[k + 1]},
                             begins_.data(), moves_.data()));
        return most;
      },
      join);
  quiet_.travelled += std::sqrt(squares.travel);
  // The bound 4/27 (|a| + |b|) <= 8/27 max(|a|, |b|) takes one root for all points.
  const double sagitta = 8.0 / 27.0 * std::sqrt(squares.bend);
  return {std::sqrt(squares.move) + sagitta, sagitta};
}

/// Returns true if lists of this radius would be long.
bool PairField::are_too_many(double radius) const {
  PointRoom room;
  for (const Vec3& r : begins_) room.add(r);
  return room.is_crowded(begins_.size(), radius);
}

/// Returns lists of all pairs that may count while no point goes farther than `move`. Without a cutoff these are pairs
/// that may halve their distance. Returns null if there would be too many.
const NeighbourLists* PairField::find_near(const Parallel& parallel, double move) {
  if (neighbours_) {
    if (neighbours_->cover(parallel, begins_, move)) return &*neighbours_;
    if (4.0 * move < neighbours_->skin()) {
      neighbours_->make(parallel, begins_, neighbours_->skin());
      return &*neighbours_;
    }
  }
  // A pair that begins with d > 2 x (2 move) keeps more than half of its distance.
  const double reach = neighbours_ ? move : 2.0 * move, skin = 6.0 * reach;  // for some two steps
  if (far_->cover(parallel, begins_, reach)) return &*far_;
  if (are_too_many(skin)) return nullptr;
  far_->make(parallel, begins_, skin);
  return &*far_;
}

/// Visits each image of j that may come nearer to i than `far`. There are several if the box is not large beside the
/// step.
void PairField::for_each_image(std::size_t i, std::size_t j, double far, const VisitApproach& visit) const {
  const Vec3 d = begins_[j] - begins_[i], nearest = box_.nearest_image(d);
  std::array<int, 3> images{};
  const std::array<double, 3> edges{box_.edges().x, box_.edges().y, box_.edges().z};
  for (std::size_t k = 0; k < 3; ++k)
    images[k] = edges[k] > 0.0 ? static_cast<int>(std::floor(far / edges[k] + 0.5)) : 0;
  for (int a = -images[0]; a <= images[0]; ++a) {
    for (int b = -images[1]; b <= images[1]; ++b) {
      for (int c = -images[2]; c <= images[2]; ++c)
        visit(Approach{i, j, nearest + Vec3{a * edges[0], b * edges[1], c * edges[2]} - d});
    }
  }
}

/// Returns true if two points may pass unseen, by the chords of all pieces and the largest distance of their path from
/// these.
bool PairField::Nearness::may_pass(const Approach& approach) const {
  const auto place = [&](std::size_t k) {
    const auto knot = static_cast<double>(k) / static_cast<double>(path_.num_pieces());
    return field_.relative(path_, approach, knot);
  };
  const double length = path_.h / static_cast<double>(path_.num_pieces());
  PointPath::Place from = place(0);
  const double begin2 = squared(from.r);
  double near2 = begin2, bend = 0.0;
  for (std::size_t k = 0; k < path_.num_pieces(); ++k) {
    const PointPath::Place to = place(k + 1);
    const Vec3 e = to.r - from.r;
    near2 = std::min(near2, squared(from.r + nearest_fraction(from.r, e) * e));
    bend = std::max(bend, detail::sagitta(from, to, length));
    from = to;
  }
  const double seen2 = std::min(begin2, squared(from.r));
  if (!field_.neighbours_) return std::sqrt(near2) - bend < std::sqrt(seen2) / seen_enough;
  const Bounds own = bounds(bend);
  if (near2 < own.cutoff2 && std::max(begin2, squared(from.r)) > std::min(own.cutoff2, far_apart2 * near2)) return true;
  return near2 < own.outer2 && seen2 - near2 + own.slack > own.allowed_growth(seen2);
}

PointPath::Place PairField::relative(const PointPath& path, const Approach& approach, double s) const {
  const PointPath::Place i = path.at(points_[approach.i], s), j = path.at(points_[approach.j], s);
  return {j.r - i.r + approach.shift, j.v - i.v};
}

/// Finds the nearest place in [a, b]. The interval is halved while the path may be near and bends; then Newton's method
/// solves d.d' = 0.
void PairField::narrow(const PointPath& path, const Approach& approach, double a, double b, int depth,
                       Encounter* nearest) const {
  constexpr double straight = 0.02;  // |sagitta| over the chord
  const PointPath::Place from = relative(path, approach, a), to = relative(path, approach, b);
  const Vec3 e = to.r - from.r;
  const double bend = sagitta(from, to, (b - a) * path.h), u = nearest_fraction(from.r, e);
  if (norm(from.r + u * e) - bend >= std::min(nearest->r, potential_.cutoff())) return;
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
  // The search goes through one piece of the path after the other.
  const auto pieces = static_cast<double>(path.num_pieces());
  for (double s = a; s < b;) {
    const double end = std::min(b, (std::floor(s * pieces * (1.0 + 1e-12)) + 1.0) / pieces);
    narrow(path, approach, s, end, most_halvings, &nearest);
    s = end;
  }
  return nearest;
}

/// Returns the error of two points by an unseen impulse between them, over their tolerances.
double PairField::measure(const PointPath& path, const Approach& approach, double impulse,
                          std::span<const double> masses) const {
  double error = 0.0;
  for (const std::size_t k : {approach.i, approach.j}) {
    const auto point = static_cast<std::size_t>(points_[k]);
    if (point >= masses.size()) continue;
    const double r = std::max(norm(load(path.positions.front(), point)), norm(load(path.positions.back(), point)));
    const double v = std::max(norm(load(path.velocities.front(), point)), norm(load(path.velocities.back(), point)));
    const double change = impulse / masses[point];
    error = std::max(
        {error, change / (path.atol_v(point) + path.rtol * v), change * path.h / (path.atol_r(point) + path.rtol * r)});
  }
  return error;
}

double PairField::examine(const PointPath& path, const Approach& approach, std::span<const double> masses) const {
  const Encounter nearest = find_nearest(path, approach, 0.0, 1.0);
  return std::min(resolve_meeting(path, approach, nearest, masses), resolve_kinks(path, approach, nearest, masses));
}

/// Returns the part of the step to make instead if no look has seen the points meet, or 1 otherwise.
double PairField::resolve_meeting(const PointPath& path, const Approach& approach, const Encounter& nearest_of_all,
                                  std::span<const double> masses) const {
  const double most = potential_.largest_force(nearest_of_all.r, std::numeric_limits<double>::infinity());
  const auto force_seen = [&](double s) { return potential_.force_at(norm(relative(path, approach, s).r)); };
  double seen = std::max(force_seen(0.0), force_seen(1.0));
  if (most <= seen_enough * seen) return 1.0;
  // The stages in between have seen it, too, unless a force of this size throws them off the path that the ends define.
  constexpr double thrown_off = 0.05;  // part of the pair's depth in its range
  double inverse_mass = 0.0;
  for (const std::size_t i : {approach.i, approach.j})
    if (const auto point = static_cast<std::size_t>(points_[i]); point < masses.size())
      inverse_mass += 1.0 / masses[point];
  const double depth = std::min(potential_.cutoff() - nearest_of_all.r, nearest_of_all.r);
  if (most * inverse_mass * path.h * path.h <= thrown_off * depth) {
    for (const double s : path.looks) seen = std::max(seen, force_seen(s));
    if (most <= seen_enough * seen) return 1.0;
  }
  for (std::size_t look = 0; look + 1 < path.looks.size(); ++look) {
    const double a = path.looks[look], b = path.looks[look + 1];
    const Encounter nearest = find_nearest(path, approach, a, b);
    const double farthest = std::max(norm(relative(path, approach, a).r), norm(relative(path, approach, b).r));
    const double force = potential_.largest_force(nearest.r, farthest);
    if (!(force > seen_enough * seen)) continue;
    // The force lasts while the points pass each other within the range. Without a cutoff, the range ends where the
    // force is a third of its largest value.
    const auto passing = [&](double range) {
      return 2.0 * std::sqrt(std::max(range * range - nearest.r * nearest.r, 0.0)) / (nearest.speed * path.h);
    };
    const double lasts = std::min(b - a, passing(std::min(potential_.cutoff(), 3.0 * nearest.r)));
    const double impulse = force * lasts * path.h;
    if (!(measure(path, approach, impulse, masses) > 1.0)) continue;
    // The next step ends where the force begins, or, if it has begun, on the way to its largest value.
    const double begins = std::max(nearest.s - 0.5 * passing(std::min(potential_.cutoff(), 2.0 * nearest.r)), 0.0);
    const double rises = nearest.s - begins;
    return begins > 4.0 * rises ? begins - 0.01 * rises : begins + 0.25 * rises;
  }
  return 1.0;
}

// ---- contacts that begin or end inside a step ----

Vec3 PairField::force_along(const PointPath& path, const Approach& approach, double s) const {
  const Vec3 d = relative(path, approach, s).r;
  const double r = norm(d);
  return r < potential_.cutoff() ? (potential_.signed_force_at(r) / r) * d : Vec3{};
}

/// Examines a contact that begins or ends inside the step, or of which the step goes through a large part. The pair's
/// impulse on the path is compared with the scheme's quadrature over its looks,
///
///   h (integral F(s) ds - sum_i w_i F(s_i))
///
/// If they differ, the next attempt ends at the kink, with a smooth force on either side.
double PairField::resolve_kinks(const PointPath& path, const Approach& approach, const Encounter& nearest,
                                std::span<const double> masses) const {
  constexpr double allowed_kink = 25.0;  // tolerances that the kink of one pair may cost in a step
  if (!path.follows_tolerance || !neighbours_ || !(nearest.r < potential_.cutoff())) return 1.0;
  const double cutoff2 = potential_.cutoff() * potential_.cutoff();
  const auto beyond = [&](double s) { return squared(relative(path, approach, s).r) - cutoff2; };
  const bool begins = beyond(0.0) > 0.0, ends = beyond(1.0) > 0.0;
  const double farthest2 = std::max(beyond(0.0), beyond(1.0)) + cutoff2;
  if (!begins && !ends && farthest2 <= far_apart2 * nearest.r * nearest.r) return 1.0;
  const double a = begins ? find_fall(0.0, nearest.s, beyond) : 0.0;
  const double b = ends ? find_fall(nearest.s, 1.0, [&](double s) { return -beyond(s); }) : 1.0;
  Vec3 missed{};
  for (const auto& [s, weight] : gauss_rule)
    missed = missed + ((b - a) * weight) * force_along(path, approach, a + s * (b - a));
  for (std::size_t k = 0; k < path.looks.size(); ++k)
    missed = missed - path.weights[k] * force_along(path, approach, path.looks[k]);
  const double error = measure(path, approach, norm(missed) * path.h, masses) / allowed_kink;
  if (!(error > 1.0)) return 1.0;
  constexpr double least = 0.02, most = 0.98;
  for (const double kink : {a, b}) {
    if (kink > least && kink < most) return kink;
  }
  return std::clamp(0.9 / std::sqrt(error), 0.1, 0.9);
}

}  // namespace tanor::detail
