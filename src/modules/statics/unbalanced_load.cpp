#include "statics/unbalanced_load.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/dense.hpp"
#include "base/text.hpp"
#include "base/with_unit.hpp"
#include "statics/islands.hpp"

namespace tanor::detail {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d to_eigen(Vec3 a) {
  return {a.x, a.y, a.z};
}

/// Returns the force on each island along the shifts u that nothing answers to, u'(KK' + WW')u = 0.
std::vector<Vector3d> find_pulls(EquilibriumEquations& equations, const StaticsIslands& islands) {
  constexpr double nothing = 1e-20, of_forces = 1e-9;
  const Model& model = equations.model();
  std::vector<Vector3d> row_shift(model.num_rows(), Vector3d::Zero());
  for (const Incidence& incidence : model.incidences) {
    if (static_cast<std::size_t>(incidence.point) < islands.of_point.size())
      row_shift[static_cast<std::size_t>(incidence.row)] +=
          to_eigen(incidence.sign * load(equations.gradients().data(), incidence.block));
  }
  // If u'W = 0, the total force along u does not depend on the positions.
  const StiffnessMatrix& W = equations.stiffness();
  std::vector<Matrix3d> sums(islands.of_point.size(), Matrix3d::Zero());
  W.for_each_block([&](std::size_t, std::size_t j, std::size_t k) {
    sums[j] += Matrix3d::NullaryExpr(
        [&](Eigen::Index row, Eigen::Index c) { return W.blocks()[k](static_cast<int>(row), static_cast<int>(c)); });
  });
  std::vector<Vector3d> pulls;
  for (const StaticsIsland& island : islands.list) {
    Matrix3d answer = Matrix3d::Zero();
    Vector3d force = Vector3d::Zero();
    double scale = 0.0;  // N, of the summed forces
    for (const std::size_t row : island.rows) answer += row_shift[row] * row_shift[row].transpose();
    for (const std::size_t i : island.points) {
      const Vec3 own = load(equations.forces().data(), i);
      const Matrix3d shifted = sums[i] / island.stiffness;
      answer += shifted * shifted.transpose();
      force += to_eigen(own);
      scale += norm(own);
    }
    const dense::SymmetricEigen eigen = dense::find_eigen(answer);
    Vector3d& pull = pulls.emplace_back(Vector3d::Zero());
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d u = eigen.vectors.col(axis);
      if (eigen.values[axis] < nothing) pull += u.dot(force) * u;
    }
    if (!(pull.norm() > of_forces * scale)) pull.setZero();
  }
  return pulls;
}

bool are_none(const std::vector<Vector3d>& pulls) {
  return std::ranges::all_of(pulls, [](const Vector3d& pull) { return pull.isZero(0.0); });
}

/// Erases the pulls of islands whose constraints, or forces along the pull, have changed after shifts by a distance.
void erase_answered(const EquilibriumEquations& equations, const StaticsIslands& islands,
                    const std::vector<double>& xi_before, const std::vector<double>& xi, double distance,
                    std::vector<Vector3d>* pulls) {
  constexpr double changed = 1e-9;
  std::vector<char> is_held(pulls->size(), 0);
  for (const Incidence& incidence : equations.model().incidences) {
    const auto row = static_cast<std::size_t>(incidence.row), point = static_cast<std::size_t>(incidence.point);
    const double gradient = norm(load(equations.gradients().data(), incidence.block));
    if (point < islands.of_point.size() && !(std::abs(xi[row] - xi_before[row]) <= changed * distance * gradient))
      is_held[islands.of_point[point]] = 1;
  }
  for (std::size_t k = 0; k < pulls->size(); ++k) {
    const double pull = (*pulls)[k].norm();
    double along = 0.0, scale = 0.0;
    for (const std::size_t i : islands.list[k].points) {
      const Vec3 force = load(equations.forces().data(), i);
      along += to_eigen(force).dot((*pulls)[k].normalized());
      scale += norm(force);
    }
    if (is_held[k] != 0 || !(std::abs(along - pull) <= changed * std::max(pull, scale))) (*pulls)[k].setZero();
  }
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

  const StaticsIslands islands(equations);
  std::vector<Vector3d> pulls = find_pulls(equations, islands);
  // Pulls are kept that are the same wherever the island is shifted along them. At the start a stiffness may be too
  // small to be seen, as far above an exponential floor or beside a stiff spring, or zero except at a kink.
  for (const double part : {1e-2, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 100.0, 1e3}) {
    if (are_none(pulls)) return {};
    const double distance = part * model.scene_size;
    std::vector<double> moved = elsewhere, xi_moved(xi.size());
    for (std::size_t i = 0; i < islands.of_point.size(); ++i) {
      const Vector3d way = distance * pulls[islands.of_point[i]].normalized();
      add_to(moved.data(), i, {way[0], way[1], way[2]});
    }
    (void)equations.evaluate(moved.data(), lambda.data(), g.data(), xi_moved.data());
    erase_answered(equations, islands, xi, xi_moved, distance, &pulls);
  }
  if (are_none(pulls)) return {};

  // Islands are told in the order of their first points.
  std::vector<std::pair<Index, Vector3d>> in_order;
  for (std::size_t k = 0; k < pulls.size(); ++k) {
    const auto user_point = [&](std::size_t i) { return model.numbering.user_point[i]; };
    const std::size_t first = std::ranges::min(islands.list[k].points, {}, user_point);
    in_order.push_back({user_point(first), pulls[k]});
  }
  std::ranges::sort(in_order, {}, &std::pair<Index, Vector3d>::first);
  const auto found = std::ranges::find_if(in_order, [](const auto& own) { return !own.second.isZero(0.0); });
  const auto& [first, pull] = *found;
  const Vector3d way = pull.normalized();
  const bool has_gravity = std::ranges::any_of(
      model.system.forces, [](const Force& force) { return std::holds_alternative<Gravity>(force); });
  const auto rounded = [](double x) { return std::round(1e3 * x) / 1e3 + 0.0; };
  return std::string(has_gravity ? "gravity" : "the load") + " pulls the free island " +
         std::to_string(found - in_order.begin()) + " (of point " + std::to_string(first) + ") along " +
         text(std::array{rounded(way[0]), rounded(way[1]), rounded(way[2])}) +
         " without end: " + with_unit(text(pull.norm()), model.system.units.force) + " that nothing balances";
}

}  // namespace tanor::detail
