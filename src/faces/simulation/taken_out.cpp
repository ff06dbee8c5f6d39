#include "simulation/taken_out.hpp"

#include <cmath>
#include <string>
#include <type_traits>

#include <tanor/motion.hpp>

#include "base/text.hpp"
#include "system/chosen_members.hpp"

namespace tanor::detail {

namespace {

/// Takes constraints out one by one, and checks supports. Points that are let go and members of forces are just not
/// there in what is left, since they have no equations.
class Remover {
 public:
  Remover(const System& system, const System& left, double t) : given_(system), result_(system), t_(t) {
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
              functions[k] = functions[k](t_).value();
            } else if constexpr (std::is_same_v<std::remove_cvref_t<decltype(group.*field.value)>, VectorFunction>) {
              if (!(group.*field.value).is_constant())
                throw InputError("", "\"" + group.name + "\" moves by its " + std::string(field.name) +
                                         ", and nothing of it can be taken out");
            }
          });
          if constexpr (std::is_same_v<Group, UserConstraints>) {
            if (group.kernel.depends_on_time)
              throw InputError("", "\"" + group.name + "\" depends on time, and nothing of it can be taken out");
          }
          const std::size_t first_added = result_.num_points();
          add_outside(satisfy(group, k));
          auto added = static_cast<Index>(first_added);
          if constexpr (has_single_points<Group>) {
            list[k] = added;
          } else {
            for (Index& point : list[k]) point = added++;
          }
        },
        result_.constraints[thing.index]);
  }

  /// Returns places [3 points of the member] where a member is satisfied, next to those that are given: a start may
  /// have been corrected.
  template <class Group>
  std::vector<double> satisfy(const Group& group, std::size_t member) const {
    System alone;
    Group own = with_members(group, {member});
    const auto take_place = [&](Index& point) {
      const double* const place = given_.positions.data() + 3 * static_cast<std::size_t>(point);
      point = alone.add_point({.position = {place[0], place[1], place[2]}}).index;
    };
    auto& list = own.*KindOf<Group>::members;
    if constexpr (has_single_points<Group>) {
      take_place(list[0]);
    } else {
      for (Index& point : list[0]) take_place(point);
    }
    if (std::isnan(t_)) return alone.positions;
    alone.constraints.push_back(std::move(own));
    Simulation start(alone, {.start = StartMode::Project}, {}, t_);
    return start.outcome().ok() ? start.solution().positions : alone.positions;
  }

  /// Adds supports.
  void add_outside(const std::vector<double>& places) {
    for (std::size_t point = 0; point < places.size() / 3; ++point) {
      result_.supports.back().points.push_back(static_cast<Index>(result_.masses.size()));
      result_.masses.push_back(1.0);
    }
    result_.positions.insert(result_.positions.end(), places.begin(), places.end());
    result_.velocities.resize(result_.positions.size());
  }

  const System& given_;
  System result_;
  double t_;
};

}  // namespace

System without(const System& system, std::span<const Thing> taken, double t) {
  Remover remover(system, Things(system, taken).what_is_left(), t);
  for (const Thing& thing : taken) remover.take(thing);
  return remover.finish();
}

}  // namespace tanor::detail
