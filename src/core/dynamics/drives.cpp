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

/// Calls visit(k) for at most `most_members` of `count`, evenly spread.
template <class Visit>
void for_some(std::size_t count, const Visit& visit) {
  const std::size_t some = std::min(count, most_members);
  for (std::size_t i = 0; i < some; ++i) visit(i * count / some);
}

double length_of(const VectorFunction& a, double t) {
  const std::array<Jet<2>, 3> at = a(t);
  return std::hypot(at[0].value(), at[1].value(), at[2].value());
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
    std::visit([&](const auto& group) { add_fields(group, t); }, system.constraints[k]);
  }
  for (std::size_t k = 0; k < system.coordinates.size(); ++k) {
    enter(coordinates_name(system, k));
    std::visit([&](const auto& group) { add_fields(group, t); }, system.coordinates[k]);
  }
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    const auto* const given = std::get_if<ConstantForce>(&system.forces[k]);
    if (given == nullptr) continue;
    enter(force_name(system, k));
    double largest = 0.0;
    for (const Index point : given->points) largest = std::max(largest, inverse_mass[numbering.inner_point[point]]);
    if (largest > 0.0) add(given->force, DriveLevel::Acceleration, largest, given->points);
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

double Drives::lever(const VectorFunction& direction, double t) const {
  return direction.is_constant() ? 0.0 : reach_ / length_of(direction, t);
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

// ---- one step ----

DriveReport Drives::look(const DrivenStep& step, const Place& place) {
  DriveReport report;
  for (const Function& each : functions_) {
    samples_.place(step, each.level, each.function);
    values_.resize(samples_.times().size());
    each.function.sample(samples_.times(), values_.data());
    assess(step, place, each, &report);
  }
  return report;
}

void Drives::assess(const DrivenStep& step, const Place& place, const Function& function, DriveReport* report) {
  const auto& [_, level, scale, points, name] = function;
  const DriveSamples::Found found = samples_.look(step, level, values_.data());
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
    report->pieces = std::max(report->pieces, samples_.count_pieces(level, values_.data(), found));
}

}  // namespace tanor::detail
