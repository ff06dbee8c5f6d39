#pragma once

#include <array>

#include <tanor/kinds.hpp>
#include <tanor/user_kernel.hpp>

namespace tanor::detail {

/// Turns a kind of force on single points into a user's force. Its definition runs on doubles and, for derivatives, on
/// Forward.
template <class Group>
ForceKernel kernel_of_definition(const Group& group) {
  ForceKernel kernel =
      make_force_kernel([group]<class T>(const std::array<T, 3>& r, const std::array<T, 3>& v, double t) {
        const typename KindOf<Group>::template Definition<T> now(group, ClockOf<T>{t});
        const std::array<TripleOf<T>, 1> place{{{r[0], r[1], r[2]}}}, velocity{{{v[0], v[1], v[2]}}};
        const TripleOf<T> force = now.force(place, velocity, T(0.0));
        return std::array<T, 3>{force.x, force.y, force.z};
      });
  kernel.depends_on_velocity = KindOf<Group>::reads_velocities(group);
  return kernel;
}

}  // namespace tanor::detail
