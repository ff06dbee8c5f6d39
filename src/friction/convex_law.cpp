#include "friction/convex_law.hpp"

#include <algorithm>
#include <cmath>

/// \file Contacts at rest whose limits stand, by an interior point method (Nocedal and Wright, Numerical Optimization,
/// sections 19.2 and 19.3). With x_c = h_c u_c and multipliers z_c = h_c |a_c|:
///
///   Q u + q + z u = 0,   z_c g_c = mu -> 0,   g_c = (1 - |u_c|^2)/2 > 0
///
/// dz eliminated, a Newton step is (Q + z + (z_c/g_c) u_c u_c') du = -(Q u + q + mu u_c/g_c).
namespace tanor {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Disk {
  Eigen::Index first, dimension;  // among the unknowns
};

/// Largest step <= 1 along du that keeps |u_c| < 1, and a little away from it.
double longest_step(const std::vector<Disk>& disks, const VectorXd& u, const VectorXd& du) {
  constexpr double part = 0.995;
  double step = 1.0;
  for (const auto& [first, dimension] : disks) {
    // |u + s du|^2 = 1
    const auto own = u.segment(first, dimension), change = du.segment(first, dimension);
    const double a = change.squaredNorm(), b = own.dot(change), c = own.squaredNorm() - 1.0;
    if (a == 0.0) continue;
    const double root = std::sqrt(std::max(0.0, b * b - a * c));
    step = std::min(step, part * (b > 0.0 ? -c / (b + root) : (root - b) / a));
  }
  return step;
}

}  // namespace

VectorXd solve_convex_law(const ContactProblem& problem, const VectorXd& limits) {
  VectorXd x = VectorXd::Zero(problem.size()), scale(problem.size());
  std::vector<Eigen::Index> rows;
  std::vector<Disk> disks;
  for (std::size_t c = 0; c < problem.contacts.size(); ++c) {
    const auto& [first, dimension, moves, mu] = problem.contacts[c];
    const double h = limits(static_cast<Eigen::Index>(c));
    if (moves) x(first) = h;
    if (moves || !(h > 0.0)) continue;
    disks.push_back({static_cast<Eigen::Index>(rows.size()), dimension});
    for (Eigen::Index k = first; k < first + dimension; ++k) {
      rows.push_back(k);
      scale(k) = h;
    }
  }
  if (rows.empty()) return x;
  const VectorXd h = scale(rows);
  MatrixXd Q = h.asDiagonal() * problem.A(rows, rows) * h.asDiagonal();
  VectorXd q = h.cwiseProduct(problem.accelerations(x)(rows));
  const double unit = std::max(q.lpNorm<Eigen::Infinity>(), Q.diagonal().maxCoeff());
  if (!(unit > 0.0)) return x;
  Q /= unit;
  q /= unit;

  constexpr int most_steps = 100;
  constexpr double least_gap = 1e-17, rounding = 1e-14;
  const auto num = static_cast<Eigen::Index>(disks.size());
  VectorXd u = VectorXd::Zero(q.size()), z = VectorXd::Constant(num, 0.5), g(num), dz(num);
  MatrixXd J;
  for (int pass = 0; pass < most_steps; ++pass) {
    VectorXd zu(u.size());
    for (Eigen::Index c = 0; c < num; ++c) {
      const auto& [first, dimension] = disks[static_cast<std::size_t>(c)];
      const double size = u.segment(first, dimension).norm();
      g(c) = 0.5 * (1.0 - size) * (1.0 + size);
      zu.segment(first, dimension) = z(c) * u.segment(first, dimension);
    }
    const VectorXd defect = Q * u + q + zu;
    const double gap = z.dot(g) / static_cast<double>(num);
    if (gap <= least_gap && defect.lpNorm<Eigen::Infinity>() <= rounding) break;
    J = Q;
    for (Eigen::Index c = 0; c < num; ++c) {
      const auto& [first, dimension] = disks[static_cast<std::size_t>(c)];
      const auto own = u.segment(first, dimension);
      auto block = J.block(first, first, dimension, dimension);
      block += z(c) / g(c) * own * own.transpose();
      block.diagonal().array() += z(c);
    }
    const Eigen::LDLT<MatrixXd> factor(J);
    // z g + g dz - z u'du = mu - (correction)
    VectorXd correction = VectorXd::Zero(num);
    const auto solve = [&](double mu) {
      VectorXd right = -defect;
      for (Eigen::Index c = 0; c < num; ++c) {
        const auto& [first, dimension] = disks[static_cast<std::size_t>(c)];
        right.segment(first, dimension) -= (mu - correction(c) - z(c) * g(c)) / g(c) * u.segment(first, dimension);
      }
      VectorXd du = factor.solve(right);
      for (Eigen::Index c = 0; c < num; ++c) {
        const auto& [first, dimension] = disks[static_cast<std::size_t>(c)];
        const double along = u.segment(first, dimension).dot(du.segment(first, dimension));
        dz(c) = (mu - correction(c) - z(c) * g(c) + z(c) * along) / g(c);
      }
      return du;
    };
    const auto longest = [&](const VectorXd& du) {
      double step = longest_step(disks, u, du);
      for (Eigen::Index c = 0; c < num; ++c) {
        if (dz(c) < 0.0) step = std::min(step, -0.995 * z(c) / dz(c));
      }
      return step;
    };
    // The step for mu = 0 says how far mu may fall, and what is of second order (Mehrotra).
    VectorXd du = solve(0.0);
    const double reached = longest(du);
    const double mu = std::pow(1.0 - 0.99 * reached, 3) * gap;
    for (Eigen::Index c = 0; c < num; ++c) {
      const auto& [first, dimension] = disks[static_cast<std::size_t>(c)];
      const double along = u.segment(first, dimension).dot(du.segment(first, dimension));
      correction(c) = reached * reached * (-dz(c) * along - 0.5 * z(c) * du.segment(first, dimension).squaredNorm());
    }
    VectorXd corrected = solve(mu);
    double step = longest(corrected);
    if (step < 0.1 * reached) {
      correction.setZero();
      corrected = solve(std::max(mu, 0.1 * gap));
      step = longest(corrected);
    }
    if (!corrected.allFinite()) break;
    u += step * corrected;
    z += step * dz;
  }
  x(rows) = h.cwiseProduct(u);
  return x;
}

}  // namespace tanor
