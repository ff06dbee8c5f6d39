#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <tuple>

#include <tanor/modes.hpp>

#include "dense.hpp"
#include "dense_modes.hpp"
#include "random_systems.hpp"
#include "statics/given_equilibrium.hpp"
#include "statics/mode_finder.hpp"

namespace tanor {
using namespace detail;
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

/// Expects shapes that are M-orthonormal, break no constraint, and have the wanted omega^2 with W q + K mu = omega^2 M
/// q.
void expect_modes(const ModeSet& found, const DenseModes& dense, double scale) {
  const Eigen::Index count = found.omega2.size();
  const MatrixXd& q = found.shapes;
  const MatrixXd masses = q.transpose() * dense.mass.asDiagonal() * q;
  RC_ASSERT((masses - MatrixXd::Identity(count, count)).cwiseAbs().maxCoeff() < 1e-11);
  if (dense.K.cols() > 0) {
    const VectorXd lengths = dense.K.colwise().norm().transpose() * std::sqrt(1.0 / dense.mass.minCoeff());
    const VectorXd worst = (dense.K.transpose() * q).cwiseAbs().rowwise().maxCoeff();
    // Shapes are combinations of random moves, whose condition multiplies rounding.
    RC_ASSERT((worst.array() <= 1e-10 * lengths.array().max(1e-300)).all());
  }
  RC_ASSERT((found.omega2 - dense.omega2.head(count)).cwiseAbs().maxCoeff() < 1e-9 * scale);
  // With the best multipliers the residual is no larger than the reported one.
  const auto weight = dense.mass.cwiseSqrt().cwiseInverse().asDiagonal();
  MatrixXd rest = weight * (dense.W * q - dense.mass.asDiagonal() * q * found.omega2.asDiagonal());
  const MatrixXd K = weight * dense.K;
  if (K.cols() > 0) rest -= K * reference::solve_least_squares(K, rest);
  const double told = found.residual * found.omega2.cwiseAbs().maxCoeff();
  RC_ASSERT(rest.colwise().norm().maxCoeff() < 1.01 * told + 1e-11 * scale);
}

/// A random system with numbers that stand for multipliers.
struct AtRest {
  explicit AtRest(const RandomSystem& random)
      : work(random.system, {.threads = 1}, random.t), equations(work, random.t), r(random.positions.size()) {
    work.model().numbering.gather_points(random.positions, r);
    for (std::size_t a = 0; a < work.model().num_rows(); ++a)
      lambda.push_back(-std::sin(1.0 + 3.0 * static_cast<double>(a)));
    equations.linearise(r.data(), lambda.data());
  }

  Workspace work;
  EquilibriumEquations equations;
  std::vector<double> r, lambda;
};

RC_GTEST_PROP(ModeFinder, FindsAllModesThatTheDenseMatricesHave, ()) {
  RandomSystem random = any_system();
  random.system.friction.clear();
  const AtRest rest(random);
  RC_PRE(rest.equations.size() > rest.equations.num_rows());
  const DenseModes dense(rest.equations);
  RC_PRE(dense.is_symmetric());
  KktSolver kkt(rest.equations);
  ModeFinder finder(rest.equations, kkt, dense.freedoms());

  const ModeSet found = finder.find_all();

  RC_ASSERT(found.outcome.ok());
  RC_ASSERT(found.omega2.size() == dense.omega2.size());
  expect_modes(found, dense, finder.scale());
}

RC_GTEST_PROP(ModeFinder, FindsTheLowestModesThatTheDenseMatricesHave, ()) {
  RandomSystem random = any_system();
  random.system.friction.clear();
  const AtRest rest(random);
  const DenseModes dense(rest.equations);
  RC_PRE(dense.freedoms() >= 2u);
  RC_PRE(dense.is_symmetric());
  const std::size_t count = *rc::gen::inRange<std::size_t>(1, dense.freedoms() / 2 + 1).as("count");
  KktSolver kkt(rest.equations);
  ModeFinder finder(rest.equations, kkt, dense.freedoms());

  const ModeSet found = finder.find_lowest(count, 1e-10);

  // Multipliers of any size make any W. Where omega^2 of both signs lie close to the wanted shift, a search may end
  // without an answer and report that.
  RC_PRE(found.outcome.ok() || found.outcome.status != Status::NotConverged);
  RC_ASSERT(found.outcome.ok());
  RC_ASSERT(static_cast<std::size_t>(found.omega2.size()) == count);
  expect_modes(found, dense, finder.scale());
  const double largest = found.omega2.cwiseAbs().maxCoeff();
  RC_ASSERT(found.residual * largest <=
            std::max(1e-10 * (largest + std::abs(finder.shift())), finder.residual_to_rounding(found.omega2[0])));
}

/// Makes copies of a hanging chain of random rods and masses, side by side.
System hang_chains(int copies, int rods, std::uint32_t seed) {
  System system;
  Rods all{.name = "rods"};
  Support held;
  for (int copy = 0; copy < copies; ++copy) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> length(0.1, 0.5), mass(0.2, 2.0);
    double z = 0.0;
    for (int i = 0; i <= rods; ++i) {
      const auto point = static_cast<int>(system.masses.size());
      system.positions.insert(system.positions.end(), {1.0 * copy, 0.0, z});
      system.masses.push_back(mass(random));
      z -= length(random);
      i == 0 ? held.points.push_back(point) : all.pairs.push_back({point - 1, point});
    }
  }
  system.supports = {held};
  system.constraints = {all};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}

RC_GTEST_PROP(ModeFinder, FindsEveryCopyOfTheModesOfEqualIslands, ()) {
  const int rods = *rc::gen::inRange(1, 5).as("rods"), copies = *rc::gen::inRange(1, 24).as("copies");
  const System system = hang_chains(copies, rods, *rc::gen::arbitrary<std::uint32_t>().as("seed"));
  const auto state = GivenEquilibrium::stand_at(system, {system.positions, {}, 1e-6}, {.solver = {.threads = 1}});
  const DenseModes dense(state->equations());
  RC_ASSERT(dense.freedoms() == static_cast<std::size_t>(2 * rods * copies));
  const std::size_t count = *rc::gen::inRange<std::size_t>(1, dense.freedoms() / 2 + 1).as("count");
  KktSolver kkt(state->equations());
  ModeFinder finder(state->equations(), kkt, dense.freedoms());

  const ModeSet found = finder.find_lowest(count, 1e-10);

  RC_ASSERT(found.outcome.ok());
  expect_modes(found, dense, finder.scale());
}

/// Nets of random masses rest, hung by two corners.
RC_GTEST_PROP(ModeFinder, FindsTheLowestModesOfRandomNets, ()) {
  const int columns = *rc::gen::inRange(3, 6).as("columns"), rows = *rc::gen::inRange(2, 6).as("rows");
  std::mt19937 random(*rc::gen::arbitrary<std::uint32_t>().as("seed"));
  std::uniform_real_distribution<double> mass(0.2, 2.0);
  System system;
  Rods rods{.name = "rods"};
  rods.length.constants = {1.0};
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int point = j * columns + i;
      system.positions.insert(system.positions.end(), {0.7 * i, 0.3 * j, -0.9 * j});
      system.masses.push_back(mass(random));
      if (i > 0) rods.pairs.push_back({point - 1, point});
      if (j > 0) rods.pairs.push_back({point - columns, point});
    }
  }
  system.supports = {Support{"", {0, columns - 1}}};
  system.constraints = {rods};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  const EquilibriumResult rest = find_equilibrium(system, {.solver = {.threads = 1}});
  RC_PRE(rest.outcome.ok() && rest.self_stress_states == 0);
  const auto state =
      GivenEquilibrium::stand_at(system, {rest.positions, rest.multipliers, 1e-6}, {.solver = {.threads = 1}});
  const DenseModes dense(state->equations());
  RC_PRE(dense.freedoms() >= 2u);
  KktSolver kkt(state->equations());
  ModeFinder finder(state->equations(), kkt, dense.freedoms());

  const ModeSet found = finder.find_lowest(dense.freedoms() / 2, 1e-10);

  RC_ASSERT(found.outcome.ok());
  expect_modes(found, dense, finder.scale());
  RC_ASSERT(std::abs(finder.find_all().omega2[0] - rest.stability.lowest_omega2) < 1e-9 * finder.scale());
}

/// Nets hang by corners which are far nearer than the nets are wide, so that K is badly conditioned. Lanczos'
/// method with inexact solves found one mode of six.
TEST(ModeFinder, FindsTheLowestModesOfNetsThatHangLoosely) {
  for (const auto& [columns, rows, held] :
       {std::tuple{20, 17, std::vector<Index>{6, 13, 320}}, std::tuple{18, 15, std::vector<Index>{0, 17, 252}},
        std::tuple{16, 16, std::vector<Index>{0, 15}}}) {
    System system;
    Rods rods{.name = "rods"};
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        const int point = j * columns + i;
        system.positions.insert(system.positions.end(), {0.1 * i, 0.1 * j, 0.0});
        system.masses.push_back(0.1);
        if (i > 0) rods.pairs.push_back({point - 1, point});
        if (j > 0) rods.pairs.push_back({point - columns, point});
      }
    }
    system.supports = {Support{"", held}};
    system.constraints = {rods};
    system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
    const EquilibriumResult rest = find_equilibrium(system, {.solver = {.threads = 1}});
    ASSERT_TRUE(rest.outcome.ok()) << rest.outcome.what;
    const auto state = GivenEquilibrium::stand_at(system, {rest.positions, {}, 1e-6}, {.solver = {.threads = 1}});
    KktSolver kkt(state->equations());
    ModeFinder finder(state->equations(), kkt, state->degrees_of_freedom());

    const ModeSet found = finder.find_lowest(6, 1e-10);

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_NEAR(found.omega2[0], rest.stability.lowest_omega2, 1e-9 * rest.stability.lowest_omega2);
    const VectorXd all = finder.find_all().omega2;
    for (Eigen::Index k = 0; k < 6; ++k) EXPECT_NEAR(found.omega2[k], all[k], 1e-8 * all[k]) << columns << ' ' << k;
  }
}

/// An upright chain of more than 300 unknowns, which nothing holds, is unstable in all directions but one, its length.
TEST(ModeFinder, CountsUnstableDirectionsOfAnUprightChainWithoutAMode) {
  System system = hang_chains(1, 150, 3);
  system.forces = {Gravity{"", {0.0, 0.0, 9.81}}};

  const EquilibriumResult rest =
      find_equilibrium(system, {.method = EquilibriumMethod::Newton, .accept = AcceptedEquilibria::Any});

  ASSERT_TRUE(rest.outcome.ok()) << rest.outcome.what;
  EXPECT_EQ(rest.stability.unstable_directions, 300u);
}

/// Single forces vanish where a molecule rests, so that rounding is all that is left of them.
TEST(Modes, AreFoundForAMoleculeAtRest) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.2, 0.1, 0.0, 1.9, 0.9, 0.3, 3.1, 1.0, 0.9};
  system.masses = {1.0, 2.0, 2.0, 1.0};
  system.forces = {Bonds{"bonds", {{0, 1}, {1, 2}, {2, 3}}, BondLaw::Harmonic, 300.0, 1.1},
                   Bendings{"angles", {{0, 1, 2}, {1, 2, 3}}, BendingLaw::Harmonic, 5.0, 1.9}};
  const EquilibriumResult rest = find_equilibrium(system, {.accept = AcceptedEquilibria::Any});
  ASSERT_TRUE(rest.outcome.ok()) << rest.outcome.what;

  const Modes found = modes(system, rest.positions, {.count = ModesOptions::all});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.unstable_directions, 0u);
  EXPECT_EQ(found.zero_modes, 7u);  // and the turn about the bond in the middle
}

/// Free straight chains resist bending: each moves as a whole in three directions and turns about two axes.
TEST(Modes, AreNoneWhereNothingMoves) {
  System system;
  for (double x : {0.0, 1.0}) system.add_support({x, 0.0, 0.0});
  system.add_gravity({0.0, 0.0, -9.81});
  for (const bool damped : {false, true}) {
    const Modes found = modes(system, system.positions, {.damped = damped});
    EXPECT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.count(), 0u);
    EXPECT_EQ(found.degrees_of_freedom, 0u);
  }
}

TEST(Modes, HaveTheZeroModesOfFreeIslands) {
  for (const int copies : {1, 2, 7}) {
    System system;
    Rods rods;
    Bendings bendings{"bending", {}, BendingLaw::Cosine, 0.3, std::acos(-1.0)};
    for (int copy = 0; copy < copies; ++copy) {
      for (int i = 0; i < 5; ++i) {
        const int point = 5 * copy + i;
        system.positions.insert(system.positions.end(), {0.2 * i, 1.0 * copy, 0.0});
        system.masses.push_back(0.1 + 0.1 * i);
        if (i > 0) rods.pairs.push_back({point - 1, point});
        if (i > 1) bendings.triples.push_back({point - 2, point - 1, point});
      }
    }
    system.constraints = {rods};
    system.forces = {bendings};

    const Modes found = modes(system, system.positions, {.count = ModesOptions::all});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.count(), static_cast<std::size_t>(11 * copies));
    EXPECT_EQ(found.zero_modes, static_cast<std::size_t>(5 * copies));
    EXPECT_EQ(found.rigid_zero_modes, found.zero_modes);
    const EquilibriumResult rest = find_equilibrium(system);
    EXPECT_EQ(rest.stability.status, Stability::Stable);
    EXPECT_EQ(rest.stability.rigid_zero_modes, found.zero_modes);
  }
}

/// There are 8,000 freedoms, of which some are equal.
TEST(Modes, HaveTheSameBitsOnAnyNumberOfThreads) {
  const System system = hang_chains(40, 100, 3);

  const Modes one = modes(system, system.positions, {.count = 20, .solver = {.threads = 1}});

  ASSERT_TRUE(one.outcome.ok()) << one.outcome.what;
  for (const int threads : {2, 3}) {
    const Modes more = modes(system, system.positions, {.count = 20, .solver = {.threads = threads}});
    EXPECT_EQ(more.omega, one.omega);
    EXPECT_EQ(more.shapes, one.shapes);
    EXPECT_EQ(more.residual_max, one.residual_max);
  }
}

}  // namespace
}  // namespace tanor
