#include "system/neighbourhoods.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <variant>

#include "base/disjoint_sets.hpp"
#include "base/vec3.hpp"
#include "system/members.hpp"

namespace tanor::detail {

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

/// Sets of points that grow as they are joined; supports stay outside.
class Joining {
 public:
  explicit Joining(const System& system) : root_(system.num_points()) {
    std::iota(root_.begin(), root_.end(), 0);
    for (const Support& support : system.supports) {
      for (const Index point : support.points) root_[static_cast<std::size_t>(point)] = -1;
    }
  }
  bool is_support(Index point) const { return root_[static_cast<std::size_t>(point)] < 0; }
  /// Returns the root of a point, -1 for a support.
  Index find(Index point) { return is_support(point) ? -1 : find_root(root_.data(), point); }
  void join(std::span<const Index> points) {
    Index first = -1;
    for (const Index point : points) {
      if (is_support(point)) continue;
      if (first < 0) first = point;
      join_sets(root_.data(), first, point);
    }
  }

 private:
  std::vector<Index> root_;
};

/// Calls visit(points) for all that joins points.
template <class Visit>
void for_each_tie(const System& system, const Visit& visit) {
  for_each_member(system, [&](std::span<const Index> points, int) { visit(points); });
  const auto visit_members = [&]<class Group>(const Group& group) {
    if constexpr (requires { KindOf<Group>::tied_points(group); }) {
      const std::vector<Index> points = KindOf<Group>::tied_points(group);
      visit(std::span<const Index>(points));
    } else if constexpr (requires { KindOf<Group>::members; }) {
      for (std::size_t k = 0; k < num_members(group) && !has_single_points<Group>; ++k) visit(member_points(group, k));
    }
  };
  for (const Force& force : system.forces) std::visit(visit_members, force);
  for (const Coordinates& coordinates : system.coordinates) std::visit(visit_members, coordinates);
}

Vec3 value_at(const VectorFunction& function, double t) {
  const auto r = function(t);
  return {r[0].value(), r[1].value(), r[2].value()};
}
Vec3 value_at(const Vector3& constant, double) {
  return make_vec3(constant);
}
template <class Value>
Vec3 value_at(const Value&, double) {
  return {};
}

/// Calls visit(point, centre) for all centres of groups, which are their fields of role Center.
template <class Visit>
void for_each_centre(const System& system, double t, const Visit& visit) {
  const auto visit_all = [&]<class Group>(const Group& group) {
    for_each_field<Group>([&](const auto& field) {
      if (field.data.role != FieldRole::Center) return;
      const Vec3 centre = value_at(group.*field.value, t);
      const auto point = static_cast<std::size_t>(field.data.point);
      for (std::size_t k = 0; k < num_members(group); ++k) visit(member_points(group, k)[point], centre);
    });
  };
  for (const Coordinates& coordinates : system.coordinates) std::visit(visit_all, coordinates);
  for (const Constraint& constraint : system.constraints) std::visit(visit_all, constraint);
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
    if (pairs == nullptr || (pairs->law != PairLaw::Wca && pairs->law != PairLaw::Lj)) continue;
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

}  // namespace tanor::detail
