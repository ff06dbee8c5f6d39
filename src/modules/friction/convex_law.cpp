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

struct Disk {
  Eigen::Index first, dimension;  // position among the unknowns
};

/// Returns the largest step <= 1 along du that keeps |u_c| < 1, and a little away from it.
double longest_step(const std::vector<Disk>& disks, const VectorXd& u, const VectorXd& du) {
  constexpr double part = 0.995;
  double step = 1.0;
  for (const auto& [first, dimension] : disks) {
    // solves |u + s du|^2 = 1 for s
    const auto own = u.segment(first, dimension), change = du.segment(first, dimension);
    const double a = change.squaredNorm(), b = own.dot(change), c = own.squaredNorm() - 1.0;
    if (a == 0.0) continue;
    const double root = std::sqrt(std::max(0.0, b * b - a * c));
    step = std::min(step, part * (b > 0.0 ? -c / (b + root) : (root - b) / a));
  }
  return step;
}

/// The problem in units of the limits, and the current point of the iteration.
class InteriorPoint {
 public:
  InteriorPoint(MatrixXd Q, VectorXd q, std::vector<Disk> disks)
      : Q_(std::move(Q)),
        q_(std::move(q)),
        disks_(std::move(disks)),
        num_(static_cast<Eigen::Index>(disks_.size())),
        u_(VectorXd::Zero(q_.size())),
        z_(VectorXd::Constant(num_, 0.5)),
        g_(num_),
        dz_(num_) {}

  /// Returns u, as near to the solution as rounding allows.
  const VectorXd& solve();

 private:
  bool is_solved();
  void factorize();
  VectorXd find_step(double mu);
  double longest(const VectorXd& du) const;
  void set_correction(double reached, const VectorXd& du);
  bool advance();
  auto part(const VectorXd& x, Eigen::Index c) const {
    const auto& [first, dimension] = disks_[static_cast<std::size_t>(c)];
    return x.segment(first, dimension);
  }

  const MatrixXd Q_;
  const VectorXd q_;
  const std::vector<Disk> disks_;
  const Eigen::Index num_;
  VectorXd u_, z_, g_, dz_;
  VectorXd defect_, correction_;  // Q u + q + z u; second-order term [disk]
  double gap_ = 0.0;              // mean of z g
  dense::Ldlt factor_;
};

const VectorXd& InteriorPoint::solve() {
  constexpr int most_steps = 100;
  for (int pass = 0; pass < most_steps && !is_solved(); ++pass) {
    factorize();
    if (!advance()) break;
  }
  return u_;
}

/// Measures the point and returns true if it is the solution.
bool InteriorPoint::is_solved() {
  constexpr double least_gap = 1e-17, rounding = 1e-14;
  VectorXd zu(u_.size());
  for (Eigen::Index c = 0; c < num_; ++c) {
    const auto& [first, dimension] = disks_[static_cast<std::size_t>(c)];
    const double size = part(u_, c).norm();
    g_(c) = 0.5 * (1.0 - size) * (1.0 + size);
    zu.segment(first, dimension) = z_(c) * part(u_, c);
  }
  defect_ = Q_ * u_ + q_ + zu;
  gap_ = z_.dot(g_) / static_cast<double>(num_);
  return gap_ <= least_gap && defect_.lpNorm<Eigen::Infinity>() <= rounding;
}

/// Factorizes Q + z + (z_c/g_c) u_c u_c'.
void InteriorPoint::factorize() {
  MatrixXd J = Q_;
  for (Eigen::Index c = 0; c < num_; ++c) {
    const auto& [first, dimension] = disks_[static_cast<std::size_t>(c)];
    const auto own = part(u_, c);
    auto block = J.block(first, first, dimension, dimension);
    block += z_(c) / g_(c) * own * own.transpose();
    block.diagonal().array() += z_(c);
  }
  factor_.compute(J);
}

/// Finds du and dz with z g + g dz - z u'du = mu - (correction).
VectorXd InteriorPoint::find_step(double mu) {
  VectorXd right = -defect_;
  for (Eigen::Index c = 0; c < num_; ++c) {
    const auto& [first, dimension] = disks_[static_cast<std::size_t>(c)];
    right.segment(first, dimension) -= (mu - correction_(c) - z_(c) * g_(c)) / g_(c) * part(u_, c);
  }
  VectorXd du = factor_.solve(right);
  for (Eigen::Index c = 0; c < num_; ++c) {
    const double along = part(u_, c).dot(part(du, c));
    dz_(c) = (mu - correction_(c) - z_(c) * g_(c) + z_(c) * along) / g_(c);
  }
  return du;
}

/// Returns the largest step <= 1 that keeps |u_c| < 1 and z > 0, and a little away from both.
double InteriorPoint::longest(const VectorXd& du) const {
  double step = longest_step(disks_, u_, du);
  for (Eigen::Index c = 0; c < num_; ++c) {
    if (dz_(c) < 0.0) step = std::min(step, -0.995 * z_(c) / dz_(c));
  }
  return step;
}

/// Sets the second-order term of the step du, of which the part `reached` can be made (Mehrotra).
void InteriorPoint::set_correction(double reached, const VectorXd& du) {
  for (Eigen::Index c = 0; c < num_; ++c) {
    const double along = part(u_, c).dot(part(du, c));
    correction_(c) = reached * reached * (-dz_(c) * along - 0.5 * z_(c) * part(du, c).squaredNorm());
  }
}

/// Makes one step. Returns false if it is not finite.
bool InteriorPoint::advance() {
  // The step for mu = 0 tells how far mu may fall.
  correction_ = VectorXd::Zero(num_);
  const VectorXd du = find_step(0.0);
  const double reached = longest(du);
  const double mu = std::pow(1.0 - 0.99 * reached, 3) * gap_;
  set_correction(reached, du);
  VectorXd corrected = find_step(mu);
  double step = longest(corrected);
  if (step < 0.1 * reached) {
    correction_.setZero();
    corrected = find_step(std::max(mu, 0.1 * gap_));
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
  x(rows) = h.cwiseProduct(InteriorPoint(std::move(Q), std::move(q), std::move(disks)).solve());
  return x;
}

}  // namespace tanor::detail
