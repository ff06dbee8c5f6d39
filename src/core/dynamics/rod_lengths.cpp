#include "dynamics/rod_lengths.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <queue>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "base/text.hpp"
#include "base/vec3.hpp"
#include "base/with_unit.hpp"

namespace tanor::detail {

namespace {

/// The rods of a system as the edges of a graph, whose supports stand at known distances.
class RodGraph {
 public:
  RodGraph(const Model& model, double t, const double* r) : model_(model), r_(r), edges_of_(model.num_points()) {
    const auto inner = [&](Index point) { return model.numbering.inner_point[static_cast<std::size_t>(point)]; };
    for (std::size_t group = 0; group < model.system.constraints.size(); ++group) {
      const auto* const rods = std::get_if<Rods>(&model.system.constraints[group]);
      if (rods == nullptr || rods->length.is_initial() || !rods->offsets.empty()) continue;
      const auto& [constants, functions] = rods->length;
      const auto of = [](const auto& list, std::size_t k) { return list[list.size() == 1 ? 0 : k]; };
      for (std::size_t k = 0; k < rods->pairs.size(); ++k) {
        const auto [i, j] = rods->pairs[k];
        const double length = functions.empty() ? of(constants, k) : of(functions, k)(t).value();
        for (const Index end : {inner(i), inner(j)}) edges_of_[static_cast<std::size_t>(end)].push_back(edges_.size());
        edges_.push_back({{static_cast<std::size_t>(inner(i)), static_cast<std::size_t>(inner(j))}, length, group, k});
      }
    }
  }

  Outcome check(double t) const {
    for (std::size_t edge = 0; edge < edges_.size(); ++edge) {
      const std::optional<Way> way = find_shorter_way(edge);
      if (!way) continue;
      const auto [length, least] = texts_apart(std::array{edges_[edge].length, way->length});
      const std::string& unit = model_.system.units.length;
      return {Status::Contradictory, name(edge) + " is " + with_unit(length, unit) + " long at t = " + text(t) +
                                         ", but " + way->names + " let its ends be " + with_unit(least, unit) +
                                         " apart at most"};
    }
    return {};
  }

 private:
  struct Edge {
    std::array<std::size_t, 2> ends;
    double length;
    std::size_t group, member;
  };
  struct Way {
    double length;
    std::string names;
  };
  struct Arrival {
    double length;
    std::size_t before, edge;  // the last point, and the rod from there
  };
  static constexpr std::size_t between_supports = static_cast<std::size_t>(-1);

  std::string name(std::size_t edge) const {
    return constraint_name(model_.system, edges_[edge].group) + "[" + text(edges_[edge].member) + "]";
  }

  /// Dijkstra's search from one end of a rod, no farther than the rod is long.
  std::optional<Way> find_shorter_way(std::size_t own) const {
    constexpr double rounding = 1e-9;
    const Edge& rod = edges_[own];
    const double most = (1.0 - rounding) * rod.length;
    std::unordered_map<std::size_t, Arrival> reached{{rod.ends[0], {0.0, rod.ends[0], own}}};
    std::priority_queue<std::pair<double, std::size_t>, std::vector<std::pair<double, std::size_t>>, std::greater<>>
        open;
    open.emplace(0.0, rod.ends[0]);
    while (!open.empty()) {
      const auto [length, point] = open.top();
      open.pop();
      if (point == rod.ends[1]) return Way{length, name_way(reached, rod)};
      if (length > reached.at(point).length) continue;
      const auto see = [&](std::size_t to, double step, std::size_t edge) {
        const auto found = reached.find(to);
        if (length + step > most || (found != reached.end() && found->second.length <= length + step)) return;
        reached[to] = {length + step, point, edge};
        open.emplace(length + step, to);
      };
      for (const std::size_t edge : edges_of_[point]) {
        const auto& [ends, step, group, member] = edges_[edge];
        if (edge != own) see(ends[0] == point ? ends[1] : ends[0], step, edge);
      }
      for (std::size_t to = model_.num_moving(); point >= model_.num_moving() && to < model_.num_points(); ++to)
        see(to, norm(load(r_, to) - load(r_, point)), between_supports);
    }
    return {};
  }

  /// Returns "links[1], links[2] and supports".
  std::string name_way(const std::unordered_map<std::size_t, Arrival>& reached, const Edge& rod) const {
    constexpr std::size_t most_names = 3;
    std::vector<std::string> names;
    bool has_supports = false;
    for (std::size_t point = rod.ends[1]; point != rod.ends[0]; point = reached.at(point).before) {
      const std::size_t edge = reached.at(point).edge;
      edge == between_supports ? void(has_supports = true) : names.push_back(name(edge));
    }
    const std::size_t others = names.size() > most_names ? names.size() - most_names : 0;
    names.resize(names.size() - others);
    if (others > 0) names.push_back(text_of_count(others, "other rod"));
    if (has_supports) names.emplace_back("the supports");
    std::string list = names.front();
    for (std::size_t k = 1; k < names.size(); ++k) list += (k + 1 == names.size() ? " and " : ", ") + names[k];
    return list;
  }

  const Model& model_;
  const double* const r_;
  std::vector<Edge> edges_;
  std::vector<std::vector<std::size_t>> edges_of_;  // [point]
};

}  // namespace

Outcome check_rod_lengths(const Model& model, double t, const double* r) {
  return RodGraph(model, t, r).check(t);
}

}  // namespace tanor::detail
