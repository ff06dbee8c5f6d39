#include <algorithm>
#include <cmath>

#include "friction/contact_problem.hpp"

/// \file How contacts at rest that hold more than can move share their load.
namespace tanor {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

double share_load(const ContactProblem& problem, const std::vector<char>& shares_it, VectorXd* x, VectorXd* weights) {
  constexpr int most_passes = 300;
  constexpr double enough = 1e-9, rank_rounding = 1e-10, least_weight = 1e-6;
  // Those at rest: A x = b, of which U'x = g is all that there is to say.
  std::vector<Eigen::Index> rows;
  std::vector<std::size_t> members;
  const auto num_contacts = static_cast<Eigen::Index>(problem.contacts.size());
  VectorXd limits = VectorXd::Zero(num_contacts);
  for (std::size_t c = 0; c < problem.contacts.size(); ++c) {
    const auto& [first, dimension, moves, mu] = problem.contacts[c];
    limits(static_cast<Eigen::Index>(c)) = mu * problem.normal_force(c, *x).norm();
    if (shares_it[c] == 0) continue;
    members.push_back(c);
    for (Eigen::Index k = first; k < first + dimension; ++k) rows.push_back(k);
  }
  weights->setOnes(num_contacts);
  constexpr double nothing_to_share = std::numeric_limits<double>::quiet_NaN();
  if (rows.empty() || limits.minCoeff() <= 0.0) return nothing_to_share;
  const MatrixXd A = problem.A(rows, rows);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
  const Eigen::Index rank = (eigen.eigenvalues().array() > rank_rounding * eigen.eigenvalues().maxCoeff()).count();
  if (rank == A.rows()) return nothing_to_share;
  const MatrixXd U = eigen.eigenvectors().rightCols(rank);
  const VectorXd own = (*x)(rows);
  const VectorXd b = A * own - problem.accelerations(*x)(rows);
  const VectorXd g = (U.transpose() * b).cwiseQuotient(eigen.eigenvalues().tail(rank));

  VectorXd shares = VectorXd::Ones(num_contacts) / static_cast<double>(members.size()), softness(own.size());
  VectorXd best_weights = *weights, best = own;
  double worst = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < most_passes; ++pass) {
    // The least sum of w |x_c|^2/h_c^2; then w *= |x_c|/h_c (Lawson).
    Eigen::Index row = 0;
    const double largest = shares.maxCoeff();
    for (const std::size_t c : members) {
      const auto k = static_cast<Eigen::Index>(c);
      const double weight = std::max(shares(k), least_weight * largest) / (limits(k) * limits(k));
      (*weights)(k) = weight;
      for (Eigen::Index i = 0; i < problem.contacts[c].dimension; ++i) softness(row++) = 1.0 / weight;
    }
    const MatrixXd soft = softness.asDiagonal() * U;
    const VectorXd trial = soft * (U.transpose() * soft).ldlt().solve(g);
    double load = 0.0, bound = 0.0;
    row = 0;
    for (const std::size_t c : members) {
      const auto k = static_cast<Eigen::Index>(c);
      const auto dimension = problem.contacts[c].dimension;
      const double each = trial.segment(row, dimension).norm() / limits(k);
      row += dimension;
      load = std::max(load, each);
      bound += shares(k) * each * each;
      shares(k) *= each;
    }
    if (load < worst) {
      worst = load;
      best_weights = *weights;
      best = trial;
    }
    if (load - std::sqrt(bound) < enough * load) break;
    for (const std::size_t c : members)
      shares(static_cast<Eigen::Index>(c)) = std::max(shares(static_cast<Eigen::Index>(c)), 0.0);
    shares /= shares.sum();
  }
  *weights = best_weights / best_weights.maxCoeff();
  (*x)(rows) = best;
  return worst;
}

}  // namespace tanor
