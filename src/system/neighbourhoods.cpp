#include "system/neighbourhoods.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <variant>

#include "base/vec3.hpp"
#include "system/members.hpp"

namespace tanor {

namespace {

class Box {
 public:
  void include(const Vec3& r) {
    low_ = {std::min(low_.x, r.x), std::min(low_.y, r.y), std::min(low_.z, r.z)};
    high_ = {std::max(high_.x, r.x), std::max(high_.y, r.y), std::max(high_.z, r.z)};
  }
  double diagonal() const { return norm(high_ - low_); }

 private:
  static constexpr double far = std::numeric_limits<double>::max();
  Vec3 low_{far, far, far}, high_{-far, -far, -far};
};

/// Sets of points that grow together; supports stay outside.
class Joining {
 public:
  explicit Joining(const System& system) : root_(system.num_points()) {
    std::iota(root_.begin(), root_.end(), 0);
    for (const Support& support : system.supports) {
      for (const Index point : support.points) root_[static_cast<std::size_t>(point)] = -1;
    }
  }
  bool is_support(Index point) const { return root_[static_cast<std::size_t>(point)] < 0; }
  /// -1: a support.
  Index find(Index point) {
    if (is_support(point)) return -1;
    while (root_[static_cast<std::size_t>(point)] != point) {
      Index& up = root_[static_cast<std::size_t>(point)];
      point = up = root_[static_cast<std::size_t>(up)];
    }
    return point;
  }
  void join(std::span<const Index> points) {
    Index first = -1;
    for (const Index point : points) {
      const Index root = find(point);
      if (root < 0) continue;
      if (first >= 0) root_[static_cast<std::size_t>(std::max(root, first))] = std::min(root, first);
      first = first < 0 ? root : std::min(root, first);
    }
  }

 private:
  std::vector<Index> root_;
};

/// visit(points) for all that join points.
template <class Visit>
void for_each_tie(const System& system, const Visit& visit) {
  for_each_member(system, [&](std::span<const Index> points, int) { visit(points); });
  for (const Force& force : system.forces) {
    const auto* springs = std::get_if<Springs>(&force);
    if (springs == nullptr) continue;
    for (const auto& pair : springs->pairs) visit(std::span<const Index>(pair));
  }
  for (const Coordinates& coordinates : system.coordinates) {
    if (const auto* chain = std::get_if<ChainAngles>(&coordinates)) {
      std::vector<Index> points = chain->points;
      points.push_back(chain->anchor);
      visit(std::span<const Index>(points));
    } else if (const auto* body = std::get_if<RigidBody>(&coordinates)) {
      visit(std::span<const Index>(body->points));
    } else if (const auto* user = std::get_if<UserCoordinates>(&coordinates)) {
      for (const std::vector<Index>& tuple : user->tuples) visit(std::span<const Index>(tuple));
    }
  }
}

Vec3 value_at(const VectorFunction& function, double t) {
  const auto r = function(t);
  return {r[0].value(), r[1].value(), r[2].value()};
}

/// visit(point, centre) for all that guides have.
template <class Visit>
void for_each_centre(const System& system, double t, const Visit& visit) {
  const auto visit_all = [&](const auto& guides) {
    const Vec3 centre = value_at(guides.center, t);
    for (const Index point : guides.points) visit(point, centre);
  };
  for (const Coordinates& coordinates : system.coordinates) {
    if (const auto* circles = std::get_if<CircleCoordinates>(&coordinates)) visit_all(*circles);
    if (const auto* spheres = std::get_if<SphereCoordinates>(&coordinates)) visit_all(*spheres);
  }
  for (const Constraint& constraint : system.constraints) {
    if (const auto* circles = std::get_if<Circles>(&constraint)) visit_all(*circles);
    if (const auto* spheres = std::get_if<Spheres>(&constraint)) visit_all(*spheres);
    if (const auto* pulleys = std::get_if<Pulleys>(&constraint)) {
      for (const auto& [i, j] : pulleys->pairs) {
        visit(i, make_vec3(pulleys->a));
        visit(j, make_vec3(pulleys->b));
      }
    }
  }
}

}  // namespace

Neighbourhoods find_neighbourhoods(const System& system, double t) {
  Joining joining(system);
  for_each_tie(system, [&](std::span<const Index> points) { joining.join(points); });

  const std::size_t num_points = system.num_points();
  Neighbourhoods result;
  result.of_point.assign(num_points, -1);
  std::vector<Index> number(num_points, -1);  // [root]
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < num_points; ++i) {
    const Index root = joining.find(static_cast<Index>(i));
    if (root < 0) continue;
    Index& own = number[static_cast<std::size_t>(root)];
    if (own < 0) {
      own = static_cast<Index>(boxes.size());
      boxes.emplace_back();
    }
    result.of_point[i] = own;
    boxes[static_cast<std::size_t>(own)].include(load(system.positions.data(), i));
  }
  const auto box_of = [&](Index point) -> Box* {
    const Index own = result.of_point[static_cast<std::size_t>(point)];
    return own < 0 ? nullptr : &boxes[static_cast<std::size_t>(own)];
  };
  for_each_tie(system, [&](std::span<const Index> points) {
    const auto moving = std::find_if(points.begin(), points.end(), [&](Index i) { return box_of(i) != nullptr; });
    if (moving == points.end()) return;
    for (const Index point : points) box_of(*moving)->include(load(system.positions.data(), point));
  });
  for_each_centre(system, t, [&](Index point, const Vec3& centre) {
    if (Box* const box = box_of(point)) box->include(centre);
  });

  std::vector<double> sigma(boxes.size(), 0.0);
  for (const Force& force : system.forces) {
    const auto* pairs = std::get_if<PairForces>(&force);
    if (pairs == nullptr || pairs->law == PairLaw::Log) continue;
    const auto give = [&](Index own) {
      if (own >= 0) sigma[static_cast<std::size_t>(own)] = std::max(sigma[static_cast<std::size_t>(own)], pairs->sigma);
    };
    for (const Index point : pairs->points) give(result.of_point[static_cast<std::size_t>(point)]);
    if (pairs->points.empty()) std::for_each(result.of_point.begin(), result.of_point.end(), give);
  }
  const double otherwise = std::min(1.0, scene_size(system));
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    const double diagonal = boxes[k].diagonal();
    result.length.push_back(diagonal > 0.0 ? diagonal : sigma[k] > 0.0 ? sigma[k] : otherwise);
  }
  return result;
}

double scene_size(const System& system) {
  Box box;
  for (std::size_t i = 0; i < system.num_points(); ++i) box.include(load(system.positions.data(), i));
  const double size = box.diagonal();
  return size > 0.0 ? size : 1.0;
}

}  // namespace tanor
