#include "friction/contact_problem.hpp"

#include <algorithm>
#include <cmath>

#include "base/dense.hpp"
#include "friction/range.hpp"

namespace tanor::detail {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

double ContactProblem::acceleration_scale(const VectorXd& x) const {
  if (size() == 0) return 0.0;
  return std::max(a0.lpNorm<Eigen::Infinity>(), (A.cwiseAbs() * x.cwiseAbs()).lpNorm<Eigen::Infinity>());
}

double ContactProblem::residual(const VectorXd& x) const {
  if (!x.allFinite()) return std::numeric_limits<double>::infinity();
  const VectorXd a = accelerations(x);
  const double largest_a = acceleration_scale(x), largest_A = A.diagonal().lpNorm<Eigen::Infinity>();
  double worst = 0.0, scale = x.lpNorm<Eigen::Infinity>();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const auto [first, dimension, moves, mu] = contacts[c];
    const double limit = this->limit(c, x);
    scale = std::max(scale, limit);
    if (moves) {
      worst = std::max(worst, std::abs(x(first) - limit));
      continue;
    }
    // Accelerations below rounding count as 0.
    VectorXd own_a = a.segment(first, dimension);
    if (own_a.norm() <= 1e-11 * largest_a) own_a.setZero();
    const double own_A = std::max(A.diagonal().segment(first, dimension).maxCoeff(), 1e-12 * largest_A);
    const VectorXd own = x.segment(first, dimension);
    VectorXd projected = own - (own_A > 0.0 ? 1.0 / own_A : 0.0) * own_a;
    if (own_A > 0.0) scale = std::max(scale, a0.segment(first, dimension).norm() / own_A);
    if (projected.norm() > limit) projected *= limit / projected.norm();
    worst = std::max(worst, (own - projected).norm());
  }
  return worst == 0.0 ? 0.0 : worst / scale;
}

bool ContactProblem::are_same(const VectorXd& x, const VectorXd& y) const {
  constexpr double digits = 1e-8;
  const double scale = std::max(acceleration_scale(x), acceleration_scale(y));
  return (A * (x - y)).lpNorm<Eigen::Infinity>() <= digits * scale;
}

bool is_monotone(const ContactProblem& problem) {
  constexpr double rounding = 1e-11;
  std::vector<std::size_t> coupled;  // contacts whose reaction friction changes
  for (std::size_t c = 0; c < problem.contacts.size(); ++c) {
    const double change = problem.W.middleRows<3>(3 * static_cast<Eigen::Index>(c)).norm();
    if (problem.contacts[c].mu * change <= rounding) continue;
    if (problem.contacts[c].moves) return false;
    coupled.push_back(c);
  }
  if (coupled.empty()) return true;
  // With A = L L' and z = L'y, y'A y = |z|^2. The bound is the largest eigenvalue of the sum of mu (s L_c'L_c +
  // V_c'V_c/s)/2, where W = V L' and s = |V_c|/|L_c|.
  const Range range(problem.A, rounding);
  const Eigen::Index rank = range.rank();
  const VectorXd root = range.values.cwiseSqrt();
  const MatrixXd L = range.vectors * root.asDiagonal(),
                 V = problem.W * range.vectors * root.cwiseInverse().asDiagonal();
  MatrixXd sum = MatrixXd::Zero(rank, rank);
  for (const std::size_t c : coupled) {
    const auto& contact = problem.contacts[c];
    const auto rows = problem.W.middleRows<3>(3 * static_cast<Eigen::Index>(c));
    if (contact.mu * (rows * range.null).norm() > rounding * std::max(1.0, rows.norm())) return false;
    const auto own_L = L.middleRows(contact.first, contact.dimension);
    const auto own_V = V.middleRows<3>(3 * static_cast<Eigen::Index>(c));
    const double size_L = own_L.norm(), size_V = own_V.norm();
    if (size_L == 0.0 || size_V == 0.0) continue;
    const double s = size_V / size_L;
    sum += 0.5 * contact.mu * (s * own_L.transpose() * own_L + own_V.transpose() * own_V / s);
  }
  return rank == 0 || dense::find_eigen(sum).values.maxCoeff() < 1.0 - 1e-6;
}

}  // namespace tanor::detail
