#include "simulation/taken_out.hpp"

#include <algorithm>
#include <string>
#include <type_traits>

#include "base/text.hpp"
#include "system/chosen_members.hpp"

namespace tanor::detail {

namespace {

/// Takes things out one by one.
class Remover {
 public:
  explicit Remover(const System& system) : given_(system), result_(system) {
    result_.supports.push_back({.name = "taken out"});
    if (result_.velocities.empty()) result_.velocities.resize(3 * system.num_points());
    for (Force& force : result_.forces)
      if (auto* pairs = std::get_if<PairForces>(&force)) pairs->points = points_of(system, *pairs);
  }

  void take(const Thing& thing) {
    if (thing.list == Thing::List::Supports)
      let_go(thing);
    else if (thing.list == Thing::List::Forces)
      erase(thing);
    else
      move_outside(thing);
  }
  System finish() { return std::move(result_); }

 private:
  void let_go(const Thing& thing) {
    const std::vector<Index>& points = given_.supports[thing.index].points;
    std::vector<Index> gone = thing.member ? std::vector{points[*thing.member]} : points;
    for (const Index point : gone) {
      if (!(given_.masses[static_cast<std::size_t>(point)] > 0.0))
        throw InputError("", "point " + text(point) + " is a support without mass and cannot be let go");
    }
    std::erase_if(result_.supports[thing.index].points,
                  [&](Index point) { return std::ranges::count(gone, point) > 0; });
  }

  /// Forces have no equations, so a member of theirs just goes.
  void erase(const Thing& thing) {
    std::visit(
        [&]<class Group>(Group& group) {
          if constexpr (requires { KindOf<Group>::members; }) {
            // Members that went before are no longer there.
            std::size_t gone = thing.member.value_or(0);
            for (const Thing& before : erased_)
              if (before.index == thing.index && *before.member < *thing.member) --gone;
            group = with_members_if(group, [gone](std::size_t k) { return k != gone; });
          }
        },
        result_.forces[thing.index]);
    erased_.push_back(thing);
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
  std::vector<Thing> erased_;
};

}  // namespace

System without(const System& system, std::span<const Thing> taken) {
  Remover remover(system);
  for (const Thing& thing : taken) remover.take(thing);
  return remover.finish();
}

}  // namespace tanor::detail
