/// Where all forces vanish at rest the largest of them is rounding, and no scale.

#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>
#include <tanor/user_kernel.hpp>

namespace tanor {
namespace {

/// Makes a triangle of springs whose lengths at rest are known to nine digits.
System make_triangle(double size, double stiffness) {
  System system;
  for (const double x : {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.3, 0.8, 0.0}) system.positions.push_back(size * x);
  system.masses.assign(3, 1.0);
  Springs springs{.name = "springs", .pairs = {{0, 1}, {1, 2}, {0, 2}}, .stiffness = stiffness};
  springs.rest_length.constants = {size, 1.063014581 * size, 0.854400375 * size};
  system.forces = {springs};
  return system;
}

/// Returns why the positions of a system are no equilibrium.
std::string find_refusal(const System& system) {
  try {
    (void)modes(system, system.positions);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

void expect_said(const std::string& words, const std::string& refusal) {
  EXPECT_NE(refusal.find(words), std::string::npos) << refusal;
}

/// Those of the exact lengths, for which the positions are an equilibrium to all digits.
TEST(StressFreeSprings, HaveModesWhereTheirLengthsHaveNineDigits) {
  for (const double size : {1e-3, 1.0, 1e3}) {
    const System triangle = make_triangle(size, 100.0);
    System exact = triangle;
    std::get<Springs>(exact.forces[0]).rest_length.constants = {size, std::hypot(0.7, 0.8) * size,
                                                                std::hypot(0.3, 0.8) * size};

    const Modes found = modes(triangle, triangle.positions, {.count = ModesOptions::all});
    const Modes wanted = modes(exact, exact.positions, {.count = ModesOptions::all});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.zero_modes, 6u);
    ASSERT_EQ(found.count(), 9u);
    for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(found.omega[k], wanted.omega[k], 1e-7) << k;
  }
}

/// A few parts in 1e7 leave forces of which W knows: those of a turned structure are the turned ones.
TEST(StressFreeSprings, MoveFreelyWhereOneLengthIsNearlyRight) {
  System triangle = make_triangle(1.0, 100.0);
  std::get<Springs>(triangle.forces[0]).rest_length.constants[0] = 1.000001;

  const Modes found = modes(triangle, triangle.positions, {.count = ModesOptions::all});

  EXPECT_EQ(found.zero_modes, 6u);
  EXPECT_EQ(found.rigid_zero_modes, 6u);
}

double round_to_seven_digits(double x) {
  std::array<char, 32> text{};
  (void)std::snprintf(text.data(), text.size(), "%.7g", x);
  return std::stod(text.data());
}

/// Joins all pairs of 4 to 8 random points by springs, and the first few pairs of each third framework by rods.
System draw_framework(unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> place(-1.0, 1.0), power(-1.0, 1.0);
  const int points = 4 + static_cast<int>(seed % 5);
  const double size = std::pow(10.0, power(generator));
  System system;
  for (int k = 0; k < 3 * points; ++k) system.positions.push_back(size * place(generator));
  for (int i = 0; i < points; ++i) system.masses.push_back(std::pow(10.0, power(generator)));
  Springs springs{.stiffness = std::pow(10.0, 3.0 * power(generator))};
  Rods rods;
  for (int i = 0; i < points; ++i) {
    for (int j = i + 1; j < points; ++j) {
      const bool is_rod = seed % 3 == 0 && j <= i + 2;
      double square = 0.0;
      for (int c = 0; c < 3; ++c)
        square += std::pow(system.positions[static_cast<std::size_t>(3 * j + c)] -
                               system.positions[static_cast<std::size_t>(3 * i + c)],
                           2);
      (is_rod ? rods.pairs : springs.pairs).push_back({i, j});
      (is_rod ? rods.length : springs.rest_length).constants.push_back(round_to_seven_digits(std::sqrt(square)));
    }
  }
  system.forces = {springs};
  if (!rods.pairs.empty()) system.constraints = {rods};
  return system;
}

/// One in seven is so soft in some direction that its rest is more than 1e-6 of the scene away.
TEST(StressFreeFrameworks, MoveFreelyWhereTheirLengthsHaveSevenDigits) {
  std::size_t refused = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const System framework = draw_framework(seed);
    if (!find_refusal(framework).empty()) {
      ++refused;
      continue;
    }

    const Modes found = modes(framework, framework.positions, {.count = ModesOptions::all});

    ASSERT_TRUE(found.outcome.ok()) << seed << ": " << found.outcome.what;
    EXPECT_EQ(found.zero_modes, 6u) << seed;
    EXPECT_EQ(found.rigid_zero_modes, 6u) << seed;
  }
  EXPECT_LT(refused, 60u);
}

TEST(StressFreeSprings, AreNoEquilibriumWhereALengthIsWrong) {
  System triangle = make_triangle(1.0, 100.0);
  std::get<Springs>(triangle.forces[0]).rest_length.constants[1] += 1e-4;

  expect_said("1e-06 of its stiffness times the size of the scene, is allowed; Newton's method would move points by",
              find_refusal(triangle));
}

/// Newton's method finds no rest where nothing is stiff.
TEST(UnbalancedWeights, AreComparedWithTheLargestForce) {
  System point;
  point.positions = {0.0, 0.0, 0.0};
  point.masses = {1.0};
  point.forces = {Gravity{"", {0.0, 0.0, -9.81}}};

  expect_said("nothing balances 9.81 at point 0 (0, 0, 0), where at most 9.81e-06, 1e-06 of the largest force, is",
              find_refusal(point));
}

/// A slack rope of stiff springs is no equilibrium although its weight is small beside them.
TEST(StiffSprings, DoNotExcuseTheirWeight) {
  System rope;
  Springs springs{.name = "rope", .stiffness = 1e10};
  springs.rest_length.constants = {1.0};
  for (int i = 0; i <= 4; ++i) {
    rope.positions.insert(rope.positions.end(), {1.0 * i, 0.0, 0.0});
    rope.masses.push_back(1.0);
    if (i > 0) springs.pairs.push_back({i - 1, i});
  }
  rope.supports = {{"", {0, 4}, {}}};
  rope.forces = {springs, Gravity{"", {0.0, 0.0, -9.81}}};

  expect_said(", where at most 4e-06, 1e-06 of the size of the scene, is allowed", find_refusal(rope));
}

TEST(StressFreeSprings, AreStableFarFromTheOrigin) {
  for (const double far : {0.0, 1e3, 1e6}) {
    System tetrahedron;
    for (const double x : {0.0, 0.0, 0.0, 1.05, 0.0, 0.0, 0.3, 0.8, 0.02, 0.4, 0.3, 0.7})
      tetrahedron.positions.push_back(far + x);
    tetrahedron.masses.assign(4, 1.0);
    Springs springs{.pairs = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}, .stiffness = 100.0};
    springs.rest_length.constants = {1.0, 0.9, 0.85, 1.1, 0.95, 0.9};
    tetrahedron.forces = {springs};

    const EquilibriumResult found = find_equilibrium(tetrahedron);

    ASSERT_TRUE(found.outcome.ok()) << far << ": " << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable);
    EXPECT_EQ(found.stability.rigid_zero_modes, 6u);
    for (std::size_t k = 0; k < springs.pairs.size(); ++k) {
      const auto [i, j] = springs.pairs[k];
      double square = 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double d =
            found.positions[3 * static_cast<std::size_t>(j) + c] - found.positions[3 * static_cast<std::size_t>(i) + c];
        square += d * d;
      }
      // 64 roundings of a coordinate
      EXPECT_NEAR(std::sqrt(square), springs.rest_length.constants[k], 1e-12 + 1.5e-14 * far);
    }
  }
}

/// Newton's method halves the distance from the minimum of x^4 and the like at best; the second order decides nothing.
TEST(FlatMinima, AreFoundAndMarginal) {
  for (const char* energy : {"x1^4+y1^4+z1^4", "x1^6+y1^4+z1^6", "1e6*(x1^4+y1^4+z1^4)"}) {
    System point;
    point.positions = {0.3, 0.2, 0.1};
    point.masses = {1.0};
    point.forces = {Potential{"flat", {{0}}, formula_potential(energy, 1), {}}};

    const EquilibriumResult found = find_equilibrium(point, {.accept = AcceptedEquilibria::Any});

    ASSERT_TRUE(found.outcome.ok()) << energy << ": " << found.outcome.what;
    for (const double x : found.positions) EXPECT_NEAR(x, 0.0, 1e-8) << energy;
    EXPECT_EQ(found.stability.status, Stability::Marginal) << energy;
    EXPECT_EQ(found.stability.zero_modes, 3u);
    EXPECT_EQ(found.stability.rigid_zero_modes, 0u);
  }
}

TEST(FlatMinima, AreFoundWithForcesByFormulas) {
  System point;
  point.positions = {0.3, 0.2, 0.1};
  point.masses = {1.0};
  point.forces = {FormulaForce{"flat", {0}, formula_force({"-4*x^3", "-4*y^3", "-4*z^3"})}};

  const EquilibriumResult found = find_equilibrium(point, {.accept = AcceptedEquilibria::Any});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  for (const double x : found.positions) EXPECT_NEAR(x, 0.0, 1e-8);
  EXPECT_EQ(found.stability.status, Stability::Marginal);
  EXPECT_EQ(found.stability.zero_modes, 3u);
}

/// exp(-x) has none, however faint its force becomes.
TEST(FlatMinima, AreNotSeenWhereForcesDieAway) {
  System point;
  point.positions = {0.3, 0.2, 0.1};
  point.masses = {1.0};
  point.forces = {Potential{"tail", {{0}}, formula_potential("exp(-x1)+y1^2+z1^2", 1), {}}};

  const EquilibriumResult found = find_equilibrium(point, {.accept = AcceptedEquilibria::Any});

  EXPECT_FALSE(found.outcome.ok());
}

}  // namespace
}  // namespace tanor
