#include "statics/unbalanced_load.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "base/dense.hpp"
#include "base/text.hpp"
#include "statics/islands.hpp"

namespace tanor::detail {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The answer to a shift of an island along the axes, u'(KK' + WW')u, and the force on it.
struct Shifted {
  Matrix3d answer = Matrix3d::Zero();
  Vector3d force = Vector3d::Zero();
  double scale = 0.0;                                 // N, of the summed forces
  int first_point = std::numeric_limits<int>::max();  // in the user's order
};

std::map<int, Shifted> shift_islands(EquilibriumEquations& equations, const std::vector<int>& island) {
  const Model& model = equations.model();
  const std::size_t n = island.size();
  std::map<int, Shifted> result;
  for (std::size_t i = 0; i < n; ++i) {
    Shifted& own = result[island[i]];
    const Vec3 force = load(equations.forces().data(), i);
    own.force += Vector3d(force.x, force.y, force.z);
    own.scale += norm(force);
    own.first_point = std::min(own.first_point, static_cast<int>(model.numbering.user_point[i]));
  }
  const std::vector<double> stiffness = find_island_stiffness(equations, island);
  std::vector<int> of_row(model.num_rows(), -1);
  std::vector<Vector3d> row_shift(model.num_rows(), Vector3d::Zero());
  for (const Incidence& incidence : model.incidences) {
    if (static_cast<std::size_t>(incidence.point) >= n) continue;
    const Vec3 g = incidence.sign * load(equations.gradients().data(), incidence.block);
    row_shift[static_cast<std::size_t>(incidence.row)] += Vector3d(g.x, g.y, g.z);
    of_row[static_cast<std::size_t>(incidence.row)] = island[static_cast<std::size_t>(incidence.point)];
  }
  for (std::size_t row = 0; row < of_row.size(); ++row) {
    if (of_row[row] >= 0) result[of_row[row]].answer += row_shift[row] * row_shift[row].transpose();
  }
  // If u'W = 0, the total force along u does not depend on the positions.
  const StiffnessMatrix& W = equations.stiffness();
  std::vector<Matrix3d> sums(n, Matrix3d::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k) {
      const auto j = static_cast<std::size_t>(W.columns()[static_cast<std::size_t>(k)]);
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
          sums[j](row, column) += W.blocks()[static_cast<std::size_t>(k)](row, column) / stiffness[j];
      }
    }
  }
  for (std::size_t j = 0; j < n; ++j) result[island[j]].answer += sums[j] * sums[j].transpose();
  return result;
}

/// Returns the force on an island along the shifts that nothing answers to.
Vector3d find_pull(const Shifted& island) {
  constexpr double nothing = 1e-20, of_forces = 1e-9;
  const dense::SymmetricEigen eigen = dense::find_eigen(island.answer);
  Vector3d pull = Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d u = eigen.vectors.col(axis);
    if (eigen.values[axis] < nothing) pull += u.dot(island.force) * u;
  }
  return pull.norm() > of_forces * island.scale ? pull : Vector3d::Zero();
}

/// Evaluates constraints and forces after shifts along the pulls.
class ShiftedIslands {
 public:
  ShiftedIslands(EquilibriumEquations& equations, const std::vector<double>& r, const std::vector<double>& lambda,
                 const std::vector<int>& island)
      : equations_(equations), model_(equations.model()), r_(r), lambda_(lambda), island_(island) {
    xi_before_ = evaluate(r);
  }

  /// Keeps the pulls that are the same wherever the island is shifted along them. At the start a stiffness may be too
  /// small to be seen, as far above an exponential floor or beside a stiff spring, or zero except at a kink.
  void keep_endless(std::map<int, Vector3d>* pulls) {
    for (const double part : {1e-2, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 100.0, 1e3}) {
      const double distance = part * model_.scene_size;
      std::vector<double> moved = r_;
      for (std::size_t i = 0; i < island_.size(); ++i) {
        const auto own = pulls->find(island_[i]);
        if (own == pulls->end()) continue;
        const Vector3d way = distance * own->second.normalized();
        store(moved.data(), i, load(r_.data(), i) + Vec3{way[0], way[1], way[2]});
      }
      erase_answered(evaluate(moved), distance, pulls);
      if (pulls->empty()) return;
    }
  }

 private:
  std::vector<double> evaluate(const std::vector<double>& r) {
    std::vector<double> g(equations_.size()), xi(model_.num_rows());
    (void)equations_.evaluate(r.data(), lambda_.data(), g.data(), xi.data());
    return xi;
  }

  void erase_answered(const std::vector<double>& xi, double distance, std::map<int, Vector3d>* pulls) {
    constexpr double changed = 1e-9;
    std::map<int, double> along, scale;
    for (std::size_t i = 0; i < island_.size(); ++i) {
      const auto own = pulls->find(island_[i]);
      if (own == pulls->end()) continue;
      const Vec3 force = load(equations_.forces().data(), i);
      along[island_[i]] += Vector3d(force.x, force.y, force.z).dot(own->second.normalized());
      scale[island_[i]] += norm(force);
    }
    std::set<int> held;
    for (const Incidence& incidence : model_.incidences) {
      if (static_cast<std::size_t>(incidence.point) >= island_.size()) continue;
      const auto row = static_cast<std::size_t>(incidence.row);
      const double gradient = norm(load(equations_.gradients().data(), incidence.block));
      if (!(std::abs(xi[row] - xi_before_[row]) <= changed * distance * gradient))
        held.insert(island_[static_cast<std::size_t>(incidence.point)]);
    }
    std::erase_if(*pulls, [&](const auto& own) {
      const double pull = own.second.norm();
      return held.contains(own.first) ||
             !(std::abs(along[own.first] - pull) <= changed * std::max(pull, scale[own.first]));
    });
  }

  EquilibriumEquations& equations_;
  const Model& model_;
  const std::vector<double>&r_, &lambda_;
  const std::vector<int>& island_;
  std::vector<double> xi_before_;  // [rows]
};

bool has_gravity(const System& system) {
  return std::ranges::any_of(system.forces, [](const Force& force) { return std::holds_alternative<Gravity>(force); });
}

}  // namespace

std::string find_unbalanced_load(EquilibriumEquations& equations, const std::vector<double>& r) {
  const Model& model = equations.model();
  // The equations are linearised at a disturbed configuration with arbitrary multipliers, so that no answer vanishes by
  // accident.
  std::vector<double> elsewhere = r, lambda(model.num_rows()), g(equations.size()), xi(model.num_rows());
  equations.disturb(0.03 * model.smallest_length, elsewhere.data());
  for (std::size_t a = 0; a < lambda.size(); ++a) lambda[a] = 1.5 + std::cos(1.0 + 1.7 * static_cast<double>(a));
  equations.linearise(elsewhere.data(), lambda.data());
  (void)equations.evaluate(elsewhere.data(), lambda.data(), g.data(), xi.data());

  const std::vector<int> island = find_statics_islands(equations);
  const std::map<int, Shifted> islands = shift_islands(equations, island);
  std::map<int, Vector3d> pulls;
  for (const auto& [number, own] : islands) {
    if (const Vector3d pull = find_pull(own); !pull.isZero(0.0)) pulls[number] = pull;
  }
  if (!pulls.empty()) ShiftedIslands(equations, elsewhere, lambda, island).keep_endless(&pulls);
  if (pulls.empty()) return {};

  const auto first_point = [&](int number) { return islands.at(number).first_point; };
  const auto& [number, pull] =
      *std::ranges::min_element(pulls, {}, [&](const auto& own) { return first_point(own.first); });
  const auto first = first_point(number);
  const auto before =
      std::ranges::count_if(islands, [first](const auto& own) { return own.second.first_point < first; });
  const Vector3d way = pull.normalized();
  const auto rounded = [](double x) { return std::round(1e3 * x) / 1e3 + 0.0; };
  return std::string(has_gravity(model.system) ? "gravity" : "the load") + " pulls the free island " +
         std::to_string(before) + " (of point " + std::to_string(first) + ") along " +
         text(std::array{rounded(way[0]), rounded(way[1]), rounded(way[2])}) + " without end: " + text(pull.norm()) +
         " N that nothing balances";
}

}  // namespace tanor::detail
