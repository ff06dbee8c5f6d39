#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <tuple>

#include "base/numbers.hpp"
#include "evaluate/locate_jump.hpp"
#include "evaluate/pair_field.hpp"

/// \file Places of a step where pairs come to a cutoff at which their force does not vanish.
namespace tanor::detail {

/// The first crossing of the cutoff by one pair.
class PairField::Crossing {
 public:
  Crossing(const PairField& field, const PointPath& path, const Approach& pair) : field_(&field), pair_(pair) {
    is_outside_ = norm(field.relative(path, pair, 0.0).r) >= field.potential_.cutoff();
    constexpr int most_halvings = 24;
    for (std::size_t k = 0; k < path.num_pieces() && !exists(); ++k)
      search(path, path.knot(k), path.knot(k + 1), most_halvings);
  }

  bool exists() const { return high_ < std::numeric_limits<double>::infinity(); }
  double low() const { return low_; }
  double high() const { return high_; }
  const Approach& pair() const { return pair_; }
  /// Returns how far the pair is on the side of the cutoff where the step begins, m.
  double side(const PointPath& path, double s) const {
    const double beyond = norm(field_->relative(path, pair_, s).r) - field_->potential_.cutoff();
    return is_outside_ ? beyond : -beyond;
  }
  bool operator<(const Crossing& other) const {
    return std::tie(high_, pair_.i, pair_.j) < std::tie(other.high_, other.pair_.i, other.pair_.j);
  }

 private:
  /// Searches [a, b]. It is halved while the distance may reach the cutoff and may turn round, or the path bends.
  void search(const PointPath& path, double a, double b, int depth) {
    constexpr double straight = 0.02;  // |sagitta| over the chord
    const PointPath::Place from = field_->relative(path, pair_, a), to = field_->relative(path, pair_, b);
    const Vec3 e = to.r - from.r;
    const double bend = sagitta(from, to, (b - a) * path.h), cutoff = field_->potential_.cutoff();
    const double u = std::clamp(-dot(from.r, e) / std::max(squared(e), std::numeric_limits<double>::min()), 0.0, 1.0);
    const bool stays =
        is_outside_ ? norm(from.r + u * e) - bend > cutoff : std::max(norm(from.r), norm(to.r)) + bend < cutoff;
    if (stays) return;
    const bool turns = (dot(from.r, from.v) > 0.0) != (dot(to.r, to.v) > 0.0);
    if (depth > 0 && (turns || bend > straight * norm(e))) {
      const double middle = 0.5 * (a + b);
      search(path, a, middle, depth - 1);
      if (!exists()) search(path, middle, b, depth - 1);
    } else if (side(path, b) < 0.0) {
      low_ = a;
      high_ = side(path, a) > 0.0 ? b : a;
    }
  }

  const PairField* field_;
  Approach pair_;
  bool is_outside_;
  double low_ = 0.0, high_ = std::numeric_limits<double>::infinity();  // fractions of the step, around it
};

void PairField::note_jumps(const Parallel& parallel, PointPath* path, std::span<const double> masses) {
  const Reach reach = measure_reach(parallel, *path);
  const Vec3 edges = box_.edges();
  for (const double edge : {edges.x, edges.y, edges.z})
    if (edge > 0.0 && reach.move > edge) return;  // `find_unseen` shortens such steps, …
  const NeighbourLists* const near = reach.move > 0.0 ? find_near(parallel, reach.move) : nullptr;
  if (near == nullptr) return;  // … and these
  std::vector<Crossing> found;
  std::mutex guard;
  // A path that bends evenly leaves its chord by the square of the number of pieces as much as these leave theirs.
  const auto pieces = static_cast<double>(path->num_pieces());
  const double cutoff = potential_.cutoff(), bend = 2.0 * std::min(pieces * pieces * reach.sagitta, reach.move);
  near->for_each_point(parallel, [&](std::size_t i, std::span<const Index> neighbours) {
    for (auto j = std::upper_bound(neighbours.begin(), neighbours.end(), static_cast<Index>(i)); j != neighbours.end();
         ++j) {
      const auto other = static_cast<std::size_t>(*j);
      // A chord that ends inside the cutoff is inside it.
      const Vec3 d = box_.nearest_image(begins_[other] - begins_[i]), e = moves_[other] - moves_[i];
      if (norm(d) > cutoff + norm(e) + bend || std::max(norm(d), norm(d + e)) + bend < cutoff) continue;
      const auto note = [&](const Approach& pair) {
        const Crossing crossing(*this, *path, pair);
        if (!crossing.exists()) return;
        const std::lock_guard lock(guard);
        found.push_back(crossing);
      };
      for_each_image(i, other, cutoff + 2.0 * reach.move, std::cref(note));
    }
  });
  std::sort(found.begin(), found.end());
  for (const Crossing& crossing : found) {
    if (crossing.low() > path->jump.after) break;
    note_jump(path, crossing, masses);
  }
}

void PairField::note_jump(PointPath* path, const Crossing& crossing, std::span<const double> masses) const {
  constexpr double some_roundings = 32.0, counts = 0.1;  // of a tolerance
  const double impulse = potential_.force_at(std::nextafter(potential_.cutoff(), 0.0)) * path->h;
  if (!(measure(*path, crossing.pair(), impulse, masses) > counts)) return;
  const PointPath::Place i = path->at(points_[crossing.pair().i], crossing.high()),
                         j = path->at(points_[crossing.pair().j], crossing.high());
  const double margin = some_roundings * eps * (norm(i.r) + norm(j.r) + potential_.cutoff());
  PointPath::Jump jump = locate_jump(path, crossing.low(), crossing.high(), margin,
                                     [&](const PointPath& on, double s) { return crossing.side(on, s); });
  jump.force = &name;
  path->jump.include(jump);
}

}  // namespace tanor::detail
