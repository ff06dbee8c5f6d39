#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/dense.hpp"
#include "friction/contact_problem.hpp"
#include "friction/range.hpp"

/// \file Shares a load among contacts at rest that hold more than can move, at the analytic centre of everything that
/// obeys the law (Boyd and Vandenberghe, Convex Optimization, sections 8.5 and 9.6).
namespace tanor::detail {

namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

/// The contacts at rest that share a load, with all shares x = own + Z y, and limits that are linear in x, since a
/// share may press contacts together.
struct Shares {
  Shares(const ContactProblem& a_problem, const std::vector<char>& shares_it, const VectorXd& x);

  const ContactProblem& problem;
  std::vector<std::size_t> members, others;
  std::vector<Eigen::Index> rows;  // components of the members
  VectorXd own;                    // their part of x, with A x = b to rounding
  struct Contact {
    Eigen::Index first, dimension;
    double base, unit;  // the limit is base + slope x, which is `unit` at the given share
    RowVectorXd slope, slope_by_y;

    double limit(const VectorXd& x) const { return base + slope.dot(x); }
    double size(const VectorXd& x) const { return x.segment(first, dimension).norm(); }
    /// Returns the load of this contact; 1 if it is at its limit.
    double load(const VectorXd& x) const { return 1.0 + (size(x) - limit(x)) / unit; }
    /// Returns u = limit + (level - 1) unit, the limit that is raised to a level.
    double raised(double level, const VectorXd& x) const { return limit(x) + (level - 1.0) * unit; }
    /// Returns q = u^2 - |x_c|^2.
    double spare(double level, const VectorXd& x) const {
      const double u = raised(level, x), own = size(x);
      return (u - own) * (u + own);
    }
  };
  std::vector<Contact> contacts;
  MatrixXd Z;  // orthonormal
  // If limits grow with the share, it may be of any size. A curb F = F0 + C x keeps the share and its reactions small,
  // relative to their size in the least share, so that no share grows from one event to the next.
  MatrixXd C, C_by_y;
  VectorXd F0;

  double load(const VectorXd& x) const {
    double worst = 0.0;
    for (const Contact& contact : contacts) worst = std::max(worst, contact.load(x));
    return worst;
  }
  /// Finds Z, and projects x onto the shares. For the members A x = b, which is equivalent to U'x = g. Returns false if
  /// nothing is free.
  bool find_free(VectorXd* x);
  /// Changes x to the least share and returns the largest of its loads.
  double find_least(VectorXd* x) const;
  /// Minimizes price level - sum of log(q_c) + |F|^2/2 by damped Newton steps from (own, level) inside. Without a price
  /// the level is fixed.
  void center(double price, double* level);
  /// Moves to the centre and returns the level there.
  double find_centre();
  /// Sets the limits at x. As |N| >= n.N, with equality at x, another share obeys the law if it obeys these limits.
  /// Returns true if limits depend on the share.
  bool set_limits(const VectorXd& x);
  void set_curb(const VectorXd& least);
  /// Sets the weights to those of the Hessian, in whose norm the least changes follow the centre.
  void set_weights(double level, VectorXd* weights) const;
};

constexpr double rounding_of_shares = 1e-10;

Shares::Shares(const ContactProblem& a_problem, const std::vector<char>& shares_it, const VectorXd& x)
    : problem(a_problem) {
  for (std::size_t c = 0; c < problem.contacts.size(); ++c) {
    const auto& [first, dimension, moves, mu] = problem.contacts[c];
    const bool shares = shares_it[c] != 0 && problem.limit(c, x) > 0.0;
    (shares ? members : others).push_back(c);
    for (Eigen::Index k = first; shares && k < first + dimension; ++k) rows.push_back(k);
  }
}

bool Shares::find_free(VectorXd* x) {
  if (rows.empty()) return false;
  const Range range(problem.A(rows, rows), rounding_of_shares);
  if (range.is_whole()) return false;
  const MatrixXd& U = range.vectors;
  Z = range.null;
  // A share that changes the reactions of others would be another motion, so that these reactions are kept.
  for (const std::size_t c : others) {
    const double mu = problem.contacts[c].mu;
    const MatrixXd change = mu * problem.W.middleRows<3>(3 * static_cast<Eigen::Index>(c))(Eigen::all, rows) * Z;
    if (Z.cols() == 0 || change.norm() <= rounding_of_shares) continue;
    const auto [sigma, U_of_change, V] = dense::find_singular_values_and_V(change);
    const Eigen::Index lost = (sigma.array() > rounding_of_shares).count();
    Z = (Z * V.rightCols(Z.cols() - lost)).eval();
  }
  const VectorXd a = problem.accelerations(*x)(rows);
  own = (*x)(rows);
  own -= U * (U.transpose() * a).cwiseQuotient(range.values);
  (*x)(rows) = own;
  return true;
}

double Shares::find_least(VectorXd* x) const {
  (*x)(rows) = own - Z * (Z.transpose() * own);
  double worst = 0.0;
  for (const std::size_t c : members) {
    const auto& [first, dimension, moves, mu] = problem.contacts[c];
    worst = std::max(worst, x->segment(first, dimension).norm() / problem.limit(c, *x));
  }
  return worst;
}

void Shares::center(double price, double* level) {
  constexpr int most_steps = 60;
  constexpr double enough = 1e-2;
  const Eigen::Index n = Z.cols(), size = price > 0.0 ? n + 1 : n;
  if (size == 0) return;
  MatrixXd B(Z.rows() + static_cast<Eigen::Index>(contacts.size()), size), H(size, size);
  VectorXd g(size);
  for (int step = 0; step < most_steps; ++step) {
    g.setZero();
    if (size > n) g(n) = price;
    Eigen::Index next = 0;
    for (const Contact& contact : contacts) {
      // With s = u - |x_c| and p = u + |x_c|, -log q = -log s - log p. The Hessian is (ds/s)^2 + (dp/p)^2, and 2/q
      // across x_c.
      const Eigen::Index num_rows = 1 + contact.dimension;
      const VectorXd part = own.segment(contact.first, contact.dimension);
      const double u = contact.raised(*level, own), length = part.norm(), s = u - length, p = u + length;
      const VectorXd along = length > 0.0 ? VectorXd(part / length) : VectorXd(VectorXd::Unit(contact.dimension, 0));
      RowVectorXd du = RowVectorXd::Zero(size), dx = RowVectorXd::Zero(size);
      du.head(n) = contact.slope_by_y;
      if (size > n) du(n) = contact.unit;
      dx.head(n) = along.transpose() * Z.middleRows(contact.first, contact.dimension);
      B.row(next) = (du - dx) / s;
      B.row(next + 1) = (du + dx) / p;
      g -= (B.row(next) + B.row(next + 1)).transpose();
      if (contact.dimension == 2) {
        B.row(next + 2).setZero();
        B.row(next + 2).head(n) =
            std::sqrt(2.0 / (s * p)) * (along(0) * Z.row(contact.first + 1) - along(1) * Z.row(contact.first));
      }
      next += num_rows;
    }
    H.setZero();
    if (C.rows() > 0) {
      g.head(n) += C_by_y.transpose() * (F0 + C * own);
      H.topLeftCorner(n, n).selfadjointView<Eigen::Lower>().rankUpdate(C_by_y.transpose());
    }
    H.selfadjointView<Eigen::Lower>().rankUpdate(B.topRows(next).transpose());
    const VectorXd change = dense::Ldlt(H).solve(g);
    const double decrement = std::sqrt(std::max(0.0, g.dot(change)));
    if (!change.allFinite()) return;
    // The function is self-concordant, so that such a step stays inside and lowers it.
    const double factor = decrement > 0.25 ? 1.0 / (1.0 + decrement) : 1.0;
    own -= factor * (Z * change.head(n));
    if (size > n) *level -= factor * change(n);
    if (decrement < enough || (size > n && load(own) < 1.0 - 1e-3)) return;
  }
}

double Shares::find_centre() {
  // Levels fall until there is something to spare, or to the least of any share; the gap is 2 m/price.
  constexpr double spared = 1e-10, smallest_gap = 1e-10;
  const VectorXd given = own;
  const auto num_terms = 2.0 * static_cast<double>(contacts.size());
  double level = 1.5 * load(own);
  for (double price = num_terms / level; load(own) > 1.0 - spared; price *= 10.0) {
    center(price, &level);
    if (num_terms / price < smallest_gap) break;
  }
  if (load(own) < 1.0 - spared) center(0.0, &(level = 1.0));
  if (load(own) <= std::max(1.0, load(given))) return level;
  own = given;
  return (1.0 + smallest_gap) * load(given);
}

bool Shares::set_limits(const VectorXd& x) {
  contacts.clear();
  bool depend_on_share = false;
  Eigen::Index first_row = 0;
  const VectorXd at = x(rows);
  for (const std::size_t c : members) {
    const auto& [first, dimension, moves, mu] = problem.contacts[c];
    const Eigen::Vector3d N = problem.normal_force(c, x);
    const RowVectorXd slope =
        mu * N.normalized().transpose() * problem.W.middleRows<3>(3 * static_cast<Eigen::Index>(c))(Eigen::all, rows);
    const double limit = mu * N.norm();
    contacts.push_back({first_row, dimension, limit - slope.dot(at), limit, slope, slope * Z});
    first_row += dimension;
    depend_on_share = depend_on_share || contacts.back().slope_by_y.norm() > rounding_of_shares;
  }
  return depend_on_share;
}

void Shares::set_curb(const VectorXd& least) {
  const MatrixXd W = problem.W(Eigen::all, rows);
  const VectorXd share = least(rows), N = problem.N0 + problem.W * least;
  const double size = share.norm() + N.norm();
  C.resize(share.size() + N.size(), share.size());
  C << MatrixXd::Identity(share.size(), share.size()) / size, W / size;
  F0.setZero(C.rows());
  F0.tail(N.size()) = (N - W * share) / size;
  C_by_y = C * Z;
}

void Shares::set_weights(double level, VectorXd* weights) const {
  double largest = 0.0;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const Contact& contact = contacts[k];
    const double size = contact.size(own) * contact.size(own), q = contact.spare(level, own);
    double& weight = (*weights)(static_cast<Eigen::Index>(members[k]));
    weight = 2.0 / q + 4.0 * size / (q * q);
    largest = std::max(largest, weight);
  }
  for (const std::size_t c : members) (*weights)(static_cast<Eigen::Index>(c)) /= largest;
}

}  // namespace

double share_load(const ContactProblem& problem, const std::vector<char>& shares_it, bool prefers_least, VectorXd* x,
                  VectorXd* weights) {
  constexpr double nothing_to_share = std::numeric_limits<double>::quiet_NaN();
  weights->setOnes(static_cast<Eigen::Index>(problem.contacts.size()));
  Shares shares(problem, shares_it, *x);
  if (!shares.find_free(x)) return nothing_to_share;

  VectorXd least = *x;
  const double least_load = shares.find_least(&least);
  constexpr double to_spare = 0.1;
  if (prefers_least && shares.Z.cols() > 0 && least_load < 1.0 - to_spare) {
    *x = least;
    return least_load;
  }

  // If reactions turn with the share, their directions are updated.
  double level = 1.0;
  constexpr int most_turns = 3;
  for (int turn = 0; turn < most_turns; ++turn) {
    const bool depends = shares.set_limits(*x);
    if (turn == 0 && depends) shares.set_curb(least);
    level = shares.find_centre();
    (*x)(shares.rows) = shares.own;
    if (!depends) break;
  }
  shares.set_weights(level, weights);
  return shares.load(shares.own);
}

}  // namespace tanor::detail
