#include <algorithm>
#include <cmath>

#include "friction/contact_problem.hpp"

/// \file How contacts at rest that hold more than can move share their load: at the analytic centre of all that obeys
/// the law (Boyd and Vandenberghe, Convex Optimization, sections 8.5 and 9.6).
namespace tanor {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// All x = x0 + Z y, with the contacts' own limits.
struct Shares {
  struct Contact {
    Eigen::Index first, dimension;
    double limit;
  };
  std::vector<Contact> contacts;
  MatrixXd Z;

  double load(const VectorXd& x) const {
    double worst = 0.0;
    for (const auto& [first, dimension, limit] : contacts)
      worst = std::max(worst, x.segment(first, dimension).norm() / limit);
    return worst;
  }
  /// Least price level - sum of log(q_c), q_c = level^2 h_c^2 - |x_c|^2, from (x, level) inside, by damped Newton
  /// steps. Without a price the level stands.
  void center(double price, double* level, VectorXd* x) const;
};

void Shares::center(double price, double* level, VectorXd* x) const {
  constexpr int most_steps = 60;
  constexpr double enough = 1e-2;
  const Eigen::Index n = Z.cols(), size = price > 0.0 ? n + 1 : n;
  MatrixXd B(Z.rows() + static_cast<Eigen::Index>(contacts.size()), n), H(size, size);
  VectorXd slope(x->size()), mixed(x->size()), g(size);
  for (int step = 0; step < most_steps; ++step) {
    double by_level = price, twice_by_level = 0.0;
    Eigen::Index next = Z.rows();
    for (const auto& [first, dimension, limit] : contacts) {
      const auto own = x->segment(first, dimension);
      const double s = *level, q = (s * limit - own.norm()) * (s * limit + own.norm()), dq = 2.0 * s * limit * limit;
      // -log q: the gradient is 2 x/q, the Hessian 2/q + 4 x x'/q^2 = B'B, and so on
      slope.segment(first, dimension) = 2.0 / q * own;
      mixed.segment(first, dimension) = -2.0 * dq / (q * q) * own;
      by_level -= dq / q;
      twice_by_level += dq * dq / (q * q) - 2.0 * limit * limit / q;
      B.middleRows(first, dimension) = std::sqrt(2.0 / q) * Z.middleRows(first, dimension);
      B.row(next++) = 2.0 / q * own.transpose() * Z.middleRows(first, dimension);
    }
    H.setZero();
    H.topLeftCorner(n, n).selfadjointView<Eigen::Lower>().rankUpdate(B.transpose());
    g.head(n) = Z.transpose() * slope;
    if (size > n) {
      H.row(n).head(n) = (Z.transpose() * mixed).transpose();
      H(n, n) = twice_by_level;
      g(n) = by_level;
    }
    const VectorXd change = H.ldlt().solve(g);
    const double decrement = std::sqrt(std::max(0.0, g.dot(change)));
    if (!change.allFinite()) return;
    // The function is self-concordant: such a step stays inside and lowers it.
    const double factor = decrement > 0.25 ? 1.0 / (1.0 + decrement) : 1.0;
    *x -= factor * (Z * change.head(n));
    if (size > n) *level -= factor * change(n);
    if (decrement < enough || (size > n && load(*x) < 1.0 - 1e-3)) return;
  }
}

}  // namespace

double share_load(const ContactProblem& problem, const std::vector<char>& shares_it, VectorXd* x, VectorXd* weights) {
  constexpr double rank_rounding = 1e-10;
  constexpr double nothing_to_share = std::numeric_limits<double>::quiet_NaN();
  // Those at rest: A x = b, of which U'x = g is all that there is to say.
  std::vector<Eigen::Index> rows;
  std::vector<std::size_t> members;
  Shares shares;
  weights->setOnes(static_cast<Eigen::Index>(problem.contacts.size()));
  for (std::size_t c = 0; c < problem.contacts.size(); ++c) {
    const auto& [first, dimension, moves, mu] = problem.contacts[c];
    if (shares_it[c] == 0) continue;
    const double limit = mu * problem.normal_force(c, *x).norm();
    if (limit <= 0.0) return nothing_to_share;
    shares.contacts.push_back({static_cast<Eigen::Index>(rows.size()), dimension, limit});
    members.push_back(c);
    for (Eigen::Index k = first; k < first + dimension; ++k) rows.push_back(k);
  }
  if (rows.empty()) return nothing_to_share;
  const MatrixXd A = problem.A(rows, rows);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
  const Eigen::Index rank = (eigen.eigenvalues().array() > rank_rounding * eigen.eigenvalues().maxCoeff()).count();
  if (rank == A.rows()) return nothing_to_share;
  const MatrixXd U = eigen.eigenvectors().rightCols(rank);
  shares.Z = eigen.eigenvectors().leftCols(A.rows() - rank);
  const VectorXd a = problem.accelerations(*x)(rows);
  VectorXd own = (*x)(rows);
  own -= U * (U.transpose() * a).cwiseQuotient(eigen.eigenvalues().tail(rank));

  // Levels fall until there is something to spare, or to the least that any share has: 2 m/price is the gap.
  constexpr double spared = 1e-8, smallest_gap = 1e-8;
  const VectorXd given = own;
  const auto num_terms = 2.0 * static_cast<double>(members.size());
  double level = 1.5 * shares.load(own);
  for (double price = num_terms / level; shares.load(own) > 1.0 - spared; price *= 10.0) {
    shares.center(price, &level, &own);
    if (num_terms / price < smallest_gap) break;
  }
  if (shares.load(own) < 1.0 - spared) shares.center(0.0, &(level = 1.0), &own);
  if (!(shares.load(own) <= std::max(1.0, shares.load(given)))) {
    own = given;
    level = (1.0 + smallest_gap) * shares.load(own);
  }
  // Changes are the least in the norm of the Hessian: they follow the centre.
  for (std::size_t k = 0; k < members.size(); ++k) {
    const auto& [first, dimension, limit] = shares.contacts[k];
    const double size = own.segment(first, dimension).squaredNorm(), q = level * level * limit * limit - size;
    (*weights)(static_cast<Eigen::Index>(members[k])) = 2.0 / q + 4.0 * size / (q * q);
  }
  double largest = 0.0;
  for (const std::size_t c : members) largest = std::max(largest, (*weights)(static_cast<Eigen::Index>(c)));
  for (const std::size_t c : members) (*weights)(static_cast<Eigen::Index>(c)) /= largest;
  (*x)(rows) = own;
  return shares.load(own);
}

}  // namespace tanor
