#pragma once

#include <vector>

#include <tanor/system.hpp>

#include "base/parallel.hpp"
#include "evaluate/force_derivatives.hpp"
#include "evaluate/forces_on_points.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// One formula (kernel) and the points that it acts on: p points a member, in the inner order.
struct FormulaGroup {
  ForceKernel kernel;
  std::vector<Index> points;  // [member][p]

  FormulaGroup(const FormulaForce& formula, const Numbering& numbering);
  std::size_t points_per_member() const { return static_cast<std::size_t>(kernel.num_points); }
  std::size_t size() const { return points.size() / points_per_member(); }
};

/// Forces that a user gives by functions of r, v and t, on single points or on the points of tuples.
class FormulaForces {
 public:
  FormulaForces() = default;
  FormulaForces(const Numbering& numbering, std::vector<FormulaGroup> groups);

  bool empty() const { return groups_.empty(); }
  bool depends_on_velocity() const { return depends_on_velocity_; }

  void evaluate(const Parallel& parallel, double t, const double* r, const double* v);
  /// Returns the forces of the last `evaluate`.
  const ForcesOnPoints& on_points() const { return on_points_; }

  void append_influences(std::vector<Influence>* list) const;
  /// Adds derivatives to the blocks of points and writes those of influences from `first_influence` on.
  void add_derivatives(const Parallel& parallel, double t, const double* r, const double* v,
                       std::size_t first_influence, const ForceDerivatives& to) const;

 private:
  struct Member;
  void add_member_derivatives(const FormulaGroup& group, const Member& member, const ForceDerivatives& to) const;

  std::size_t num_moving_ = 0;
  std::vector<FormulaGroup> groups_;
  ForcesOnPoints on_points_;  // group by group, point by point of each member
  bool depends_on_velocity_ = false;
};

}  // namespace tanor::detail
