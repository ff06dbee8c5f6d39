#include "evaluate/formula_passages.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace tanor {

namespace {

// How often a formula changes its course in a step that schemes of high order resolve: three radians of a sine, or a
// factor of e^3 of an exponential, need some twenty terms of a series for ten digits. Intervals say more than twice as
// much of sums of squares.
constexpr double resolved = 8.0;
constexpr double resolved_by_part = 2.5;  // by the two places where each part is looked at
constexpr double of_a_kink = 9.0;         // more than is resolved: error estimates may miss one between two looks
constexpr int most_divisions = 4;         // of a step, into eight parts each

constexpr std::size_t num_nodes = 13;

/// Chebyshev's extreme points on [0, 1], where polynomials interpolate best.
std::array<double, num_nodes> make_nodes() {
  std::array<double, num_nodes> nodes;
  for (std::size_t j = 0; j < num_nodes; ++j)
    nodes[j] = 0.5 - 0.5 * std::cos(M_PI * static_cast<double>(j) / static_cast<double>(num_nodes - 1));
  return nodes;
}

/// p(s) = sum w_j g_j/(s - s_j) / sum w_j/(s - s_j),   w_j = (-1)^j, half of it at both ends
Vec3 interpolate(const std::array<double, num_nodes>& nodes, const std::array<Vec3, num_nodes>& values, double s) {
  Vec3 above{};
  double below = 0.0;
  for (std::size_t j = 0; j < num_nodes; ++j) {
    if (s == nodes[j]) return values[j];
    const double end = j == 0 || j + 1 == num_nodes ? 0.5 : 1.0;
    const double weight = (j % 2 == 0 ? end : -end) / (s - nodes[j]);
    above = above + weight * values[j];
    below += weight;
  }
  return (1.0 / below) * above;
}

/// Numbers of one lane between two places that are `length` apart in time. Number by number a cubic leaves its chord by
/// at most 4/27 (|H v_a - e| + |H v_b - e|), and its rate the line between both rates by 3/2 |e/H - (v_a + v_b)/2|.
void enclose(const PointPath::Place& a, const PointPath::Place& b, double t, double length, bool with_rates,
             std::size_t lane, Intervals* variables) {
  const auto set = [&](std::size_t variable, double x, double y, double leaves) {
    variables[variable].low[lane] = std::min(x, y) - leaves;
    variables[variable].high[lane] = std::max(x, y) + leaves;
  };
  const double inverse = 1.0 / length;
  const auto set_both = [&](std::size_t axis, double x, double y, double u, double v) {
    const double e = y - x;
    set(axis, x, y, 4.0 / 27.0 * (std::abs(length * u - e) + std::abs(length * v - e)));
    if (with_rates) set(3 + axis, u, v, 1.5 * std::abs(e * inverse - 0.5 * (u + v)));
  };
  set_both(0, a.r.x, b.r.x, a.v.x, b.v.x);
  set_both(1, a.r.y, b.r.y, a.v.y, b.v.y);
  set_both(2, a.r.z, b.r.z, a.v.z, b.v.z);
  set(6, t, t + length, 0.0);
}

}  // namespace

FormulaPassages::FormulaPassages(const ForceKernel& kernel, std::vector<Index> points)
    : narrowness_(*kernel.expression),
      asks_for_rates_(narrowness_.asks_for(3) || narrowness_.asks_for(4) || narrowness_.asks_for(5)),
      points_(std::move(points)),
      is_doubtful_(points_.size()) {}

double FormulaPassages::find(const Parallel& parallel, PointPath* path, std::span<const double> masses) {
  constexpr std::size_t grain = 64;
  const std::size_t groups = (points_.size() + num_lanes - 1) / num_lanes;
  const double doubtful = parallel.max_over_ranges(
      groups,
      [&](std::size_t begin, std::size_t end) {
        bool any = false;
        for (std::size_t group = begin; group < end; ++group) {
          const std::size_t first = num_lanes * group, count = std::min(num_lanes, points_.size() - first);
          const Counts counts = count_along(*path, std::span(points_).subspan(first, count));
          for (std::size_t k = 0; k < count; ++k) {
            is_doubtful_[first + k] = !(counts[k] <= resolved) && is_doubtful(*path, points_[first + k]);
            any = any || is_doubtful_[first + k];
          }
        }
        return any ? 1.0 : 0.0;
      },
      grain);
  if (doubtful == 0.0) return 1.0;
  path->refine(1e-7);
  std::atomic<double> part = 1.0;
  parallel.for_ranges(
      points_.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          if (!is_doubtful_[k]) continue;
          const double found = examine(*path, points_[k], masses[static_cast<std::size_t>(points_[k])]);
          for (double known = part; found < known && !part.compare_exchange_weak(known, found);) {
          }
        }
      },
      grain);
  return part;
}

/// Of the whole step, for a point in each lane.
FormulaPassages::Counts FormulaPassages::count_along(const PointPath& path, std::span<const Index> points) const {
  const double length = path.h / static_cast<double>(path.num_pieces());
  Counts sums{};
  for (std::size_t k = 0; k < path.num_pieces(); ++k) {
    std::array<Intervals, 7> variables{};
    for (std::size_t lane = 0; lane < points.size(); ++lane) {
      const Index i = points[lane];
      enclose({load(path.positions[k], i), load(path.velocities[k], i)},
              {load(path.positions[k + 1], i), load(path.velocities[k + 1], i)}, path.t + path.knot(k) * path.h, length,
              asks_for_rates_, lane, variables.data());
    }
    const Counts counts = narrowness_.count(variables.data());
    for (std::size_t lane = 0; lane < points.size(); ++lane) sums[lane] += counts[lane];
  }
  return sums;
}

/// Of equal parts, one in each lane.
FormulaPassages::Counts FormulaPassages::count_parts(const PointPath& path, Index point, double begin,
                                                     double end) const {
  const double part = (end - begin) / static_cast<double>(num_lanes);
  std::array<Intervals, 7> variables{};
  PointPath::Place from = path.at(point, begin);
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double s = begin + static_cast<double>(lane) * part;
    const PointPath::Place to = path.at(point, s + part);
    enclose(from, to, path.t + s * path.h, part * path.h, asks_for_rates_, lane, variables.data());
    from = to;
  }
  return narrowness_.count(variables.data());
}

/// Intervals say too much of long paths: they are asked once more for eighths.
bool FormulaPassages::is_doubtful(const PointPath& path, Index point) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < path.num_pieces(); ++k) {
    for (const double count : count_parts(path, point, path.knot(k), path.knot(k + 1))) sum += count;
    if (!(sum <= resolved)) return true;
  }
  return false;
}

/// Returns the sum of what the parts may change.
double FormulaPassages::divide(const PointPath& path, Index point, double begin, double end, int depth,
                               std::vector<Part>* parts) const {
  const double length = (end - begin) / static_cast<double>(num_lanes);
  const Counts counts = count_parts(path, point, begin, end);
  double sum = 0.0;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double from = begin + static_cast<double>(lane) * length;
    if (counts[lane] <= resolved_by_part || depth == 1) {
      parts->push_back({from, from + length});
      sum += std::min(counts[lane], of_a_kink);
    } else {
      sum += divide(path, point, from, from + length, depth - 1, parts);
    }
  }
  return sum;
}

Vec3 FormulaPassages::acceleration(const PointPath& path, Index point, double s, double mass) const {
  const auto [r, v] = path.at(point, s);
  const std::array<double, 7> variables{r.x, r.y, r.z, v.x, v.y, v.z, path.t + s * path.h};
  std::array<double, 3> force;
  narrowness_.evaluate(variables.data(), force.data());
  return (1.0 / mass) * make_vec3(force);
}

/// What the polynomial p leaves of the acceleration a changes the end of the step by
///
///   dv = h integral (a - p) ds,   dx = h integral |dv(s)| ds
double FormulaPassages::examine(const PointPath& path, Index point, double mass) const {
  constexpr double tolerances = 1.0;
  constexpr double path_error = 1e-7;  // of the path, and of the acceleration on it
  thread_local std::vector<Part> parts;
  parts.clear();
  double changes = 0.0;
  const int depth = path.num_pieces() > num_lanes ? most_divisions - 1 : most_divisions;
  for (std::size_t k = 0; k < path.num_pieces(); ++k)
    changes += divide(path, point, path.knot(k), path.knot(k + 1), depth, &parts);
  if (changes <= resolved) return 1.0;

  static const std::array<double, num_nodes> nodes = make_nodes();
  std::array<Vec3, num_nodes> values;
  double largest = 0.0;
  for (std::size_t j = 0; j < num_nodes; ++j) {
    values[j] = acceleration(path, point, nodes[j], mass);
    largest = std::max(largest, norm(values[j]));
  }
  const PointPath::Place from = path.at(point, 0.0), to = path.at(point, 1.0);
  const double of_v = tolerances * (path.atol_v(point) + path.rtol * std::max(norm(from.v), norm(to.v)));
  const double of_r = tolerances * (path.atol_r(point) + path.rtol * std::max(norm(from.r), norm(to.r)));
  Vec3 dv{};
  double dx = 0.0, first_bad = 2.0;
  for (const auto& [begin, end] : parts) {
    const double length = (end - begin) * path.h;
    for (const double place : {0.5 - std::sqrt(1.0 / 12.0), 0.5 + std::sqrt(1.0 / 12.0)}) {  // Gauss
      const double s = begin + place * (end - begin);
      const Vec3 a = acceleration(path, point, s, mass);
      largest = std::max(largest, norm(a));
      dv = dv + 0.5 * length * (a - interpolate(nodes, values, s));
      dx += 0.5 * length * norm(dv);
    }
    const double noise = path_error * largest * path.h;
    const bool is_bad = !(dx <= of_r + noise * path.h) || !(norm(dv) <= of_v + noise);
    if (is_bad) first_bad = std::min(first_bad, begin);
  }
  const double noise = path_error * largest * path.h;
  if (dx <= of_r + noise * path.h && norm(dv) <= of_v + noise) return 1.0;
  return std::clamp(first_bad, 0.125, 0.9);
}

}  // namespace tanor
