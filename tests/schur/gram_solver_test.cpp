/// The tests compare x = -S^-1 b over all parts with the dense S.

#include "schur/gram_solver.hpp"

#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "linearised.hpp"
#include "random_numbers.hpp"

namespace tanor {
using namespace detail;
namespace {

GramSolver make_solver(const Linearised& inner, Ordering ordering = Ordering::Auto) {
  return {inner.incidences, inner.inverse_masses, inner.numbering, ordering,
          inner.constraints.squared_gradient_norms()};
}

/// Makes chains of rods in random directions, each from a support of its own; the last rod of chain `redundant` is
/// doubled.
System make_chains(int chains, int rods, int redundant = -1) {
  System system;
  Rods group;
  Support support;
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  for (int chain = 0; chain < chains; ++chain) {
    const auto first = static_cast<Index>(chain * (rods + 1));
    support.points.push_back(first);
    for (Index k = 0; k <= rods; ++k) {
      for (int c = 0; c < 3; ++c) system.positions.push_back(k + normal(generator));
      system.masses.push_back(std::exp(normal(generator)));
      if (k > 0) group.pairs.push_back({first + k - 1, first + k});
    }
  }
  if (redundant >= 0) {
    const auto last = static_cast<Index>((redundant + 1) * (rods + 1) - 1);
    group.pairs.push_back({last, last - 1});
  }
  system.supports = {support};
  system.constraints = {group};
  return system;
}

Linearised linearised_start(const System& system) {
  return {system, 0.0, system.positions, std::vector<double>(system.positions.size(), 0.0)};
}

RC_GTEST_PROP(GramSolver, GivesMinusTheSolutionOfTheDenseSystem, ()) {
  const auto ordering =
      *rc::gen::element(Ordering::Auto, Ordering::Amd, Ordering::Metis, Ordering::Nesdis, Ordering::Natural);
  const RandomSystem random = any_system();
  const Linearised inner(random);
  GramSolver solver = make_solver(inner, ordering);
  const Parallel parallel(1);
  std::vector<double> x = normal_numbers(inner.constraints.num_rows(), 1);
  const Eigen::VectorXd b = reference::vector(x);

  solver.assemble(parallel, inner.blocks.data());
  const GramSolver::Quality quality = solver.factorize(parallel);
  solver.solve_negative(parallel, x.data(), x.data());

  RC_ASSERT(quality.positive_definite && quality.reciprocal_condition > GramSolver::singular_below);
  const Eigen::MatrixXd S = inner.S();
  // The residual is scaled, since rows of S are as large as the root of their diagonal.
  const Eigen::VectorXd root = S.diagonal().cwiseSqrt();
  const Eigen::VectorXd residual = (S * reference::vector(x) + b).cwiseQuotient(root);
  const Eigen::VectorXd scaled_x = reference::vector(x).cwiseProduct(root);
  RC_ASSERT(residual.norm() <= 1e-13 * (scaled_x.norm() + b.cwiseQuotient(root).norm()));
}

TEST(GramSolver, ManyIslandsAreSolvedPartByPart) {
  const Linearised inner = linearised_start(make_chains(40, 30));
  GramSolver solver = make_solver(inner);
  const Parallel parallel(2);
  const std::vector<double> b = normal_numbers(1200, 1);
  std::vector<double> x(1200, NAN);

  solver.assemble(parallel, inner.blocks.data());
  ASSERT_TRUE(solver.factorize(parallel).positive_definite);
  solver.solve_negative(parallel, b.data(), x.data());

  EXPECT_EQ(solver.summary().factor.parts, 2U);
  EXPECT_EQ(solver.summary().factor.pattern_nonzeros, 40U * 59U);
  EXPECT_EQ(solver.summary().factor.factor_nonzeros, 40U * 59U);
  EXPECT_EQ(solver.summary().factor.orderings, std::vector{Ordering::Natural});
  EXPECT_EQ(solver.summary().factor.factorizations, std::vector{Factorization::Simplicial});
  const Eigen::VectorXd residual = inner.S() * reference::vector(x) + reference::vector(b);
  EXPECT_LE(residual.norm(), 1e-12 * reference::vector(b).norm());
}

TEST(GramSolver, TwoThreadsGiveTheSameBits) {
  const Linearised inner = linearised_start(make_chains(200, 30));
  const std::vector<double> b = normal_numbers(6000, 1);
  const auto solve = [&](int threads) {
    GramSolver solver = make_solver(inner, Ordering::Amd);
    const Parallel parallel(threads);
    std::vector<double> x(6000);
    solver.assemble(parallel, inner.blocks.data());
    (void)solver.factorize(parallel);
    solver.solve_negative(parallel, b.data(), x.data());
    return x;
  };

  const std::vector<double> one = solve(1), two = solve(2);

  EXPECT_EQ(one, two);
}

TEST(GramSolver, RedundantRowIsFoundInItsPart) {
  // There are 1201 rows in two parts; the doubled rod closes chain 33 and lies in the second.
  const System system = make_chains(40, 30, 33);
  const Linearised inner = linearised_start(system);
  for (const Ordering ordering : {Ordering::Auto, Ordering::Amd, Ordering::Metis}) {
    GramSolver solver = make_solver(inner, ordering);
    const Parallel parallel(1);

    solver.assemble(parallel, inner.blocks.data());
    const GramSolver::Quality quality = solver.factorize(parallel);

    EXPECT_TRUE(!quality.positive_definite || quality.reciprocal_condition <= GramSolver::singular_below);
    const Index row = inner.numbering.user_row[quality.weakest_row];
    EXPECT_TRUE(row == 1200 || row == 33 * 30 + 29) << row;
  }
}

TEST(GramSolver, ReciprocalConditionIsThatOfTheWorstPart) {
  // Two planes whose directions differ by 1e-3 hold a further free point: cos = 1 - 5e-7, and the second pivot is
  // sin^2 = 1e-6.
  System system = make_chains(40, 30);
  const Index point = 1240;
  system.positions.insert(system.positions.end(), {0.0, 0.0, 0.0});
  system.masses.push_back(2.0);
  const Linearised good = linearised_start(system);
  system.constraints.push_back(Planes{"", {point}, Vector3{0.0, 0.0, 1.0}, 0.0});
  system.constraints.push_back(Planes{"", {point}, Vector3{0.0, 1e-3, 1.0}, 0.0});
  const Linearised bad = linearised_start(system);
  const auto quality_of = [](const Linearised& inner) {
    GramSolver solver = make_solver(inner);
    solver.assemble(Parallel(1), inner.blocks.data());
    return solver.factorize(Parallel(1));
  };

  const GramSolver::Quality before = quality_of(good), after = quality_of(bad);

  EXPECT_GT(before.reciprocal_condition, 1e-4);
  EXPECT_NEAR(after.reciprocal_condition, 1e-6, 1e-11);
  EXPECT_GE(bad.numbering.user_row[after.weakest_row], 1200);
}

TEST(GramSolver, SystemWithoutRowsNeedsNothing) {
  System system = make_chains(1, 2);
  system.constraints.clear();
  const Linearised inner = linearised_start(system);
  GramSolver solver = make_solver(inner);

  solver.assemble(Parallel(1), inner.blocks.data());
  const GramSolver::Quality quality = solver.factorize(Parallel(1));
  solver.solve_negative(Parallel(1), nullptr, nullptr);

  EXPECT_TRUE(quality.positive_definite);
  EXPECT_EQ(quality.reciprocal_condition, 1.0);
  EXPECT_EQ(solver.summary().factor.parts, 0U);
  EXPECT_TRUE(solver.summary().factor.factorizations.empty());
}

TEST(GramSolver, LatticeIsFactorizedBySupernodes) {
  // Rods join neighbours of an 11 x 11 x 11 lattice of disturbed positions: S is a matrix of 3630 rows.
  constexpr Index side = 11;
  System system;
  Rods rods;
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> jitter(-0.3, 0.3);
  const auto node = [](Index x, Index y, Index z) { return (x * side + y) * side + z; };
  for (Index x = 0; x < side; ++x) {
    for (Index y = 0; y < side; ++y) {
      for (Index z = 0; z < side; ++z) {
        for (const Index c : {x, y, z}) system.positions.push_back(c + jitter(generator));
        system.masses.push_back(1.0);
        if (x + 1 < side) rods.pairs.push_back({node(x, y, z), node(x + 1, y, z)});
        if (y + 1 < side) rods.pairs.push_back({node(x, y, z), node(x, y + 1, z)});
        if (z + 1 < side) rods.pairs.push_back({node(x, y, z), node(x, y, z + 1)});
      }
    }
  }
  system.constraints = {rods};
  const Linearised inner = linearised_start(system);
  GramSolver solver = make_solver(inner);
  const Parallel parallel(1);
  const std::size_t d = rods.pairs.size();
  const std::vector<double> b = normal_numbers(d, 1);
  std::vector<double> x(d);

  solver.assemble(parallel, inner.blocks.data());
  const GramSolver::Quality quality = solver.factorize(parallel);
  solver.solve_negative(parallel, b.data(), x.data());

  EXPECT_EQ(solver.summary().factor.factorizations, std::vector{Factorization::Multifrontal});
  ASSERT_TRUE(quality.positive_definite);
  // The product S x = K' M^-1 (K x) is computed without a dense matrix.
  std::vector<double> Kx(inner.r.size(), 0.0), Sx(d);
  for (const auto& [point, row, block, sign] : inner.incidences) {
    for (int c = 0; c < 3; ++c) {
      Kx[3 * static_cast<std::size_t>(point) + static_cast<std::size_t>(c)] +=
          sign * x[static_cast<std::size_t>(row)] *
          inner.blocks[3 * static_cast<std::size_t>(block) + static_cast<std::size_t>(c)];
    }
  }
  (void)inner.constraints.apply_transposed(parallel, inner.blocks.data(), Kx.data(), nullptr, Sx.data());
  const Eigen::VectorXd residual = reference::vector(Sx) + reference::vector(b);
  EXPECT_LE(residual.norm(), 1e-11 * reference::vector(b).norm());
}

}  // namespace
}  // namespace tanor
