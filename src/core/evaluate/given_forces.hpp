#pragma once

#include <vector>

#include "base/groups.hpp"
#include "base/vec3.hpp"
#include "kinds/tables.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Forces on points that depend on nothing but the time.
class GivenForces {
 public:
  GivenForces() = default;
  GivenForces(const Numbering& numbering, const std::vector<ConstantForce>& forces) {
    std::vector<std::pair<Index, Index>> slots;
    for (const ConstantForce& given : forces) {
      const auto slot = static_cast<Index>(table_.add(given.force));
      is_constant_.push_back(given.force.is_constant());
      for (const Index point : given.points) slots.push_back({numbering.inner_point[point], slot});
    }
    slots_ = {numbering.num_points(), slots};
  }

  bool empty() const { return slots_.empty(); }
  bool depend_on_time() const { return !table_.is_constant(); }
  void set_time(double t) { table_.set_time(t); }

  /// Calls visit(force, is constant) for all forces that act on a point, N.
  template <class Visit>
  void for_each_force_on(std::size_t point, const Visit& visit) const {
    for (const Index slot : slots_[point]) visit(table_[slot].value, is_constant_[slot] != 0);
  }

 private:
  VectorTable<AsGiven> table_;
  std::vector<char> is_constant_;  // [slot]
  Groups<Index> slots_;            // in table_
};

/// The numbers of the drag -c1 v - c2 |v| v of one entry on a point, N s/m and N s^2/m^2.
struct DragNumbers {
  double linear, quadratic;

  double over_speed(double speed) const { return linear + quadratic * speed; }
};

}  // namespace tanor::detail
