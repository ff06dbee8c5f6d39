#pragma once

/// \file Random scenes of beads on rough lines that rods join, and all solutions of their friction, found by trying.

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <vector>

#include <tanor/system.hpp>

#include "dense.hpp"
#include "reference.hpp"

namespace tanor {

/// Makes `count` beads on lines in the plane z = 0, each joined to the next, that slide with their one degree of
/// freedom.
inline System make_rough_lines(unsigned seed, std::size_t count, double mu, bool equal_masses) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1.0, 1.0), angle(0.0, 6.283185307179586), log_mass(-1.0, 1.0);
  System system;
  Rods rods{"rods", {}, {}, {}};
  std::vector<Vector3> directions;
  std::vector<std::string> wires;
  for (std::size_t i = 0; i < count; ++i) {
    system.positions.insert(system.positions.end(), {2.0 * static_cast<double>(i), place(random), 0.0});
    system.masses.push_back(equal_masses ? 1.0 : std::exp(log_mass(random)));
    const double a = angle(random);
    directions.push_back({std::cos(a), std::sin(a), 0.0});
    wires.push_back("wire" + std::to_string(i));
    const Vector3 origin{system.positions[3 * i], system.positions[3 * i + 1], 0.0};
    system.constraints.push_back(Lines{wires.back(), {static_cast<Index>(i)}, origin, directions.back()});
    if (i > 0) rods.pairs.push_back({static_cast<Index>(i) - 1, static_cast<Index>(i)});
  }
  // The rods keep their lengths if (r_j - r_i).(u_j d_j - u_i d_i) = 0.
  double u = 1.0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) {
      const auto part = [&](std::size_t k, std::size_t c) { return system.positions[3 * k + c]; };
      const double x = part(i, 0) - part(i - 1, 0), y = part(i, 1) - part(i - 1, 1);
      u *= (x * directions[i - 1][0] + y * directions[i - 1][1]) / (x * directions[i][0] + y * directions[i][1]);
    }
    for (std::size_t c = 0; c < 3; ++c) system.velocities.push_back(u * directions[i][c]);
  }
  if (!rods.pairs.empty()) system.constraints.push_back(rods);
  system.forces = {Gravity{"", {0.0, -9.81, 0.0}}};
  system.friction = {Coulomb{.name = "rough", .at = wires, .coefficient = mu}};
  return system;
}

/// The dense twin solves S lambda + C |N| = b, where N_i is lambda of wire i in the plane.
struct DenseFriction {
  reference::Mechanics dense;
  Eigen::MatrixXd S, C, N;  ///< C: d x m, N: m x d picks the force of each wire along its normal in the plane
  Eigen::VectorXd b;

  explicit DenseFriction(const System& system, double mu)
      : dense(reference::make_mechanics(system, 0.0, system.positions, system.velocities)), S(dense.S()) {
    const auto count = static_cast<Eigen::Index>(system.num_points());
    b = -(dense.phi + dense.K.transpose() * dense.f.cwiseQuotient(dense.M));
    C.setZero(S.rows(), count);
    N.setZero(count, S.rows());
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::Vector3d v = dense.v.segment<3>(3 * i);
      const Eigen::Vector3d normal = Eigen::Vector3d(0.0, 0.0, 1.0).cross(v.normalized());
      for (Eigen::Index k = 0; k < 2; ++k) N(i, 2 * i + k) = dense.K.col(2 * i + k).segment<3>(3 * i).dot(normal);
      // Friction is tau_i = -mu |N_i| v_i/|v_i|.
      Eigen::VectorXd along = Eigen::VectorXd::Zero(dense.M.size());
      along.segment<3>(3 * i) = -mu * v.normalized();
      C.col(i) = dense.K.transpose() * along.cwiseQuotient(dense.M);
    }
  }

  /// Solves (S + C diag(signs) N) lambda = b for all signs and returns each lambda whose N has these signs.
  std::vector<Eigen::VectorXd> find_all() const {
    std::vector<Eigen::VectorXd> found;
    const Eigen::Index m = N.rows();
    for (int choice = 0; choice < (1 << m); ++choice) {
      Eigen::VectorXd signs(m);
      for (Eigen::Index i = 0; i < m; ++i) signs(i) = (choice >> i) & 1 ? 1.0 : -1.0;
      const Eigen::VectorXd lambda = reference::solve_full(S + C * signs.asDiagonal() * N, b);
      if ((signs.asDiagonal() * (N * lambda)).minCoeff() >= 0.0) found.push_back(lambda);
    }
    return found;
  }
  /// Returns the residual over the terms that cancel in it.
  double residual(const Eigen::VectorXd& lambda) const {
    const Eigen::VectorXd rest = S * lambda + C * (N * lambda).cwiseAbs() - b;
    return rest.norm() / (S.cwiseAbs() * lambda.cwiseAbs() + b.cwiseAbs()).norm();
  }
};

}  // namespace tanor
