#pragma once

#include <utility>
#include <vector>

#include <tanor/dynamics.hpp>

#include "system/members.hpp"

namespace tanor::detail {

/// Finds the points that rods under tension hold between fixed supports, more strongly than K alone tells.
///
///   X---o---o---o---X    five rods in a line, as long together as the supports are apart
///
/// A dependence sum of omega_a K_a = 0 makes omega'phi = 0 a condition on velocities. If all rows in it are rods and
/// all omega_a have one sign, the condition is sum of omega_a |dv_a|^2/l_a = 0. Then none of these rods turns, and
/// since their tensions are in balance, they end at supports. So none of their points moves, now or later, although
/// K'w = -phi alone would allow it. The tension of such a rod is not determined (it would be infinite under any load
/// across it).
///
/// `dependences` are those at the initial positions. Returns the points in the user's order, increasing. Dependences in
/// which something moves contribute none.
std::vector<Index> find_prestress_rigid_points(const System& system, const std::vector<RowDependence>& dependences);

/// Returns the equations of the rods between such points and supports, increasing.
std::vector<std::size_t> list_prestress_rigid_equations(const System& system, const std::vector<Index>& points);

/// Turns points held rigid by prestress into supports.
inline void hold_rigid_points(System* system, std::vector<Index> points) {
  if (!points.empty()) system->supports.push_back({rigid_points_name, std::move(points), {}});
}

/// Makes a system by `make(system)`, and once more with the points that `find` lists in the last result as supports,
/// until there are none. Appends these points to `all` in the order in which they were found.
template <class Make, class Find>
auto make_without_rigid_points(System system, const Make& make, const Find& find, std::vector<Index>* all) {
  for (;;) {
    auto made = make(system);
    const std::vector<Index> rigid = find(*made);
    if (rigid.empty()) return made;
    all->insert(all->end(), rigid.begin(), rigid.end());
    hold_rigid_points(&system, rigid);
  }
}

}  // namespace tanor::detail
