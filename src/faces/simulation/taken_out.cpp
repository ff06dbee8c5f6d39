#include "simulation/taken_out.hpp"

#include <string>
#include <type_traits>

#include "base/text.hpp"
#include "system/chosen_members.hpp"

namespace tanor::detail {

namespace {

/// Makes the numbers of a member, which may be functions of time that end, constant.
template <class Group>
void freeze(Group& group, std::size_t member, double t) {
  const std::size_t count = num_members(group);
  for_each_field<Group>([&](const auto& field) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(group.*field.value)>, Parameter>) {
      std::vector<ScalarFunction>& functions = (group.*field.value).functions;
      if (functions.empty()) return;
      if (functions.size() == 1) functions.assign(count, functions[0]);
      functions[member] = functions[member](t).value();
    }
  });
}

}  // namespace

void check_let_go(const System& system, const Thing& thing) {
  if (thing.list != Thing::List::Supports) return;
  const std::vector<Index>& points = system.supports[thing.index].points;
  for (const Index point : thing.member ? std::vector{points[*thing.member]} : points) {
    if (!(system.masses[static_cast<std::size_t>(point)] > 0.0))
      throw InputError("", "point " + text(point) + " is a support without mass and cannot be let go");
  }
}

System without(const System& system, std::span<const Thing> taken, double t) {
  System left = Things(system, taken).what_is_left(), result = system;
  result.forces = std::move(left.forces);
  result.supports = std::move(left.supports);
  if (result.velocities.empty()) result.velocities.resize(result.positions.size());
  for (Force& force : result.forces)
    if (auto* pairs = std::get_if<PairForces>(&force)) pairs->points = points_of(system, *pairs);
  Support outside{.name = outside_name};
  const auto move_outside = [&](Index& point) {
    const std::vector<double> place = rows_of(system.positions, std::vector{point}, 3);
    point = static_cast<Index>(result.num_points());
    outside.points.push_back(point);
    result.masses.push_back(1.0);
    result.positions.insert(result.positions.end(), place.begin(), place.end());
    result.velocities.resize(result.positions.size());
  };
  for (const Thing& thing : taken) {
    if (thing.list != Thing::List::Constraints) continue;
    std::visit(
        [&]<class Group>(Group& group) {
          freeze(group, *thing.member, t);
          auto& own = (group.*KindOf<Group>::members)[*thing.member];
          if constexpr (has_single_points<Group>)
            move_outside(own);
          else
            for (Index& point : own) move_outside(point);
        },
        result.constraints[thing.index]);
  }
  if (!outside.points.empty()) result.supports.push_back(std::move(outside));
  return result;
}

}  // namespace tanor::detail
