#include "dynamics/drives.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "base/vec3.hpp"
#include "system/contacts.hpp"
#include "system/members.hpp"

namespace tanor::detail {

namespace {

constexpr std::size_t most_members = 16;  // of one entry that are evaluated

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;  // clang 14 needs this guide

/// Calls visit(k) for at most `most_members` of `count`, evenly spread.
template <class Visit>
void for_some(std::size_t count, const Visit& visit) {
  const std::size_t some = std::min(count, most_members);
  for (std::size_t i = 0; i < some; ++i) visit(i * count / some);
}

/// Returns true if the expression reads the variable. Unused operands of instructions are 0, so the variable of
/// instruction 0 may count although nothing reads it.
bool depends_on(const Expression& expression, std::size_t variable) {
  const int number = expression.variables[variable];
  if (std::ranges::count(expression.results, number) > 0) return true;
  return std::ranges::any_of(expression.instructions, [number](const Expression::Instruction& i) {
    return i.operation != Expression::Operation::Variable && (i.a == number || i.b == number || i.c == number);
  });
}
/// The time is the last variable.
bool depends_on_time(const Expression& expression) {
  return depends_on(expression, expression.variables.size() - 1);
}
bool depends_on_state(const Expression& expression) {
  for (std::size_t i = 0; i + 1 < expression.variables.size(); ++i) {
    if (depends_on(expression, i)) return true;
  }
  return false;
}

/// Returns the expression with the constants of one tuple in place of the variables behind its coordinates.
Expression with_constants(const Potential& group, std::size_t k) {
  Expression result = *group.kernel.expression;
  const auto first = result.variables.begin() + 3 * group.kernel.num_points;
  const auto last = first + static_cast<std::ptrdiff_t>(group.constants.size());
  for (std::size_t c = 0; const std::vector<double>& each : group.constants)
    result.instructions[static_cast<std::size_t>(first[static_cast<std::ptrdiff_t>(c++)])] = {
        .operation = Expression::Operation::Constant, .constant = each[each.size() == 1 ? 0 : k]};
  result.variables.erase(first, last);
  return result;
}

double length_of(const VectorFunction& a, double t) {
  const std::array<Jet<2>, 3> at = a(t);
  return std::hypot(at[0].value(), at[1].value(), at[2].value());
}

std::size_t num_coordinates(const Coordinates& coordinates) {
  return std::visit([](const auto& group) { return num_coordinates_of(group); }, coordinates);
}

}  // namespace

Drives::Drives(const System& system, const Numbering& numbering, std::span<const double> inverse_mass,
               double scene_size, double t)
    : numbering_(numbering), scene_size_(scene_size) {
  for (std::size_t i = 0; i < system.num_points(); ++i)
    reach_ = std::max(reach_, norm(load(system.positions.data(), i)));
  reach_ = std::max(reach_, scene_size);
  // Each entry of the system adds its functions under its own name.
  const auto enter = [&](std::string name) { names_.push_back(std::move(name)); };
  for (std::size_t k = 0; k < system.supports.size(); ++k) {
    const Support& support = system.supports[k];
    enter("the motion of " + (support.name.empty() ? "supports[" + std::to_string(k) + "]" : support.name));
    add(support.displacement, DriveLevel::Position, 1.0, support.points);
  }
  for (std::size_t k = 0; k < system.constraints.size(); ++k) {
    enter(constraint_name(system, k));
    add_constraint(system.constraints[k], t);
  }
  std::size_t first_coordinate = 0;
  for (std::size_t k = 0; k < system.coordinates.size(); ++k) {
    enter(coordinates_name(system, k));
    add_coordinates(system.coordinates[k], t, first_coordinate);
    first_coordinate += num_coordinates(system.coordinates[k]);
  }
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    enter(force_name(system, k));
    add_force(system.forces[k], inverse_mass);
  }
  const std::vector<Contact> contacts = system.friction.empty() ? std::vector<Contact>{} : list_contacts(system);
  for (std::size_t k = 0; k < system.friction.size(); ++k) {
    enter(friction_name(system, k));
    std::vector<Index> points;
    for (const Contact& contact : contacts) {
      if (contact.friction == static_cast<Index>(k)) points.push_back(contact.point);
    }
    std::visit([&](const auto& law) { add(law.velocity, DriveLevel::Velocity, 1.0, points); }, system.friction[k]);
  }
  if (empty()) return;
  samples_.reserve();
  values_.reserve(DriveSamples::most_of_a_step);
}

// ---- the functions of a system ----

void Drives::add(const ScalarFunction& function, DriveLevel level, double scale, std::span<const Index> users_points) {
  if (function.is_constant() || users_points.empty()) return;
  Function added{function, level, scale, {}, names_.size() - 1};
  for_some(users_points.size(), [&](std::size_t k) {
    added.points.push_back(numbering_.inner_point[static_cast<std::size_t>(users_points[k])]);
  });
  functions_.push_back(std::move(added));
}

void Drives::add(const VectorFunction& function, DriveLevel level, double scale, std::span<const Index> users_points) {
  for (const ScalarFunction& component : function.components) add(component, level, scale, users_points);
}

/// Adds one function for all members, or one for each.
template <class Group>
void Drives::add(const Parameter& parameter, double scale, const Group& group) {
  if (parameter.functions.empty() || num_members(group) == 0) return;
  if (parameter.functions.size() == 1) {
    std::vector<Index> points;
    for_some(num_members(group), [&](std::size_t k) { points.push_back(member_points(group, k).back()); });
    return add(parameter.functions[0], DriveLevel::Position, scale, points);
  }
  for (std::size_t k = 0; k < parameter.functions.size(); ++k)
    add(parameter.functions[k], DriveLevel::Position, scale, member_points(group, k));
}

void Drives::add(const Expression& expression, Program::As as, double scale, std::size_t first_coordinate,
                 std::span<const Index> users_points) {
  Program added{as,
                SeriesProgram(expression, as == Program::As::AConstraint || as == Program::As::AnEnergy),
                {},
                first_coordinate,
                scale,
                !depends_on_state(expression),
                names_.size() - 1};
  for (const Index point : users_points)
    added.points.push_back(numbering_.inner_point[static_cast<std::size_t>(point)]);
  programs_.push_back(std::move(added));
}

double Drives::lever(const VectorFunction& direction, double t) const {
  return direction.is_constant() ? 0.0 : reach_ / length_of(direction, t);
}

void Drives::add_force(const Force& force, std::span<const double> inverse_mass) {
  // Returns the inverse of the smallest mass of some points.
  const auto largest_inverse = [&](std::span<const Index> points) {
    double largest = 0.0;
    for (const Index point : points) largest = std::max(largest, inverse_mass[numbering_.inner_point[point]]);
    return largest;
  };
  // A force without an expression does not tell its functions of time.
  const auto may_be_driven = [](const auto& kernel) {
    return kernel.expression != nullptr && depends_on_time(*kernel.expression);
  };
  if (const auto* given = std::get_if<ConstantForce>(&force)) {
    const double largest = largest_inverse(given->points);
    if (largest > 0.0) add(given->force, DriveLevel::Acceleration, largest, given->points);
  } else if (const auto* formula = std::get_if<FormulaForce>(&force); formula && may_be_driven(formula->kernel)) {
    const auto watch = [&](std::span<const Index> points) {
      const double largest = largest_inverse(points);
      if (largest > 0.0) add(*formula->kernel.expression, Program::As::AForce, largest, 0, points);
    };
    for_some(formula->points.size(), [&](std::size_t k) { watch({&formula->points[k], 1}); });
    for_some(formula->tuples.size(), [&](std::size_t k) { watch(formula->tuples[k]); });
  } else if (const auto* group = std::get_if<Potential>(&force); group && may_be_driven(group->kernel)) {
    for_some(group->points.size(), [&](std::size_t k) {
      const double largest = largest_inverse(group->points[k]);
      if (largest > 0.0) add(with_constants(*group, k), Program::As::AnEnergy, largest, 0, group->points[k]);
    });
  }
}

/// Lists the points of all members.
template <class Group>
std::vector<Index> list_points(const Group& group) {
  std::vector<Index> points;
  for (std::size_t k = 0; k < num_members(group); ++k) {
    for (const Index point : member_points(group, k)) points.push_back(point);
  }
  return points;
}

/// Adds the fields of a group that move its points: positions by their own change, directions and parameters by a
/// lever.
template <class Group>
void Drives::add_fields(const Group& group, double t) {
  for_each_field<Group>([&]<class Value>(const FieldOf<Group, Value>& field) {
    const Value& value = group.*field.value;
    if constexpr (std::is_same_v<Value, VectorFunction>) {
      const bool turns = field.data.role == FieldRole::Direction;
      add(value, DriveLevel::Position, turns ? lever(value, t) : 1.0, list_points(group));
    } else if constexpr (std::is_same_v<Value, Parameter>) {
      double scale = 1.0;
      if constexpr (requires { KindOf<Group>::leverage(group, t, scene_size_); })
        scale = KindOf<Group>::leverage(group, t, scene_size_);
      if (scale > 0.0) add(value, scale, group);
    }
  });
}

void Drives::add_constraint(const Constraint& constraint, double t) {
  std::visit(Overloaded{[&](const auto& group) { add_fields(group, t); },
                        [&](const UserConstraints& group) {
                          if (group.kernel.expression == nullptr || !group.kernel.depends_on_time) return;
                          for_some(group.tuples.size(), [&](std::size_t k) {
                            add(*group.kernel.expression, Program::As::AConstraint, 1.0, 0, group.tuples[k]);
                          });
                        }},
             constraint);
}

void Drives::add_coordinates(const Coordinates& coordinates, double t, std::size_t first_coordinate) {
  std::visit(Overloaded{[&](const auto& group) { add_fields(group, t); },
                        [&](const UserCoordinates& group) {
                          if (group.kernel.expression == nullptr || !group.kernel.depends_on_time) return;
                          for_some(group.tuples.size(), [&](std::size_t k) {
                            add(*group.kernel.expression, Program::As::SomeCoordinates, 1.0,
                                first_coordinate + k * static_cast<std::size_t>(group.kernel.num_coordinates),
                                group.tuples[k]);
                          });
                        }},
             coordinates);
}

// ---- one step ----

DriveReport Drives::look(const DrivenStep& step, const Place& place) {
  DriveReport report;
  for (const Function& each : functions_) {
    samples_.place(step, each.level, &each.function);
    values_.resize(samples_.times().size());
    each.function.sample(samples_.times(), values_.data());
    assess(step, place, each.points, each.level, each.scale, values_.data(), each.name, &report);
  }
  for (const Program& each : programs_) {
    report.is_of_time_alone = report.is_of_time_alone && each.is_of_time_alone;
    if (each.as == Program::As::SomeCoordinates && place.q == nullptr) continue;
    const DriveLevel level = each.is_force() ? DriveLevel::Acceleration : DriveLevel::Position;
    samples_.place(step, level, nullptr);
    const double scale = each.scale / run(each, place);
    for (std::size_t m = 0; m < each.num_values(); ++m)
      assess(step, place, each.points, level, scale, values_.data() + m * samples_.times().size(), each.name, &report);
  }
  return report;
}

void Drives::assess(const DrivenStep& step, const Place& place, std::span<const Index> points, DriveLevel level,
                    double scale, const double* values, std::size_t name, DriveReport* report) {
  const DriveSamples::Found found = samples_.look(step, level, values);
  if (!found.varies()) return;
  const DriveSamples::Misses& missed = found.missed;

  // The point with the smallest tolerance counts.
  double v_allowed = std::numeric_limits<double>::infinity(), x_allowed = v_allowed;
  for (const Index point : points) {
    const auto p = static_cast<std::size_t>(point);
    v_allowed = std::min(v_allowed, place.scales.velocity_tolerance(step.atol, p) + step.rtol * norm(load(place.v, p)));
    x_allowed = std::min(x_allowed, place.scales.position_tolerance(step.atol, p) + step.rtol * norm(load(place.r, p)));
  }
  v_allowed += step.rtol * scale * missed.v_done;
  x_allowed += step.rtol * scale * missed.x_done;
  const double error = scale * std::max(missed.v / v_allowed, missed.x / x_allowed);
  if (error > report->error) {
    report->error = error;
    report->drive = name;
  }

  // A step does not follow a function, not even roughly, if it misses more than this part of its effect.
  constexpr double unseen = 0.2;
  const bool is_acceleration = level == DriveLevel::Acceleration;
  if (is_acceleration ? missed.v > unseen * missed.v_done : missed.x > unseen * missed.x_done) {
    const double velocity = scale * (is_acceleration ? missed.v : missed.x / step.h);
    report->velocity = std::max(report->velocity, velocity);
  }
  if (scale * (is_acceleration ? missed.v_done : missed.x_done) > (is_acceleration ? v_allowed : x_allowed))
    report->pieces = std::max(report->pieces, samples_.count_pieces(level, values, found));
}

}  // namespace tanor::detail
