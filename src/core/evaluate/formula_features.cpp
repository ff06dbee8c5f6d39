#include "evaluate/formula_features.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "base/chebyshev.hpp"
#include "base/instruction_sets.hpp"

namespace tanor::detail {

namespace {

// Returns how often a formula may change its course in a step that a scheme resolves. Three radians of a sine, or a
// factor of e^3 of an exponential, need some twenty terms of a series for ten digits. Intervals overestimate sums of
// squares more than twofold. If the course changes more often, an error estimate may be small by chance.
double resolved_by(int order) {
  return std::clamp(0.4 * order, 2.0, 8.0);
}
constexpr double resolved_by_part = 2.5;  // by the two places where each part is looked at
constexpr double of_a_kink = 9.0;         // more than is resolved: error estimates may miss one between two looks
constexpr int most_divisions = 4;         // levels of a step, into eight parts each
constexpr std::size_t least_nodes = 6, most_nodes = 13;  // of the polynomial that a scheme follows

/// Numbers between two instants that are `length` H apart. With the chord e and the rates u and v at both ends, a cubic
/// leaves its chord by at most 4/27 (|H u - e| + |H v - e|), and its rate the line between both rates by
/// 3/2 |e/H - (u + v)/2|.
struct Segments {
  Pack<> from, to, rate_from, rate_to;
};
[[gnu::always_inline]] inline Pack<> size_of(const Pack<>& x) {
  return x < 0.0 ? -x : x;
}
[[gnu::always_inline]] inline Intervals around(const Pack<>& x, const Pack<>& y, const Pack<>& leaves) {
  return {(x < y ? x : y) - leaves, (x < y ? y : x) + leaves};
}
/// Encloses the numbers and, unless `rate` is null, their rates.
void enclose_segments(const Segments& segments, double length, Intervals* place, Intervals* rate) {
  dispatch([=, &segments] {
    const Pack<> e = segments.to - segments.from;
    const Pack<> leaves = size_of(length * segments.rate_from - e) + size_of(length * segments.rate_to - e);
    *place = around(segments.from, segments.to, 4.0 / 27.0 * leaves);
    if (rate == nullptr) return;
    const Pack<> missed = size_of((1.0 / length) * e - 0.5 * (segments.rate_from + segments.rate_to));
    *rate = around(segments.rate_from, segments.rate_to, 1.5 * missed);
  });
}

/// Returns true if a is within b in all lanes.
bool is_within(const Intervals& a, const Intervals& b) {
  const auto is_outside = (a.low < b.low) | (a.high > b.high);
  long any = 0;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) any |= is_outside[lane];
  return any == 0;
}

}  // namespace

FormulaFeatures::FormulaFeatures(const Expression& expression, Variables variables, bool thread_safe,
                                 const Members& members)
    : narrowness_(expression),
      variables_(variables),
      thread_safe_(thread_safe),
      points_(members.points.begin(), members.points.end()),
      constants_(members.constants.begin(), members.constants.end()),
      points_per_member_(members.points_per_member),
      num_constants_(num_members() > 0 ? constants_.size() / num_members() : 0),
      num_numbers_((narrowness_.num_variables() - 1 - num_constants_) /
                   (variables == Variables::OfPointsAndTheirRates ? 2 : 1)),
      num_moving_(members.num_moving) {
  if (variables == Variables::OfMechanics) {
    numbers_.resize(num_members() * num_numbers_);
    std::iota(numbers_.begin(), numbers_.end(), members.first_variable);
  } else {
    for (const Index point : points_)
      for (Index c = 0; c < 3; ++c) numbers_.push_back(3 * point + c);
  }
  if (variables != Variables::OfPointsAndTheirRates) return;
  for (std::size_t i = num_numbers_; i < 2 * num_numbers_; ++i)
    asks_for_rates_ = asks_for_rates_ || narrowness_.asks_for(i);
}

double FormulaFeatures::find(const Parallel& parallel, PointPath* path) {
  constexpr std::size_t grain = 64;
  const std::size_t members = num_members(), groups = (members + num_lanes - 1) / num_lanes;
  if (boxes_.empty()) {
    boxes_.resize(groups);
    sides_.resize(groups * narrowness_.num_variables());
    is_doubtful_.resize(members);
  }
  const auto sort_out = [&](std::size_t begin, std::size_t end) {
    thread_local std::vector<Part> parts;
    const double resolved = resolved_by(path->order);
    bool any = false;
    for (std::size_t group = begin; group < end; ++group) {
      const std::size_t first = num_lanes * group, count = std::min(num_lanes, members - first);
      const Counts counts = count_along(*path, group);
      for (std::size_t k = 0; k < count; ++k) {
        // Intervals overestimate on long paths, so they are evaluated once more for eighths of the pieces.
        is_doubtful_[first + k] = !(counts[k] <= resolved) && !(divide(*path, first + k, 1, &parts) <= resolved);
        any = any || is_doubtful_[first + k];
      }
    }
    return any;
  };
  if (!parallel.join_over_ranges(groups, false, sort_out, std::logical_or<>(), grain)) return 1.0;
  path->refine(1e-7);
  for (std::size_t k = 0; k < members && path->ends_at_jumps && may_jump(); ++k)
    if (is_doubtful_[k]) note_jumps(path, k);
  if (path->jump.exists()) return 1.0;  // what comes after the jump differs
  const auto find_least = [&](std::size_t begin, std::size_t end) {
    double least = 1.0;
    for (std::size_t k = begin; k < end; ++k)
      if (is_doubtful_[k]) least = std::min(least, examine(*path, k));
    return least;
  };
  const auto smaller = [](double a, double b) { return std::min(a, b); };
  const Parallel serial(1);
  const double part = (thread_safe_ ? parallel : serial).join_over_ranges(members, 1.0, find_least, smaller, grain);
  if (part < 1.0) path->passed = &name;
  return part;
}

/// Encloses the variables of a group in one piece, with a member in each lane. The last member fills the lanes that are
/// left.
void FormulaFeatures::enclose(const PointPath& path, std::size_t group, std::size_t piece, Intervals* to) const {
  const bool of_mechanics = variables_ == Variables::OfMechanics;
  const auto& places = of_mechanics ? path.variables : path.positions;
  const auto& rates = of_mechanics ? path.rates : path.velocities;
  const double length = path.h / static_cast<double>(path.num_pieces()), t = path.t + path.knot(piece) * path.h;
  const std::size_t first = num_lanes * group, last = num_members() - 1;
  for (std::size_t i = 0; i < num_numbers_; ++i) {
    Segments segments;
    for (std::size_t lane = 0; lane < num_lanes; ++lane) {
      const auto k = static_cast<std::size_t>(numbers_[std::min(first + lane, last) * num_numbers_ + i]);
      segments.from[lane] = places[piece][k];
      segments.to[lane] = places[piece + 1][k];
      segments.rate_from[lane] = rates[piece][k];
      segments.rate_to[lane] = rates[piece + 1][k];
    }
    enclose_segments(segments, length, to + i, asks_for_rates_ ? to + num_numbers_ + i : nullptr);
  }
  const std::size_t before_constants = narrowness_.num_variables() - 1 - num_constants_;
  for (std::size_t i = 0; i < num_constants_; ++i) {
    Pack<> constant;
    for (std::size_t lane = 0; lane < num_lanes; ++lane) constant[lane] = constants(std::min(first + lane, last))[i];
    to[before_constants + i] = {constant, constant};
  }
  const Pack<> zero{};
  to[narrowness_.num_variables() - 1] = {zero + t, zero + (t + length)};
}

/// Counts along the whole step, for a member in each lane. In a box around the whole path the formula changes its
/// course at least as often as in any piece of it. The counts are 0 if the box shows that the step is resolved.
FormulaFeatures::Counts FormulaFeatures::count_along(const PointPath& path, std::size_t group) {
  thread_local std::vector<Intervals> piece, hull;
  const std::size_t width = narrowness_.num_variables();
  const std::size_t first = num_lanes * group, count = std::min(num_lanes, num_members() - first);
  const auto pieces = static_cast<double>(path.num_pieces());
  hull.assign(width, Intervals{});
  for (std::size_t k = 0; k < path.num_pieces(); ++k) {
    std::vector<Intervals>& to = k == 0 ? hull : piece;
    if (k > 0) to.assign(width, Intervals{});
    enclose(path, group, k, to.data());
    for (std::size_t i = 0; k > 0 && i < width; ++i) {
      hull[i].low = piece[i].low < hull[i].low ? piece[i].low : hull[i].low;
      hull[i].high = piece[i].high > hull[i].high ? piece[i].high : hull[i].high;
    }
  }

  Box& box = boxes_[group];
  Intervals* const sides = sides_.data() + group * width;
  const double resolved = resolved_by(path.order);
  const auto serves = [&](double times) {
    return std::all_of(box.counts.begin(), box.counts.begin() + count,
                       [&](double each) { return times * pieces * each <= resolved; });
  };
  const auto holds_path = [&] {
    for (std::size_t i = 0; i < width; ++i)
      if (narrowness_.asks_for(i) && !is_within(hull[i], sides[i])) return false;
    return true;
  };
  if (box.is_known && holds_path() && serves(1.0)) return {};
  for (;;) {
    for (std::size_t i = 0; i < width; ++i) {
      const Pack<> more = box.margin * (hull[i].high - hull[i].low);
      sides[i] = {hull[i].low - more, hull[i].high + more};
    }
    box.counts = narrowness_.count(sides);
    box.is_known = serves(1.0);
    if (box.is_known) {
      if (box.margin < 16.0 && serves(3.0)) box.margin = std::max(1.5 * box.margin, 1.0);
      return {};
    }
    if (box.margin == 0.0) break;
    box.margin = box.margin > 0.5 ? 0.5 * box.margin : 0.0;
  }
  Counts counts = box.counts;
  for (double& each : counts) each *= pieces;
  return counts;
}

/// Counts in equal parts of [begin, end], one in each lane.
FormulaFeatures::Counts FormulaFeatures::count_parts(const PointPath& path, std::size_t member, double begin,
                                                     double end) const {
  thread_local std::vector<Intervals> variables;
  variables.assign(narrowness_.num_variables(), Intervals{});
  const double part = (end - begin) / static_cast<double>(num_lanes), length = part * path.h;
  const bool of_mechanics = variables_ == Variables::OfMechanics;
  const std::span<const Index> own = numbers(member);
  for (std::size_t i = 0; i < own.size(); ++i) {
    Segments segments;
    PointPath::Number from = path.number(own[i], begin, of_mechanics);
    for (std::size_t lane = 0; lane < num_lanes; ++lane) {
      const PointPath::Number to = path.number(own[i], begin + static_cast<double>(lane + 1) * part, of_mechanics);
      segments.from[lane] = from.x;
      segments.to[lane] = to.x;
      segments.rate_from[lane] = from.rate;
      segments.rate_to[lane] = to.rate;
      from = to;
    }
    enclose_segments(segments, length, &variables[i], asks_for_rates_ ? &variables[own.size() + i] : nullptr);
  }
  const std::size_t before_constants = narrowness_.num_variables() - 1 - num_constants_;
  for (std::size_t i = 0; i < num_constants_; ++i) {
    const Pack<> constant = Pack<>{} + constants(member)[i];
    variables[before_constants + i] = {constant, constant};
  }
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double t = path.t + (begin + static_cast<double>(lane) * part) * path.h;
    variables.back().low[lane] = t;
    variables.back().high[lane] = t + length;
  }
  return narrowness_.count(variables.data());
}

/// Divides the pieces of the step, see below.
double FormulaFeatures::divide(const PointPath& path, std::size_t member, int depth, std::vector<Part>* parts) const {
  double sum = 0.0;
  parts->clear();
  for (std::size_t k = 0; k < path.num_pieces(); ++k)
    sum += divide(path, member, path.knot(k), path.knot(k + 1), depth, parts);
  return sum;
}
double FormulaFeatures::divide(const PointPath& path, std::size_t member, std::vector<Part>* parts) const {
  return divide(path, member, path.num_pieces() > num_lanes ? most_divisions - 1 : most_divisions, parts);
}

/// Divides [begin, end] into parts in each of which the formula changes little. Returns the sum of what the parts may
/// change.
double FormulaFeatures::divide(const PointPath& path, std::size_t member, double begin, double end, int depth,
                               std::vector<Part>* parts) const {
  const double length = (end - begin) / static_cast<double>(num_lanes);
  const Counts counts = count_parts(path, member, begin, end);
  double sum = 0.0;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double from = begin + static_cast<double>(lane) * length;
    if (counts[lane] <= resolved_by_part || depth == 1) {
      parts->push_back({from, from + length});
      sum += std::min(counts[lane], of_a_kink);
    } else {
      sum += divide(path, member, from, from + length, depth - 1, parts);
    }
  }
  return sum;
}

/// Returns the least of what the points of a member that move may miss by the path's tolerances.
FormulaFeatures::Allowed FormulaFeatures::allow(const PointPath& path, std::size_t member) const {
  Allowed least{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (const Index point : points(member)) {
    if (!moves(point)) continue;
    const PointPath::Place from = path.at(point, 0.0), to = path.at(point, 1.0);
    least.v = std::min(least.v, path.atol_v(point) + path.rtol * std::max(norm(from.v), norm(to.v)));
    least.r = std::min(least.r, path.atol_r(point) + path.rtol * std::max(norm(from.r), norm(to.r)));
  }
  return least;
}

double FormulaFeatures::largest_acceleration(const PointPath& path, std::size_t member) const {
  double largest = 0.0;
  for (const Index point : points(member)) largest = std::max(largest, path.largest_acceleration(point));
  return largest;
}

void FormulaFeatures::load_points(const PointPath& path, std::size_t member, double s, double* r, double* v) const {
  for (std::size_t i = 0; const Index point : points(member)) {
    const PointPath::Place place = path.at(point, s);
    store(r, i, place.r);
    if (v != nullptr) store(v, i, place.v);
    ++i;
  }
}

/// Integrals along the path of one member, in the numbers that `accelerate` writes.
struct FormulaFeatures::Integrals {
  std::vector<double> a, dv;         // [number] at one place; h integral (a - p) ds
  std::vector<double> end_v, end_x;  // [number] h integral a ds, h^2 integral (1 - s) a ds
  double dx = 0.0, largest = 0.0;    // m; the largest |a|, m/s^2

  void clear(std::size_t count) {
    a.resize(count);
    for (std::vector<double>* array : {&dv, &end_v, &end_x}) array->assign(count, 0.0);
    dx = largest = 0.0;
  }
  /// Returns the error of dv that a path of limited accuracy leaves, m/s.
  double noise(double h) const {
    constexpr double path_error = 1e-7;  // relative, for the path and the acceleration on it
    return path_error * largest * h;
  }
  bool exceed(const Allowed& allowed, double h) const {
    return !(dx <= allowed.r + noise(h) * h) || !(norm_of(dv) <= allowed.v + noise(h));
  }
};

/// Compares the acceleration a with its polynomial p over the step. On the way, their difference changes the motion by
///
///   dv = h integral (a - p) ds,   dx = h integral |dv(s)| ds
///
/// At its end the scheme misses, whatever its error estimate says,
///
///   h (integral a ds - sum w_k a(s_k)),   h^2 (integral (1 - s) a ds - sum w_k (1 - s_k) a(s_k))
///
/// Returns the part of the step to make instead, or 1.
double FormulaFeatures::examine(const PointPath& path, std::size_t member) const {
  constexpr double tolerances = 10.0;  // what an estimate may have missed
  constexpr double part_of_jumps = 0.1;
  constexpr std::size_t least_looks = 4;  // with fewer, the scheme knows more of the step than what it sees in them
  thread_local std::vector<Part> parts;
  thread_local Integrals sums;
  if (const double changes = divide(path, member, &parts); changes <= resolved_by(path.order)) return 1.0;

  const bool counts_jumps = has_jumps() && !path.follows_tolerance;
  const double part = counts_jumps ? part_of_jumps : 1.0, more = counts_jumps ? 1.0 : tolerances;
  Allowed allowed = allow(path, member);
  allowed = {part * allowed.r, part * allowed.v};
  const double first_bad = integrate(path, member, parts, allowed, &sums);
  if (sums.exceed(allowed, path.h)) return std::clamp(first_bad, 0.125, 0.9);
  if (path.looks.size() < least_looks && !counts_jumps) return 1.0;
  subtract_looks(path, member, &sums);
  const double noise = sums.noise(path.h);
  const double error = std::max(norm_of(sums.end_v) / (more * allowed.v + noise),
                                norm_of(sums.end_x) / (more * allowed.r + noise * path.h));
  return error > 1.0 ? std::clamp(0.9 * std::pow(error, -1.0 / (path.order + 1)), 0.1, 0.9) : 1.0;
}

/// Integrates by Gauss' rule of two points in each part. Returns the beginning of the first part at whose end more than
/// what is allowed is missed, or 2 if there is none.
double FormulaFeatures::integrate(const PointPath& path, std::size_t member, std::span<const Part> parts,
                                  const Allowed& allowed, Integrals* sums) const {
  thread_local ChebyshevPolynomial polynomial;
  thread_local std::vector<double> places, at_nodes, acting, hidden;
  const std::size_t count = num_accelerations();
  sums->clear(count);
  auto& [a, dv, end_v, end_x, dx, largest] = *sums;
  polynomial.place(std::clamp(static_cast<std::size_t>(path.order) + 1, least_nodes, most_nodes));
  const std::vector<double>& nodes = polynomial.points();
  places.clear();
  for (const auto& [begin, end] : parts)
    for (const double place : {0.5 - std::sqrt(1.0 / 12.0), 0.5 + std::sqrt(1.0 / 12.0)})
      places.push_back(begin + place * (end - begin));
  const auto sample = [&](std::span<const double> at, std::vector<double>* values) {  // [number][place]
    values->resize(count * at.size());
    for (std::size_t k = 0; k < at.size(); ++k) {
      accelerate(path, member, at[k], a.data());
      for (std::size_t i = 0; i < count; ++i) (*values)[i * at.size() + k] = a[i];
    }
  };
  sample(nodes, &at_nodes);
  sample(places, &acting);
  hidden = acting;
  for (std::size_t i = 0; i < count; ++i)
    polynomial.subtract(&at_nodes[i * nodes.size()], places, &hidden[i * places.size()]);
  for (std::size_t j = 0; j < nodes.size(); ++j) {
    for (std::size_t i = 0; i < count; ++i) a[i] = at_nodes[i * nodes.size() + j];
    largest = std::max(largest, norm_of(a));
  }
  double first_bad = 2.0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto& [begin, end] = parts[k / 2];
    const double weight = 0.5 * (end - begin) * path.h;
    for (std::size_t i = 0; i < count; ++i) {
      a[i] = acting[i * places.size() + k];
      dv[i] += weight * hidden[i * places.size() + k];
      end_v[i] += weight * a[i];
      end_x[i] += weight * path.h * (1.0 - places[k]) * a[i];
    }
    largest = std::max(largest, norm_of(a));
    dx += weight * norm_of(dv);
    if (k % 2 == 1 && sums->exceed(allowed, path.h)) first_bad = std::min(first_bad, begin);
  }
  return first_bad;
}

/// Subtracts the scheme's quadrature over its looks from the integrals at the end.
void FormulaFeatures::subtract_looks(const PointPath& path, std::size_t member, Integrals* sums) const {
  for (std::size_t k = 0; k < path.looks.size(); ++k) {
    const double s = path.looks[k], weight = path.weights[k] * path.h;
    accelerate(path, member, s, sums->a.data());
    for (std::size_t i = 0; i < sums->a.size(); ++i) {
      sums->end_v[i] -= weight * sums->a[i];
      sums->end_x[i] -= weight * path.h * (1.0 - s) * sums->a[i];
    }
  }
}

}  // namespace tanor::detail
