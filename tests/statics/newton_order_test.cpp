/// Newton's own last steps are quadratic. The last three of them are measured for chains, a lattice of springs and
/// energies of tuples, each from a start near its equilibrium. Nets are in tests/cases/rest_cases_test.cpp.

#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>

#include "scenes.hpp"
#include "statics/observed_order.hpp"

namespace tanor {
namespace {

TEST(ObservedOrders, TellLinearConvergenceFromQuadratic) {
  for (const double order : observed_orders({1.0, 0.1, 0.01, 0.001}, 0.0)) EXPECT_NEAR(order, 1.0, 1e-12);
  const std::vector<double> quadratic = observed_orders({0.1, 1e-2, 1e-4, 1e-8, 1e-15}, 1e-12);
  ASSERT_EQ(quadratic.size(), 2u);
  for (const double order : quadratic) EXPECT_NEAR(order, 2.0, 1e-12);
  // The last step alone was quadratic.
  const std::vector<double> late = observed_orders({1.0, 0.5, 0.2, 0.2 * 0.2 * 0.4}, 0.0);
  ASSERT_EQ(late.size(), 2u);
  EXPECT_GT(late[0], 1.8);
  EXPECT_LT(late[1], 1.8);
}

/// Finds the equilibrium, and again from a start near it, where points are moved by a part of the rods' length.
void expect_quadratic(const char* name, System system, double part) {
  const EquilibriumResult rest = find_equilibrium(system);
  ASSERT_TRUE(rest.outcome.ok()) << name << ": " << rest.outcome.what;
  system.positions = rest.positions;
  for (std::size_t i = 0; i < system.positions.size(); ++i)
    system.positions[i] += part * scenes::spacing * std::sin(1.0 + 2.3 * static_cast<double>(i));
  for (const Support& support : system.supports) {
    for (const Index point : support.points) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t k = 3 * static_cast<std::size_t>(point) + axis;
        system.positions[k] = rest.positions[k];
      }
    }
  }

  const EquilibriumResult found = find_equilibrium(system, {.force_tolerance = 1e-14});

  const std::vector<double> orders = observed_orders(found.search.residuals, 1e-11 * found.largest_force);
  ASSERT_EQ(orders.size(), 2u) << name << ": " << testing::PrintToString(found.search.residuals);
  for (const double order : orders)
    EXPECT_GE(order, 1.8) << name << ": " << testing::PrintToString(found.search.residuals);
}

System make_catenary(int count, double chord) {
  System system;
  Rods rods{"rods", {}, scenes::spacing, {}};
  for (int i = 0; i <= count; ++i) {
    const double s = static_cast<double>(i) / count;
    scenes::add_point({chord * s, 0.0, -0.3 * count * scenes::spacing * s * (1.0 - s)}, &system);
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  system.constraints = {rods};
  system.supports = {{"", {0, count}, {}}};
  system.forces = {scenes::gravity};
  return system;
}

TEST(NewtonsOrder, IsTwoOnChains) {
  expect_quadratic("chain of 10", make_catenary(10, 0.7), 0.05);
  expect_quadratic("chain of 60", make_catenary(60, 4.0), 0.02);
}

/// Springs lie along the edges of a cubic lattice, which is held at its floor.
TEST(NewtonsOrder, IsTwoOnALatticeOfSprings) {
  System lattice = scenes::make_lattice(4);
  Springs springs{.name = "springs", .pairs = std::get<Rods>(lattice.constraints[0]).pairs, .stiffness = 400.0};
  for (Index i = 0; i < 64; ++i) {  // diagonals, that it does not shear
    const auto place = [&](Index k) { return scenes::place_of(lattice, static_cast<std::size_t>(k)); };
    for (Index j = i + 1; j < 64; ++j) {
      const Vector3 a = place(i), b = place(j);
      const double length = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
      if (length > 1.2 * scenes::spacing && length < 1.5 * scenes::spacing) springs.pairs.push_back({i, j});
    }
  }
  springs.rest_length = Parameter{};  // as they are
  lattice.constraints.clear();
  lattice.forces = {springs, scenes::gravity};
  lattice.supports = {{"", {}, {}}};
  for (Index i = 0; i < 64; ++i) {
    if (lattice.positions[3 * static_cast<std::size_t>(i) + 2] < 0.5 * scenes::spacing)
      lattice.supports[0].points.push_back(i);
  }
  expect_quadratic("lattice of springs", lattice, 0.05);
}

/// A clamped rod of bonds, bendings and torsions sags, on the energies of its bonds and angles alone.
TEST(NewtonsOrder, IsTwoOnEnergiesOfTuples) {
  System system;
  Bonds bonds{.name = "bonds"};
  Bendings bendings{.name = "bendings"};
  Torsions torsions{.name = "torsions", .law = TorsionLaw::Opls, .coefficients = {0.02, 0.01, 0.03, 0.0}};
  constexpr int count = 12;
  for (int i = 0; i <= count; ++i) {  // a zigzag that turns
    const double angle = 0.7 * i;
    scenes::add_point({0.08 * i, 0.03 * std::cos(angle), 0.03 * std::sin(angle)}, &system);
    if (i > 1) bonds.pairs.push_back({i - 1, i});
    if (i > 1) bendings.triples.push_back({i - 2, i - 1, i});
    if (i > 2) torsions.quadruples.push_back({i - 3, i - 2, i - 1, i});
  }
  bonds.stiffness = 30.0;
  bonds.rest_length = 0.09;
  bendings.stiffness = 0.5;
  bendings.rest = 2.6;
  system.forces = {bonds, bendings, torsions, scenes::gravity};
  system.supports = {{"", {0, 1}, {}}};
  expect_quadratic("bonds, bendings and torsions", system, 0.4);
}

}  // namespace
}  // namespace tanor
