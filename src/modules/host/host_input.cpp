#include "host/host_input.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "system/one_sided.hpp"
#include "system/strengths.hpp"
#include "system/value_checks.hpp"

namespace tanor::detail {

namespace {

/// The positions of a member's points, in a cell at the images that it joins.
struct MemberImages {
  const HostPoints& points;
  const Lattice* lattice;           // null if there is no cell
  const std::array<int, 3>* image;  // null for the nearest ones
  std::span<const Index> members;

  TripleOf<double> operator[](std::size_t p) const {
    const auto at = [&](std::size_t k) { return load(points.positions.data(), members[k]); };
    Vec3 r = at(p);
    if (lattice != nullptr && p > 0) {
      const Vec3 n = image != nullptr ? Vec3{static_cast<double>((*image)[0]), static_cast<double>((*image)[1]),
                                             static_cast<double>((*image)[2])}
                                      : lattice->round(lattice->fraction(at(0) - r));
      r = r + lattice->vector(n);
    }
    return {r.x, r.y, r.z};
  }
};

/// Replaces "initial" by the values that the members have.
void fix_initial(const HostPoints& points, const Lattice* lattice, std::span<const std::array<int, 3>> images,
                 Constraint* constraint) {
  const auto fix = [&]<class Kind>(Kind& group) {
    if constexpr (requires { KindOf<Kind>::parameter; }) {
      Parameter& parameter = group.*KindOf<Kind>::parameter;
      if (!parameter.is_initial()) return;
      const typename KindOf<Kind>::template Definition<double> now(group, ClockOf<double>{0.0});
      std::vector<double> numbers(num_members(group));
      for (std::size_t k = 0; k < numbers.size(); ++k) {
        const MemberImages at{points, lattice, images.empty() ? nullptr : &images[k], member_points(group, k)};
        numbers[k] = now.measure(at, k);
      }
      parameter = std::move(numbers);
    }
  };
  std::visit(fix, *constraint);
}

/// Makes a system of the group and of the points that it has, and no others.
System make_small(const HostPoints& points, Constraint group) {
  std::set<Index> used;
  for_each_point(&group, [&](const Index* point) { used.insert(*point); });
  const std::vector<Index> list(used.begin(), used.end());
  System system;
  system.masses.assign(list.size(), 1.0);
  for (const Index point : list) {
    if (point < 0 || static_cast<std::size_t>(point) >= points.of_host.size()) throw InputError("", "no such point");
    const Vec3 r = load(points.positions.data(), points.of_host[static_cast<std::size_t>(point)]);
    system.positions.insert(system.positions.end(), {r.x, r.y, r.z});
  }
  for_each_point(&group, [&](Index* point) {
    *point = static_cast<Index>(std::ranges::lower_bound(list, *point) - list.begin());
  });
  system.constraints.push_back(std::move(group));
  return system;
}

}  // namespace

HostPoints make_points(std::span<const double> masses, const ConstPointArray& at) {
  require_array(at, masses.size(), "positions");
  HostPoints points;
  points.of_host.resize(masses.size());
  std::iota(points.of_host.begin(), points.of_host.end(), 0);
  points.host_point = points.of_host;
  points.mass.assign(masses.begin(), masses.end());
  points.positions.resize(3 * masses.size());
  copy_points(at, points.of_host, points.positions.data());
  return points;
}

System make_system(const HostPoints& points, std::vector<Constraint> constraints) {
  System system = points.make_system(points.of_host);
  system.constraints = std::move(constraints);
  return system;
}

void check_group(const HostParts& parts, const Constraint& group, std::size_t num_images) {
  const GroupShape shape = shape_of(group);
  if (num_images > 0) check_size(num_images, shape.members * shape.rows_per_member, "images");
  const std::string& name = std::visit([](const auto& kind) -> const std::string& { return kind.name; }, group);
  if (parts.inventory().has_name(name))
    throw InputError("/constraints", "\"" + name + "\" is the name of other constraints already; a name is used once");
  try {
    refuse_sides(make_small(parts.points(), group), one_sided_host);
    refuse_breaks(make_small(parts.points(), group), unbreakable_host);
    validate(make_small(parts.points(), group));
  } catch (const InputError&) {
    validate(make_system(parts.points(), {group}));  // here points have the host's numbers
    throw;
  }
}

ConstraintId add_group(Constraint group, std::vector<std::array<int, 3>> images, HostParts* parts) {
  const HostPoints& points = parts->points();
  const std::size_t rows = shape_of(group).rows_per_member;
  for (std::size_t k = 1; rows * k < images.size(); ++k) images[k] = images[rows * k];
  if (!images.empty()) images.resize(images.size() / rows);
  for_each_point(&group, [&](Index* point) { *point = points.of_host[static_cast<std::size_t>(*point)]; });
  std::optional<Lattice> lattice;
  if (parts->cell() != nullptr) lattice.emplace(points.cell);
  fix_initial(points, lattice ? &*lattice : nullptr, images, &group);
  return parts->add(std::move(group), std::move(images));
}

void check_mass(double mass, std::optional<double> before, std::size_t point) {
  constexpr double infinite = HostPoints::infinite_mass;
  const std::string where = "/masses/" + std::to_string(point);
  if (mass != infinite) check_number(mass, ValueRange::positive, where, "mass");
  if (!is_in_range(1.0 / mass)) throw InputError(where, "mass " + text(mass) + " is below 1e-100");
  if (before && (mass == infinite) != (*before == infinite))
    throw InputError(where, mass == infinite ? "a point that moves does not become a support"
                                             : "a support has an infinite mass, and keeps it");
}

std::vector<Index> check_numbers(const HostParts& parts, std::span<const std::int64_t> from,
                                 std::span<const double> masses) {
  check_size(masses.size(), from.size(), "masses");
  const HostPoints& points = parts.points();
  std::vector<Index> result;
  std::vector<char> stays(points.size(), 0);
  for (std::size_t i = 0; i < from.size(); ++i) {
    const std::string where = "/from/" + std::to_string(i);
    if (from[i] < -1 || from[i] >= static_cast<std::int64_t>(parts.num_points()))
      throw InputError(where, "there was no point " + text(from[i]));
    const Index point = from[i] < 0 ? -1 : points.of_host[static_cast<std::size_t>(from[i])];
    result.push_back(point);
    if (point >= 0 && std::exchange(stays[static_cast<std::size_t>(point)], 1) != 0)
      throw InputError(where, "point " + text(from[i]) + " is there twice");
    check_mass(masses[i], point < 0 ? std::nullopt : std::optional(points.mass[static_cast<std::size_t>(point)]), i);
  }
  if (std::ranges::count(stays, 1) == static_cast<std::ptrdiff_t>(parts.num_points())) return result;
  const Inventory& inventory = parts.inventory();
  for (ConstraintId id = 0; id < inventory.next_id(); ++id) {
    if (!inventory.has(id)) continue;
    for (const Index point : inventory.points(id)) {
      if (stays[static_cast<std::size_t>(point)] != 0) continue;
      throw InputError("/from", inventory.row_name(inventory.first_row(id)) + " still holds point " +
                                    text(points.host_point[static_cast<std::size_t>(point)]) + ", which has left");
    }
  }
  return result;
}

}  // namespace tanor::detail
