#include <algorithm>
#include <cmath>

#include "base/dense.hpp"
#include "friction/contact_problem.hpp"

/// \file Finds some motion of a ContactProblem with many contacts.
namespace tanor::detail {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The law as equations: x - P(x - rho a) for a contact at rest, where P is the projection onto |x| <= h and rho =
/// 1/A_cc, and x - h for one that moves (Alart and Curnier 1991).
class Equations {
 public:
  explicit Equations(const ContactProblem& problem) : problem_(problem) {
    const double largest = problem.A.diagonal().lpNorm<Eigen::Infinity>();
    for (const auto& contact : problem.contacts) {
      const double own = problem.A.diagonal().segment(contact.first, contact.dimension).maxCoeff();
      rho_.push_back(largest > 0.0 ? 1.0 / std::max(own, 1e-9 * largest) : 0.0);
    }
  }

  /// Returns the defect at x, and writes its derivative unless null.
  VectorXd evaluate(const VectorXd& x, MatrixXd* J) const;

 private:
  const ContactProblem& problem_;
  std::vector<double> rho_;
};

VectorXd Equations::evaluate(const VectorXd& x, MatrixXd* J) const {
  // If contacts share a load, a small multiple of x in the derivative leads to the nearest share.
  constexpr double share = 1e-7;
  const VectorXd a = problem_.accelerations(x);
  VectorXd F(x.size());
  if (J != nullptr) J->setZero(x.size(), x.size());
  for (std::size_t c = 0; c < problem_.contacts.size(); ++c) {
    const auto [first, dimension, moves, mu] = problem_.contacts[c];
    const auto at = 3 * static_cast<Eigen::Index>(c);
    const double h = problem_.limit(c, x), size = problem_.normal_force(c, x).norm();
    Eigen::RowVectorXd dh = Eigen::RowVectorXd::Zero(x.size());
    if (J != nullptr && size > 0.0)
      dh = mu / size * problem_.normal_force(c, x).transpose() * problem_.W.middleRows<3>(at);
    if (moves) {
      F(first) = x(first) - h;
      if (J != nullptr) {
        J->row(first) = -dh;
        (*J)(first, first) += 1.0;
      }
      continue;
    }
    const VectorXd own = x.segment(first, dimension), z = own - rho_[c] * a.segment(first, dimension);
    const double length = z.norm();
    const bool sticks = length <= h;
    F.segment(first, dimension) = sticks ? VectorXd(own - z) : VectorXd(own - h / length * z);
    if (J == nullptr) continue;
    auto rows = J->middleRows(first, dimension);
    const MatrixXd unit = MatrixXd::Identity(dimension, dimension);
    const MatrixXd A_rows = rho_[c] * problem_.A.middleRows(first, dimension);
    if (sticks) {
      rows = A_rows;
      rows.middleCols(first, dimension) += share * unit;
      continue;
    }
    const VectorXd e = z / length;
    const MatrixXd turn = h / length * (unit - e * e.transpose());
    rows = turn * A_rows - e * dh;
    rows.middleCols(first, dimension) += unit - turn;
  }
  return F;
}

/// Solves by Newton's method, with shorter steps if a whole one leads away. Returns true if it converged.
bool solve_by_newton(const Equations& equations, VectorXd* x) {
  constexpr int most_steps = 40, patience = 8;
  MatrixXd J;
  VectorXd F = equations.evaluate(*x, &J);
  double size = F.norm(), best = size;
  int since_best = 0;
  for (int step = 0; step < most_steps; ++step) {
    if (size <= 1e-14 * x->norm()) return true;
    const VectorXd dx = dense::solve(J, F);
    if (!dx.allFinite()) return false;
    VectorXd trial;
    double factor = 1.0, trial_size = 0.0;
    for (int cut = 0; cut < 6; ++cut, factor *= 0.5) {
      trial = *x - factor * dx;
      trial_size = equations.evaluate(trial, nullptr).norm();
      if (trial_size < (1.0 - 0.1 * factor) * size) break;
    }
    if (!std::isfinite(trial_size)) return false;
    *x = trial;
    F = equations.evaluate(*x, &J);
    size = F.norm();
    since_best = size < 0.9 * best ? 0 : since_best + 1;
    best = std::min(best, size);
    if (since_best >= patience) return size <= 1e-10 * x->norm();
  }
  return size <= 1e-10 * x->norm();
}

}  // namespace

VectorXd find_one(const ContactProblem& problem, const VectorXd& guess) {
  const auto obeys = [&](const VectorXd& x) { return problem.residual(x) <= obeys_below; };
  const Equations equations(problem);
  const auto refine = [&](const VectorXd& from) {
    VectorXd x = from;
    return solve_by_newton(equations, &x) && obeys(x) ? x : VectorXd();
  };
  VectorXd x = guess.size() == problem.size() ? guess : VectorXd(VectorXd::Zero(problem.size()));
  if (VectorXd found = refine(x); found.size() > 0) return found;
  constexpr int most_rounds = 60;
  VectorXd limits(static_cast<Eigen::Index>(problem.contacts.size()));
  for (int round = 0; round < most_rounds; ++round) {
    for (std::size_t c = 0; c < problem.contacts.size(); ++c)
      limits(static_cast<Eigen::Index>(c)) = problem.limit(c, x);
    x = solve_convex_law(problem, limits);
    if (obeys(x)) return x;
    if (VectorXd found = refine(x); found.size() > 0) return found;
  }
  return {};
}

}  // namespace tanor::detail
