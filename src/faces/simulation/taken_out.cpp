#include "simulation/taken_out.hpp"

#include <algorithm>
#include <numeric>
#include <string>
#include <tuple>

#include "base/text.hpp"
#include "system/members.hpp"

namespace tanor::detail {

namespace {

/// Calls visit(parameter) for each field of a group that has a number for each member.
template <class Group, class Visit>
void for_each_parameter(Group& group, const Visit& visit) {
  std::apply(
      [&](const auto&... field) {
        [[maybe_unused]] const auto see = [&](auto& value) {
          if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, Parameter>) visit(value);
        };
        (see(group.*field.value), ...);
      },
      KindOf<Group>::fields);
}

/// Takes things out one by one.
class Remover {
 public:
  explicit Remover(const System& system) : given_(system), result_(system) {
    result_.supports.push_back({.name = "taken out"});
    if (result_.velocities.empty()) result_.velocities.resize(3 * system.num_points());
    std::vector<Index> all(system.num_points());
    std::iota(all.begin(), all.end(), 0);
    for (Force& force : result_.forces)
      if (auto* pairs = std::get_if<PairForces>(&force); pairs && pairs->points.empty()) pairs->points = all;
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
            auto& list = group.*KindOf<Group>::members;
            // Members that went before are no longer there.
            auto k = static_cast<std::ptrdiff_t>(thing.member.value_or(0));
            for (const Thing& before : erased_)
              if (before.index == thing.index && *before.member < *thing.member) --k;
            for_each_parameter(group, [&](Parameter& parameter) {
              if (parameter.constants.size() == list.size()) parameter.constants.erase(parameter.constants.begin() + k);
            });
            list.erase(list.begin() + k);
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
          for_each_parameter(group, [&](Parameter& parameter) {
            if (parameter.functions.empty()) return;
            if (parameter.functions.size() == 1) parameter.functions.assign(count, parameter.functions[0]);
            parameter.functions[k] = parameter.functions[k](0.0).value();
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
