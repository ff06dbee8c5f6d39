#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/dense.hpp"
#include "friction/contact_problem.hpp"

/// \file Solves for contacts at rest with fixed limits by an interior point method (Nocedal and Wright, Numerical
/// Optimization, sections 19.2 and 19.3). With x_c = h_c u_c and multipliers z_c = h_c |a_c|:
///
///   Q u + q + z u = 0,   z_c g_c = mu -> 0,   g_c = (1 - |u_c|^2)/2 > 0
///
/// With dz eliminated, a Newton step is (Q + z + (z_c/g_c) u_c u_c') du = -(Q u + q + mu u_c/g_c).
namespace tanor::detail {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The problem in units of the limits, and the current point of the iteration.
class InteriorPoint {
 public:
  /// `disk` [unknown] is the number of its contact; unknowns of a contact stand side by side.
  InteriorPoint(MatrixXd Q, VectorXd q, std::vector<Eigen::Index> disk)
      : Q_(std::move(Q)),
        q_(std::move(q)),
        disk_(std::move(disk)),
        u_(VectorXd::Zero(q_.size())),
        z_(VectorXd::Constant(disk_.back() + 1, 0.5)) {}

  /// Returns u, as near to the solution as rounding allows.
  const VectorXd& solve() {
    constexpr int most_steps = 100;
    for (int pass = 0; pass < most_steps && !is_solved(); ++pass) {
      if (!advance()) break;
    }
    return u_;
  }

 private:
  bool is_solved();
  void factorize();
  VectorXd find_step(double mu, const VectorXd& correction);
  double longest(const VectorXd& du) const;
  bool advance();
  VectorXd spread(const VectorXd& of_disks) const { return of_disks(disk_); }
  /// Returns x_c.y_c of each disk.
  VectorXd dot(const VectorXd& x, const VectorXd& y) const {
    VectorXd sum = VectorXd::Zero(z_.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) sum(disk_[static_cast<std::size_t>(k)]) += x(k) * y(k);
    return sum;
  }

  const MatrixXd Q_;
  const VectorXd q_;
  const std::vector<Eigen::Index> disk_;
  VectorXd u_, z_, g_, dz_;
  VectorXd defect_;   // Q u + q + z u
  double gap_ = 0.0;  // mean of z g
  dense::Ldlt factor_;
};

/// Measures the point and returns true if it is the solution.
bool InteriorPoint::is_solved() {
  constexpr double least_gap = 1e-17, rounding = 1e-14;
  const Eigen::ArrayXd size = dot(u_, u_).array().sqrt();
  g_ = 0.5 * (1.0 - size) * (1.0 + size);
  defect_ = Q_ * u_ + q_ + spread(z_).cwiseProduct(u_);
  gap_ = z_.dot(g_) / static_cast<double>(z_.size());
  return gap_ <= least_gap && defect_.lpNorm<Eigen::Infinity>() <= rounding;
}

/// Factorizes Q + z + (z_c/g_c) u_c u_c'.
void InteriorPoint::factorize() {
  MatrixXd J = Q_;
  J.diagonal() += spread(z_);
  for (Eigen::Index k = 0; k < u_.size(); ++k) {
    const Eigen::Index c = disk_[static_cast<std::size_t>(k)];
    for (Eigen::Index j = k; j >= 0 && disk_[static_cast<std::size_t>(j)] == c; --j)
      J(k, j) += z_(c) / g_(c) * u_(k) * u_(j);
  }
  factor_.compute(J);
}

/// Finds du and dz with z g + g dz - z u'du = mu - correction, for a second-order term [disk].
VectorXd InteriorPoint::find_step(double mu, const VectorXd& correction) {
  const VectorXd rest = (mu - correction.array()) / g_.array() - z_.array();
  VectorXd du = factor_.solve(-defect_ - spread(rest).cwiseProduct(u_));
  dz_ = rest.array() + z_.array() * dot(u_, du).array() / g_.array();
  return du;
}

/// Returns the largest step <= 1 along du and dz that keeps |u_c| < 1 and z > 0, and a little away from both.
double InteriorPoint::longest(const VectorXd& du) const {
  constexpr double part = 0.995;
  const VectorXd a = dot(du, du), b = dot(u_, du);
  double step = 1.0;
  for (Eigen::Index c = 0; c < z_.size(); ++c) {
    // solves |u + s du|^2 = 1 for s
    const double root = std::sqrt(std::max(0.0, b(c) * b(c) + 2.0 * a(c) * g_(c)));
    if (a(c) > 0.0) step = std::min(step, part * (b(c) > 0.0 ? 2.0 * g_(c) / (b(c) + root) : (root - b(c)) / a(c)));
    if (dz_(c) < 0.0) step = std::min(step, -part * z_(c) / dz_(c));
  }
  return step;
}

/// Makes one step. Returns false if it is not finite.
bool InteriorPoint::advance() {
  factorize();
  // The step for mu = 0 tells how far mu may fall.
  const VectorXd none = VectorXd::Zero(z_.size()), du = find_step(0.0, none);
  const double reached = longest(du);
  const double mu = std::pow(1.0 - 0.99 * reached, 3) * gap_;
  // The second-order term of the part that can be made (Mehrotra).
  const VectorXd correction = -reached * reached * (dz_.cwiseProduct(dot(u_, du)) + 0.5 * z_.cwiseProduct(dot(du, du)));
  VectorXd corrected = find_step(mu, correction);
  double step = longest(corrected);
  if (step < 0.1 * reached) {
    corrected = find_step(std::max(mu, 0.1 * gap_), none);
    step = longest(corrected);
  }
  if (!corrected.allFinite()) return false;
  u_ += step * corrected;
  z_ += step * dz_;
  return true;
}

}  // namespace

VectorXd solve_convex_law(const ContactProblem& problem, const VectorXd& limits) {
  VectorXd x = VectorXd::Zero(problem.size()), scale(problem.size());
  std::vector<Eigen::Index> rows, disk;
  for (std::size_t c = 0; c < problem.contacts.size(); ++c) {
    const auto& [first, dimension, moves, mu] = problem.contacts[c];
    const double h = limits(static_cast<Eigen::Index>(c));
    if (moves) x(first) = h;
    if (moves || !(h > 0.0)) continue;
    const Eigen::Index number = disk.empty() ? 0 : disk.back() + 1;
    for (Eigen::Index k = first; k < first + dimension; ++k) {
      rows.push_back(k);
      disk.push_back(number);
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
  x(rows) = h.cwiseProduct(InteriorPoint(std::move(Q), std::move(q), std::move(disk)).solve());
  return x;
}

}  // namespace tanor::detail
