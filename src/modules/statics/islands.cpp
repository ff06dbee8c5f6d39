#include "statics/islands.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "statics/equilibrium_equations.hpp"

namespace tanor::detail {

namespace {

/// Disjoint sets of points.
class PointSets {
 public:
  explicit PointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

  void join(int i, int j) { parent_[static_cast<std::size_t>(find(i))] = find(j); }
  void join_rows(const Model& model) {
    std::vector<int> first(model.num_rows(), -1);
    for (const Incidence& incidence : model.incidences) {
      if (static_cast<std::size_t>(incidence.point) >= parent_.size()) continue;
      int& own = first[static_cast<std::size_t>(incidence.row)];
      own < 0 ? void(own = incidence.point) : join(own, incidence.point);
    }
  }
  std::vector<int> representatives() {
    for (std::size_t i = 0; i < parent_.size(); ++i) parent_[i] = find(static_cast<int>(i));
    return parent_;
  }

 private:
  int find(int i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      int& up = parent_[static_cast<std::size_t>(i)];
      i = up = parent_[static_cast<std::size_t>(up)];
    }
    return i;
  }

  std::vector<int> parent_;
};

}  // namespace

std::vector<int> find_joined_points(const Model& model) {
  PointSets sets(model.num_moving());
  sets.join_rows(model);
  return sets.representatives();
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
  PointSets sets(W.num_points());
  W.for_each_block(
      [&](std::size_t i, std::size_t j, std::size_t) { sets.join(static_cast<int>(i), static_cast<int>(j)); });
  sets.join_rows(equations.model());
  const std::vector<int> representatives = sets.representatives();
  std::vector<std::size_t> number;
  for (std::size_t i = 0, next = 0; i < representatives.size(); ++i)
    number.push_back(representatives[i] == static_cast<int>(i) ? next++ : next);
  for (std::size_t i = 0; i < representatives.size(); ++i) {
    of_point.push_back(number[static_cast<std::size_t>(representatives[i])]);
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
