#pragma once

#include <utility>
#include <vector>

#include <tanor/dynamics.hpp>

namespace tanor {

/// Points that rods under tension hold between fixed supports: K says less about them than the rods do.
///
///   X---o---o---o---X    five rods in a line, as long together as the supports are apart
///
/// A dependence sum of omega_a K_a = 0 makes omega'phi = 0 a condition on velocities. Where all omega_a are rods and of
/// one sign that is sum of omega_a |dv_a|^2/l_a = 0: no rod of it turns, and since their tensions are in balance, they
/// end at supports. So no point of it moves, now or later, though K'w = -phi alone would let it; what a rod carries
/// there is not determined (it would be infinite under any load across it).
///
/// `dependences`: at the initial positions. Users' order, increasing; empty where something of it moves.
std::vector<Index> find_prestress_rigid_points(const System& system, const std::vector<RowDependence>& dependences);

/// They stand: they become supports.
inline void hold_rigid_points(System* system, std::vector<Index> points) {
  if (!points.empty()) system->supports.push_back({"points held rigid by prestress", std::move(points), {}});
}

/// What becomes of a system that has such points: `make(system)` once more with those that `find` says of the last one
/// made as supports, until there are none. `all`: these, in the order in which they were found.
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

}  // namespace tanor
