#include "evaluate/constraint_series.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <variant>

#include "base/groups.hpp"
#include "base/text.hpp"
#include "evaluate/definitions.hpp"
#include "system/members.hpp"

namespace tanor::detail {

namespace {

/// Finds the blocks of K by row and point.
class BlockPlaces {
 public:
  BlockPlaces(std::span<const Incidence> incidences, std::size_t num_rows)
      : blocks_(num_rows, [&](const auto& add) {
          for (const Incidence& incidence : incidences) add(incidence.row, {incidence.point, incidence.block});
        }) {}
  /// Returns the block of this row and point.
  Index find(Index row, Index point) const {
    return std::ranges::find(blocks_[static_cast<std::size_t>(row)], point, &PointBlock::point)->block;
  }

 private:
  struct PointBlock {
    Index point, block;
  };
  Groups<PointBlock> blocks_;  // [row]
};

/// Returns the slot of a member's parameter: one for all members if they share it, else one each.
template <class Get>
std::size_t add_parameter(TimeSeriesTable* table, const Parameter& parameter, std::optional<std::size_t>* shared,
                          const Get& get) {
  const bool is_shared = parameter.functions.size() == 1 || parameter.constants.size() == 1;
  if (is_shared && *shared) return **shared;
  const std::size_t slot = table->add(get());
  if (is_shared) *shared = slot;
  return slot;
}

}  // namespace

/// The input of the constructor.
struct ConstraintSeries::Source {
  const System& system;
  const Numbering& numbering;
  Definitions definitions;
  BlockPlaces places;
  std::span<const char> takes_part;
  Index first_outside = find_first_outside(system);  // of points of members that events took out

  Index inner(Index point) const { return numbering.inner_point[static_cast<std::size_t>(point)]; }
  /// Returns the slot of the length of member k in the table, or nothing if the length does not move.
  std::optional<std::size_t> add_length(TimeSeriesTable* table, const Parameter& length, std::size_t group,
                                        std::size_t k, std::optional<std::size_t>* shared) const {
    if (length.functions.empty()) return std::nullopt;
    return add_parameter(table, length, shared, [&] { return definitions.parameter(group, k); });
  }
};

ConstraintSeries::ConstraintSeries(const System& system, const Numbering& numbering,
                                   std::span<const Incidence> incidences, double t0, std::span<const char> takes_part) {
  const Source source{system, numbering, Definitions(system, t0), BlockPlaces(incidences, numbering.num_rows()),
                      takes_part};
  std::size_t first_member = 0;
  for (std::size_t g = 0; g < system.constraints.size() && obstacle_.empty(); ++g) {
    std::visit(
        [&](const auto& given) {
          if (num_members(given) > 0) add_group(source, g, given, first_member);
          first_member += num_members(given);
        },
        system.constraints[g]);
  }
  if (obstacle_.empty() && table_.has_unknown(t0)) obstacle_ = "a function of time is known as a function alone";
}

void ConstraintSeries::add_group(const Source& source, std::size_t g, const Rods& rods, std::size_t first_member) {
  std::optional<std::size_t> shared;
  for (std::size_t k = 0; k < rods.pairs.size(); ++k) {
    const Index i = source.inner(rods.pairs[k][0]), j = source.inner(rods.pairs[k][1]);
    const Index row = source.numbering.member_row[first_member + k];
    if (rods.pairs[k][0] >= source.first_outside) continue;
    if (!source.takes_part.empty() && source.takes_part[static_cast<std::size_t>(row)] == 0) continue;
    DistanceSeries::Extra extra;
    if (!rods.offsets.empty()) extra.offset = make_vec3(rods.offsets[k]);
    extra.length = source.add_length(&table_, rods.length, g, k, &shared);
    distances_.append({.i = i, .j = j, .row = row, .block = source.places.find(row, j)}, extra);
  }
}

void ConstraintSeries::add_group(const Source& source, std::size_t g, const Spheres& spheres,
                                 std::size_t first_member) {
  std::optional<std::size_t> shared;
  std::array<std::size_t, 3> center;
  for (std::size_t c = 0; c < 3; ++c) center[c] = table_.add(spheres.center.components[c]);
  for (std::size_t k = 0; k < spheres.points.size(); ++k) {
    if (spheres.points[k] >= source.first_outside) continue;
    const Index j = source.inner(spheres.points[k]), row = source.numbering.member_row[first_member + k];
    DistanceSeries::Extra extra{.center = center[0]};
    extra.length = source.add_length(&table_, spheres.radius, g, k, &shared);
    distances_.append({.j = j, .row = row, .block = source.places.find(row, j)}, extra);
  }
}

/// Adds a group of any other kind, which runs on its definition. The two unit vectors of a direction that turns come
/// from an axis that depends on the instant, so all three axes are prepared.
template <class G>
void ConstraintSeries::add_group(const Source& source, std::size_t g, const G& given, std::size_t first_member) {
  if constexpr (requires { KindOf<G>::turning; }) {
    const VectorFunction& direction = given.*KindOf<G>::turning;
    if (!direction.is_constant()) {
      Turning turning{};
      for (std::size_t c = 0; c < 3; ++c) turning.direction[c] = table_.add(direction.components[c]);
      for (turning.axis = 0; turning.axis < 3 && obstacle_.empty(); ++turning.axis)
        add_recorded(source, g, given, first_member, turning);
      return;
    }
  }
  add_recorded(source, g, given, first_member, std::nullopt);
}

/// Adds a program for each number of points that members have.
template <class G>
void ConstraintSeries::add_recorded(const Source& source, std::size_t g, const G& given, std::size_t first_member,
                                    std::optional<Turning> turning) {
  const auto size_of = [&](std::size_t k) { return member_points(given, k).size(); };
  std::vector<std::size_t> sizes;
  for (std::size_t k = 0; k < num_members(given) && obstacle_.empty(); ++k) {
    if (std::ranges::find(sizes, size_of(k)) != sizes.end()) continue;
    sizes.push_back(size_of(k));
    add_members_like(source, g, given, first_member, turning, k);
  }
}

template <class G>
void ConstraintSeries::add_members_like(const Source& source, std::size_t g, const G& given, std::size_t first_member,
                                        std::optional<Turning> turning, std::size_t member) {
  const Definitions& definitions = source.definitions;
  const std::optional<RecordedDefinition> recorded =
      definitions.record(g, turning ? std::optional(turning->axis) : std::nullopt, member);
  if (!recorded) {
    obstacle_ = "constraints[" + text(g) + "] cannot be expanded in time: it is known as a function alone";
    return;
  }
  const int p = static_cast<int>(member_points(given, member).size());
  const int num_functions = static_cast<int>(recorded->expression.variables.size()) - 3 * p;
  std::vector<char> is_position(3 * static_cast<std::size_t>(p), 1);
  is_position.resize(recorded->expression.variables.size(), 0);
  const bool is_linear = SeriesProgram(recorded->expression, false).is_linear_in(is_position);
  SeriesProgram program(recorded->expression, !is_linear);
  Group group{.family = ProgramFamily(std::move(program), list_variables(p, false, num_functions), p, num_functions),
              .is_linear = is_linear,
              .turning = turning};
  bool is_still = is_linear;
  std::vector<std::size_t> slots;
  const auto add = [&](const ScalarFunction& function) {
    is_still = is_still && function.is_constant();
    slots.push_back(table_.add(function));
  };
  for (const ScalarFunction& function : recorded->functions) add(function);
  const std::size_t num_shared = slots.size();
  for (std::size_t k = member; k < num_members(given); ++k) {
    if (member_points(given, k).size() != static_cast<std::size_t>(p)) continue;
    if (member_points(given, k)[0] >= source.first_outside) continue;
    const Index row = source.numbering.member_row[first_member + k];
    slots.resize(num_shared);
    if (recorded->has_parameter) add(definitions.parameter(g, k));
    std::vector<Index> points;
    for (const Index point : member_points(given, k)) points.push_back(source.inner(point));
    group.family.append_member(points, slots);
    group.rows.push_back(row);
    for (const Index point : points) group.blocks.push_back(source.places.find(row, point));
  }
  if (group.rows.empty()) return;
  if (!is_still) {
    groups_.push_back(std::move(group));
    return;
  }
  for (const Index row : group.rows) {
    for (std::size_t m = 0; m < group.family.program().num_results(); ++m)
      still_rows_.push_back(row + static_cast<Index>(m));
  }
}

std::vector<Incidence> ConstraintSeries::turning(std::span<const Incidence> incidences) const {
  std::vector<char> turns;
  const auto mark = [&](Index block) {
    turns.resize(std::max(turns.size(), static_cast<std::size_t>(block) + 1), 0);
    turns[static_cast<std::size_t>(block)] = 1;
  };
  distances_.for_each_block(mark);
  for (const Group& group : groups_) {
    if (!group.is_linear) std::for_each(group.blocks.begin(), group.blocks.end(), mark);
  }
  std::vector<Incidence> result;
  for (const Incidence& incidence : incidences) {
    const auto block = static_cast<std::size_t>(incidence.block);
    if (block < turns.size() && turns[block] != 0) result.push_back(incidence);
  }
  return result;
}

void ConstraintSeries::begin(double t, int order) {
  table_.expand(t, order);
  distances_.resize(order);
  for (Group& group : groups_) {
    group.family.resize(order);
    if (!group.turning) continue;
    std::array<double, 3> d;
    for (std::size_t c = 0; c < 3; ++c) d[c] = table_[group.turning->direction[c]][0];
    group.takes_part = line_axis(d) == group.turning->axis;
  }
}

template <class Lane>
void ConstraintSeries::advance_chunk(Group& group, Lane* lanes, std::size_t chunk, int k,
                                     std::span<double* const> coefficients, const double* last, double* blocks,
                                     double* rows) {
  ProgramFamily& family = group.family;
  const SeriesProgram& program = family.program();
  const int order = family.order();
  // Coefficient k + 1 of the points and k - 1 of lambda became known. The next ones are evaluated without the points.
  const auto evaluate = [&](int coefficient, bool points_known) {
    family.load(lanes, chunk, coefficient, coefficients, table_, points_known);
    program.evaluate(lanes, order, coefficient);
  };
  if (k == 0) evaluate(0, true);
  evaluate(k + 1, true);
  evaluate(k + 2, false);

  const std::size_t first = chunk * series_width, count = std::min(series_width, family.size() - first);
  const std::size_t p = family.points_per_member();
  for (std::size_t m = 0; m < program.num_results(); ++m) {
    const Lane& xi = program.result(lanes, order, m)[k + 2];
    for (std::size_t lane = 0; lane < count; ++lane)
      rows[group.rows[first + lane] + static_cast<Index>(m)] = member_of(xi, lane);
  }
  if (group.is_linear) return;
  Lane zero[2]{};
  if (k > 0) {
    Lane seeds[2]{};
    for (std::size_t m = 0; m < program.num_results(); ++m) {
      for (std::size_t lane = 0; lane < width_of<Lane>; ++lane)
        member_of(seeds[m], lane) = last[group.rows[family.member(chunk, lane)] + static_cast<Index>(m)];
    }
    program.differentiate(lanes, order, k - 1, seeds);
    program.differentiate(lanes, order, k, zero);
  }
  for (std::size_t i = 0; i < p; ++i) {
    const Lane* gradient[3];
    for (std::size_t c = 0; c < 3; ++c) gradient[c] = program.adjoint(lanes, order, 3 * i + c) + k;
    for (std::size_t lane = 0; lane < count; ++lane) {
      Vec3 force{};
      if (k > 0) force = {member_of(*gradient[0], lane), member_of(*gradient[1], lane), member_of(*gradient[2], lane)};
      store(blocks, group.blocks[(first + lane) * p + i], force);
    }
  }
}

void ConstraintSeries::advance(const Parallel& parallel, int k, std::span<double* const> coefficients,
                               const double* last, double* blocks, double* rows) {
  for (const Index row : still_rows_) rows[row] = 0.0;
  if (distances_.size() > 0) distances_.advance(parallel, k, coefficients, table_, last, blocks, rows);
  for (Group& group : groups_) {
    if (!group.takes_part) continue;
    group.family.for_each_chunk(parallel, [&](std::size_t chunk, auto* lanes) {
      advance_chunk(group, lanes, chunk, k, coefficients, last, blocks, rows);
    });
  }
}

}  // namespace tanor::detail
