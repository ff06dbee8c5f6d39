/// Systems with published digits rest at their equilibria. They are uneven catenaries (B1), a net of ropes between four
/// corners (B2), a chain that is pushed (B4), a bead on an ellipsoid (B5) and charges on a sphere (B6).

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

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

/// Expects quadratic convergence of the last three steps from a place near the equilibrium.
void expect_quadratic(System system, const EquilibriumResult& rest, double move) {
  const std::vector<Index>& held = system.supports[0].points;
  for (std::size_t i = 0; i < system.positions.size(); ++i) {
    if (std::ranges::find(held, static_cast<Index>(i / 3)) == held.end())
      system.positions[i] = rest.positions[i] + move * std::sin(1.0 + 2.3 * static_cast<double>(i));
  }
  const EquilibriumResult found = find_equilibrium(system, {.force_tolerance = 1e-14});
  const std::vector<double> orders = observed_orders(found.search.residuals, 1e-11 * found.largest_force);
  ASSERT_EQ(orders.size(), 2u) << testing::PrintToString(found.search.residuals);
  for (const double order : orders) EXPECT_GE(order, 1.8) << testing::PrintToString(found.search.residuals);
}

void expect_places(const EquilibriumResult& found, std::size_t first, const nlohmann::json& nodes) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (std::size_t axis = 0; axis < nodes[i].size(); ++axis)
      EXPECT_NEAR(found.positions[3 * (i + first) + axis], number(nodes[i][axis]), 1e-12) << i;
  }
}

void expect_tensions(const EquilibriumResult& found, const nlohmann::json& wanted) {
  const std::vector<double> tensions = numbers(wanted);
  for (std::size_t k = 0; k < tensions.size(); ++k)
    EXPECT_NEAR(-found.multipliers[k], tensions[k], 1e-11 * std::abs(tensions[k])) << k;
}

void expect_omega(const Modes& found, std::vector<double> wanted) {
  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  std::ranges::sort(wanted);
  ASSERT_EQ(found.count(), wanted.size());
  for (std::size_t k = 0; k < wanted.size(); ++k) EXPECT_NEAR(found.omega[k], wanted[k], 1e-10 * wanted[k]) << k;
}

class UnevenCatenary : public testing::TestWithParam<const char*> {};

/// The search starts from a sagging chain, and from the straight line between its supports, where its rods have other
/// lengths.
TEST_P(UnevenCatenary, RestsAsItsClosedForm) {
  const nlohmann::json file = read_case(GetParam());
  System system = make_system(file.at("scene"));
  for (const bool is_straight : {false, true}) {
    const std::size_t last = system.num_points() - 1;
    for (std::size_t i = 3; i < 3 * last && is_straight; ++i)
      system.positions[i] = system.positions[3 * last + i % 3] * static_cast<double>(i / 3) / static_cast<double>(last);

    const EquilibriumResult found = find_equilibrium(system, {.force_tolerance = 1e-12});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable);
    expect_places(found, 1, file.at("nodes"));
    expect_tensions(found, file.at("tensions"));
    for (std::size_t axis = 0; axis < 2; ++axis) {
      // The file has the forces of the supports on the chain.
      const double first = -number(file.at("support_forces").at("point 0")[axis]),
                   second = -number(file.at("support_forces").at("last")[axis]);
      EXPECT_NEAR(found.support_forces[axis], first, 1e-11 * std::abs(first));
      EXPECT_NEAR(found.support_forces[3 * last + axis], second, 1e-11 * std::abs(second));
    }
    const double length = std::get<Rods>(system.constraints[0]).length.constants[0];
    if (!file.contains("omega_in_plane")) {  // the long one
      if (!is_straight) expect_quadratic(system, found, 0.1 * length);
      continue;
    }
    std::vector<double> omega = numbers(file.at("omega_in_plane"));
    const std::vector<double> across = numbers(file.at("omega_out_of_plane"));
    omega.insert(omega.end(), across.begin(), across.end());
    expect_omega(modes(system, found.positions, {.count = ModesOptions::all}), omega);
  }
}

INSTANTIATE_TEST_SUITE_P(Rods, UnevenCatenary, testing::Values("B1_catenary_uneven_N10", "B1_catenary_uneven_N100"),
                         [](const auto& file) { return std::string(file.param).substr(20); });

TEST(NetOfRopes, RestsAndSwingsWithItsDigits) {
  const nlohmann::json file = read_case("B2_hanging_net_5x5");
  const System system = make_system(file.at("scene"));

  for (const bool are_ropes : {false, true}) {
    EquilibriumOptions options{.force_tolerance = 1e-12};
    if (are_ropes) options.one_sided = {{"rods", OneSide::AtMost}};
    const EquilibriumResult found = find_equilibrium(system, options);

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable);
    EXPECT_EQ(std::ranges::count(found.open, true), 0);
    const nlohmann::json& moving = file.at("moving_points");
    for (std::size_t i = 0; i < moving.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(found.positions[3 * moving[i].get<std::size_t>() + axis],
                    number(file.at("positions_of_moving_points")[i][axis]), 1e-12);
    }
    expect_tensions(found, file.at("tensions"));
    expect_quadratic(system, found, 0.02 * std::get<Rods>(system.constraints[0]).length.constants[0]);
    const double energy = number(file.at("potential_energy_of_moving_points"));
    EXPECT_NEAR(found.energy, energy, 1e-13 * std::abs(energy));
    expect_omega(modes(system, found.positions, {.count = ModesOptions::all}), numbers(file.at("omega")));
  }
}

/// Makes six rods that bend in a plane and are pushed beyond what the straight chain carries.
System make_pushed_chain(const nlohmann::json& file) {
  System system;
  Rods rods{"rods", {}, number(file.at("l"))};
  Bendings bendings{"bending", {}, BendingLaw::Cosine, number(file.at("kappa")), {}};
  for (Index i = 0; i <= 6; ++i) {
    system.positions.insert(system.positions.end(), {0.2 * i, 0.0, 0.0});
    system.masses.push_back(number(file.at("mass_each_for_modes")));
    if (i > 0) rods.pairs.push_back({i - 1, i});
    if (i > 1) bendings.triples.push_back({i - 2, i - 1, i});
  }
  system.supports = {Support{"", {0}}};
  system.constraints = {rods, Planes{"paper", {1, 2, 3, 4, 5}, Vector3{0, 0, 1}, 0.0},
                        Lines{"guide", {6}, Vector3{0, 0, 0}, Vector3{1, 0, 0}}};
  system.forces = {bendings, ConstantForce{"push", {6}, Vector3{-number(file.at("push")), 0, 0}}};
  return system;
}

TEST(PushedChain, BendsAsItsDigitsAndToTheSideWhereItBegins) {
  const nlohmann::json file = read_case("B4_buckled_chain_N6");
  for (const double side : {1.0, -1.0}) {
    System system = make_pushed_chain(file);
    for (std::size_t i = 1; i < 6; ++i)
      system.positions[3 * i + 1] = side * 0.05 * std::sin(static_cast<double>(i) * std::acos(-1.0) / 6.0);

    const EquilibriumResult found = find_equilibrium(system, {.force_tolerance = 1e-13});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable);
    const nlohmann::json& nodes = file.at("nodes");
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      EXPECT_NEAR(found.positions[3 * i + 3], number(nodes[i][0]), 1e-12);
      EXPECT_NEAR(found.positions[3 * i + 4], side * number(nodes[i][1]), 1e-12);
    }
    expect_tensions(found, file.at("tensions"));
    // The guide of the end has rows 11 and 12, behind six rods and five planes.
    for (const std::size_t row : {11u, 12u}) EXPECT_NEAR(found.multipliers[row], 0.0, 1e-12);
  }
}

TEST(PushedChain, StandsUnstablyWhenStraight) {
  const nlohmann::json file = read_case("B4_buckled_chain_N6");
  const System plane = make_pushed_chain(file);
  System space = plane;
  space.constraints.erase(space.constraints.begin() + 1);
  for (const System& system : {plane, space}) {
    const EquilibriumResult found =
        find_equilibrium(system, {.method = EquilibriumMethod::Newton, .accept = AcceptedEquilibria::Any});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.positions, system.positions);
    EXPECT_EQ(found.stability.status, Stability::Unstable);
    EXPECT_EQ(found.stability.unstable_directions, system.constraints.size() == 3 ? 1u : 2u);
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(found.multipliers[k], number(file.at("push")), 1e-12);
  }
}

/// A bead on an ellipsoid has two equilibria, which are compared by place, load, energy and vibrations.
TEST(BeadOnAnEllipsoid, RestsAndSwingsWithItsDigits) {
  const nlohmann::json file = read_case("B5_ellipsoid_equilibria");
  for (const nlohmann::json& each : file.at("equilibria")) {
    const std::vector<double> place = numbers(each.at("position")), omega2 = numbers(each.at("omega2"));
    System system;
    system.positions = {place[0] + 1e-3, place[1] - 2e-3, place[2] + 1e-3};
    system.masses = {number(file.at("m"))};
    system.constraints = {UserConstraints{
        "ellipsoid", {{0}}, formula_constraint(file.at("constraint").at("equation").get<std::string>(), 1)}};
    system.forces = {Gravity{"", {0, 0, -9.81}},
                     Potential{"spring", {{0}}, formula_potential("20*((x1-0.5)^2+(y1-0.3)^2+(z1-0.6)^2)", 1), {}}};
    const bool is_stable = each.at("unstable_directions").get<int>() == 0;
    // The descent leaves a maximum, so the start is the maximum itself.
    if (!is_stable) system.positions = place;

    const EquilibriumResult found =
        find_equilibrium(system, {.method = EquilibriumMethod::Newton,
                                  .force_tolerance = 1e-14,
                                  .accept = is_stable ? AcceptedEquilibria::Stable : AcceptedEquilibria::Any});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.unstable_directions, each.at("unstable_directions").get<std::size_t>());
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(found.positions[axis], place[axis], 1e-13);
    const double lambda = number(each.at("lambda (for xi as written)")),
                 normal = number(each.at("normal_force (lambda |grad|)")), energy = number(each.at("energy"));
    EXPECT_NEAR(found.multipliers[0], lambda, 1e-12 * lambda);
    EXPECT_NEAR(std::hypot(found.reactions[0], found.reactions[1], found.reactions[2]), normal, 1e-12 * normal);
    EXPECT_NEAR(found.energy, energy, 1e-12 * energy);
    const Modes vibrations = modes(system, found.positions, {.count = ModesOptions::all});
    ASSERT_TRUE(vibrations.outcome.ok()) << vibrations.outcome.what;
    for (std::size_t k = 0; k < 2; ++k) {
      const double omega = std::copysign(std::sqrt(std::abs(omega2[k])), omega2[k]);
      EXPECT_NEAR(vibrations.omega[k], omega, 1e-10 * std::abs(omega));
    }
  }
}

/// Thomson's problem starts from places pushed away from the minimum, which is unique but for a rotation.
TEST(ChargesOnASphere, RestWithTheEnergyTheForcesAndTheDistancesOfTheirMinimum) {
  const nlohmann::json reference = read_case("B6_thomson");
  for (const nlohmann::json& each : reference.at("cases")) {
    System system;
    Spheres sphere{"sphere", {}, Vector3{0, 0, 0}, 1.0};
    std::vector<double> places;
    for (const nlohmann::json& point : each.at("positions")) {
      for (const double x : numbers(point)) places.push_back(x);
      sphere.points.push_back(static_cast<Index>(system.masses.size()));
      system.masses.push_back(1.0);
    }
    system.positions = places;
    for (std::size_t i = 0; i < places.size(); ++i)
      system.positions[i] += 0.03 * std::sin(1.0 + 2.3 * static_cast<double>(i));
    system.constraints = {sphere};
    system.forces = {PairForces{.law = PairLaw::Coulomb, .strength = 1.0, .charges = {1.0}}};

    const EquilibriumResult found = find_equilibrium(system, {.force_tolerance = 1e-13});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable);
    EXPECT_EQ(found.stability.zero_modes, 3u);
    const double energy = number(each.at("energy"));
    EXPECT_NEAR(found.energy, energy, 1e-13 * energy);
    std::vector<double> lambda = numbers(each.at("lambda")), multipliers = found.multipliers;
    std::ranges::sort(lambda);
    std::ranges::sort(multipliers);
    EXPECT_NEAR(std::reduce(multipliers.begin(), multipliers.end()), -energy, 1e-11 * energy);
    for (std::size_t k = 0; k < lambda.size(); ++k) EXPECT_NEAR(multipliers[k], lambda[k], 1e-10 * -lambda[k]);
    const auto distances = [](const std::vector<double>& r) {
      std::vector<double> result;
      for (std::size_t i = 0; i < r.size(); i += 3)
        for (std::size_t j = 0; j < i; j += 3)
          result.push_back(std::hypot(r[i] - r[j], r[i + 1] - r[j + 1], r[i + 2] - r[j + 2]));
      std::ranges::sort(result);
      return result;
    };
    const std::vector<double> wanted = distances(places), given = distances(found.positions);
    for (std::size_t k = 0; k < wanted.size(); ++k) EXPECT_NEAR(given[k], wanted[k], 1e-10);
  }
}

}  // namespace
}  // namespace tanor::cases
