/// Where all forces vanish at rest the largest of them is rounding, and no scale.

#include <cmath>
#include <string>
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

TEST(StressFreeSprings, AreNoEquilibriumWhereALengthIsWrong) {
  System triangle = make_triangle(1.0, 100.0);
  std::get<Springs>(triangle.forces[0]).rest_length.constants[1] += 1e-4;

  try {
    (void)modes(triangle, triangle.positions);
    ADD_FAILURE() << "the positions are no equilibrium";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("Newton's method would move points by"), std::string::npos)
        << error.what();
  }
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

  EXPECT_THROW((void)modes(rope, rope.positions), InputError);
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
