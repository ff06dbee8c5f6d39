#include "statics/islands.hpp"

#include <algorithm>
#include <numeric>

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

std::vector<int> find_statics_islands(const EquilibriumEquations& equations) {
  const StiffnessMatrix& W = equations.stiffness();
  PointSets sets(W.num_points());
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k)
      sets.join(static_cast<int>(i), W.columns()[static_cast<std::size_t>(k)]);
  }
  sets.join_rows(equations.model());
  return sets.representatives();
}

std::vector<double> find_island_stiffness(const EquilibriumEquations& equations, const std::vector<int>& island) {
  const StiffnessMatrix& W = equations.stiffness();
  std::vector<double> largest(island.size(), 1e-150), result;
  for (std::size_t i = 0; i < island.size(); ++i) {
    double& own = largest[static_cast<std::size_t>(island[i])];
    own = std::max(own, W.largest_of(i));
  }
  for (const int own : island) result.push_back(largest[static_cast<std::size_t>(own)]);
  return result;
}

}  // namespace tanor::detail
