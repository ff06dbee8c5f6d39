/// Pair forces enter the stiffness of equilibria and modes, also those with a cutoff and of many points.

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>

#include "errors.hpp"
#include "scenes.hpp"
#include "statics/equilibrium_equations.hpp"
#include "statics/kkt_solver.hpp"

namespace tanor {
using namespace detail;
namespace {

using scenes::g;

/// Makes random points in a cube; the last one is a support.
System cloud(std::size_t count, double size) {
  System system;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(0.0, size);
  for (std::size_t i = 0; i < 3 * count; ++i) system.positions.push_back(place(random));
  system.masses.assign(count, 1.0);
  system.supports.push_back({"", {static_cast<Index>(count - 1)}, {}});
  return system;
}

PairForces pairs_of(PairLaw law, std::optional<double> cutoff) {
  PairForces pairs{.name = "pairs", .law = law, .epsilon = 0.7, .sigma = 0.8, .cutoff = cutoff, .strength = 0.6};
  pairs.length = 0.5;
  pairs.depth = 0.4;
  pairs.width = 1.7;
  pairs.rest_length = 0.9;
  if (law == PairLaw::Coulomb) pairs.charges = {1.3};
  return pairs;
}

/// W x is compared with -df along x, by central differences of the forces.
TEST(PairStiffness, AgreesWithDifferencesOfForces) {
  const std::pair<PairLaw, std::optional<double>> laws[] = {
      {PairLaw::Yukawa, 1.1}, {PairLaw::Morse, 1.2}, {PairLaw::Lj, 1.5},    {PairLaw::Wca, {}},
      {PairLaw::Log, {}},     {PairLaw::Yukawa, {}}, {PairLaw::Coulomb, {}}};
  for (const auto& [law, cutoff] : laws) {
    for (const Vector3& box : {Vector3{}, Vector3{4.0, 4.0, 4.0}}) {
      if (box != Vector3{} && !cutoff && law != PairLaw::Wca) continue;
      System system = cloud(40, 4.0);
      system.forces = {pairs_of(law, cutoff)};
      std::get<PairForces>(system.forces[0]).box = box;
      Workspace work(system, {}, 0.0);
      StiffnessMatrix W(work);
      const std::size_t n = work.model().num_points();
      std::vector<double> r(3 * n), v(3 * n, 0.0), f(3 * n), before(3 * n);
      work.model().numbering.gather_points(system.positions, r);
      W.evaluate(0.0, r.data(), nullptr);
      std::vector<double> x(3 * n, 0.0), product(3 * n), moved = r;
      for (std::size_t i = 0; i < 3 * W.num_points(); ++i) x[i] = std::sin(1.0 + 3.7 * static_cast<double>(i));

      W.multiply(x.data(), product.data());

      constexpr double e = 1e-6;
      for (std::size_t i = 0; i < r.size(); ++i) moved[i] = r[i] + e * x[i];
      work.forces.evaluate(Parallel(1), 0.0, moved.data(), v.data(), f.data());
      for (std::size_t i = 0; i < r.size(); ++i) moved[i] = r[i] - e * x[i];
      work.forces.evaluate(Parallel(1), 0.0, moved.data(), v.data(), before.data());
      for (std::size_t i = 0; i < 3 * W.num_points(); ++i)
        EXPECT_NEAR(product[i], (before[i] - f[i]) / (2.0 * e), 1e-7 * W.largest())
            << static_cast<int>(law) << " " << i;
      EXPECT_LE(W.asymmetry(), 1e-15);
    }
  }
}

/// A chain is drawn together and apart again: W has blocks of the pairs within the cutoff, and the factor follows them.
TEST(PairStiffness, HasTheBlocksOfPairsWithinTheCutoff) {
  System system;
  system.positions = {0, 0, 0, 1, 0, 0, 3, 0, 0, 4, 0, 0};
  system.masses.assign(4, 1.0);
  system.supports.push_back({"", {0}, {}});
  PairForces pairs = pairs_of(PairLaw::Morse, 1.5);
  system.forces = {pairs, Springs{.name = "springs", .pairs = {{0, 1}, {1, 2}, {2, 3}}, .stiffness = 9.0}};
  Workspace work(system, {}, 0.0);
  EquilibriumEquations equations(work, 0.0);
  std::vector<double> r(12);
  work.model().numbering.gather_points(system.positions, r);
  equations.linearise(r.data(), nullptr);
  KktSolver kkt(equations);
  const std::size_t apart = equations.stiffness().columns().size();

  for (const double shorter : {1.0, 0.4, 1.0}) {
    std::vector<double> moved = r;
    for (double& x : moved) x *= shorter;
    equations.linearise(moved.data(), nullptr);
    EXPECT_EQ(equations.stiffness().columns().size() > apart, shorter < 1.0);
    ASSERT_TRUE(kkt.factorize(1e3));
    std::vector<double> x(9), y, wanted(9);
    for (std::size_t i = 0; i < 9; ++i) x[i] = wanted[i] = std::cos(static_cast<double>(i));
    EXPECT_LE(kkt.solve(x.data(), y.data()), 1e-13);
    std::vector<double> image(9);
    equations.stiffness().multiply(x.data(), image.data());
    for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(image[i] + 1e3 * x[i], wanted[i], 1e-12);
  }
}

/// Morse's law binds beads on a line between supports to their neighbours alone, as a chain of springs of 2 D a^2.
TEST(PairStiffness, GivesAChainOfNeighboursItsModes) {
  constexpr std::size_t count = 11;
  const double depth = 0.4, width = 1.7, distance = 0.9;
  System system;
  for (std::size_t i = 0; i < count; ++i)
    system.positions.insert(system.positions.end(), {distance * static_cast<double>(i), 0.0, 0.0});
  system.masses.assign(count, 2.0);
  system.supports.push_back({"", {0, count - 1}, {}});
  std::vector<Index> inner;
  for (std::size_t i = 1; i + 1 < count; ++i) inner.push_back(static_cast<Index>(i));
  system.constraints = {Lines{"line", inner, Vector3{0.0, 0.0, 0.0}, Vector3{1.0, 0.0, 0.0}}};
  system.forces = {pairs_of(PairLaw::Morse, 1.3)};

  const EquilibriumResult found = find_equilibrium(system);
  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  const Modes result = modes(system, found.positions, {.count = 9});

  ASSERT_EQ(result.omega.size(), 9u);
  const double stiffness = 2.0 * depth * width * width, mass = 2.0;
  for (std::size_t j = 0; j < 9; ++j) {
    // The modes have omega = 2 sqrt(k/m) sin(j pi/2N).
    const double wanted = 2.0 * std::sqrt(stiffness / mass) *
                          std::sin(static_cast<double>(j + 1) * M_PI / (2.0 * static_cast<double>(count - 1)));
    EXPECT_NEAR(result.omega[j], wanted, 1e-9);
  }
}

/// The 603 unknowns of these charges on a sphere are more than stability takes as a dense matrix (300). Euler's sum of
/// multipliers and the rigid motions check the answer.
TEST(PairStiffness, ManyChargesAreKnownToBeStable) {
  constexpr std::size_t count = 201;
  System system;
  std::vector<Index> all;
  for (std::size_t i = 0; i < count; ++i) {
    // Fibonacci's spiral is near a minimum.
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / count,
                 turn = static_cast<double>(i) * 2.399963229728653;
    const double radius = std::sqrt(1.0 - z * z);
    system.positions.insert(system.positions.end(), {radius * std::cos(turn), radius * std::sin(turn), z});
    all.push_back(static_cast<Index>(i));
  }
  system.masses.assign(count, 1.0);
  system.constraints = {Spheres{"sphere", all, Vector3{0.0, 0.0, 0.0}, 1.0}};
  PairForces charges{.name = "charges", .law = PairLaw::Coulomb};
  charges.charges = {1.0};
  system.forces = {charges};

  const EquilibriumResult found = find_equilibrium(system, {.accept = AcceptedEquilibria::Marginal});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.stability.rigid_zero_modes, 3u);
  double sum = 0.0;
  for (const double lambda : found.multipliers) sum += lambda;
  EXPECT_NEAR(sum, -found.energy, 1e-8 * found.energy);
}

/// Charges that take more than memory holds are refused with the number of bytes, unless nobody asks for stability.
TEST(PairStiffness, TooManyChargesAreRefused) {
  System system = cloud(3001, 30.0);
  PairForces charges{.name = "charges", .law = PairLaw::Coulomb};
  charges.charges = {1.0};
  system.forces = {charges};

  const std::string refusal = error_of([&] { (void)find_equilibrium(system); });

  EXPECT_NE(refusal.find("charges: 3001 points all interact"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("bytes"), std::string::npos) << refusal;
}

}  // namespace
}  // namespace tanor
