#include "statics/islands.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "base/disjoint_sets.hpp"
#include "statics/equilibrium_equations.hpp"

namespace tanor::detail {

namespace {

/// Joins the points of each row in sets (see disjoint_sets.hpp).
void join_rows(const Model& model, std::vector<int>* sets) {
  std::vector<int> first(model.num_rows(), -1);
  for (const Incidence& incidence : model.incidences) {
    if (static_cast<std::size_t>(incidence.point) >= sets->size()) continue;
    int& own = first[static_cast<std::size_t>(incidence.row)];
    own = own < 0 ? incidence.point : join_sets(sets->data(), own, static_cast<int>(incidence.point));
  }
}

}  // namespace

std::vector<int> find_joined_points(const Model& model) {
  std::vector<int> sets(model.num_moving());
  std::iota(sets.begin(), sets.end(), 0);
  join_rows(model, &sets);
  for (int& point : sets) point = find_root(sets.data(), point);
  return sets;
}

std::vector<Eigen::Index> StaticsIsland::coordinates() const {
  std::vector<Eigen::Index> result;
  for (const std::size_t i : points) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) result.push_back(3 * static_cast<Eigen::Index>(i) + axis);
  }
  return result;
}

StaticsIslands::StaticsIslands(const EquilibriumEquations& equations) {
  const StiffnessMatrix& W = equations.stiffness();
  std::vector<int> sets(W.num_points());
  std::iota(sets.begin(), sets.end(), 0);
  W.for_each_block([&](std::size_t i, std::size_t j, std::size_t) {
    join_sets(sets.data(), static_cast<int>(i), static_cast<int>(j));
  });
  join_rows(equations.model(), &sets);
  for (std::size_t i = 0; i < sets.size(); ++i) {
    // Every root is the least point of its island.
    const auto root = static_cast<std::size_t>(find_root(sets.data(), sets[i]));
    of_point.push_back(root == i ? list.size() : of_point[root]);
    list.resize(std::max(list.size(), of_point[i] + 1));
    StaticsIsland& own = list[of_point[i]];
    own.points.push_back(i);
    own.stiffness = std::max(own.stiffness, W.largest_of(i));
  }
  std::vector<char> is_listed(equations.model().num_rows(), 0);
  for (const Incidence& incidence : equations.model().incidences) {
    const auto row = static_cast<std::size_t>(incidence.row), point = static_cast<std::size_t>(incidence.point);
    if (point < of_point.size() && !std::exchange(is_listed[row], 1)) list[of_point[point]].rows.push_back(row);
  }
}

}  // namespace tanor::detail
