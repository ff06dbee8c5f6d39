#pragma once

#include <vector>

#include <tanor/system.hpp>

#include "base/parallel.hpp"
#include "evaluate/by_point.hpp"
#include "evaluate/force_derivatives.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// One formula (kernel) and the points that it acts on: p points a member, in the inner order.
struct FormulaGroup {
  ForceKernel kernel;
  std::vector<Index> points;  // [member][p]

  FormulaGroup(const FormulaForce& formula, const Numbering& numbering);
  std::size_t points_per_member() const { return static_cast<std::size_t>(kernel.num_points); }
  std::size_t size() const { return points.size() / points_per_member(); }
};

/// Forces that a user gives by functions of r, v and t, on single points or on the points of tuples.
///
/// Each member writes the forces on its points; then each point gathers them in a fixed order.
class FormulaForces {
 public:
  FormulaForces() = default;
  FormulaForces(const Numbering& numbering, std::vector<FormulaGroup> groups);

  bool empty() const { return groups_.empty(); }
  bool depends_on_velocity() const { return depends_on_velocity_; }

  void evaluate(const Parallel& parallel, double t, const double* r, const double* v);
  /// visit(force of one member) for all that act on a point at the last `evaluate`, N.
  template <class Visit>
  void for_each_force_on(std::size_t point, const Visit& visit) const {
    for (const Index slot : slots_[point]) visit(load(force_.data(), slot));
  }

  void append_influences(std::vector<Influence>* list) const;
  /// Adds to the blocks of points; writes influences from `first_influence` on.
  void add_derivatives(const Parallel& parallel, double t, const double* r, const double* v,
                       std::size_t first_influence, const ForceDerivatives& to) const;

 private:
  struct Member;
  void add_member_derivatives(const FormulaGroup& group, const Member& member, const ForceDerivatives& to) const;

  std::size_t num_moving_ = 0;
  std::vector<FormulaGroup> groups_;
  std::vector<double> force_;  // group by group, 3 numbers a point
  ByPoint<Index> slots_;       // in force_
  bool depends_on_velocity_ = false;
};

}  // namespace tanor
