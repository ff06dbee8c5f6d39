#include "statics/rigid_modes.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

namespace tanor {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Six motions of every island at once: shifts along the axes, and turns about its centre; all of unit size.
struct RigidFields {
  RigidFields(const std::vector<int>& island, const double* r);

  std::vector<double> count, radius;         // [island] its points, and how far they stand from their centre
  std::vector<Vec3> centre;                  // [island]
  std::array<std::vector<double>, 6> moves;  // [3 points]
};

RigidFields::RigidFields(const std::vector<int>& island, const double* r)
    : count(island.size(), 0.0), radius(island.size(), 0.0), centre(island.size()) {
  const auto own = [&](std::size_t i) { return static_cast<std::size_t>(island[i]); };
  for (std::size_t i = 0; i < island.size(); ++i) {
    centre[own(i)] = centre[own(i)] + load(r, i);
    count[own(i)] += 1.0;
  }
  for (std::size_t k = 0; k < centre.size(); ++k) {
    if (count[k] > 0.0) centre[k] = (1.0 / count[k]) * centre[k];
  }
  const auto arm = [&](std::size_t i) { return load(r, i) - centre[own(i)]; };
  for (std::size_t i = 0; i < island.size(); ++i) radius[own(i)] = std::max(radius[own(i)], norm(arm(i)));
  constexpr std::array<Vec3, 3> axes{Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 1.0, 0.0}, Vec3{0.0, 0.0, 1.0}};
  for (std::size_t k = 0; k < 6; ++k) {
    moves[k].assign(3 * island.size(), 0.0);
    for (std::size_t i = 0; i < island.size(); ++i) {
      if (k < 3)
        store(moves[k].data(), i, axes[k]);
      else if (radius[own(i)] > 0.0)
        store(moves[k].data(), i, (1.0 / radius[own(i)]) * cross(axes[k - 3], arm(i)));
    }
  }
}

/// The scalar products of six vectors at one place.
template <class Product>
void add_products(Matrix6* to, const Product& product) {
  for (std::size_t a = 0; a < 6; ++a) {
    for (std::size_t b = 0; b < 6; ++b) (*to)(static_cast<int>(a), static_cast<int>(b)) += product(a, b);
  }
}

/// Combinations that move points, by 1 m on an average of squares, and that nothing answers to, by columns.
Eigen::MatrixXd find_unanswered(const Matrix6& moves, const Matrix6& answers, double nothing) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(moves);
  Eigen::MatrixXd basis(6, 0);
  for (int k = 0; k < 6; ++k) {
    if (eigen.eigenvalues()[k] < 1e-10) continue;
    basis.conservativeResize(6, basis.cols() + 1);
    basis.rightCols(1) = eigen.eigenvectors().col(k) / std::sqrt(eigen.eigenvalues()[k]);
  }
  if (basis.cols() == 0) return basis;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> answer(basis.transpose() * answers * basis);
  return basis * answer.eigenvectors().leftCols((answer.eigenvalues().array() < nothing).count());
}

/// Where u(x) = shift + turn x (x - c) carries a point within 1 s (exponential of a twist).
class Screw {
 public:
  Screw(Vec3 shift, Vec3 turn) : turn_(turn) {
    const double angle = norm(turn);
    if (angle > 1e-4) {
      first_ = std::sin(angle) / angle;
      second_ = (1.0 - std::cos(angle)) / (angle * angle);
      third_ = (1.0 - first_) / (angle * angle);
    }
    shift_ = shift + second_ * cross(turn, shift) + third_ * cross(turn, cross(turn, shift));
  }
  Vec3 rotate(Vec3 a) const { return a + first_ * cross(turn_, a) + second_ * cross(turn_, cross(turn_, a)); }
  Vec3 carry(Vec3 arm) const { return rotate(arm) + shift_; }

 private:
  Vec3 turn_, shift_;
  double first_ = 1.0, second_ = 0.5, third_ = 1.0 / 6.0;
};

/// How many of the motions of each island, by columns of `motions`, leave its forces as they are on a finite way too:
/// at the top of -x^4 nothing answers to a small one.
std::size_t count_free(const EquilibriumEquations& equations, const std::vector<double>& r,
                       const std::vector<int>& island, const RigidFields& fields,
                       const std::vector<Eigen::MatrixXd>& motions) {
  constexpr double part = 0.1, digits = 1e-7;
  const Model& model = equations.model();
  const std::vector<double> at_rest(r.size(), 0.0);
  const auto forces_at = [&](const std::vector<double>& at) {
    std::vector<double> f(at.size(), 0.0);
    equations.work().forces.evaluate(model.parallel, equations.time(), at.data(), at_rest.data(), f.data());
    return f;
  };
  const std::vector<double> before = forces_at(r), stiffness = find_island_stiffness(equations, island);
  std::size_t result = 0;
  for (Eigen::Index k = 0; k < 6; ++k) {
    std::vector<double> moved = r;
    std::vector<std::optional<Screw>> screws(island.size());
    std::vector<double> size(island.size(), 0.0), largest(island.size(), 0.0);
    for (std::size_t own = 0; own < island.size(); ++own) {
      if (k >= motions[own].cols()) continue;
      size[own] = part * std::max(fields.radius[own], model.smallest_length);
      const double turn = fields.radius[own] > 0.0 ? size[own] / fields.radius[own] : 0.0;
      const auto c = motions[own].col(k);
      screws[own].emplace(size[own] * Vec3{c[0], c[1], c[2]}, turn * Vec3{c[3], c[4], c[5]});
    }
    const auto screw_of = [&](std::size_t i) -> const std::optional<Screw>& {
      return screws[static_cast<std::size_t>(island[i])];
    };
    for (std::size_t i = 0; i < island.size(); ++i) {
      const Vec3 centre = fields.centre[static_cast<std::size_t>(island[i])];
      if (screw_of(i)) store(moved.data(), i, centre + screw_of(i)->carry(load(r.data(), i) - centre));
    }
    const std::vector<double> after = forces_at(moved);
    std::vector<double> change(island.size(), 0.0);
    for (std::size_t i = 0; i < island.size(); ++i) {
      if (!screw_of(i)) continue;
      const auto own = static_cast<std::size_t>(island[i]);
      const Vec3 was = load(before.data(), i);
      change[own] = larger(change[own], norm(load(after.data(), i) - screw_of(i)->rotate(was)));
      largest[own] = larger(largest[own], norm(was));
    }
    for (std::size_t own = 0; own < island.size(); ++own) {
      const double scale = largest[own] + stiffness[own] * size[own];
      if (screws[own] && change[own] <= digits * scale) ++result;
    }
  }
  (void)forces_at(r);  // which others may read on
  return result;
}

}  // namespace

std::vector<int> find_statics_islands(const EquilibriumEquations& equations) {
  const StiffnessMatrix& W = equations.stiffness();
  std::vector<int> parent(W.num_points());
  std::iota(parent.begin(), parent.end(), 0);
  const auto find = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      int& up = parent[static_cast<std::size_t>(i)];
      i = up = parent[static_cast<std::size_t>(up)];
    }
    return i;
  };
  const auto join = [&](int i, int j) { parent[static_cast<std::size_t>(find(i))] = find(j); };
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k)
      join(static_cast<int>(i), W.columns()[static_cast<std::size_t>(k)]);
  }
  std::vector<int> first(equations.model().num_rows(), -1);
  for (const Incidence& incidence : equations.model().incidences) {
    if (static_cast<std::size_t>(incidence.point) >= parent.size()) continue;
    int& own = first[static_cast<std::size_t>(incidence.row)];
    own < 0 ? void(own = incidence.point) : join(own, incidence.point);
  }
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = find(static_cast<int>(i));
  return parent;
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

std::size_t count_rigid_modes(const EquilibriumEquations& equations, const std::vector<double>& r) {
  const Model& model = equations.model();
  const std::vector<int> island = find_statics_islands(equations);
  const std::size_t n = island.size();
  const RigidFields fields(island, r.data());
  std::array<std::vector<double>, 6> images, rows;
  for (std::size_t k = 0; k < 6; ++k) {
    images[k].resize(3 * n);
    rows[k].resize(model.num_rows());
    equations.stiffness().multiply(fields.moves[k].data(), images[k].data());
    equations.apply_transposed(fields.moves[k].data(), rows[k].data());
  }
  // u'u, and what answers to u: W u and K'u.
  const std::vector<double> stiffness = find_island_stiffness(equations, island);
  std::vector<Matrix6> moves(n, Matrix6::Zero()), answers(n, Matrix6::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    const auto own = static_cast<std::size_t>(island[i]);
    add_products(&moves[own], [&](std::size_t a, std::size_t b) {
      return dot(load(fields.moves[a].data(), i), load(fields.moves[b].data(), i)) / fields.count[own];
    });
    add_products(&answers[own], [&](std::size_t a, std::size_t b) {
      return dot(load(images[a].data(), i), load(images[b].data(), i)) / (stiffness[i] * stiffness[i]);
    });
  }
  std::vector<int> of_row(model.num_rows(), -1);
  for (const Incidence& incidence : model.incidences) {
    if (static_cast<std::size_t>(incidence.point) < n)
      of_row[static_cast<std::size_t>(incidence.row)] = island[static_cast<std::size_t>(incidence.point)];
  }
  for (std::size_t row = 0; row < of_row.size(); ++row) {
    if (of_row[row] < 0) continue;
    add_products(&answers[static_cast<std::size_t>(of_row[row])],
                 [&](std::size_t a, std::size_t b) { return rows[a][row] * rows[b][row]; });
  }
  constexpr double nothing = 1e-14;  // of squares
  std::vector<Eigen::MatrixXd> motions(n);
  for (std::size_t own = 0; own < n; ++own) {
    if (fields.count[own] > 0.0) motions[own] = find_unanswered(moves[own], answers[own], nothing * fields.count[own]);
  }
  return count_free(equations, r, island, fields, motions);
}

}  // namespace tanor
