#include "statics/unbalanced_load.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/text.hpp"
#include "statics/rigid_modes.hpp"

namespace tanor {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What answers to a shift of an island along the axes, u'(KK' + W'W)u, and the force on it.
struct Shifted {
  Matrix3d answer = Matrix3d::Zero();
  Vector3d force = Vector3d::Zero();
  double scale = 0.0;                                 // N, of the forces that are summed
  int first_point = std::numeric_limits<int>::max();  // the user's
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
  const double stiffness = std::max(equations.stiffness().largest(), 1e-300);
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
  const StiffnessMatrix& W = equations.stiffness();
  for (std::size_t i = 0; i < n; ++i) {
    Matrix3d sum = Matrix3d::Zero();
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k) {
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
          sum(row, column) += W.blocks()[static_cast<std::size_t>(k)](row, column) / stiffness;
      }
    }
    result[island[i]].answer += sum.transpose() * sum;
  }
  return result;
}

bool has_gravity(const System& system) {
  return std::ranges::any_of(system.forces, [](const Force& force) { return std::holds_alternative<Gravity>(force); });
}

}  // namespace

std::string find_unbalanced_load(EquilibriumEquations& equations, const std::vector<double>& r) {
  const Model& model = equations.model();
  // Somewhere else, with other multipliers: what answers nowhere does not answer here by chance.
  std::vector<double> elsewhere = r, lambda(model.num_rows()), g(equations.size()), xi(model.num_rows());
  for (std::size_t i = 0; i < equations.size(); ++i)
    elsewhere[i] += 0.03 * model.smallest_length * std::sin(1.0 + 2.3 * static_cast<double>(i));
  for (std::size_t a = 0; a < lambda.size(); ++a) lambda[a] = 1.5 + std::cos(1.0 + 1.7 * static_cast<double>(a));
  equations.linearise(elsewhere.data(), lambda.data());
  (void)equations.evaluate(elsewhere.data(), lambda.data(), g.data(), xi.data());

  std::vector<Shifted> islands;
  for (const auto& [number, island] : shift_islands(equations, find_statics_islands(equations)))
    islands.push_back(island);
  std::sort(islands.begin(), islands.end(), [](const auto& a, const auto& b) { return a.first_point < b.first_point; });
  for (std::size_t k = 0; k < islands.size(); ++k) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(islands[k].answer);
    Vector3d pull = Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d u = eigen.eigenvectors().col(axis);
      if (eigen.eigenvalues()[axis] < 1e-20) pull += u.dot(islands[k].force) * u;
    }
    if (!(pull.norm() > 1e-9 * islands[k].scale)) continue;
    const Vector3d way = pull.normalized();
    const auto rounded = [](double x) { return std::round(1e3 * x) / 1e3 + 0.0; };
    return std::string(has_gravity(model.system) ? "gravity" : "the load") + " pulls the free island " +
           std::to_string(k) + " (of point " + std::to_string(islands[k].first_point) + ") along " +
           text(std::array{rounded(way[0]), rounded(way[1]), rounded(way[2])}) + " without end: " + text(pull.norm()) +
           " N that nothing balances";
  }
  return {};
}

}  // namespace tanor
