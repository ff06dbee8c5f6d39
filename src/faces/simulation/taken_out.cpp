#include "simulation/taken_out.hpp"

#include <string>
#include <type_traits>

#include "base/text.hpp"
#include "system/chosen_members.hpp"

namespace tanor::detail {

namespace {

/// Takes constraints out one by one, and checks supports. Points that are let go and members of forces are just not
/// there in what is left, since they have no equations.
class Remover {
 public:
  Remover(const System& system, const System& left) : given_(system), result_(system) {
    result_.forces = left.forces;
    result_.supports = left.supports;
    result_.supports.push_back({.name = "taken out"});
    if (result_.velocities.empty()) result_.velocities.resize(3 * system.num_points());
    for (Force& force : result_.forces)
      if (auto* pairs = std::get_if<PairForces>(&force)) pairs->points = points_of(system, *pairs);
  }

  void take(const Thing& thing) {
    if (thing.list == Thing::List::Supports)
      check_let_go(thing);
    else if (thing.list == Thing::List::Constraints)
      move_outside(thing);
  }
  System finish() { return std::move(result_); }

 private:
  void check_let_go(const Thing& thing) const {
    const std::vector<Index>& points = given_.supports[thing.index].points;
    for (const Index point : thing.member ? std::vector{points[*thing.member]} : points) {
      if (!(given_.masses[static_cast<std::size_t>(point)] > 0.0))
        throw InputError("", "point " + text(point) + " is a support without mass and cannot be let go");
    }
  }

  void move_outside(const Thing& thing) {
    std::visit(
        [&]<class Group>(Group& group) {
          auto& list = group.*KindOf<Group>::members;
          const std::size_t count = list.size(), k = *thing.member;
          for_each_field<Group>([&](const auto& field) {
            if constexpr (std::is_same_v<std::remove_cvref_t<decltype(group.*field.value)>, Parameter>) {
              std::vector<ScalarFunction>& functions = (group.*field.value).functions;
              if (functions.empty()) return;
              if (functions.size() == 1) functions.assign(count, functions[0]);
              functions[k] = functions[k](0.0).value();
            }
          });
          if constexpr (has_single_points<Group>) {
            list[k] = add_outside(list[k]);
          } else {
            for (Index& point : list[k]) point = add_outside(point);
          }
        },
        result_.constraints[thing.index]);
  }

  /// Adds a support where a point started, so that what joins it is satisfied.
  Index add_outside(Index point) {
    const auto first = 3 * static_cast<std::size_t>(point);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      result_.positions.push_back(given_.positions[first + axis]);
      result_.velocities.push_back(0.0);
    }
    result_.masses.push_back(1.0);
    const auto added = static_cast<Index>(result_.num_points() - 1);
    result_.supports.back().points.push_back(added);
    return added;
  }

  const System& given_;
  System result_;
};

}  // namespace

System without(const System& system, std::span<const Thing> taken) {
  Remover remover(system, Things(system, taken).what_is_left());
  for (const Thing& thing : taken) remover.take(thing);
  return remover.finish();
}

}  // namespace tanor::detail
