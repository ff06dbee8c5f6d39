#include "report/guides.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <ranges>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "report/shown_parts.hpp"
#include "report/starting_places.hpp"

namespace tanor::report {

namespace {

/// True for groups that hold each point by itself, on a surface or curve that their fields describe.
template <class Group>
constexpr bool is_drawn = has_single_points<Group> && !std::is_same_v<Group, ChainAngles> &&
                          !std::is_same_v<decltype(KindOf<Group>::fields), const std::tuple<>>;

/// Returns the number of a member at time t, or nothing if the start decides it.
std::optional<double> number_of(const Parameter& parameter, std::size_t k, double t) {
  const auto of = [k](const auto& list) { return list[list.size() == 1 ? 0 : k]; };
  if (!parameter.constants.empty()) return of(parameter.constants);
  if (!parameter.functions.empty()) return of(parameter.functions)(t).value();
  return {};
}

/// Returns the fields of a member at time t, one after the other. What the system leaves to the start is measured
/// there.
template <class Group>
std::vector<double> place(const System& system, const Group& group, double t_start, double t, std::size_t k) {
  std::vector<double> numbers;
  const auto add = [&]<class Value>(const Value& value) {
    if constexpr (std::is_same_v<Value, VectorFunction>) {
      for (const auto& jet : value(t)) numbers.push_back(jet.value());
    } else if constexpr (std::is_same_v<Value, Parameter>) {
      const std::optional<double> given = number_of(value, k, t);
      numbers.push_back(given ? *given : measure_initial(system, group, t_start, k));
    } else if constexpr (std::is_same_v<Value, std::array<Vector3, 2>>) {
      for (const Vector3& v : value) numbers.insert(numbers.end(), v.begin(), v.end());
    } else if constexpr (std::is_same_v<Value, Vector3>) {
      numbers.insert(numbers.end(), value.begin(), value.end());
    } else if constexpr (std::is_same_v<Value, double>) {
      numbers.push_back(value);
    }
  };
  for_each_field<Group>([&](const auto& field) {
    if (std::string_view(field.name) != "restitution") add(group.*field.value);  // what a picture shows
  });
  return numbers;
}

bool are_close(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr double rounding = 1e-9;
  return std::ranges::equal(a, b, [](double x, double y) { return std::abs(x - y) <= rounding * (1.0 + std::abs(x)); });
}

/// Guides, and the points that each holds; none if a group has several guides. Those for which there is no room are
/// counted where `left_out` is given.
struct Placed {
  std::size_t* left_out;
  GoneTimes gone;
  std::vector<Guide> guides;
  std::vector<std::vector<Index>> points;

  /// Lets the last guide hold as long as another member does.
  void extend(double since) {
    double& last = guides.back().gone;
    last = std::isnan(since) ? since : std::max(last, since);
  }
  bool is_full() const { return guides.size() >= 64; }
  bool takes_another() const {
    if (is_full() && left_out != nullptr) ++*left_out;
    return !is_full();
  }
};

/// Returns the center, normal and radius of the circle in which a plane meets a sphere; the radius is 0 if it does not.
std::vector<double> cut_sphere(const std::vector<double>& sphere, const std::vector<double>& plane) {
  const TripleOf<double> center{sphere[0], sphere[1], sphere[2]}, normal{plane[0], plane[1], plane[2]};
  const double square = dot(normal, normal), shift = (plane[3] - dot(normal, center)) / square;
  const TripleOf<double> middle = center + shift * normal;
  const double radius = std::sqrt(std::max(0.0, sphere[3] * sphere[3] - shift * shift * square));
  return {middle.x, middle.y, middle.z, normal.x, normal.y, normal.z, radius};
}

/// Replaces a sphere and a plane that hold the same points.
void merge_rings(Placed* placed) {
  for (std::size_t s = 0; s < placed->guides.size(); ++s) {
    for (std::size_t p = 0; p < placed->guides.size() && placed->guides[s].kind == "sphere"; ++p) {
      if (placed->guides[p].kind != "plane" || placed->points[p].empty() || placed->points[p] != placed->points[s])
        continue;
      Guide& ring = placed->guides[s];
      ring = {"circle", ring.name, cut_sphere(ring.numbers, placed->guides[p].numbers),
              std::fmin(ring.gone, placed->guides[p].gone)};
      placed->guides.erase(placed->guides.begin() + static_cast<std::ptrdiff_t>(p));
      placed->points.erase(placed->points.begin() + static_cast<std::ptrdiff_t>(p));
      if (p < s) --s;
    }
  }
}

/// Adds one guide for all points, or one for each if their numbers differ at the start.
template <class Group>
void add_guides(const System& system, const Group& group, const std::string& entry, double t_start, double t,
                Placed* placed) {
  if constexpr (is_drawn<Group>) {
    const std::size_t first = placed->guides.size();
    std::vector<double> before;
    bool is_placed = false;
    for (std::size_t k = 0; k < group.points.size() && (!placed->is_full() || placed->left_out != nullptr); ++k) {
      std::vector<double> numbers = place(system, group, t_start, t_start, k);
      const double gone = placed->gone.of(entry, k);
      if (are_close(numbers, before)) {
        if (is_placed) placed->extend(gone);
        continue;
      }
      before = std::move(numbers);
      is_placed = placed->takes_another();
      if (is_placed)
        placed->guides.push_back(
            {std::string(KindOf<Group>::name), group.name, place(system, group, t_start, t, k), gone});
    }
    placed->points.resize(placed->guides.size());
    if (placed->guides.size() == first + 1) placed->points.back() = group.points;
  }
}

/// Returns true for a formula that defines a surface: it has one point, and its operations are known and few enough to
/// draw.
template <class Group>
bool has_surface([[maybe_unused]] const Group& group) {
  if constexpr (std::is_same_v<Group, UserConstraints>) {
    constexpr std::size_t most_steps = 500;
    const std::shared_ptr<const Expression>& expression = group.kernel.expression;
    return group.kernel.num_points == 1 && expression != nullptr && expression->instructions.size() <= most_steps;
  }
  return false;
}

/// Returns true for a formula of several points, between which a line is drawn.
template <class Group>
bool is_tie([[maybe_unused]] const Group& group) {
  if constexpr (std::is_same_v<Group, UserConstraints>) return group.kernel.num_points > 1;
  return false;
}

Guide place_surface(const UserConstraints& group, double t) {
  const Expression& expression = *group.kernel.expression;
  Guide guide{std::string(KindOf<UserConstraints>::name), group.name, {}};
  guide.numbers = {group.kernel.depends_on_time ? t : 0.0, static_cast<double>(expression.results[0])};
  for (std::size_t k = 0; k < expression.instructions.size(); ++k) {
    const Expression::Instruction& step = expression.instructions[k];
    const auto variable = std::ranges::find(expression.variables, static_cast<int>(k));
    const double constant = variable == expression.variables.end()
                                ? step.constant
                                : static_cast<double>(variable - expression.variables.begin());
    guide.numbers.insert(guide.numbers.end(), {static_cast<double>(step.operation), static_cast<double>(step.a),
                                               static_cast<double>(step.b), constant});
  }
  return guide;
}

template <class Visit>
void visit_groups(const System& system, const Visit& visit) {
  for (std::size_t k = 0; k < system.constraints.size(); ++k)
    std::visit([&](const auto& group) { visit(group, place_of_constraint(k)); }, system.constraints[k]);
  for (const auto& each : system.coordinates) std::visit([&](const auto& group) { visit(group, ""); }, each);
}

void mark(Index point, std::vector<bool>* marks) {
  (*marks)[static_cast<std::size_t>(point)] = true;
}
template <std::ranges::range Points>
void mark(const Points& points, std::vector<bool>* marks) {
  for (const auto& each : points) mark(each, marks);
}

}  // namespace

std::vector<Guide> place_guides(const System& system, double t_start, double t, std::span<const Passage> passages,
                                std::size_t* left_out) {
  if (left_out != nullptr) *left_out = 0;
  Placed placed{left_out, GoneTimes(passages), {}, {}};
  visit_groups(system, [&]<class Group>(const Group& group, const std::string& entry) {
    if constexpr (std::is_same_v<Group, UserConstraints>) {
      if (!has_surface(group) || !placed.takes_another()) return;
      placed.guides.push_back(place_surface(group, t));
      placed.guides.back().gone = placed.gone.of(entry, 0);
      for (std::size_t k = 1; k < (group.*KindOf<Group>::members).size(); ++k) placed.extend(placed.gone.of(entry, k));
      placed.points.emplace_back();
    } else {
      add_guides(system, group, entry, t_start, t, &placed);
    }
  });
  merge_rings(&placed);
  return std::move(placed.guides);
}

std::vector<Guide> list_ties(const ShownParts& shown, std::span<const Passage> passages) {
  const GoneTimes gone(passages);
  std::vector<Guide> guides;
  for (const ShownParts::Tie& tie : shown.ties) {
    Guide guide{tie.kind == "spring" ? tie.kind : "tie",
                tie.name,
                {static_cast<double>(tie.sheaves.size())},
                gone.of(tie.place)};
    for (const Vector3& sheave : tie.sheaves) guide.numbers.insert(guide.numbers.end(), sheave.begin(), sheave.end());
    guide.numbers.insert(guide.numbers.end(), tie.points.begin(), tie.points.end());
    guides.push_back(std::move(guide));
  }
  return guides;
}

double find_rope_length(const System& system, const RopeShape& rope, double t_start, double t) {
  const auto& ropes = std::get<Ropes>(system.constraints[rope.group]);
  const std::optional<double> given = number_of(ropes.length, rope.member, t);
  return given ? *given : measure_initial(system, ropes, t_start, rope.member);
}

std::vector<Guide> list_guides_without_picture(const System& system, const ShownParts& shown, double t_start) {
  std::vector<Guide> guides;
  for (const Constraint& each : system.constraints) {
    std::visit(
        [&]<class Group>(const Group& group) {
          constexpr bool has_line =
              std::is_same_v<Group, Rods> || std::is_same_v<Group, Ropes> || std::is_same_v<Group, Pulleys>;
          if constexpr (!is_drawn<Group> && !has_line)
            if (!has_surface(group) && !is_tie(group))
              guides.push_back({std::string(KindOf<Group>::name), group.name, {0.0}});
        },
        each);
  }
  std::size_t more = 0;
  place_guides(system, t_start, t_start, {}, &more);
  for (const auto& [what, count] :
       {std::pair{"ropes, formulas, springs and bonds", shown.ties_left_out}, {"guides", more}})
    if (count > 0) guides.push_back({of_others, what, {static_cast<double>(count)}});
  return guides;
}

std::vector<Guide> list_guides(const System& system, const ShownParts& shown, const std::vector<Guide>& without_picture,
                               double t_start, double t, std::span<const Passage> passages) {
  std::vector<Guide> guides = place_guides(system, t_start, t, passages), cells;
  if (const std::optional<Cell>& cell = system.cell; cell && cell->is_periodic_everywhere()) {
    const Vector3& o = cell->origin;
    cells.push_back(
        {"cell", "", {o[0], o[1], o[2], cell->xx, 0, 0, cell->xy, cell->yy, 0, cell->xz, cell->yz, cell->zz}});
  }
  std::vector<Guide> ties = list_ties(shown, passages);
  for (std::size_t k = 0; k < ties.size(); ++k) {
    const ShownParts::Tie& tie = shown.ties[k];
    if (!tie.rope) continue;
    std::vector<double> numbers{find_rope_length(system, *tie.rope, t_start, t)};
    numbers.insert(numbers.end(), tie.rope->coefficients.begin(), tie.rope->coefficients.end());
    numbers.insert(numbers.end(), tie.points.begin(), tie.points.end());
    ties[k].kind = tie.kind;
    ties[k].numbers = std::move(numbers);
  }
  for (const auto& list : {ties, cells, without_picture}) guides.insert(guides.end(), list.begin(), list.end());
  return guides;
}

std::string name_guide(const Guide& guide) {
  if (guide.kind == of_others) return fmt::format("{} more {}", count_of(guide), guide.name);
  return guide.name.empty() ? guide.kind : fmt::format("{} ({})", guide.name, guide.kind);
}

std::vector<bool> find_held_points(const System& system) {
  std::vector<bool> held(system.num_points(), false);
  for (const Support& support : system.supports) mark(support.points, &held);
  for (const Constraint& each : system.constraints) {
    std::visit(
        [&]<class Group>(const Group& group) {
          if constexpr (!std::is_same_v<Group, Rods>) mark(group.*KindOf<Group>::members, &held);
        },
        each);
  }
  for (const auto& each : system.coordinates) {
    std::visit(
        [&](const auto& group) {
          if constexpr (is_drawn<std::remove_cvref_t<decltype(group)>>) mark(group.points, &held);
        },
        each);
  }
  return held;
}

}  // namespace tanor::report
