#include "host/part_builder.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "host/group_names.hpp"

namespace tanor::detail {

namespace {

/// Points and rows from which threads of its own pay for a part.
constexpr std::int64_t least_for_threads = 16384;

}  // namespace

void PartBuilder::build(HostPart* part) {
  try {
    part->host = make_host(part);
  } catch (const InputError& wrong) {
    throw InputError(wrong.where(), with_host_names(inventory_, part->members, wrong.what()));
  }
  part->number_points(points_);
}

std::unique_ptr<ConstrainedHost> PartBuilder::make_host(HostPart* part) {
  System system = make_system(part);
  SolverOptions options = options_;
  std::int64_t weight = 0;
  for (const HostIsland& island : part->islands) weight += island.weight;
  if (weight < least_for_threads) options.threads = 1;
  part->has_own_threads = options.threads != 1;
  std::unique_ptr<PeriodicImages> images;
  if (cell_) {
    images = std::make_unique<PeriodicImages>(system, Periodicity{points_.cell, inventory_.take_images(part->members)});
    images->prepare(&system);
    images->set_cell(*cell_);
    images->set_offsets(&system);
  }
  auto host = std::make_unique<ConstrainedHost>(std::move(system), options);
  if (images) {
    images->use(host->model.system, host->model.numbering);
    host->set_images(std::move(images));
  }
  return host;
}

System PartBuilder::make_system(HostPart* part) {
  part->places = part->moving;
  for (const ConstraintId id : part->members) {
    for (const Index point : inventory_.points(id)) {
      if (points_.is_support(point)) part->places.push_back(point);
    }
  }
  std::ranges::sort(part->places);
  part->places.erase(std::unique(part->places.begin(), part->places.end()), part->places.end());
  local_.resize(points_.size(), -1);
  System system;
  Support supports{"supports", {}, {}};
  for (const Index point : part->places) {
    const auto number = static_cast<std::size_t>(point);
    const auto own = static_cast<Index>(system.masses.size());
    local_[number] = own;
    const bool is_support = points_.is_support(point);
    if (is_support) supports.points.push_back(own);
    system.masses.push_back(is_support ? 1.0 : points_.mass[number]);
    const auto position = points_.positions.begin() + static_cast<std::ptrdiff_t>(3 * number);
    system.positions.insert(system.positions.end(), position, position + 3);
  }
  if (!supports.points.empty()) system.supports.push_back(std::move(supports));
  system.constraints =
      inventory_.take(part->members, [&](Index point) { return local_[static_cast<std::size_t>(point)]; });
  std::size_t first = 0;
  for (Constraint& constraint : system.constraints) {
    const std::string name = part_name_of_group(inventory_.group_number(part->members[first]));
    std::visit([&](auto& group) { group.name = name; }, constraint);
    first += shape_of(constraint).members;
  }
  return system;
}

}  // namespace tanor::detail
