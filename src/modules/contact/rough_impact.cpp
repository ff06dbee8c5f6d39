#include "contact/rough_impact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/dense.hpp"
#include "contact/cone_solver.hpp"

namespace tanor::detail {

namespace {

using Eigen::VectorXd;

/// Returns the contacts for the cone solver. Components in which nothing moves stand alone there, and bear nothing.
ConeProblem make_cones(const RoughProblem& problem) {
  ConeProblem cones;
  const auto size = static_cast<Eigen::Index>(problem.size());
  const double mean = problem.W.size() > 0 ? problem.W.diagonal().maxCoeff() : 1.0;
  for (Eigen::Index c = 0; c < size; ++c) {
    cones.friction.push_back(problem.contacts[static_cast<std::size_t>(c)].mu);
    for (Eigen::Index other = 0; other < size; ++other) {
      Block3 block;
      for (Eigen::Index i = 0; i < 3; ++i) {
        for (Eigen::Index k = 0; k < 3; ++k)
          block.entries[static_cast<std::size_t>(3 * i + k)] = problem.W(3 * c + i, 3 * other + k);
        if (other == c && block(static_cast<int>(i), static_cast<int>(i)) == 0.0)
          block.entries[static_cast<std::size_t>(4 * i)] = mean > 0.0 ? mean : 1.0;
      }
      cones.columns.push_back(static_cast<int>(other));
      cones.blocks.push_back(block);
    }
    cones.start.push_back(cones.columns.size());
  }
  cones.q.assign(problem.q.data(), problem.q.data() + problem.q.size());
  for (Eigen::Index i = 0; i < problem.q.size(); ++i)
    if (problem.W(i, i) == 0.0) cones.q[static_cast<std::size_t>(i)] = 0.0;
  return cones;
}

/// Solves from the guess P, and replaces it. Returns the error.
double solve(const ConeProblem& cones, int sweeps, VectorXd* P) {
  constexpr double finest = 1e-15;  // no answer is refused for it
  std::vector<double> r(P->data(), P->data() + P->size());
  const ConeReport report =
      solve_contacts(cones, {.tolerance = finest, .most_sweeps = sweeps, .most_factorizations = 60}, &r);
  *P = Eigen::Map<const VectorXd>(r.data(), P->size());
  return report.error;
}

double energy_change(const RoughProblem& problem, const VectorXd& P) {
  return P.dot(problem.q) + 0.5 * P.dot(problem.W * P);
}

/// Returns the rounding of energy_change(), whose terms may be much larger than itself.
double rounding_of_energy(const RoughProblem& problem, const VectorXd& P) {
  constexpr double rounding = 16.0 * std::numeric_limits<double>::epsilon();
  const VectorXd size = P.cwiseAbs();
  return rounding * (size.dot(problem.q.cwiseAbs()) + 0.5 * size.dot(problem.W.cwiseAbs() * size));
}

}  // namespace

RoughImpact solve_impact(const RoughProblem& problem, const VectorXd& restitution) {
  constexpr int sweeps = 200, bisections = 60;
  ConeProblem cones = make_cones(problem);
  RoughImpact impact{.P = VectorXd::Zero(problem.q.size())};
  const auto solve_with = [&](double part) {
    for (std::size_t c = 0; c < problem.size(); ++c) {
      const double e = part * restitution(static_cast<Eigen::Index>(c));
      cones.q[3 * c] = (1.0 + e) * problem.normal(c, problem.q);
    }
    VectorXd P = impact.P;
    const double error = solve(cones, sweeps, &P);
    return RoughImpact{.P = P, .energy_change = energy_change(problem, P), .is_capped = part < 1.0, .error = error};
  };
  impact = solve_with(1.0);
  if (restitution.isZero(0.0) || impact.energy_change <= rounding_of_energy(problem, impact.P)) return impact;
  RoughImpact best = solve_with(0.0);
  double low = 0.0, high = 1.0;
  for (int k = 0; k < bisections; ++k) {
    const double middle = 0.5 * (low + high);
    const RoughImpact trial = solve_with(middle);
    (trial.energy_change <= -rounding_of_energy(problem, trial.P) ? low : high) = middle;
    if (low == middle) best = trial;
  }
  return best;
}

RoughImpact solve_jam(const RoughProblem& problem) {
  ConeProblem cones = make_cones(problem);
  const double speed = problem.q.lpNorm<Eigen::Infinity>();
  RoughImpact impact{.P = VectorXd::Zero(problem.q.size())};
  int sweeps = 200;
  for (const double part : {1e-2, 1e-4, 1e-6, 0.0}) {
    for (std::size_t c = 0; c < problem.size(); ++c) cones.q[3 * c] = -part * speed;
    impact.error = solve(cones, sweeps, &impact.P);
    if (part < 1e-3) sweeps = 0;  // from sweeps the answer 0 would come back
  }
  impact.energy_change = energy_change(problem, impact.P);
  return impact;
}

RoughImpact solve_slow_flight(const RoughProblem& problem, double rest) {
  // y: the normal impulses, and the tangential ones of contacts that do not slip; P = B y
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(problem.q.size(), 0);
  std::vector<Eigen::Index> zero;  // components of u+
  const auto add = [&](Eigen::Index component) {
    zero.push_back(component);
    B.conservativeResize(Eigen::NoChange, B.cols() + 1);
    B.rightCols<1>().setZero();
    B(component, B.cols() - 1) = 1.0;
  };
  for (std::size_t c = 0; c < problem.size(); ++c) {
    const Eigen::Index first = 3 * static_cast<Eigen::Index>(c);
    const Eigen::Vector2d u = problem.tangential(c, problem.q);
    add(first);
    if (u.norm() > rest) {
      B.block<2, 1>(first + 1, B.cols() - 1) = -problem.contacts[c].mu / u.norm() * u;
    } else if (problem.contacts[c].has_friction()) {
      add(first + 1);
      add(first + 2);
    }
  }
  const Eigen::MatrixXd M = problem.W(zero, Eigen::all) * B;
  RoughImpact impact;
  impact.P = B * dense::solve_least_squares(M, VectorXd(-problem.q(zero)), 1e-12);
  impact.energy_change = energy_change(problem, impact.P);
  return impact;
}

}  // namespace tanor::detail
