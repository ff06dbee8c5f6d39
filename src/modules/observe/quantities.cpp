#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "base/parallel.hpp"
#include "evaluate/definitions.hpp"
#include "evaluate/forces.hpp"
#include "observe/quantity.hpp"
#include "system/law_numbers.hpp"
#include "system/members.hpp"
#include "system/strengths.hpp"

namespace tanor::detail {

namespace {

using List = Thing::List;

/// The members of a thing that a quantity speaks of: one of them or all.
struct Members {
  Members(const Things& things, const Thing& thing)
      : whole{thing.list, thing.index},
        name(things.name(whole)),
        first(thing.member.value_or(0)),
        count(thing.member ? 1 : things.num_members(thing)),
        numbers(things.numbers(thing)) {
    const std::vector<bool> gone = things.find_absent(whole);
    for (std::size_t k = 0; k < count && !gone.empty(); ++k)
      if (gone[first + k]) absent.push_back(k);
  }

  Thing whole;
  std::string name;
  std::size_t first, count;
  std::span<const std::size_t> numbers;
  std::vector<std::size_t> absent;
};

/// Returns a quantity of members, whose numbers `evaluate` writes.
template <class Evaluate>
Quantity of_members(const Members& members, Dimension dimension, Needs needs, Evaluate evaluate,
                    std::vector<std::string> parts = {}) {
  Quantity result{dimension, needs, evaluate, std::move(parts), members.count};
  result.name_member = [members](std::size_t k) {
    const std::size_t member = members.first + k;
    return members.name + "[" + std::to_string(members.numbers.empty() ? member : members.numbers[member]) + "]";
  };
  result.thing = [members](std::size_t k) { return Thing{members.whole.list, members.whole.index, members.first + k}; };
  result.absent = members.absent;
  return result;
}

// ---- scalars of constraints and springs ----

/// Reads the multipliers of constraints, times a factor: -1 gives the tension of rods and of ropes on pulleys. They are
/// 0 for members that were taken out.
struct Multipliers {
  Multipliers(const Things& things, const Members& members, double by)
      : factor(by),
        rows_per_member(shape_of(things.system().constraints[members.whole.index]).rows_per_member),
        first(things.first_row(members.whole.index) + members.first * rows_per_member),
        count(members.count * rows_per_member) {}
  void operator()(const ObservedInstant& at, double* values) const {
    const double *const own = at.multipliers.data() + first, by = factor;
    for (std::size_t k = 0; k < count; ++k) values[k] = by * own[k] + 0.0;  // no -0
  }

  double factor;
  std::size_t rows_per_member, first, count;
};

Quantity multipliers_of(const Things& things, const Thing& thing, Dimension dimension, double factor) {
  const Members members(things, thing);
  const Multipliers read(things, members, factor);
  return of_members(members, dimension, {.multipliers = true}, read,
                    read.rows_per_member == 2 ? std::vector<std::string>{"0", "1"} : std::vector<std::string>{});
}

/// Returns the pull of springs or bonds between two points: slope(instant, pair, r_j - r_i, number of the member).
template <class Slope>
Quantity pulls_of(const Members& members, const std::vector<std::array<Index, 2>>& all, Slope slope) {
  const auto evaluate = [=](const ObservedInstant& at, double* values) {
    const double* const r = at.positions.data();
    for (std::size_t k = 0; k < members.count; ++k) {
      const std::array<Index, 2>& pair = all[members.first + k];
      values[k] = slope(at, pair, load(r, pair[1]) - load(r, pair[0]), k);
    }
  };
  return of_members(members, Dimension::Forces, {.places = true}, evaluate);
}

/// The pull of a spring is -dU/dL and what damping adds.
Quantity pulls_of_springs(const Things& things, const Thing& thing, const Springs& springs) {
  const Members members(things, thing);
  const Parameter& given = springs.rest_length;
  const double* const positions = things.system().positions.data();
  std::vector<double> rest;
  for (std::size_t k = members.first; k < members.first + members.count; ++k) {
    const auto [i, j] = springs.pairs[k];
    rest.push_back(given.is_initial() ? norm(load(positions, j) - load(positions, i))
                                      : given.constants[given.constants.size() == 1 ? 0 : k]);
  }
  const auto slope = [rest, stiffness = springs.stiffness, damping = springs.damping](
                         const ObservedInstant& at, const std::array<Index, 2>& pair, const Vec3& a, std::size_t k) {
    const double length = norm(a), *const v = at.velocities.data();
    return stiffness * (length - rest[k]) + damping * dot(a, load(v, pair[1]) - load(v, pair[0])) / length;
  };
  return pulls_of(members, springs.pairs, slope);
}

/// The pull of a bond is -dU/dL, from the definition of its law.
Quantity pulls_of_bonds(const Things& things, const Thing& thing, const Bonds& bonds) {
  using Slope = Forward<1>;
  const Members members(things, thing);
  std::vector<decltype(law_numbers_of(things.system(), bonds, 0))> numbers;
  for (std::size_t k = 0; k < members.count; ++k)
    numbers.push_back(law_numbers_of(things.system(), bonds, members.first + k));
  return pulls_of(members, bonds.pairs, [=](const auto&, const auto&, const Vec3& a, std::size_t k) {
    std::array<Slope, KindOf<Bonds>::most_numbers> constants;
    std::ranges::copy(numbers[k], constants.begin());
    const std::array<TripleOf<Slope>, 2> r{TripleOf<Slope>{}, {Slope::variable(norm(a), 0), 0.0, 0.0}};
    return KindOf<Bonds>::Definition<Slope>(bonds).energy(r, constants).d[0];
  });
}

Quantity make_tension(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "rods, ropes, pulleys, springs or bonds");
  const Argument& argument = arguments[0];
  const Thing thing = things.find(argument, {List::Constraints, List::Forces});
  if (thing.list == List::Constraints) {
    const Constraint& constraint = things.system().constraints[thing.index];
    if (has_tension(constraint)) return multipliers_of(things, thing, Dimension::Forces, -1.0);
    argument.fail("'" + things.name(thing) + "' is a " + std::string(kind_name(constraint)) +
                  ", which has no tension; force(" + things.name(thing) + ") is its force");
  }
  const Force& force = things.system().forces[thing.index];
  if (const auto* springs = std::get_if<Springs>(&force)) return pulls_of_springs(things, thing, *springs);
  if (const auto* bonds = std::get_if<Bonds>(&force)) return pulls_of_bonds(things, thing, *bonds);
  argument.fail("'" + things.name(thing) + "' has no tension; rods, ropes, pulleys, springs and bonds have one");
}

/// The pull over that at which members break.
Quantity make_utilisation(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "rods or ropes");
  const Thing thing = things.find(arguments[0], {List::Constraints});
  const std::span<const double> given = strengths_of(things.system().constraints[thing.index]);
  const std::vector<double> strength(given.begin(), given.end());
  if (strength.empty()) arguments[0].fail("'" + things.name(thing) + "' has no breaks_at");
  Quantity result = multipliers_of(things, thing, Dimension::None, -1.0);
  result.evaluate = [pulls = result.evaluate, strength, first = thing.member.value_or(0), count = result.num_members](
                        const ObservedInstant& at, double* values) {
    pulls(at, values);
    for (std::size_t k = 0; k < count; ++k) values[k] /= strength[strength.size() == 1 ? 0 : first + k];
  };
  return result;
}

Quantity make_multiplier(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "constraints");
  return multipliers_of(things, things.find(arguments[0], {List::Constraints}), Dimension::None, 1.0);
}

// ---- vectors of points ----

std::vector<std::string> xyz() {
  return {"x", "y", "z"};
}

using ArrayMember = std::span<const double> ObservedInstant::*;

/// Returns vectors of some points: positions, velocities, loads, …
Quantity vectors_of(const Things& things, std::vector<Index> points, Dimension dimension, ArrayMember array,
                    Needs needs) {
  Quantity result{dimension, needs, {}, xyz(), points.size()};
  result.name_member = [things, points](std::size_t k) { return things.name_point(points[k]); };
  result.evaluate = [points = std::move(points), array](const ObservedInstant& at, double* values) {
    for (std::size_t k = 0; k < points.size(); ++k)
      store(values, k, (at.*array).empty() ? Vec3{} : load((at.*array).data(), points[k]));
  };
  return result;
}

template <Dimension dimension, ArrayMember array, bool needs_forces>
Quantity make_of_points(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "points");
  return vectors_of(things, things.points(arguments[0]), dimension, array, {.places = true, .forces = needs_forces});
}

std::vector<Index> points_of_support(const Things& things, const Thing& thing) {
  const std::vector<Index>& all = things.system().supports[thing.index].points;
  return thing.member ? std::vector{all[*thing.member]} : all;
}

Quantity make_load(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "supports");
  const Thing thing = things.find(arguments[0], {List::Supports});
  Quantity result = vectors_of(things, points_of_support(things, thing), Dimension::Forces,
                               &ObservedInstant::support_forces, {.forces = true});
  result.is_sum = true;
  result.absent = Members(things, thing).absent;
  result.thing = [thing](std::size_t k) { return Thing{List::Supports, thing.index, thing.member.value_or(0) + k}; };
  return result;
}

Quantity make_friction(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "points");
  things.require_forces(arguments);
  return vectors_of(things, things.points(arguments[0]), Dimension::Forces, &ObservedInstant::friction,
                    {.friction = true});
}

// ---- forces of constraints, and moments ----

/// The forces with which members of constraints act on their points, from their definitions.
class ConstraintForces {
 public:
  ConstraintForces(const Things& things, const Members& members) : read_(things, members, 1.0) {
    system_.constraints = {things.system().constraints[members.whole.index]};
    const GroupShape shape = shape_of(system_.constraints[0]);
    rows_.resize(shape.members * shape.rows_per_member);
    first_row_ = members.first * shape.rows_per_member;
    definitions_.emplace(system_, 0.0, things.system().positions.data());
  }
  ConstraintForces(const ConstraintForces&) = delete;
  ConstraintForces& operator=(const ConstraintForces&) = delete;

  /// Calls use(member, point, force) with the parts of the forces.
  template <class Use>
  void for_each(const ObservedInstant& at, const Use& use) {
    read_(at, rows_.data() + first_row_);
    definitions_->for_each_reaction(at.time, at.positions, rows_, [&](std::size_t row, Index point, const Vec3& force) {
      if (row >= first_row_ && row < first_row_ + read_.count)
        use((row - first_row_) / read_.rows_per_member, point, force);
    });
  }

 private:
  Multipliers read_;
  System system_;  // of this group alone
  std::optional<Definitions> definitions_;
  std::size_t first_row_ = 0;
  std::vector<double> rows_;  // 0 for other members
};

/// The sum of the forces with which each member acts on its points. What it is fixed to feels the opposite.
Quantity make_force(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "constraints");
  const Members members(things, things.find(arguments[0], {List::Constraints}));
  const auto forces = std::make_shared<ConstraintForces>(things, members);
  const auto evaluate = [forces, count = members.count](const ObservedInstant& at, double* values) {
    std::fill_n(values, 3 * count, 0.0);
    forces->for_each(at, [&](std::size_t k, Index, const Vec3& force) { add_to(values, k, force); });
  };
  Quantity result = of_members(members, Dimension::Forces, {.forces = true}, evaluate, xyz());
  result.is_sum = true;
  return result;
}

/// The moment about an axis of the forces with which each member acts on the mechanism: the torque of a motor.
Quantity make_moment(const Things& things, const Arguments& arguments) {
  if (arguments.size() == 1)
    throw TextFault{arguments.place, "a moment needs an axis: moment(" + arguments[0].text + ", z, [0, 0, 0])"};
  arguments.require(2, 3, "supports or constraints, axis, about");
  const Vec3 axis = things.axis(arguments[1]);
  const Thing thing = things.find(arguments[0], {List::Supports, List::Constraints});
  const bool is_load = thing.list == List::Supports;
  const Members members(things, thing);
  const auto forces = is_load ? nullptr : std::make_shared<ConstraintForces>(things, members);
  const std::vector<Index> points = is_load ? points_of_support(things, thing) : std::vector<Index>{};
  const std::optional<Vec3> place = arguments.size() < 3 ? Vec3{} : things.vector(arguments[2]);
  const Index about_point = place ? 0 : things.point(arguments[2]);
  const auto evaluate = [=, count = members.count](const ObservedInstant& at, double* values) {
    const Vec3 about = place ? *place : load(at.positions.data(), about_point);
    const auto add = [&](std::size_t k, Index point, const Vec3& force) {
      values[k] += dot(axis, cross(load(at.positions.data(), point) - about, force));
    };
    std::fill_n(values, count, 0.0);
    if (!is_load) forces->for_each(at, add);
    for (std::size_t k = 0; k < points.size(); ++k) add(k, points[k], -1.0 * load(at.support_forces.data(), points[k]));
  };
  Quantity result = of_members(members, Dimension::Moment, {.forces = true}, evaluate);
  result.is_sum = true;
  return result;
}

// ---- geometry ----

Quantity make_distance(const Things& things, const Arguments& arguments) {
  arguments.require(2, 2, "point, point");
  const Index i = things.point(arguments[0]), j = things.point(arguments[1]);
  if (i == j) arguments[1].fail("a distance is that of two different points");
  return one_number(Dimension::Length, {.places = true}, [=](const ObservedInstant& at) {
    return norm(load(at.positions.data(), j) - load(at.positions.data(), i));
  });
}

Quantity make_angle(const Things& things, const Arguments& arguments) {
  arguments.require(3, 3, "point, corner, point");
  const Index i = things.point(arguments[0]), corner = things.point(arguments[1]), j = things.point(arguments[2]);
  if (i == corner || j == corner || i == j) arguments[2].fail("an angle is that of three different points");
  return one_number(Dimension::Angle, {.places = true}, [=](const ObservedInstant& at) {
    const Vec3 here = load(at.positions.data(), corner);
    const Vec3 a = load(at.positions.data(), i) - here, b = load(at.positions.data(), j) - here;
    return std::atan2(norm(cross(a, b)), dot(a, b));
  });
}

// ---- energies ----

/// The potential energy of what is left of one force.
struct PotentialOfForce {
  PotentialOfForce(const Things& things, std::size_t force) : system(things.what_is_left()), numbering(number(system)) {
    system.forces = {system.forces[force]};
    forces.emplace(system, numbering);
    r.resize(system.positions.size());
  }
  double evaluate(const ObservedInstant& at) {
    numbering.gather_points(at.positions, r);
    forces->set_time(at.time);
    return forces->potential(Parallel(1), at.time, r.data());
  }

  System system;
  Numbering numbering;
  std::optional<Forces> forces;
  std::vector<double> r;
};

Quantity make_potential(const Things& things, const Arguments& arguments) {
  arguments.require(0, 1, "force");
  things.require_forces(arguments);
  if (arguments.size() == 0)
    return one_number(Dimension::Energy, {.energy = true}, [](const ObservedInstant& at) { return at.potential; });
  const Thing thing = things.find(arguments[0], {List::Forces});
  const auto one = std::make_shared<PotentialOfForce>(things, thing.index);
  return one_number(Dimension::Energy, {.places = true},
                    [one](const ObservedInstant& at) { return one->evaluate(at); });
}

/// Returns the kinetic energy, and with it the potential one or not.
template <bool has_potential>
Quantity make_energy(const Things& things, const Arguments& arguments) {
  arguments.require(0, 0, "");
  if (has_potential) things.require_forces(arguments);
  return one_number(Dimension::Energy, {.energy = true},
                    [](const ObservedInstant& at) { return has_potential ? at.kinetic + at.potential : at.kinetic; });
}

}  // namespace

bool has_tension(const Constraint& group) {
  return std::holds_alternative<Rods>(group) || std::holds_alternative<Ropes>(group) ||
         std::holds_alternative<Pulleys>(group);
}

bool has_tension(const Force& force) {
  return std::holds_alternative<Springs>(force) || std::holds_alternative<Bonds>(force);
}

std::span<const QuantityKind> quantity_kinds() {
  static constexpr QuantityKind kinds[] = {
      {"tension", "rods, ropes, pulleys, springs or bonds",
       "pull of a rod or rope, of the rope of a pulley, of a spring or bond", make_tension},
      {"utilisation", "rods or ropes", "pull over breaks_at", make_utilisation},
      {"force", "constraints", "sum of the forces of guides, pulleys and other constraints on their points",
       make_force},
      {"moment", "supports or constraints, axis, about",
       "moment about an axis of the forces with which they act on the mechanism: the torque of a motor", make_moment},
      {"load", "supports", "force that supports carry, added up", make_load},
      {"multiplier", "constraints", "multipliers lambda", make_multiplier},
      {"reaction", "points", "force of all constraints on points",
       make_of_points<Dimension::Forces, &ObservedInstant::reactions, true>},
      {"friction", "points", "friction on points", make_friction},
      {"position", "points", "positions", make_of_points<Dimension::Length, &ObservedInstant::positions, false>},
      {"velocity", "points", "velocities", make_of_points<Dimension::Velocity, &ObservedInstant::velocities, false>},
      {"acceleration", "points", "accelerations",
       make_of_points<Dimension::Acceleration, &ObservedInstant::accelerations, true>},
      {"distance", "point, point", "distance of two points", make_distance},
      {"angle", "point, corner, point", "angle at a corner, 0 to pi", make_angle},
      {"energy", "", "kinetic and potential energy", make_energy<true>},
      {"kinetic", "", "kinetic energy", make_energy<false>},
      {"potential", "force", "potential energy, of one force or of all", make_potential},
      {"temperature", "", "temperature of all moving points", make_temperature},
      {"pressure", "", "pressure of a periodic sample", make_pressure},
      {"virial", "", "virial tensor of a periodic sample, r (x) F", make_virial},
  };
  return kinds;
}

}  // namespace tanor::detail
