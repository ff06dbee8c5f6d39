/// Where chains and nets rest, with published digits: an uneven catenary of 100 rods (B1), a net of ropes between four
/// corners (B2).

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>

#include "cases/reference_case.hpp"
#include "statics/observed_order.hpp"

namespace tanor::cases {
namespace {

System make_system(const nlohmann::json& scene) {
  System system;
  for (const nlohmann::json& at : scene.at("points").at("positions"))
    for (const double x : at) system.positions.push_back(x);
  const nlohmann::json& masses = scene.at("points").at("masses");
  system.masses = masses.is_array() ? masses.get<std::vector<double>>()
                                    : std::vector<double>(system.positions.size() / 3, masses.get<double>());
  const nlohmann::json& rods = scene.at("constraints").at(0);
  Rods all{.name = "rods", .pairs = rods.at("pairs").get<std::vector<std::array<Index, 2>>>()};
  all.length.constants = {rods.at("length").get<double>()};
  system.constraints = {all};
  system.supports = {Support{"", scene.at("supports").at(0).at("points").get<std::vector<Index>>()}};
  const auto g = scene.at("forces").at(0).at("acceleration").get<std::vector<double>>();
  system.forces = {Gravity{"", {g[0], g[1], g[2]}}};
  return system;
}

/// The last three steps from beside the equilibrium are quadratic.
void expect_quadratic(System system, const EquilibriumResult& rest, double move) {
  const std::vector<Index>& held = system.supports[0].points;
  for (std::size_t i = 0; i < system.positions.size(); ++i) {
    if (std::ranges::find(held, static_cast<Index>(i / 3)) == held.end())
      system.positions[i] = rest.positions[i] + move * std::sin(1.0 + 2.3 * static_cast<double>(i));
  }
  const EquilibriumResult found = find_equilibrium(system, {.force_tolerance = 1e-14});
  const std::vector<double> orders = observed_orders(found.residuals, 1e-11 * found.largest_force);
  ASSERT_EQ(orders.size(), 2u) << testing::PrintToString(found.residuals);
  for (const double order : orders) EXPECT_GE(order, 1.8) << testing::PrintToString(found.residuals);
}

TEST(UnevenCatenary, Of100RodsRestsAsItsClosedForm) {
  const nlohmann::json file = read_case("B1_catenary_uneven_N100");
  const System system = make_system(file.at("scene"));

  const EquilibriumResult found = find_equilibrium(system, {.force_tolerance = 1e-12});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.status, Stability::Stable);
  for (std::size_t i = 0; i < file.at("nodes").size(); ++i) {
    for (std::size_t axis = 0; axis < 2; ++axis)
      EXPECT_NEAR(found.positions[3 * (i + 1) + axis], number(file.at("nodes")[i][axis]), 1e-12) << i;
  }
  const std::vector<double> tensions = numbers(file.at("tensions"));
  for (std::size_t k = 0; k < tensions.size(); ++k)
    EXPECT_NEAR(-found.multipliers[k], tensions[k], 1e-11 * tensions[k]) << k;
  expect_quadratic(system, found, 0.1 * std::get<Rods>(system.constraints[0]).length.constants[0]);
}

TEST(NetOfRopes, RestsAndSwingsWithItsDigits) {
  const nlohmann::json file = read_case("B2_hanging_net_5x5");
  const System system = make_system(file.at("scene"));

  for (const bool are_ropes : {false, true}) {
    EquilibriumOptions options{.force_tolerance = 1e-12};
    if (are_ropes) options.one_sided = {{"rods", OneSide::AtMost}};
    const EquilibriumResult found = find_equilibrium(system, options);

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.status, Stability::Stable);
    EXPECT_EQ(std::ranges::count(found.open, true), 0);
    const nlohmann::json& moving = file.at("moving_points");
    for (std::size_t i = 0; i < moving.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(found.positions[3 * moving[i].get<std::size_t>() + axis],
                    number(file.at("positions_of_moving_points")[i][axis]), 1e-12);
    }
    const std::vector<double> tensions = numbers(file.at("tensions"));
    for (std::size_t k = 0; k < tensions.size(); ++k)
      EXPECT_NEAR(-found.multipliers[k], tensions[k], 1e-11 * tensions[k]) << k;
    expect_quadratic(system, found, 0.02 * std::get<Rods>(system.constraints[0]).length.constants[0]);
    const Modes vibrations = modes(system, found.positions, {.count = ModesOptions::all});
    ASSERT_TRUE(vibrations.outcome.ok()) << vibrations.outcome.what;
    const std::vector<double> omega = numbers(file.at("omega"));
    ASSERT_EQ(vibrations.count(), omega.size());
    for (std::size_t k = 0; k < omega.size(); ++k) EXPECT_NEAR(vibrations.omega[k], omega[k], 1e-10 * omega[k]);
  }
}

}  // namespace
}  // namespace tanor::cases
