/// Small vibrations with closed forms are those of chains that bend (A3), hang (B3), stand or buckle (B4), charges on a
/// sphere (B6) and a prestressed net (B8).

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include <gtest/gtest.h>
#include <Eigen/Dense>
#include <tanor/modes.hpp>

#include "../scenes.hpp"
#include "cases/reference_case.hpp"
#include "dense.hpp"

namespace tanor::cases {
namespace {

constexpr double pi = 3.14159265358979323846;

Bendings bend(int count, BendingLaw law, double stiffness) {
  Bendings bendings{"bending", {}, law, stiffness, pi};
  for (int i = 1; i < count; ++i) bendings.triples.push_back({i - 1, i, i + 1});
  return bendings;
}

Modes all_modes(const System& system, ModesOptions options = {}) {
  options.count = ModesOptions::all;
  return modes(system, system.positions, options);
}

/// Expects each of the wanted omega `times` times, in order, to 1e-10.
void expect_omega(const Modes& found, std::vector<double> wanted, std::size_t times, std::size_t first = 0) {
  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  std::ranges::sort(wanted);
  ASSERT_EQ(found.count(), first + times * wanted.size());
  for (std::size_t k = first; k < found.count(); ++k) {
    const double exact = wanted[(k - first) / times];
    EXPECT_NEAR(found.omega[k], exact, 1e-10 * std::abs(exact)) << "mode " << k;
  }
  EXPECT_LT(found.residual_max, 1e-12);
}

class BendingChain : public testing::TestWithParam<BendingLaw> {};

TEST_P(BendingChain, HasItsFrequenciesWhenHingedAndPulled) {
  const nlohmann::json file = read_case("A3_bending_chain_modes");
  System system = scenes::make_chain_along(10, {0.1, 0.0, 0.0}, 0.05);
  system.supports = {Support{"", {0}}};
  system.constraints.push_back(Lines{"guide", {10}, Vector3{0, 0, 0}, Vector3{1, 0, 0}});
  system.forces = {bend(10, GetParam(), 0.02), ConstantForce{"pull", {10}, Vector3{1.5, 0, 0}}};

  expect_omega(all_modes(system), numbers(file.at("hinged_closed_omega")), 2);
}

TEST_P(BendingChain, HasItsFrequenciesWhenClamped) {
  const nlohmann::json file = read_case("A3_bending_chain_modes");
  System system = scenes::make_chain_along(10, {0.1, 0.0, 0.0}, 0.05);
  system.supports = {Support{"", {0, 1}}};
  system.forces = {bend(10, GetParam(), 0.02)};

  expect_omega(all_modes(system), numbers(file.at("clamped_omega")), 2);
}

TEST_P(BendingChain, HasFiveRigidMotionsWhenFree) {
  const nlohmann::json file = read_case("A3_bending_chain_modes");
  System system = scenes::make_chain_along(10, {0.1, 0.0, 0.0}, 0.05);
  system.forces = {bend(10, GetParam(), 0.02)};

  const Modes found = all_modes(system);

  expect_omega(found, numbers(file.at("free_omega")), 2, 5);
  EXPECT_EQ(found.zero_modes, 5u);
  EXPECT_EQ(found.rigid_zero_modes, 5u);
  EXPECT_EQ(found.omega[4], 0.0);
}

INSTANTIATE_TEST_SUITE_P(Laws, BendingChain, testing::Values(BendingLaw::Cosine, BendingLaw::Harmonic),
                         [](const auto& law) { return law.param == BendingLaw::Cosine ? "cosine" : "harmonic"; });

TEST(HangingChain, HasTheZerosOfLaguerrePolynomials) {
  const nlohmann::json reference = read_case("B3_pendulum_chain_frequencies");
  for (const nlohmann::json& each : reference.at("cases")) {
    System system = scenes::make_chain_along(each.at("N").get<int>(), {0.0, 0.0, -0.1}, 0.1);
    system.supports = {Support{"", {0}}};
    system.forces = {Gravity{"", {0, 0, -9.81}}};

    expect_omega(all_modes(system), numbers(each.at("omega")), 2);
  }
}

TEST(HangingChain, HasItsFrequenciesWithAHeavyTip) {
  const nlohmann::json file = read_case("B3_pendulum_chain_heavy_tip");
  System system;
  Rods rods;
  system.positions = {0, 0, 0};
  system.masses = {1.0};
  double height = 0.0;
  for (std::size_t i = 0; i < file.at("masses").size(); ++i) {
    height -= number(file.at("lengths")[i]);
    system.positions.insert(system.positions.end(), {0.0, 0.0, height});
    system.masses.push_back(number(file.at("masses")[i]));
    rods.pairs.push_back({static_cast<Index>(i), static_cast<Index>(i) + 1});
  }
  system.supports = {Support{"", {0}}};
  system.constraints = {rods};
  system.forces = {Gravity{"", {0, 0, -9.81}}};

  expect_omega(all_modes(system), numbers(file.at("omega")), 2);
}

TEST(InvertedChain, IsHeldBySpringsAboveTheirCriticalStiffness) {
  const nlohmann::json reference = read_case("B4_inverted_chain_springs");
  for (const nlohmann::json& each : reference.at("cases")) {
    const int count = each.at("N").get<int>();
    System system = scenes::make_chain_along(count, {0.0, 0.0, 0.1}, 0.1);
    system.supports = {Support{"", {0}}};
    std::vector<std::vector<Index>> beads;
    for (int i = 1; i <= count; ++i) beads.push_back({i});
    const auto held_by = [&](double factor) {
      const double stiffness = factor * number(each.at("critical_stiffness"));
      system.forces = {Gravity{"", {0, 0, -9.81}},
                       Potential{"hold", beads, formula_potential("k/2*(x1^2+y1^2)", 1, {{"k", stiffness}}), {}}};
      return all_modes(system);
    };

    expect_omega(held_by(1.25), numbers(each.at("omega_at_1.25_critical")), 2);
    const Modes fallen = held_by(0.9);
    ASSERT_TRUE(fallen.outcome.ok());
    const std::vector<double> growing = numbers(each.at("omega2_negative_at_0.9_critical"));
    EXPECT_EQ(fallen.unstable_directions, 2 * each.at("inertia_at_0.9").get<std::size_t>());
    EXPECT_NEAR(fallen.omega[0], -std::sqrt(-growing[0]), 1e-10 * std::sqrt(-growing[0]));
    const Modes critical = held_by(1.0);
    EXPECT_EQ(critical.zero_modes, 2u);
    // One or two beads always move as a rigid body.
    if (count > 2) {
      EXPECT_EQ(critical.rigid_zero_modes, 0u) << count;
    }
  }
}

TEST(GreenhillColumn, BucklesUnderItsOwnWeight) {
  const nlohmann::json reference = read_case("B4_greenhill_column");
  for (const nlohmann::json& each : reference.at("cases")) {
    const int count = each.at("moving_rods").get<int>() + 1;
    System system = scenes::make_chain_along(count, {0.0, 0.0, 0.1}, 0.1);
    system.supports = {Support{"", {0, 1}}};
    for (const BendingLaw law : {BendingLaw::Cosine, BendingLaw::Harmonic}) {
      system.forces = {Gravity{"weight", {0, 0, -9.81}}, bend(count, law, 2.5 * number(each.at("kappa_critical")))};

      const Buckling found = find_buckling(system, system.positions, {.loads = {"weight"}});

      ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
      EXPECT_NEAR(found.load_factor, 2.5, 2.5e-10);
    }
  }
}

/// The same column is written by angles, with kappa sum (theta_i - theta_i-1)^2 and the sum of weight_i l theta_i^2,
/// for columns whose bending is a small difference of large terms.
TEST(GreenhillColumn, BucklesUnderItsOwnWeightWithManyRods) {
  for (const int count : {50, 100, 300}) {
    const double length = 1.0 / count, kappa = 1.0 / length, mass = 0.1;
    System system = scenes::make_chain_along(count, {0.0, 0.0, length}, mass);
    system.supports = {Support{"", {0, 1}}};
    system.forces = {Gravity{"weight", {0, 0, -9.81}}, bend(count, BendingLaw::Harmonic, kappa)};
    const int moving = count - 1;
    Eigen::MatrixXd bending = Eigen::MatrixXd::Zero(moving, moving);
    Eigen::VectorXd weight(moving);
    for (int i = 0; i < moving; ++i) {
      bending(i, i) = i + 1 < moving ? 2.0 * kappa : kappa;
      if (i > 0) bending(i, i - 1) = bending(i - 1, i) = -kappa;
      weight[i] = 9.81 * mass * (moving - i) * length;
    }
    const Eigen::VectorXd scale = weight.cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * bending * scale.asDiagonal();
    const double wanted = reference::eigenvalues(scaled)[0];

    const Buckling found = find_buckling(system, system.positions, {.loads = {"weight"}});

    ASSERT_TRUE(found.outcome.ok()) << count << ": " << found.outcome.what;
    // Rounding leaves count^4 eps of the terms of x'Wx, which are count^2 rod by rod.
    EXPECT_NEAR(found.load_factor, wanted, std::numeric_limits<double>::epsilon() * std::pow(count, 4) * wanted)
        << count;
  }
}

/// The chain buckles at P = 4 kappa/l sin^2(pi/2N), whatever the size of the given push.
TEST(HingedChain, BucklesWithManyRodsUnderAPushOfAnySize) {
  for (const int count : {30, 120, 250}) {
    const double length = 1.0 / count, kappa = 0.1 / length;
    const double wanted = 4.0 * kappa / length * std::pow(std::sin(0.5 * pi / count), 2);
    for (const double push : {1e-4, 0.01, 1.0, 1e3}) {
      System system = scenes::make_chain_along(count, {length, 0.0, 0.0}, 0.05);
      system.supports = {Support{"", {0}}};
      system.constraints.push_back(Lines{"guide", {count}, Vector3{0, 0, 0}, Vector3{1, 0, 0}});
      system.forces = {bend(count, BendingLaw::Harmonic, kappa), ConstantForce{"push", {count}, Vector3{-push, 0, 0}}};

      const Buckling found = find_buckling(system, system.positions, {.loads = {"push"}});

      ASSERT_TRUE(found.outcome.ok()) << count << " rods, push " << push << ": " << found.outcome.what;
      EXPECT_NEAR(found.load_factor * push, wanted,
                  std::numeric_limits<double>::epsilon() * std::pow(count, 4) * wanted)
          << count << " rods, " << push;
    }
  }
}

TEST(HingedChain, BucklesAtItsCriticalPush) {
  const nlohmann::json file = read_case("B4_buckled_chain_N6");
  System system = scenes::make_chain_along(6, {0.2, 0.0, 0.0}, 0.05);
  system.supports = {Support{"", {0}}};
  system.constraints.push_back(Lines{"guide", {6}, Vector3{0, 0, 0}, Vector3{1, 0, 0}});
  system.forces = {bend(6, BendingLaw::Cosine, 0.8), ConstantForce{"push", {6}, Vector3{-0.5, 0, 0}}};

  const Buckling found = find_buckling(system, system.positions, {.loads = {"push"}});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_NEAR(0.5 * found.load_factor, number(file.at("critical_push")), 1e-10);
  system.forces[1] = ConstantForce{"push", {6}, Vector3{0.5, 0, 0}};
  EXPECT_TRUE(std::isinf(find_buckling(system, system.positions, {.loads = {"push"}}).load_factor));
}

TEST(HingedChain, SwingsAboutItsBentShapeInThePlane) {
  const nlohmann::json file = read_case("B4_buckled_chain_N6");
  System system = scenes::make_chain_along(6, {0.2, 0.0, 0.0}, 0.05);
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t axis = 0; axis < 2; ++axis)
      system.positions[3 * (i + 1) + axis] = number(file.at("nodes")[i][axis]);
  }
  system.supports = {Support{"", {0}}};
  system.constraints.push_back(Planes{"paper", {1, 2, 3, 4, 5}, Vector3{0, 0, 1}, 0.0});
  system.constraints.push_back(Lines{"guide", {6}, Vector3{0, 0, 0}, Vector3{1, 0, 0}});
  system.forces = {bend(6, BendingLaw::Cosine, number(file.at("kappa"))),
                   ConstantForce{"push", {6}, Vector3{-number(file.at("push")), 0, 0}}};
  std::vector<double> wanted = numbers(file.at("omega2_in_plane"));
  for (double& each : wanted) each = std::sqrt(each);

  expect_omega(all_modes(system), wanted, 1);
}

TEST(ChargesOnASphere, HaveThreeZeroModes) {
  const nlohmann::json reference = read_case("B6_thomson");
  for (const nlohmann::json& each : reference.at("cases")) {
    System system;
    std::vector<Index> all;
    std::vector<std::vector<Index>> pairs;
    for (const nlohmann::json& point : each.at("positions")) {
      for (const double x : numbers(point)) system.positions.push_back(x);
      for (const Index other : all) pairs.push_back({other, static_cast<Index>(all.size())});
      all.push_back(static_cast<Index>(all.size()));
      system.masses.push_back(1.0);
    }
    system.constraints = {Spheres{"sphere", all, Vector3{0, 0, 0}, 1.0}};
    system.forces = {Potential{"charges", pairs, formula_potential("1/sqrt((x2-x1)^2+(y2-y1)^2+(z2-z1)^2)", 2), {}}};
    std::vector<double> wanted = numbers(each.at("omega2"));
    for (double& omega : wanted) omega = std::sqrt(omega);

    const Modes found = all_modes(system);

    expect_omega(found, {wanted.begin() + 3, wanted.end()}, 1, 3);
    EXPECT_EQ(found.zero_modes, 3u);
    EXPECT_EQ(found.rigid_zero_modes, 3u);
  }
}

/// Makes wires of rods 0.2 m long along x and y. Each is fixed at one end and pulled, or fixed, at the other.
System make_pulled_net(int columns, int rows, bool has_fixed_ends) {
  System system;
  Rods rods{"wires", {}};
  std::vector<Index> number(static_cast<std::size_t>((columns + 1) * (rows + 1)), -1), fixed, right, top;
  const auto at = [&](int i, int j) -> Index& { return number[static_cast<std::size_t>(i * (rows + 1) + j)]; };
  for (int i = 0; i <= columns; ++i) {
    for (int j = 0; j <= rows; ++j) {
      const bool ends_x = i == 0 || i == columns, ends_y = j == 0 || j == rows;
      if (ends_x && ends_y) continue;
      at(i, j) = static_cast<Index>(system.masses.size());
      system.positions.insert(system.positions.end(), {0.2 * i, 0.2 * j, 0.0});
      system.masses.push_back(0.05);
      if (i == 0 || j == 0 || has_fixed_ends) {
        if (ends_x || ends_y) fixed.push_back(at(i, j));
      } else if (ends_x || ends_y) {
        (ends_x ? right : top).push_back(at(i, j));
      }
      if (i > 0 && !ends_y) rods.pairs.push_back({at(i - 1, j), at(i, j)});
      if (j > 0 && !ends_x) rods.pairs.push_back({at(i, j - 1), at(i, j)});
    }
  }
  system.supports = {Support{"", fixed}};
  system.constraints = {rods};
  const auto pull = [&](const std::vector<Index>& ends, const Vector3& force, const Vector3& direction) {
    for (const Index end : ends) {
      const double* const r = system.positions.data() + 3 * end;
      system.constraints.push_back(Lines{"", {end}, Vector3{r[0], r[1], r[2]}, direction});
    }
    if (!ends.empty()) system.forces.push_back(ConstantForce{"", ends, force});
  };
  pull(right, {12, 0, 0}, {1, 0, 0});
  pull(top, {0, 8, 0}, {0, 1, 0});
  return system;
}

TEST(PrestressedNet, HasTheFrequenciesOfItsTensions) {
  const System system = make_pulled_net(5, 4, false);

  expect_omega(all_modes(system), numbers(read_case("B8_prestressed_net").at("omega")), 1);
}

TEST(PrestressedNet, IsRefusedWithFixedEndsUnlessItsTensionsAreGiven) {
  const System system = make_pulled_net(5, 4, true);

  const Modes refused = all_modes(system);
  EXPECT_EQ(refused.outcome.status, Status::NotUnique);
  EXPECT_NE(refused.outcome.what.find("wires["), std::string::npos) << refused.outcome.what;
  // Each of seven wires has a self-stress of its own, of which the message names three.
  EXPECT_NE(refused.outcome.what.find("; and 4 more)"), std::string::npos) << refused.outcome.what;

  std::vector<double> tensions;
  for (const auto& [i, j] : std::get<Rods>(system.constraints[0]).pairs) {
    const bool is_along_x =
        system.positions[3 * static_cast<std::size_t>(i)] != system.positions[3 * static_cast<std::size_t>(j)];
    tensions.push_back(is_along_x ? 12.0 : 8.0);
  }
  expect_omega(all_modes(system, {.prestress = {{"wires", tensions}}}),
               numbers(read_case("B8_prestressed_net").at("omega")), 1);
}

/// Above 300 freedoms the lowest modes are found by Lanczos' method, to the required tolerance.
TEST(PrestressedNet, HasItsLowestFrequenciesWithManyPoints) {
  constexpr int columns = 24, rows = 18;
  const System system = make_pulled_net(columns, rows, false);
  std::vector<double> wanted;
  for (int i = 1; i < columns; ++i) {
    for (int j = 1; j < rows; ++j) {
      const double x = std::sin(i * pi / (2 * columns)), y = std::sin(j * pi / (2 * rows));
      wanted.push_back(std::sqrt(4.0 / (0.05 * 0.2) * (12.0 * x * x + 8.0 * y * y)));
    }
  }
  std::ranges::sort(wanted);
  wanted.resize(25);

  const Modes found = modes(system, system.positions, {.count = 25, .tolerance = 1e-12});

  EXPECT_EQ(found.degrees_of_freedom, static_cast<std::size_t>((columns - 1) * (rows - 1)));
  expect_omega(found, wanted, 1);
  EXPECT_LT(modes(system, system.positions, {.count = 25}).residual_max, 1e-10);
}

}  // namespace
}  // namespace tanor::cases
