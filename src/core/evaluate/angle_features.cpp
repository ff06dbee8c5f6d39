#include "evaluate/angle_features.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "evaluate/locate_jump.hpp"

namespace tanor::detail {

namespace {

// A step may pass a minimum of the sine that is at least `shallow` times the smaller sine at its ends. It is cut to the
// part `approach` of the way to a deeper one.
constexpr double shallow = 0.25, approach = 0.75;

/// The vectors a, b and their normal n = a x b in piece k at its fraction u, with the rate of n, m^2/s.
struct Corner {
  Vec3 a, b, n, rate;

  Corner(const PointPath& path, const std::array<Index, 3>& points, std::size_t k, double u) {
    const PointPath::Place first = path.cubic(points[0], k, u), corner = path.cubic(points[1], k, u),
                           last = path.cubic(points[2], k, u);
    a = first.r - corner.r;
    b = last.r - corner.r;
    n = cross(a, b);
    rate = cross(first.v - corner.v, b) + cross(a, last.v - corner.v);
  }
  double sine() const { return norm(n) / (norm(a) * norm(b)); }
  /// Returns d(|n|^2/2)/dt, which is negative while the points come nearer to a line.
  double slope() const { return dot(n, rate); }
};

}  // namespace

void AngleFeatures::append(const std::array<Index, 3>& triple, Ends ends) {
  const auto [i, corner, j] = triple;
  triples_.push_back({{std::min(i, j), corner, std::max(i, j)}, ends});
}

void AngleFeatures::finish() {
  std::sort(triples_.begin(), triples_.end());
  triples_.erase(std::unique(triples_.begin(), triples_.end()), triples_.end());
  is_doubtful_.resize(triples_.size());
}

/// Returns false if the sine cannot fall far. In a piece the angle changes by at most the turns of a and b, which are
/// bounded by |change of a|/|a| and |change of b|/|b|, where |a| and |b| are the least in the piece.
bool AngleFeatures::may_fall(const PointPath& path, const Triple& triple) {
  const Index i = triple.points[0], corner = triple.points[1], j = triple.points[2];
  const double length = path.h / static_cast<double>(path.num_pieces());
  const auto side_at = [&](Index end, std::size_t knot) {
    const double *const r = path.positions[knot], *const v = path.velocities[knot];
    return PointPath::Place{load(r, end) - load(r, corner), load(v, end) - load(v, corner)};
  };
  PointPath::Place a = side_at(i, 0), b = side_at(j, 0);
  for (std::size_t k = 0; k < path.num_pieces(); ++k) {
    const PointPath::Place next_a = side_at(i, k + 1), next_b = side_at(j, k + 1);
    const double length_a = norm(a.r), length_b = norm(b.r), sine = norm(cross(a.r, b.r)) / (length_a * length_b);
    const double left_a = length_a - (norm(next_a.r - a.r) + sagitta(a, next_a, length)),
                 left_b = length_b - (norm(next_b.r - b.r) + sagitta(b, next_b, length));
    const double turn = length_a / left_a - 1.0 + length_b / left_b - 1.0;
    if (!(left_a > 0.0 && left_b > 0.0 && (1.0 - shallow) * sine > turn)) return true;
    a = next_a;
    b = next_b;
  }
  return false;
}

AngleFeatures::Fall AngleFeatures::find_least(const PointPath& path, const Triple& triple) {
  constexpr int parts = 8;  // into which a piece is divided
  const std::size_t last = path.num_pieces() - 1;
  const double at_ends =
      std::min(Corner(path, triple.points, 0, 0.0).sine(), Corner(path, triple.points, last, 1.0).sine());
  Fall deepest;
  for (std::size_t k = 0; k <= last; ++k) {
    double slope = Corner(path, triple.points, k, 0.0).slope();
    for (int part = 1; part <= parts; ++part) {
      const double low = static_cast<double>(part - 1) / parts, high = static_cast<double>(part) / parts;
      const double before = std::exchange(slope, Corner(path, triple.points, k, high).slope());
      if (!(before < 0.0 && slope >= 0.0)) continue;
      const double u = find_fall(low, high, [&](double at) { return -Corner(path, triple.points, k, at).slope(); });
      const Corner here(path, triple.points, k, u);
      if (triple.ends == Ends::AtZero && dot(here.a, here.b) < 0.0) continue;
      const double depth = here.sine() / at_ends;
      if (depth < deepest.depth) deepest = {(static_cast<double>(k) + u) / static_cast<double>(last + 1), depth};
    }
  }
  return deepest;
}

double AngleFeatures::find(const Parallel& parallel, PointPath* path) {
  constexpr std::size_t grain = 256;
  constexpr double path_error = 1e-7;
  const auto sort_out = [&](std::size_t begin, std::size_t end) {
    bool any = false;
    for (std::size_t k = begin; k < end; ++k) {
      is_doubtful_[k] = may_fall(*path, triples_[k]) && find_least(*path, triples_[k]).depth < 2.0 * shallow;
      any = any || is_doubtful_[k] != 0;
    }
    return any;
  };
  if (!parallel.join_over_ranges(triples_.size(), false, sort_out, std::logical_or<>(), grain)) return 1.0;
  path->refine(path_error);
  double part = 1.0;
  for (std::size_t k = 0; k < triples_.size(); ++k) {
    if (is_doubtful_[k] == 0) continue;
    if (const Fall fall = find_least(*path, triples_[k]); fall.depth < shallow)
      part = std::min(part, approach * fall.part);
  }
  return part;
}

}  // namespace tanor::detail
