#pragma once

#include <algorithm>
#include <vector>

#include <tanor/kinds/constraint/formula.hpp>

namespace tanor::detail {

/// Members of one group of user constraints: one kernel, tuples of one size.
struct UserGroup {
  ConstraintKernel kernel;
  std::vector<Index> points;    ///< [member][p]
  std::vector<Index> rows;      ///< [member]
  std::vector<double> lengths;  ///< [member] m, of the neighbourhood
  Index first_block = 0;        ///< counted from the first one of the family; p blocks a member

  std::size_t size() const { return rows.size(); }
  std::size_t points_per_member() const { return static_cast<std::size_t>(kernel.num_points); }
};

struct UserKernels {
  using Group = UserConstraints;

  std::vector<UserGroup> groups;
  double t = 0.0;

  void set_time(double time) { t = time; }
  bool depends_on_time() const {
    return std::ranges::any_of(groups, [](const UserGroup& group) { return group.kernel.depends_on_time; });
  }
  bool gradients_are_constant() const { return false; }
  double scale(std::size_t k) const {
    auto group = groups.begin();
    for (; k >= group->size(); ++group) k -= group->size();
    return group->lengths[k];
  }
};

}  // namespace tanor::detail
