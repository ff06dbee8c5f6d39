#include <algorithm>
#include <cmath>
#include <functional>

#include "base/parallel.hpp"
#include "evaluate/definitions.hpp"
#include "evaluate/forces.hpp"
#include "observe/quantity.hpp"
#include "system/law_numbers.hpp"
#include "system/members.hpp"

namespace tanor::detail {

namespace {

using List = Thing::List;
constexpr List constraints_or_forces[] = {List::Constraints, List::Forces};
constexpr List constraints_alone[] = {List::Constraints};
constexpr List forces_alone[] = {List::Forces};
constexpr List supports_alone[] = {List::Supports};
constexpr List supports_or_constraints[] = {List::Supports, List::Constraints};

/// The members of a thing that a quantity speaks of: one of them or all.
class Members : public Quantity {
 public:
  Members(const Things& things, const Thing& thing)
      : thing_(thing),
        name_(things.name({thing.list, thing.index})),
        first_(thing.member.value_or(0)),
        count_(thing.member ? 1 : things.num_members(thing)),
        numbers_(things.numbers(thing)) {
    for (std::size_t k = 0; k < count_; ++k)
      if (things.is_absent({thing.list, thing.index, first_ + k})) absent_.push_back(k);
  }

  std::size_t num_members() const override { return count_; }
  std::string name_member(std::size_t k) const override {
    return name_ + "[" + std::to_string(numbers_.empty() ? first_ + k : numbers_[first_ + k]) + "]";
  }
  bool is_gone() const override { return count_ > 0 && absent_.size() == count_; }
  std::optional<Thing> thing(std::size_t k) const override { return Thing{thing_.list, thing_.index, first_ + k}; }

 protected:
  /// Members that were taken out have no number.
  void forget_absent(std::size_t num_parts, double* values) const {
    for (const std::size_t k : absent_)
      std::fill_n(values + k * num_parts, num_parts, std::numeric_limits<double>::quiet_NaN());
  }

  Thing thing_;
  std::string name_;
  std::size_t first_, count_;

 private:
  std::span<const std::size_t> numbers_;
  std::vector<std::size_t> absent_;
};

// ---- scalars of constraints and springs ----

/// The multipliers of constraints, times a factor: -1 gives the tension of rods and of ropes on pulleys.
class Multipliers final : public Members {
 public:
  Multipliers(const Things& things, const Thing& thing, double factor) : Members(things, thing), factor_(factor) {
    for (std::size_t group = 0; group < thing.index; ++group) {
      const GroupShape shape = shape_of(things.system().constraints[group]);
      first_row_ += shape.members * shape.rows_per_member;
    }
    rows_per_member_ = shape_of(things.system().constraints[thing.index]).rows_per_member;
    first_row_ += first_ * rows_per_member_;
  }
  std::vector<std::string> parts() const override {
    return rows_per_member_ == 2 ? std::vector<std::string>{"0", "1"} : std::vector<std::string>{};
  }
  std::size_t num_parts() const override { return rows_per_member_; }
  Needs needs() const override { return {.multipliers = true}; }
  void evaluate(const ObservedInstant& at, double* values) const override {
    read(at, values);
    forget_absent(rows_per_member_, values);
  }
  /// Does the same with 0 for members that were taken out.
  void read(const ObservedInstant& at, double* values) const {
    for (std::size_t k = 0; k < count_ * rows_per_member_; ++k)
      values[k] = factor_ * at.multipliers[first_row_ + k] + 0.0;  // no -0
  }

 private:
  std::size_t first_row_ = 0, rows_per_member_ = 1;
  double factor_;
};

/// The pull of springs and bonds between two points: -dU/dL and what damping adds.
template <class Group>
class Pull final : public Members {
 public:
  Pull(const Things& things, const Thing& thing)
      : Members(things, thing), group_(std::get<Group>(things.system().forces[thing.index])) {
    for (std::size_t k = first_; k < first_ + count_; ++k) numbers_.push_back(numbers_of(things.system(), k));
  }
  Needs needs() const override { return {.places = true}; }
  void evaluate(const ObservedInstant& at, double* values) const override {
    for (std::size_t k = 0; k < count_; ++k) {
      const auto [i, j] = group_.pairs[first_ + k];
      const Vec3 a = load(at.positions.data(), j) - load(at.positions.data(), i);
      const double length = norm(a);
      values[k] = slope(length, k);
      if constexpr (std::is_same_v<Group, Springs>)
        values[k] += group_.damping * dot(a, load(at.velocities.data(), j) - load(at.velocities.data(), i)) / length;
    }
    forget_absent(1, values);
  }

 private:
  using Slope = Forward<1>;
  auto numbers_of(const System& system, std::size_t k) const {
    if constexpr (std::is_same_v<Group, Springs>) {
      const Parameter& rest = group_.rest_length;
      const auto [i, j] = group_.pairs[k];
      if (rest.is_initial()) return norm(load(system.positions.data(), j) - load(system.positions.data(), i));
      return rest.constants[rest.constants.size() == 1 ? 0 : k];
    } else {
      return law_numbers_of(system, group_, k);
    }
  }
  double slope(double length, std::size_t k) const {
    if constexpr (std::is_same_v<Group, Springs>) {
      return group_.stiffness * (length - numbers_[k]);
    } else {
      std::array<Slope, KindOf<Group>::most_numbers> numbers;
      std::ranges::copy(numbers_[k], numbers.begin());
      const std::array<TripleOf<Slope>, 2> r{TripleOf<Slope>{}, {Slope::variable(length, 0), 0.0, 0.0}};
      return typename KindOf<Group>::template Definition<Slope>(group_).energy(r, numbers).d[0];
    }
  }

  const Group group_;
  std::vector<decltype(std::declval<const Pull&>().numbers_of(std::declval<const System&>(), 0))> numbers_;
};

std::unique_ptr<Quantity> make_tension(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "rods, pulleys, springs or bonds");
  const Thing thing = things.find(arguments[0], constraints_or_forces);
  std::unique_ptr<Quantity> result;
  if (thing.list == List::Constraints) {
    const Constraint& constraint = things.system().constraints[thing.index];
    if (std::holds_alternative<Rods>(constraint) || std::holds_alternative<Pulleys>(constraint))
      result = std::make_unique<Multipliers>(things, thing, -1.0);
    else
      arguments[0].fail("'" + things.name(thing) + "' is a " + std::string(kind_name(constraint)) +
                        ", which has no tension; force(" + things.name(thing) + ") is its force");
  } else if (std::holds_alternative<Springs>(things.system().forces[thing.index])) {
    result = std::make_unique<Pull<Springs>>(things, thing);
  } else if (std::holds_alternative<Bonds>(things.system().forces[thing.index])) {
    result = std::make_unique<Pull<Bonds>>(things, thing);
  } else {
    arguments[0].fail("'" + things.name(thing) + "' has no tension; rods, pulleys, springs and bonds have one");
  }
  result->dimension = Dimension::Forces;
  return result;
}

std::unique_ptr<Quantity> make_multiplier(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "constraints");
  return std::make_unique<Multipliers>(things, things.find(arguments[0], constraints_alone), 1.0);
}

// ---- vectors of points ----

std::vector<std::string> xyz() {
  return {"x", "y", "z"};
}

/// Vectors of some points: positions, velocities, loads, …
class PointVectors final : public Quantity {
 public:
  using Array = std::span<const double> ObservedInstant::*;
  PointVectors(const Things& things, std::vector<Index> points, Array array, Needs needs, bool is_sum = false)
      : points_(std::move(points)), array_(array), needs_(needs), is_sum_(is_sum) {
    for (const Index point : points_) names_.push_back(things.name_point(point));
  }
  std::size_t num_members() const override { return points_.size(); }
  std::string name_member(std::size_t k) const override { return names_[k]; }
  std::vector<std::string> parts() const override { return xyz(); }
  std::size_t num_parts() const override { return 3; }
  bool is_sum() const override { return is_sum_; }
  Needs needs() const override { return needs_; }
  void evaluate(const ObservedInstant& at, double* values) const override {
    for (std::size_t k = 0; k < points_.size(); ++k)
      store(values, k, (at.*array_).empty() ? Vec3{} : load((at.*array_).data(), points_[k]));
  }
  std::optional<Thing> thing(std::size_t k) const override {
    if (support_) return Thing{List::Supports, support_->index, support_->member.value_or(0) + k};
    return {};
  }
  const std::vector<Index>& points() const { return points_; }
  /// Tells that the points are those of an entry of supports, or one of them.
  void belong_to(const Thing& support) { support_ = support; }

 private:
  std::optional<Thing> support_;
  std::vector<Index> points_;
  std::vector<std::string> names_;
  Array array_;
  Needs needs_;
  bool is_sum_;
};

template <Dimension dimension, std::span<const double> ObservedInstant::*array, bool needs_forces>
std::unique_ptr<Quantity> make_of_points(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "points");
  auto result = std::make_unique<PointVectors>(things, things.points(arguments[0]), array,
                                               Needs{.places = true, .forces = needs_forces});
  result->dimension = dimension;
  return result;
}

std::unique_ptr<PointVectors> make_load_of(const Things& things, const Argument& argument) {
  const Thing thing = things.find(argument, supports_alone);
  const std::vector<Index>& all = things.system().supports[thing.index].points;
  auto result = std::make_unique<PointVectors>(things, thing.member ? std::vector{all[*thing.member]} : all,
                                               &ObservedInstant::support_forces, Needs{.forces = true}, true);
  result->belong_to(thing);
  return result;
}

std::unique_ptr<Quantity> make_load(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "supports");
  auto result = make_load_of(things, arguments[0]);
  result->dimension = Dimension::Forces;
  return result;
}

std::unique_ptr<Quantity> make_friction(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "points");
  things.require_forces(arguments);
  auto result = std::make_unique<PointVectors>(things, things.points(arguments[0]), &ObservedInstant::friction,
                                               Needs{.friction = true});
  result->dimension = Dimension::Forces;
  return result;
}

// ---- forces of constraints, and moments ----

/// The forces with which constraints act on their points, from their definitions.
class ConstraintForces {
 public:
  ConstraintForces(const Things& things, const Thing& thing) : members_(things, thing, 1.0), system_(things.system()) {
    system_.constraints = {things.system().constraints[thing.index]};
    system_.forces.clear();
    system_.friction.clear();
    system_.coordinates.clear();
    const GroupShape shape = shape_of(system_.constraints[0]);
    rows_.resize(shape.members * shape.rows_per_member);
    first_row_ = thing.member.value_or(0) * shape.rows_per_member;
    definitions_.emplace(system_, 0.0);
    eta_.resize(3 * system_.num_points());
    std::size_t k = 0;
    for_each_member(system_, [&](std::span<const Index> points, int) {
      if (!thing.member || k == *thing.member) points_.insert(points_.end(), points.begin(), points.end());
      ++k;
    });
    std::ranges::sort(points_);
    points_.erase(std::ranges::unique(points_).begin(), points_.end());
  }
  ConstraintForces(const ConstraintForces&) = delete;
  ConstraintForces& operator=(const ConstraintForces&) = delete;

  const std::vector<Index>& points() const { return points_; }
  /// Returns eta [3n] of these constraints alone.
  const double* evaluate(const ObservedInstant& at) const {
    std::ranges::fill(rows_, 0.0);
    members_.read(at, rows_.data() + first_row_);
    definitions_->reactions(at.time, at.positions, rows_, eta_);
    return eta_.data();
  }

 private:
  Multipliers members_;
  System system_;
  std::optional<Definitions> definitions_;
  std::vector<Index> points_;
  std::size_t first_row_ = 0;
  mutable std::vector<double> rows_, eta_;
};

/// The sum of the forces with which constraints act on their points. What they are fixed to feels the opposite.
class ForceOfConstraints final : public Quantity {
 public:
  ForceOfConstraints(const Things& things, const Thing& thing) : forces_(things, thing) {
    dimension = Dimension::Forces;
  }
  std::vector<std::string> parts() const override { return xyz(); }
  std::size_t num_parts() const override { return 3; }
  Needs needs() const override { return {.forces = true}; }
  void evaluate(const ObservedInstant& at, double* values) const override {
    const double* const eta = forces_.evaluate(at);
    Vec3 sum{};
    for (const Index point : forces_.points()) sum = sum + load(eta, point);
    store(values, 0, sum);
  }

 private:
  ConstraintForces forces_;
};

std::unique_ptr<Quantity> make_force(const Things& things, const Arguments& arguments) {
  arguments.require(1, 1, "constraints");
  return std::make_unique<ForceOfConstraints>(things, things.find(arguments[0], constraints_alone));
}

/// The moment about an axis of the forces with which a thing acts on the mechanism: the torque of a motor.
class Moment final : public Quantity {
 public:
  Moment(const Things& things, const Arguments& arguments) : axis_(things.axis(arguments[1])) {
    dimension = Dimension::Moment;
    const Thing thing = things.find(arguments[0], supports_or_constraints);
    if (thing.list == List::Supports)
      loads_ = make_load_of(things, arguments[0]);
    else
      constraints_.emplace(things, thing);
    if (arguments.size() < 3) return;
    const std::optional<Vec3> place = things.vector(arguments[2]);
    if (place)
      about_ = *place;
    else
      about_point_ = things.point(arguments[2]);
  }
  Needs needs() const override { return {.forces = true}; }
  void evaluate(const ObservedInstant& at, double* values) const override {
    const Vec3 about = about_point_ ? load(at.positions.data(), *about_point_) : about_;
    const double* const forces = loads_ ? at.support_forces.data() : constraints_->evaluate(at);
    double sum = 0.0;
    for (const Index point : loads_ ? loads_->points() : constraints_->points())
      sum += dot(axis_, cross(load(at.positions.data(), point) - about, load(forces, point)));
    values[0] = loads_ ? -sum : sum;
  }

 private:
  Vec3 axis_, about_{};
  std::optional<Index> about_point_;
  std::unique_ptr<PointVectors> loads_;
  std::optional<ConstraintForces> constraints_;
};

std::unique_ptr<Quantity> make_moment(const Things& things, const Arguments& arguments) {
  if (arguments.size() == 1)
    throw TextFault{arguments.place,
                    "a moment needs an axis: moment(" + std::string(arguments[0].text) + ", z, [0, 0, 0])"};
  arguments.require(2, 3, "supports or constraints, axis, about");
  return std::make_unique<Moment>(things, arguments);
}

// ---- geometry ----

std::unique_ptr<Quantity> make_distance(const Things& things, const Arguments& arguments) {
  arguments.require(2, 2, "point, point");
  const Index i = things.point(arguments[0]), j = things.point(arguments[1]);
  return std::make_unique<Number>(Dimension::Length, Needs{.places = true}, [=](const ObservedInstant& at) {
    return norm(load(at.positions.data(), j) - load(at.positions.data(), i));
  });
}

std::unique_ptr<Quantity> make_angle(const Things& things, const Arguments& arguments) {
  arguments.require(3, 3, "point, corner, point");
  const Index i = things.point(arguments[0]), corner = things.point(arguments[1]), j = things.point(arguments[2]);
  return std::make_unique<Number>(Dimension::Angle, Needs{.places = true}, [=](const ObservedInstant& at) {
    const Vec3 here = load(at.positions.data(), corner);
    const Vec3 a = load(at.positions.data(), i) - here, b = load(at.positions.data(), j) - here;
    return std::atan2(norm(cross(a, b)), dot(a, b));
  });
}

// ---- energies ----

/// The potential energy of one force.
class PotentialOfForce final : public Quantity {
 public:
  PotentialOfForce(const Things& things, const Thing& thing)
      : system_(with_force(things.system(), thing.index)), numbering_(number(system_)), forces_(system_, numbering_) {
    dimension = Dimension::Energy;
    r_.resize(system_.positions.size());
  }
  Needs needs() const override { return {.places = true}; }
  void evaluate(const ObservedInstant& at, double* values) const override {
    numbering_.gather_points(at.positions, r_);
    forces_.set_time(at.time);
    values[0] = forces_.potential(Parallel(1), at.time, r_.data());
  }

 private:
  static System with_force(const System& system, std::size_t index) {
    System one = system;
    one.forces = {system.forces[index]};
    return one;
  }

  System system_;
  Numbering numbering_;
  mutable Forces forces_;
  mutable std::vector<double> r_;
};

std::unique_ptr<Quantity> make_kinetic(const Things&, const Arguments& arguments) {
  arguments.require(0, 0, "");
  return std::make_unique<Number>(Dimension::Energy, Needs{.energy = true},
                                  [](const ObservedInstant& at) { return at.kinetic; });
}

std::unique_ptr<Quantity> make_potential(const Things& things, const Arguments& arguments) {
  arguments.require(0, 1, "force");
  things.require_forces(arguments);
  if (arguments.size() == 1) return std::make_unique<PotentialOfForce>(things, things.find(arguments[0], forces_alone));
  return std::make_unique<Number>(Dimension::Energy, Needs{.energy = true},
                                  [](const ObservedInstant& at) { return at.potential; });
}

std::unique_ptr<Quantity> make_energy(const Things& things, const Arguments& arguments) {
  arguments.require(0, 0, "");
  things.require_forces(arguments);
  return std::make_unique<Number>(Dimension::Energy, Needs{.energy = true},
                                  [](const ObservedInstant& at) { return at.kinetic + at.potential; });
}

}  // namespace

std::span<const QuantityKind> quantity_kinds() {
  static constexpr QuantityKind kinds[] = {
      {"tension", "rods, pulleys, springs or bonds", "pull of a rod, of the rope of a pulley, of a spring or bond",
       make_tension},
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
      {"energy", "", "kinetic and potential energy", make_energy},
      {"kinetic", "", "kinetic energy", make_kinetic},
      {"potential", "force", "potential energy, of one force or of all", make_potential},
      {"temperature", "", "temperature of all moving points", make_temperature},
      {"pressure", "", "pressure of a periodic sample", make_pressure},
      {"virial", "", "virial tensor of a periodic sample, r (x) F", make_virial},
  };
  return kinds;
}

}  // namespace tanor::detail
