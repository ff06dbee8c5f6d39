/// The tests check the equations of the normal form, by their numbers in docs/theory.md, on random systems of up to 30
/// points, and two witnesses that do not use S, which are the KKT matrix and Gauss's principle.

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "dense.hpp"
#include "linearised.hpp"
#include "random_numbers.hpp"
#include "schur/gram_solver.hpp"
#include "solved.hpp"

namespace tanor {
using namespace detail;
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd any_vector(Eigen::Index size, std::uint32_t seed) {
  const std::vector<double> numbers = normal_numbers(static_cast<std::size_t>(size), seed);
  return VectorXd::Map(numbers.data(), size);
}

/// An orthonormal basis of the range of K, and with it of its complement.
class Range {
 public:
  explicit Range(const MatrixXd& K)
      : basis_(reference::orthonormal_basis(K.colwise().normalized()).leftCols(K.cols())) {}
  VectorXd part_in(const VectorXd& u) const { return basis_ * (basis_.transpose() * u); }
  VectorXd part_outside(const VectorXd& u) const {
    const VectorXd once = u - part_in(u);
    return once - part_in(once);
  }

 private:
  MatrixXd basis_;
};

// ---- the projectors ----------------------------------------------------------------------------------------------

/// Applies u -> K (K'W K)^-1 K'u through the library's S solver, with W = M^-1 or 1.
class ThroughSolver {
 public:
  ThroughSolver(const Linearised& inner, std::vector<double> weights)
      : solver_(inner.incidences, weights, inner.numbering, Ordering::Auto, inner.constraints.squared_gradient_norms()),
        K_(inner.K().topRows(static_cast<Eigen::Index>(3 * inner.numbering.num_moving))) {
    solver_.assemble(Parallel(1), inner.blocks.data());
    (void)solver_.factorize(Parallel(1));
  }

  VectorXd operator()(const VectorXd& u) {
    VectorXd x = K_.transpose() * u;
    solver_.solve_negative(Parallel(1), x.data(), x.data());
    return -(K_ * x);
  }
  const MatrixXd& K() const { return K_; }

 private:
  GramSolver solver_;
  MatrixXd K_;
};

double sqrt_condition(const MatrixXd& K, const VectorXd& weights) {
  reference::Mechanics mechanics;
  mechanics.K = K;
  mechanics.M = weights.cwiseInverse();
  return mechanics.sqrt_condition();
}

RC_GTEST_PROP(ForwardDynamics, Equation12_KSinvKtMinvLeavesVectorsOfTheNormalSpaceAsTheyAre, ()) {
  const Linearised inner(any_system());
  ThroughSolver through(inner, inner.inverse_masses);
  const VectorXd inverse_M = inner.inverse_M().head(through.K().rows());
  const VectorXd u_N = through.K() * any_vector(through.K().cols(), 1);

  const VectorXd result = through(inverse_M.cwiseProduct(u_N));

  const double accuracy = 1e-12 * sqrt_condition(through.K(), inverse_M);
  RC_ASSERT((result - u_N).norm() <= accuracy * u_N.norm());
}

RC_GTEST_PROP(ForwardDynamics, Equation15_KGammainvKtIsTheOrthogonalProjectorOntoTheNormalSpace, ()) {
  const Linearised inner(any_system());
  std::vector<double> unit(inner.inverse_masses);
  for (double& weight : unit) weight = weight > 0.0 ? 1.0 : 0.0;
  ThroughSolver P(inner, unit);
  const Eigen::Index size = P.K().rows();
  const VectorXd u = any_vector(size, 1), x = any_vector(size, 2);

  const VectorXd Pu = P(u), PPu = P(Pu), Px = P(x);

  const double accuracy = 1e-12 * sqrt_condition(P.K(), VectorXd::Ones(size));
  RC_ASSERT((PPu - Pu).norm() <= accuracy * u.norm());
  RC_ASSERT(std::abs(x.dot(Pu) - u.dot(Px)) <= accuracy * u.norm() * x.norm());
  RC_ASSERT((P.K().transpose() * (u - Pu)).norm() <= accuracy * P.K().norm() * u.norm());
  if (P.K().cols() > 0) RC_ASSERT((Pu - Range(P.K()).part_in(u)).norm() <= accuracy * u.norm());
}

RC_GTEST_PROP(ForwardDynamics, Equation10_KSinvKtMinvIsAProjectorOrthogonalInTheMetricOfMinv, ()) {
  const Linearised inner(any_system());
  ThroughSolver through(inner, inner.inverse_masses);
  const VectorXd inverse_M = inner.inverse_M().head(through.K().rows());
  const VectorXd u = any_vector(inverse_M.size(), 1);

  // B u and the rest are orthogonal, so that u'M^-1u = (Bu)'M^-1(Bu) + (u - Bu)'M^-1(u - Bu).
  const VectorXd Bu = through(inverse_M.cwiseProduct(u));

  const double accuracy = 1e-12 * sqrt_condition(through.K(), inverse_M);
  const auto square = [&](const VectorXd& a) { return a.dot(inverse_M.cwiseProduct(a)); };
  RC_ASSERT(std::abs(square(u) - square(Bu) - square(u - Bu)) <= accuracy * square(u));
}

// ---- reactions and accelerations ---------------------------------------------------------------------------------

RC_GTEST_PROP(ForwardDynamics, Equation31_MultipliersSolveSLambdaPlusPhiPlusKtMinvF, ()) {
  const Solved solved(any_system());
  const reference::Mechanics& dense = solved.dense;

  const MatrixXd S = dense.S();
  const VectorXd b = dense.phi + dense.K.transpose() * dense.f.cwiseQuotient(dense.M);

  RC_ASSERT(solved.report.outcome.ok());
  const VectorXd root = S.diagonal().cwiseSqrt();
  const double size = root.cwiseProduct(solved.lambda).norm() + b.cwiseQuotient(root).norm() + 1.0;
  RC_ASSERT((S * solved.lambda + b).cwiseQuotient(root).norm() <= solved.accuracy * size);
}

RC_GTEST_PROP(ForwardDynamics, Equation23_ReactionsFromTheSplitAreKLambda, ()) {
  Solved solved(any_system());
  const reference::Mechanics& dense = solved.dense;
  const Split split = solved.split();
  RC_ASSERT(split.outcome.ok());
  const VectorXd w_N = dense.pick(split.normal_accelerations);

  // eta = K S^-1 K'[w_N - M^-1 f]
  const VectorXd right_side = dense.K.transpose() * (w_N - dense.f.cwiseQuotient(dense.M));
  const VectorXd eta = dense.K * reference::solve_definite(dense.S(), right_side);

  const double terms = solved.as_acceleration(dense.K.cwiseAbs() * solved.lambda.cwiseAbs());
  RC_ASSERT(solved.as_acceleration(solved.eta - dense.K * solved.lambda) <= 1e-14 * terms);
  RC_ASSERT(solved.as_acceleration(solved.eta - eta) <= 10.0 * solved.accuracy * solved.size);
}

RC_GTEST_PROP(ForwardDynamics, Equation25_MassTimesAccelerationIsForcePlusReaction, ()) {
  const Solved solved(any_system());
  const reference::Mechanics& dense = solved.dense;

  const VectorXd Mw = dense.M.cwiseProduct(solved.w);

  RC_ASSERT(solved.as_acceleration(Mw - dense.f - solved.eta) <= solved.accuracy * solved.size);
}

RC_GTEST_PROP(ForwardDynamics, AccelerationsSatisfyTheDifferentiatedConstraints, ()) {
  const Solved solved(any_system());
  const reference::Mechanics& dense = solved.dense;

  // K'w + phi = 0 holds to rounding whatever the condition number, since refinement brings it there.
  const VectorXd residual = dense.K.transpose() * solved.w + dense.phi;

  RC_ASSERT(residual.norm() <= 1e-13 * dense.K.norm() * solved.size);
  RC_ASSERT(solved.report.residual <= 1e-14);
}

RC_GTEST_PROP(ForwardDynamics, SupportsCarryTheirPrescribedAcceleration, ()) {
  const Solved solved(any_system());

  for (const Support& support : solved.random.system.supports) {
    const auto now = support.displacement(solved.random.t);
    for (const Index i : support.points) {
      for (std::size_t k = 0; k < 3; ++k) {
        RC_ASSERT(solved.accelerations[3 * static_cast<std::size_t>(i) + k] == now[k].derivative(2));
      }
    }
  }
}

// ---- the split ---------------------------------------------------------------------------------------------------

RC_GTEST_PROP(ForwardDynamics, Equations19And21_SplitIsNormalAndTangent, ()) {
  Solved solved(any_system());
  const reference::Mechanics& dense = solved.dense;

  const Split split = solved.split();

  RC_ASSERT(split.outcome.ok());
  const VectorXd w_T = dense.pick(split.tangent_accelerations), w_N = dense.pick(split.normal_accelerations);
  RC_ASSERT(solved.is_small(w_T + w_N - solved.w));
  RC_ASSERT(solved.is_small((dense.K.transpose() * w_N + dense.phi) / dense.K.norm()) || dense.K.cols() == 0);
  RC_ASSERT(solved.is_small((dense.K.transpose() * w_T) / dense.K.norm()) || dense.K.cols() == 0);
  RC_ASSERT(solved.is_small(dense.K.cols() == 0 ? w_N : Range(dense.K).part_outside(w_N)));
  // (19): w_T = [I - M^-1 K S^-1 K'](M^-1 f - w_N)
  const VectorXd given = dense.f.cwiseQuotient(dense.M) - w_N;
  const VectorXd lambda = reference::solve_definite(dense.S(), dense.K.transpose() * given);
  RC_ASSERT(solved.is_small((w_T - given + (dense.K * lambda).cwiseQuotient(dense.M)) / 10.0));
}

RC_GTEST_PROP(ForwardDynamics, SplitLeavesSupportsAtZero, ()) {
  Solved solved(any_system());

  const Split split = solved.split();

  RC_ASSERT(split.outcome.ok());
  for (const Support& support : solved.random.system.supports) {
    for (const Index i : support.points) {
      for (std::size_t c = 3 * static_cast<std::size_t>(i), k = 0; k < 3; ++k) {
        RC_ASSERT(split.tangent_accelerations[c + k] == 0.0 && split.normal_accelerations[c + k] == 0.0);
        RC_ASSERT(split.tangent_forces[c + k] == 0.0 && split.normal_forces[c + k] == 0.0);
      }
    }
  }
}

// ---- witnesses ---------------------------------------------------------------------------------------------------

RC_GTEST_PROP(ForwardDynamics, AgreesWithTheKktMatrix, ()) {
  const Solved solved(any_system());

  const reference::Solution expected = reference::solve_kkt(solved.dense);

  RC_ASSERT(solved.is_small(solved.w - expected.w));
  const VectorXd root = solved.dense.S().diagonal().cwiseSqrt();
  RC_ASSERT(root.cwiseProduct(solved.lambda - expected.lambda).norm() <=
            solved.accuracy * (solved.size + root.cwiseProduct(expected.lambda).norm()));
}

RC_GTEST_PROP(ForwardDynamics, GaussPrinciple_NoOtherAdmissibleAccelerationIsCloserToTheFreeOne, ()) {
  const Solved solved(any_system());
  const reference::Mechanics& dense = solved.dense;
  const VectorXd free = dense.f.cwiseQuotient(dense.M);
  // 1/2 (w - M^-1 f)'M(w - M^-1 f)
  const auto constraint = [&](const VectorXd& w) { return 0.5 * (w - free).dot(dense.M.cwiseProduct(w - free)); };
  const double least = constraint(solved.w);

  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    VectorXd z = any_vector(solved.w.size(), seed);
    if (dense.K.cols() > 0) z = Range(dense.K).part_outside(z);
    const double growth = 0.5 * z.dot(dense.M.cwiseProduct(z));
    // At the minimum the first-order term vanishes: G(w + z) = G(w) + 1/2 z'Mz.
    const double rounding = solved.accuracy * (solved.size * solved.size + 1.0) * dense.M.maxCoeff();
    RC_ASSERT(std::abs(constraint(solved.w + z) - least - growth) <= rounding);
  }
}

// ---- power and momentum ------------------------------------------------------------------------------------------

RC_GTEST_PROP(ForwardDynamics, PowerOfReactionsIsThatOfMovingConstraintsAndSupports, ()) {
  const Solved solved(any_system());
  const reference::Mechanics& dense = solved.dense;

  // The power is eta'v = -lambda'(xi_t + K_s'v_s), and 0 where nothing is driven.
  const double power = solved.eta.dot(dense.v), expected = -solved.lambda.dot(dense.rheonomic_rate);

  const double size = solved.eta.norm() * dense.v.norm() + solved.lambda.norm() * dense.rheonomic_rate.norm() + 1.0;
  RC_ASSERT(std::abs(power - expected) <= solved.accuracy * size);
}

RC_GTEST_PROP(ForwardDynamics, IdealReactionsDoNoWorkWhereNothingIsDriven, ()) {
  const Solved solved(any_system({.time_dependent = false}));

  const double power = solved.eta.dot(solved.dense.v);

  RC_ASSERT(std::abs(power) <= solved.accuracy * (1.0 + solved.eta.norm() * solved.dense.v.norm()));
}

RC_GTEST_PROP(ForwardDynamics, SupportLoadsAndActiveForcesAreTheRateOfMomentum, ()) {
  // Rods and angles act between points, so that d/dt sum m v = sum of all forces - sum of the forces on supports.
  Solved solved(without_guides(any_system()));
  const reference::Mechanics& dense = solved.dense;
  const std::vector<double> carried = solved.support_forces(), forces = solved.active_forces();

  Eigen::Vector3d momentum_rate = Eigen::Vector3d::Zero(), balance = momentum_rate;
  for (Index i = 0; i < static_cast<Index>(solved.random.system.num_points()); ++i) {
    balance += reference::point(forces, i) - reference::point(carried, i);
  }
  const VectorXd Mw = dense.M.cwiseProduct(solved.w);
  for (Eigen::Index c = 0; c < Mw.size(); c += 3) momentum_rate += Mw.segment<3>(c);

  const double size =
      1.0 + Mw.lpNorm<1>() + reference::vector(carried).lpNorm<1>() + reference::vector(forces).lpNorm<1>();
  RC_ASSERT((momentum_rate - balance).norm() <= solved.accuracy * size);
}

RC_GTEST_PROP(ForwardDynamics, SupportForceIsKLambdaPlusTheActiveForceThere, ()) {
  Solved solved(any_system());
  const RandomSystem& random = solved.random;

  const std::vector<double> carried = solved.support_forces(), forces = solved.active_forces();

  const VectorXd f = reference::evaluate_forces(random.system, random.t, random.positions, random.velocities);
  RC_ASSERT((reference::vector(forces) - f).norm() <= 1e-13 * (1.0 + f.norm()));
  const auto numbers = reference::evaluate_constraints(random.system, random.t, random.positions, random.velocities);
  const VectorXd expected = numbers.K * solved.lambda + f;
  const std::vector<char> is_support = reference::find_supports(random.system);
  for (Index i = 0; i < static_cast<Index>(is_support.size()); ++i) {
    const Eigen::Vector3d at_support = is_support[static_cast<std::size_t>(i)]
                                           ? Eigen::Vector3d(expected.segment<3>(3 * i))
                                           : Eigen::Vector3d(Eigen::Vector3d::Zero());
    RC_ASSERT((reference::point(carried, i) - at_support).norm() <= 1e-13 * (1.0 + expected.norm()));
  }
}

}  // namespace
}  // namespace tanor
