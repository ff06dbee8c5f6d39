#include "report/shown_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <type_traits>
#include <utility>
#include <variant>

#include "system/members.hpp"

namespace tanor::report {

namespace {

/// Adds the members of a constraint or force that a line from point to point shows, those whose points are all shown.
template <class Group>
void add_ties(const Group& group, const std::string& name, const std::string& place, std::size_t entry, std::size_t row,
              const std::vector<std::int32_t>& slots, ShownParts* shown) {
  constexpr std::size_t most = 2000;  // each stands in every frame of a trajectory, as text
  if constexpr (std::is_same_v<Group, Pulleys> || std::is_same_v<Group, Ropes> ||
                std::is_same_v<Group, UserConstraints> || std::is_same_v<Group, Springs> ||
                std::is_same_v<Group, Bonds>) {
    const auto& members = group.*KindOf<Group>::members;
    for (std::size_t k = 0; k < members.size(); ++k) {
      const std::string number = std::to_string(k);
      ShownParts::Tie tie{
          std::string(KindOf<Group>::name), name + "[" + number + "]", place + "/" + number, {}, {}, row + k};
      for (const Index point : members[k]) tie.points.push_back(slots[point]);
      if constexpr (std::is_same_v<Group, Pulleys>) tie.sheaves = {group.a, group.b};
      if constexpr (std::is_same_v<Group, Ropes>) {
        tie.rope = {entry, k, group.coefficients};
        tie.rope->coefficients.resize(members[k].size() - 1, 1.0);
      }
      if (tie.points.size() < 2 || std::ranges::any_of(tie.points, [](std::int32_t slot) { return slot < 0; }))
        continue;
      if (shown->ties.size() == most)
        ++shown->ties_left_out;
      else
        shown->ties.push_back(std::move(tie));
    }
  }
}

double find_tension(std::size_t row, std::span<const double> multipliers) {
  const bool is_known = row < multipliers.size() && !std::isnan(multipliers[row]);  // no -nan in tables
  return is_known ? -multipliers[row] : std::numeric_limits<double>::quiet_NaN();
}

/// Adds the image of a point and returns its position behind the points.
std::int32_t add_image(std::int32_t point, const Vector3& offset, ShownParts* shown) {
  shown->images.push_back({point, offset});
  return static_cast<std::int32_t>(shown->num_points + shown->images.size() - 1);
}

}  // namespace

ShownParts choose_parts(const System& system, std::span<const Index> chosen) {
  ShownParts shown;
  shown.units = system.units;
  shown.points.assign(chosen.begin(), chosen.end());
  if (chosen.empty()) {
    shown.points.resize(system.num_points());
    std::iota(shown.points.begin(), shown.points.end(), 0);
  }
  shown.num_points = shown.points.size();

  std::vector<std::int32_t> slots(system.num_points(), -1);
  for (std::size_t k = 0; k < shown.num_points; ++k) slots[shown.points[k]] = static_cast<std::int32_t>(k);

  shown.is_support.assign(shown.num_points, false);
  for (std::size_t k = 0; k < system.supports.size(); ++k) {
    const auto& [given, points, motion] = system.supports[k];
    const std::string name = given.empty() ? "support" + std::to_string(k) : given;
    for (std::size_t member = 0; member < points.size(); ++member) {
      const std::int32_t slot = slots[points[member]];
      if (slot < 0) continue;
      shown.is_support[slot] = true;
      shown.support_names[slot] = {name, "supports/" + std::to_string(k), member};
    }
  }

  std::vector<bool> is_touched(shown.num_points, false);
  std::size_t row = 0;
  for (std::size_t g = 0; g < system.constraints.size(); ++g) {
    const Constraint& constraint = system.constraints[g];
    const std::string name = constraint_name(system, g);
    if (const auto* rods = std::get_if<Rods>(&constraint)) {
      ShownParts::RodGroup group{name, shown.rods.size(), {}, g};
      for (std::size_t k = 0; k < rods->pairs.size(); ++k) {
        const std::int32_t i = slots[rods->pairs[k][0]], j = slots[rods->pairs[k][1]];
        if (i < 0 || j < 0) continue;
        const Vector3 offset = rods->offsets.empty() ? Vector3{} : rods->offsets[k];
        shown.rods.push_back({i, offset == Vector3{} ? j : add_image(j, offset, &shown)});
        shown.rod_rows.push_back(row + k);
        group.members.push_back(k);
        is_touched[i] = is_touched[j] = true;
      }
      const bool is_shown = !group.members.empty();
      if (group.members.size() == rods->pairs.size()) group.members.clear();
      if (is_shown) shown.rod_groups.push_back(std::move(group));
    }
    std::visit([&](const auto& group) { add_ties(group, name, place_of_constraint(g), g, row, slots, &shown); },
               constraint);
    const auto [members, rows_per_member] = detail::shape_of(constraint);
    row += members * rows_per_member;
  }
  for (std::size_t k = 0; k < system.forces.size(); ++k)
    std::visit(
        [&](const auto& group) {
          add_ties(group, force_name(system, k), "forces/" + std::to_string(k), k, row, slots, &shown);
        },
        system.forces[k]);
  for (std::size_t k = 0; k < shown.num_points; ++k) {
    if (!is_touched[k]) shown.loose_points.push_back(static_cast<std::int32_t>(k));
  }
  return shown;
}

GoneTimes::GoneTimes(std::span<const Passage> passages) {
  for (const Passage& each : passages)
    if (!each.taken.empty()) times_.emplace(each.taken, each.time);
}

double GoneTimes::of(const std::string& place) const {
  const auto found = times_.find(place);
  return found == times_.end() ? std::numeric_limits<double>::quiet_NaN() : found->second;
}

GoneParts find_gone(const ShownParts& shown, std::span<const Passage> passages) {
  const GoneTimes times(passages);
  if (times.is_empty()) return {};
  GoneParts gone;
  shown.for_each_rod([&](const ShownParts::RodGroup& group, std::size_t k) {
    gone.rods.push_back(times.of(place_of_constraint(group.number), k));
  });
  gone.supports.assign(shown.num_points, times.of(""));
  for (const auto& [slot, member] : shown.support_names)
    gone.supports[slot] = std::fmin(times.of(member.entry), times.of(member.entry, member.number));
  return gone;
}

void gather_points(const ShownParts& shown, std::span<const double> all, std::vector<double>* rows) {
  rows->resize(3 * shown.num_points);
  double* row = rows->data();
  for (const Index point : shown.points) row = std::copy_n(&all[3 * static_cast<std::size_t>(point)], 3, row);
}

std::vector<double> find_tensions(const ShownParts& shown, std::span<const double> multipliers) {
  std::vector<double> tensions;
  tensions.reserve(shown.rod_rows.size());
  for (const std::size_t row : shown.rod_rows) tensions.push_back(find_tension(row, multipliers));
  return tensions;
}

std::vector<double> unique_multipliers(std::span<const double> multipliers, std::span<const double> self_stress) {
  std::vector<double> unique(multipliers.begin(), multipliers.end());
  for (std::size_t row = 0; row < self_stress.size(); ++row)
    if (self_stress[row] != 0.0) unique[row] = std::numeric_limits<double>::quiet_NaN();
  return unique;
}

std::vector<double> find_tie_tensions(const ShownParts& shown, std::span<const double> multipliers) {
  std::vector<double> tensions;
  for (const ShownParts::Tie& tie : shown.ties) tensions.push_back(find_tension(tie.row, multipliers));
  return tensions;
}

std::vector<double> gather_images(const ShownParts& shown, std::span<const double> rows) {
  std::vector<double> images;
  images.reserve(3 * shown.images.size());
  for (const auto& [point, offset] : shown.images) {
    for (std::size_t axis = 0; axis < 3; ++axis) images.push_back(rows[3 * static_cast<std::size_t>(point) + axis]);
  }
  return images;
}

std::vector<double> gather_shifted_images(const ShownParts& shown, std::span<const double> positions) {
  std::vector<double> images = gather_images(shown, positions);
  double* row = images.data();
  for (const auto& [point, offset] : shown.images) {
    for (std::size_t axis = 0; axis < 3; ++axis) *row++ += offset[axis];
  }
  return images;
}

double measure_diagonal(std::span<const double> positions) {
  double square = 0.0;
  for (std::size_t axis = 0; axis < 3 && !positions.empty(); ++axis) {
    double low = positions[axis], high = low;
    for (std::size_t i = axis; i < positions.size(); i += 3) {
      low = std::min(low, positions[i]);
      high = std::max(high, positions[i]);
    }
    square += (high - low) * (high - low);
  }
  return std::sqrt(square);
}

Vector3 find_gravity(const System& system) {
  Vector3 sum{};
  for (const Force& force : system.forces) {
    const auto* gravity = std::get_if<Gravity>(&force);
    if (!gravity) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += gravity->acceleration[axis];
  }
  return sum;
}

std::vector<double> find_guide_forces(const ShownParts& shown, std::span<const double> positions,
                                      std::span<const double> tensions, std::span<const double> reactions,
                                      std::span<const double> support_forces) {
  std::vector<double> rows(3 * shown.num_points);
  for (std::size_t k = 0; k < shown.num_points; ++k) {
    const std::size_t first = 3 * static_cast<std::size_t>(shown.points[k]);
    for (std::size_t axis = 0; axis < 3; ++axis)
      rows[3 * k + axis] = shown.is_support[k] ? -support_forces[first + axis] : reactions[first + axis];
  }
  const std::vector<double> images = gather_shifted_images(shown, positions);
  for (std::size_t k = 0; k < shown.rods.size(); ++k) {
    const auto [i, j] = shown.rods[k];
    const auto place = [&](std::size_t p) {
      return p < shown.num_points ? &positions[3 * p] : &images[3 * (p - shown.num_points)];
    };
    const double *a = place(i), *b = place(j);
    // T (r_j - r_i)/|r_j - r_i|
    const double length = std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]), pull = tensions[k] / length;
    if (!std::isfinite(pull)) continue;
    const std::size_t far = static_cast<std::size_t>(j) < shown.num_points
                                ? static_cast<std::size_t>(j)
                                : static_cast<std::size_t>(shown.images[j - shown.num_points].point);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double force = pull * (b[axis] - a[axis]);
      if (!shown.is_support[i]) rows[3 * i + axis] -= force;
      if (!shown.is_support[far]) rows[3 * far + axis] += force;
    }
  }
  return rows;
}

}  // namespace tanor::report
