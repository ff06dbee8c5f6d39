#include "system/loops.hpp"

#include <numeric>
#include <span>
#include <variant>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "system/members.hpp"

namespace tanor::detail {

bool closes_loops(const System& system) {
  // Points of one tree have one root. All supports and centers are one place.
  const auto ground = static_cast<Index>(system.num_points());
  std::vector<Index> parent(system.num_points() + 1), place(system.num_points() + 1);
  std::iota(parent.begin(), parent.end(), 0);
  std::iota(place.begin(), place.end(), 0);
  for (const Support& support : system.supports)
    for (const Index point : support.points) place[static_cast<std::size_t>(point)] = ground;
  const auto joins_what_is_joined = [&](Index point, Index other) {
    const Index i = place[static_cast<std::size_t>(point)], j = place[static_cast<std::size_t>(other)];
    if (find_root(parent.data(), i) == find_root(parent.data(), j)) return i != j;  // between supports alone it is idle
    join_sets(parent.data(), i, j);
    return false;
  };
  const auto closes = [&]<class Group>(const Group& group) {
    if constexpr (requires { KindOf<Group>::is_distance; }) {
      for (std::size_t k = 0; k < num_members(group); ++k) {
        const std::span<const Index> points = member_points(group, k);
        if (joins_what_is_joined(points[0], points.size() == 2 ? points[1] : ground)) return true;
      }
      return false;
    }
    return true;
  };
  for (const Constraint& constraint : system.constraints) {
    if (std::visit(closes, constraint)) return true;
  }
  return false;
}

}  // namespace tanor::detail
