#include "host/host_observables.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "base/text.hpp"
#include "base/vec3.hpp"
#include "host/host_input.hpp"
#include "host/point_address.hpp"

namespace tanor::detail {

namespace {

std::vector<ConstraintId> list_ids(const Inventory& inventory) {
  std::vector<ConstraintId> ids;
  for (ConstraintId id = 0; id < inventory.next_id(); ++id)
    if (inventory.has(id)) ids.push_back(id);
  return ids;
}

/// Gives the groups of a system the names that they have in the inventory, and tells which members are left.
HostNames name_groups(const Inventory& inventory, std::span<const ConstraintId> ids, System* system) {
  HostNames names;
  for (Constraint& constraint : system->constraints) {
    const std::size_t number = inventory.group_number(ids.front()), count = shape_of(constraint).members;
    std::visit([&](auto& group) { group.name = inventory.group_name(number); }, constraint);
    HostNames::Group& group = names.groups.emplace_back();
    group.size = inventory.group_size(number);
    for (const ConstraintId id : ids.first(count < group.size ? count : 0))
      group.left.push_back(inventory.member_number(id));
    ids = ids.subspan(count);
  }
  for (std::size_t number = 0; number < inventory.num_groups(); ++number)
    if (inventory.group_size(number) == 0) names.removed.push_back(inventory.group_name(number));
  return names;
}

void read_points(const ConstPointArray& from, std::size_t num_points, std::vector<double>* to) {
  to->clear();
  for (std::size_t i = 0; from && i < num_points; ++i)
    for (const double number : read_point(from, i)) to->push_back(number);
}

/// Returns the edges that repeat. Observables read no more of a host's cell than that there is one.
Cell edges_of(const PeriodicCell& from) {
  const auto length = [&](std::size_t k) { return from.repeats[k] ? norm(make_vec3(from.edges[k])) : 0.0; };
  return {.xx = length(0), .yy = length(1), .zz = length(2)};
}

}  // namespace

HostObservables::Reading::Reading(const HostParts& parts, const ConstPointArray& positions)
    : num_edits(parts.num_edits()) {
  const Inventory& inventory = parts.inventory();
  const HostPoints& points = parts.points();
  const std::vector<ConstraintId> ids = list_ids(inventory);
  system = make_system(
      points, inventory.take(ids, [&](Index point) { return points.host_point[static_cast<std::size_t>(point)]; }));
  names = name_groups(inventory, ids, &system);
  for (Support& support : system.supports) support.name.clear();
  if (const PeriodicCell* const cell = parts.cell()) {
    system.cell = edges_of(*cell);
    if (positions) read_points(positions, points.of_host.size(), &system.positions);
    const auto is_finite = [](double x) { return std::isfinite(x); };
    if (positions && std::ranges::all_of(system.positions, is_finite)) {
      images.emplace(system, Periodicity{*cell, inventory.take_images(ids)});
      images->set_offsets(&system);
    }
  }
  observables.emplace(system, std::span<const Thing>(), &names);
}

/// Reads all texts for what there is now.
void HostObservables::read(const ConstPointArray& positions) {
  auto next = std::make_unique<Reading>(parts_, positions);
  next->observables->add(*now_->observables);
  now_ = std::move(next);
}

std::size_t HostObservables::add(const Observable& what) {
  if (now_->num_edits != parts_.num_edits()) read({});
  return now_->observables->add(what);
}

void HostObservables::remove(std::size_t number) {
  if (number >= observed().size()) throw InputError("", "there is no observable " + text(number));
  now_->observables->remove(number);
}

Needs HostObservables::prepare(const ConstPointArray& positions) {
  const PeriodicCell* const cell = parts_.cell();
  const std::optional<PeriodicImages>& images = now_->images;
  const bool has_images = cell == nullptr || (images && (!images->close_ways() || images->cell() == *cell));
  if (now_->num_edits != parts_.num_edits() || !has_images) read(positions);
  return now_->observables->needs(Observables::Which::All);
}

HostState HostObservables::own_arrays(HostState at) {
  for (std::vector<double>* array : {&accelerations_, &reactions_}) array->resize(3 * parts_.num_points());
  multipliers_.resize(parts_.inventory().num_rows());
  at.accelerations = accelerations_;
  at.wanted = {.multipliers = multipliers_, .forces = reactions_};
  return at;
}

void HostObservables::evaluate(const HostState& at) {
  const std::size_t n = parts_.num_points();
  read_points(at.positions, n, &positions_);
  read_points(at.velocities, n, &velocities_);
  if (now_->images) {
    now_->images->set_cell(*parts_.cell());
    std::swap(positions_, wrapped_);
    positions_.resize(3 * n);
    now_->images->unwrap(Parallel(1), now_->images->lattice(), wrapped_.data(), positions_.data());
  }
  // Supports carry the forces of constraints and those of the host.
  loads_.assign(at.forces ? 3 * n : 0, 0.0);
  double kinetic = 0.0;
  std::size_t num_moving = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Index point = parts_.points().of_host[i];
    const Vec3 v = load(velocities_.data(), i);
    num_moving += parts_.points().is_support(point) ? 0 : 1;
    if (!parts_.points().is_support(point))
      kinetic += 0.5 * parts_.points().mass[static_cast<std::size_t>(point)] * dot(v, v);
    else if (at.forces)
      store(loads_.data(), i, load(reactions_.data(), i) + make_vec3(read_point(at.forces, i)));
  }
  const std::vector<double> self_stress =
      now_->observables->needs(Observables::Which::All).solves() ? parts_.find_self_stress() : std::vector<double>();
  now_->observables->take({.time = at.time,
                           .positions = positions_,
                           .velocities = velocities_,
                           .accelerations = accelerations_,
                           .multipliers = multipliers_,
                           .reactions = reactions_,
                           .support_forces = loads_,
                           .friction = {},
                           .kinetic = kinetic,
                           .degrees_of_freedom = 3 * num_moving - now_->rank.value_or(0),
                           .self_stress = self_stress},
                          Observables::Which::All);
}

}  // namespace tanor::detail
