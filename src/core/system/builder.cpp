#include <utility>

#include <tanor/system.hpp>

#include "base/text.hpp"

/// \file The functions that build a System point by point, by appending to its arrays.
namespace tanor {
using namespace detail;

namespace {

Rods& rods_of(System& system, std::size_t group) {
  Rods* const rods = group < system.constraints.size() ? std::get_if<Rods>(&system.constraints[group]) : nullptr;
  if (rods == nullptr) throw InputError("", "constraints[" + text(group) + "] are no rods any more");
  return *rods;
}

}  // namespace

Point System::add_point(const PointStart& start) {
  const bool all_rest = velocities.empty() && start.velocity == Vector3{};
  if (!all_rest) velocities.resize(positions.size(), 0.0);
  positions.insert(positions.end(), start.position.begin(), start.position.end());
  if (!all_rest) velocities.insert(velocities.end(), start.velocity.begin(), start.velocity.end());
  masses.push_back(start.mass);
  return {static_cast<Index>(masses.size() - 1)};
}

Point System::add_support(const Vector3& position, VectorFunction displacement, std::string support_name) {
  const Point point = add_point({.position = position});
  supports.push_back({std::move(support_name), {point.index}, std::move(displacement)});
  return point;
}

RodGroup System::add_rods(std::string group_name) {
  constraints.emplace_back(Rods{.name = std::move(group_name)});
  return {*this, constraints.size() - 1};
}

void System::add_gravity(const Vector3& acceleration) {
  forces.emplace_back(Gravity{.acceleration = acceleration});
}

Member RodGroup::join(Point i, Point j) {
  Rods& rods = rods_of(*system_, group_);
  rods.pairs.push_back({i.index, j.index});
  return {group_, rods.pairs.size() - 1};
}

Member RodGroup::operator[](std::size_t number) const {
  if (number >= size()) throw InputError("", "rods[" + text(number) + "]: there are " + text_of_count(size(), "rod"));
  return {group_, number};
}

std::size_t RodGroup::size() const {
  return rods_of(*system_, group_).pairs.size();
}

}  // namespace tanor
