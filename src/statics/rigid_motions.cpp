#include "statics/rigid_motions.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace tanor {

namespace {

using Field = Eigen::Matrix<double, 6, 1>;
using Form = Eigen::Matrix<double, 6, 6>;

/// Squares below are 0, of motions whose mean square is 1: what is felt is known to 1e-8.
constexpr double nothing = 1e-14;

/// The moving points that W or a row joins, as numbers of their bodies.
std::vector<int> find_bodies(const EquilibriumEquations& equations) {
  const StiffnessMatrix& W = equations.stiffness();
  std::vector<int> parent(W.num_points()), point_of_row(equations.model().num_rows(), -1);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) i = parent[static_cast<std::size_t>(i)] = parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(i)])];
    return i;
  };
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    for (auto k = static_cast<std::size_t>(W.start()[i]); k < static_cast<std::size_t>(W.start()[i + 1]); ++k)
      parent[static_cast<std::size_t>(root(static_cast<int>(i)))] = root(W.columns()[k]);
  }
  for (const Incidence& incidence : equations.model().incidences) {
    if (static_cast<std::size_t>(incidence.point) >= W.num_points()) continue;
    int& first = point_of_row[static_cast<std::size_t>(incidence.row)];
    if (first < 0) first = incidence.point;
    parent[static_cast<std::size_t>(root(first))] = root(incidence.point);
  }
  std::vector<int> body(W.num_points());
  for (std::size_t i = 0; i < body.size(); ++i) body[i] = root(static_cast<int>(i));
  return body;
}

/// Translations, and rotations about `center`, at r.
std::array<Vec3, 6> move(Vec3 r, Vec3 center, double size) {
  constexpr Vec3 x{1.0, 0.0, 0.0}, y{0.0, 1.0, 0.0}, z{0.0, 0.0, 1.0};
  const Vec3 arm = (1.0 / size) * (r - center);
  return {x, y, z, cross(x, arm), cross(y, arm), cross(z, arm)};
}

/// How many combinations of the six fields are motions and feel nothing.
std::size_t count_free(const Form& mass, const Form& felt) {
  const Eigen::SelfAdjointEigenSolver<Form> moves(mass);
  const double most = moves.eigenvalues()[5];
  const auto count = static_cast<Eigen::Index>((moves.eigenvalues().array() > 1e-12 * most).count());
  if (most <= 0.0 || count == 0) return 0;
  const Eigen::MatrixXd basis =
      moves.eigenvectors().rightCols(count) * moves.eigenvalues().tail(count).cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd form = basis.transpose() * felt * basis;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(form);
  return static_cast<std::size_t>((eigen.eigenvalues().array() < nothing).count());
}

}  // namespace

std::size_t count_rigid_zero_modes(const EquilibriumEquations& equations, const double* r) {
  const Model& model = equations.model();
  const std::size_t n = model.num_moving();
  const std::vector<int> body = find_bodies(equations);
  const double size = model.scene_size > 0.0 ? model.scene_size : 1.0;
  std::vector<Vec3> center(n);
  std::vector<double> weight(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const auto b = static_cast<std::size_t>(body[i]);
    center[b] = center[b] + model.mass[i] * load(r, i);
    weight[b] += model.mass[i];
  }
  for (std::size_t b = 0; b < n; ++b) {
    if (weight[b] > 0.0) center[b] = (1.0 / weight[b]) * center[b];
  }

  const auto fields = [&](std::size_t i) { return move(load(r, i), center[static_cast<std::size_t>(body[i])], size); };
  std::vector<Form> mass(n, Form::Zero()), felt(n, Form::Zero());
  std::vector<Field> rows(model.num_rows(), Field::Zero());
  std::vector<double> squares(model.num_rows(), 0.0);
  std::vector<int> body_of_row(model.num_rows(), -1);
  for (const Incidence& incidence : model.incidences) {
    const auto row = static_cast<std::size_t>(incidence.row), i = static_cast<std::size_t>(incidence.point);
    if (i >= n) continue;
    const Vec3 gradient = incidence.sign * load(equations.gradients().data(), incidence.block);
    const std::array<Vec3, 6> u = fields(i);
    for (std::size_t k = 0; k < 6; ++k) rows[row][static_cast<Eigen::Index>(k)] += dot(gradient, u[k]);
    squares[row] += squared(gradient);
    body_of_row[row] = body[i];
  }
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (body_of_row[row] >= 0 && squares[row] > 0.0)
      felt[static_cast<std::size_t>(body_of_row[row])] += rows[row] * rows[row].transpose() / squares[row];
  }
  const double stiffness = std::max(equations.stiffness().largest(), 1e-300);
  const StiffnessMatrix& W = equations.stiffness();
  for (std::size_t i = 0; i < n; ++i) {
    const auto b = static_cast<std::size_t>(body[i]);
    Eigen::Matrix<double, 3, 6> force = Eigen::Matrix<double, 3, 6>::Zero(), own;
    for (auto k = static_cast<std::size_t>(W.start()[i]); k < static_cast<std::size_t>(W.start()[i + 1]); ++k) {
      const std::array<Vec3, 6> u = fields(static_cast<std::size_t>(W.columns()[k]));
      for (std::size_t c = 0; c < 6; ++c) {
        const Vec3 f = W.blocks()[k] * u[c];
        force.col(static_cast<Eigen::Index>(c)) += Eigen::Vector3d(f.x, f.y, f.z) / stiffness;
      }
    }
    const std::array<Vec3, 6> u = fields(i);
    for (std::size_t c = 0; c < 6; ++c) own.col(static_cast<Eigen::Index>(c)) = Eigen::Vector3d(u[c].x, u[c].y, u[c].z);
    felt[b] += force.transpose() * force;
    mass[b] += model.mass[i] / weight[b] * own.transpose() * own;
  }
  std::size_t count = 0;
  for (std::size_t b = 0; b < n; ++b) {
    if (weight[b] > 0.0) count += count_free(mass[b], felt[b]);
  }
  return count;
}

}  // namespace tanor
