#pragma once

#include <span>
#include <utility>
#include <vector>

#include <tanor/system.hpp>

#include "base/groups.hpp"
#include "base/vec3.hpp"

namespace tanor::detail {

/// Forces that the members of a family write into slots of their own, N. Each point then gathers what acts on it in a
/// fixed order, so any number of threads gives the same bits.
class ForcesOnPoints {
 public:
  ForcesOnPoints() = default;
  /// `slots` has pairs of a point and a slot, or ~slot if the opposite of that force acts on the point.
  ForcesOnPoints(std::size_t num_points, std::size_t num_slots, const std::vector<std::pair<Index, Index>>& slots)
      : force_(3 * num_slots), slots_(num_points, slots) {}
  /// Gives slot k to points[k] alone.
  ForcesOnPoints(std::size_t num_points, std::span<const Index> points)
      : ForcesOnPoints(num_points, points.size(), number(points)) {}

  double* slot(std::size_t k) { return force_.data() + 3 * k; }
  Vec3 operator[](std::size_t k) const { return load(force_.data(), k); }
  /// Returns the slots of a point.
  std::span<const Index> slots_of(std::size_t point) const { return slots_[point]; }
  /// Calls visit(force) for all forces that act on a point, N.
  template <class Visit>
  void for_each_on(std::size_t point, const Visit& visit) const {
    for (const Index k : slots_[point]) visit(k >= 0 ? load(force_.data(), k) : -load(force_.data(), ~k));
  }

 private:
  static std::vector<std::pair<Index, Index>> number(std::span<const Index> points) {
    std::vector<std::pair<Index, Index>> slots;
    for (const Index point : points) slots.push_back({point, static_cast<Index>(slots.size())});
    return slots;
  }

  std::vector<double> force_;  // [slot]
  Groups<Index> slots_;
};

}  // namespace tanor::detail
