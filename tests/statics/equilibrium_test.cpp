#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>

#include "errors.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

using scenes::g;

/// Makes `count` rods of the given length between supports at the ends; beads start on a parabola below the chord.
System make_hanging_chain(int count, double length, double mass, Vector3 end, double sag) {
  System system;
  Rods rods{.name = "rods"};
  for (int i = 0; i <= count; ++i) {
    const double s = static_cast<double>(i) / count;
    system.positions.insert(system.positions.end(), {s * end[0], s * end[1] - 4.0 * sag * s * (1.0 - s), 0.0});
    system.masses.push_back(mass);
    if (i < count) rods.pairs.push_back({i, i + 1});
  }
  rods.length.constants = {length};
  system.constraints.push_back(rods);
  system.supports.push_back({"", {0, count}, {}});
  system.add_gravity({0.0, -g, 0.0});
  return system;
}

// The tensions are T_i = sqrt(H^2 + V_i^2), V_i = V_0 + i m g, with H and V_0 of 10 rods of 0.1 m between (0, 0) and
// (0.7, 0.25).
TEST(Equilibrium, ChainBetweenUnevenSupportsIsTheDiscreteCatenary) {
  constexpr double H = 2.378492301432212934792583225, V0 = -3.044284345718873534849989889;

  const EquilibriumResult found = find_equilibrium(make_hanging_chain(10, 0.1, 0.1, {0.7, 0.25, 0.0}, 0.2));

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.stability.status, Stability::Stable);
  for (int i = 0; i < 10; ++i) {
    const double V = V0 + i * 0.1 * g;
    EXPECT_NEAR(-found.multipliers[static_cast<std::size_t>(i)], std::hypot(H, V), 1e-10);
  }
  EXPECT_NEAR(found.positions[3], 0.06156673741177575710, 1e-11);
  EXPECT_NEAR(found.positions[4], -0.07880061449296589028, 1e-11);
  EXPECT_NEAR(found.support_forces[0], H, 1e-10);
  EXPECT_NEAR(found.support_forces[1], V0, 1e-10);
  EXPECT_NEAR(std::sqrt(found.stability.lowest_omega2), 6.313398211465762790, 1e-8);
}

TEST(Equilibrium, ChainThatStartsStraightBetweenItsSupportsFindsTheCatenary) {
  const EquilibriumResult found = find_equilibrium(make_hanging_chain(10, 0.1, 0.1, {0.7, 0.25, 0.0}, 0.0));

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_NEAR(found.positions[4], -0.07880061449296589028, 1e-11);
}

TEST(Equilibrium, DescentFindsTheCatenary) {
  const EquilibriumResult found =
      find_equilibrium(make_hanging_chain(10, 0.1, 0.1, {0.7, 0.25, 0.0}, 0.2), {.method = EquilibriumMethod::Descent});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.search.method_used, EquilibriumMethod::Descent);
  EXPECT_NEAR(found.positions[4], -0.07880061449296589028, 1e-11);
}

// MoorPy's case 4 is a line of 500 m, 400 m apart, 200 m high; N rods come near the catenary as 1/N^2.
TEST(Equilibrium, LongMooringLineIsMoorPysCatenary) {
  constexpr int count = 2000;
  constexpr double weight = 200.0;
  System line = make_hanging_chain(count, 500.0 / count, weight * 500.0 / count / g, {400.0, 200.0, 0.0}, 150.0);

  const EquilibriumResult found = find_equilibrium(line);

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_NEAR(found.support_forces[0], 43694.60642855651631, 43694.6 * 1e-6);
}

System make_pendulum(const Vector3& bead) {
  return scenes::make_pendulum(bead, 2.0);
}

TEST(Equilibrium, PendulumRestsBelowItsSupport) {
  const EquilibriumResult found = find_equilibrium(make_pendulum({0.5, 0.0, 0.0}));

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_NEAR(found.positions[5], -0.5, 1e-12);
  EXPECT_NEAR(-found.multipliers[0], 2.0 * g, 1e-10);
  EXPECT_NEAR(found.stability.lowest_omega2, g / 0.5, 1e-9);
}

TEST(Equilibrium, UnstableRestIsReportedWhereAnyIsAccepted) {
  const EquilibriumResult found = find_equilibrium(make_pendulum({0.0, 0.0, 0.5}), {.accept = AcceptedEquilibria::Any});

  ASSERT_TRUE(found.outcome.ok());
  EXPECT_EQ(found.stability.status, Stability::Unstable);
  EXPECT_EQ(found.stability.unstable_directions, 2u);
  EXPECT_EQ(found.search.iterations, 0);
  EXPECT_NEAR(found.stability.lowest_omega2, -g / 0.5, 1e-9);
}

TEST(Equilibrium, UnstableRestIsLeftForAStableOne) {
  const EquilibriumResult found = find_equilibrium(make_pendulum({0.0, 0.0, 0.5}));

  ASSERT_TRUE(found.outcome.ok());
  EXPECT_NEAR(found.positions[5], -0.5, 1e-12);
}

TEST(Equilibrium, UnstableRestIsRefusedByNewtonsMethodAlone) {
  const EquilibriumResult found =
      find_equilibrium(make_pendulum({0.0, 0.0, 0.5}), {.method = EquilibriumMethod::Newton});

  EXPECT_EQ(found.outcome.status, Status::NoSolution);
  EXPECT_NE(found.outcome.what.find("unstable in 2 directions"), std::string::npos) << found.outcome.what;
}

/// Makes rods above each other, with each bead held to the vertical by k/2 (x^2 + y^2).
System make_inverted_chain(int count, double stiffness) {
  System system;
  Rods rods{.name = "rods"};
  Potential springs{.name = "springs"};
  springs.kernel = formula_potential("k/2*(x1^2+y1^2)", 1, {{"k", stiffness}});
  for (int i = 0; i <= count; ++i) {
    system.positions.insert(system.positions.end(), {0.0, 0.0, 0.1 * i});
    system.masses.push_back(0.1);
    if (i == 0) continue;
    rods.pairs.push_back({i - 1, i});
    springs.points.push_back({i});
  }
  system.constraints.push_back(rods);
  system.forces.push_back(springs);
  system.supports.push_back({"", {0}, {}});
  system.add_gravity({0.0, 0.0, -g});
  return system;
}

// It is stable where k > (m g/l) x_max, x_max the largest zero of Laguerre's polynomial; omega^2 = k/m - (g/l) x.
TEST(Equilibrium, InvertedChainOnSpringsIsStableBeyondTheCriticalStiffness) {
  for (const auto& [count, critical] : {std::pair{1, 9.81}, {2, 33.49343504688006}, {5, 124.0062562823454}}) {
    const EquilibriumResult stiff = find_equilibrium(make_inverted_chain(count, 1.25 * critical));
    EXPECT_TRUE(stiff.outcome.ok()) << stiff.outcome.what;
    EXPECT_NEAR(stiff.stability.lowest_omega2, 0.25 * critical / 0.1, 1e-9 * critical);

    const EquilibriumResult soft =
        find_equilibrium(make_inverted_chain(count, 0.9 * critical), {.accept = AcceptedEquilibria::Any});
    EXPECT_EQ(soft.stability.unstable_directions, 2u);  // one in each plane
    EXPECT_NEAR(soft.stability.lowest_omega2, -0.1 * critical / 0.1, 1e-9 * critical);
  }
}

TEST(Equilibrium, IsMarginalAtTheCriticalStiffness) {
  const EquilibriumResult found = find_equilibrium(make_inverted_chain(1, 9.81), {.method = EquilibriumMethod::Newton});

  EXPECT_EQ(found.stability.status, Stability::Marginal);
  EXPECT_EQ(found.stability.zero_modes, 2u);
  EXPECT_EQ(found.outcome.status, Status::NoSolution);
}

/// Makes a bead on an ellipsoid, with gravity and a spring of length 0 to a point.
System make_bead_on_ellipsoid(Vector3 start) {
  System system;
  system.positions = {start[0], start[1], start[2]};
  system.masses = {2.0};
  system.constraints.push_back(UserConstraints{
      .name = "ellipsoid", .tuples = {{0}}, .kernel = formula_constraint("(x1/1.5)^2 + y1^2 + (z1/0.7)^2 - 1", 1)});
  system.forces.push_back(
      Potential{.points = {{0}}, .kernel = formula_potential("20*((x1-0.5)^2+(y1-0.3)^2+(z1-0.6)^2)", 1)});
  system.add_gravity({0.0, 0.0, -g});
  return system;
}

/// A small move along x meets no force but a large one does, so that it is no motion of the point as a whole.
TEST(Equilibrium, IsMarginalWhereTheSecondOrderSaysNothing) {
  for (const char* energy : {"x1^4+y1^2+z1^2", "-x1^4+y1^2+z1^2", "x1^3+y1^2+z1^2", "y1^2+z1^2"}) {
    System system;
    system.positions = {0.0, 0.0, 0.0};
    system.masses = {2.0};
    system.forces = {Potential{"valley", {{0}}, formula_potential(energy, 1), {}}};

    const EquilibriumResult found = find_equilibrium(system, {.accept = AcceptedEquilibria::Any});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.zero_modes, 1u) << energy;
    const bool is_free = std::string(energy) == "y1^2+z1^2";
    EXPECT_EQ(found.stability.rigid_zero_modes, is_free ? 1u : 0u) << energy;
    EXPECT_EQ(found.stability.status, is_free ? Stability::Stable : Stability::Marginal) << energy;
  }
}

TEST(Equilibrium, FreeTriangleHasSixRigidZeroModes) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.3, 0.8, 0.0};
  system.masses = {1.0, 2.0, 3.0};
  system.constraints = {Rods{"rods", {{0, 1}, {1, 2}, {2, 0}}}};

  const EquilibriumResult found = find_equilibrium(system);

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.stability.status, Stability::Stable);
  EXPECT_EQ(found.stability.rigid_zero_modes, 6u);
}

TEST(Equilibrium, BeadOnAnEllipsoidFindsTheOnlyMinimumFromAnywhere) {
  for (const Vector3& start : {Vector3{-1.4, 0.1, 0.3}, {0.0, -1.0, 0.1}, {0.2, 0.1, -0.7}, {2.0, 2.0, 2.0}}) {
    const EquilibriumResult found = find_equilibrium(make_bead_on_ellipsoid(start));

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_NEAR(found.positions[0], 0.6050419427761517912, 1e-9);
    EXPECT_NEAR(found.multipliers[0], 7.812495449882627, 1e-8);
    EXPECT_NEAR(found.energy, 11.62579896111221685, 1e-9);
    EXPECT_NEAR(found.stability.lowest_omega2, 10.75180293881470877, 1e-8);
  }
}

TEST(Equilibrium, MaximumOnAnEllipsoidHasTwoUnstableDirections) {
  const EquilibriumResult found =
      find_equilibrium(make_bead_on_ellipsoid({-1.482476750916294567, -0.1493380449916554513, -0.02130125908724319901}),
                       {.accept = AcceptedEquilibria::Any});

  EXPECT_EQ(found.stability.unstable_directions, 2u);
  EXPECT_NEAR(found.stability.lowest_omega2, -102.4247958744150931, 1e-6);
}

// Thomson's problem has charges on a sphere: the sum of lambda is -U, and three turns of the whole cost nothing.
TEST(Equilibrium, ChargesOnASphereHaveThreeRigidZeroModes) {
  for (const auto& [count, energy] :
       {std::pair{4, 3.674234614174767}, {6, 9.985281374238570}, {12, 49.16525305762880}}) {
    System system;
    Spheres spheres{.name = "sphere", .center = Vector3{}, .radius = {}};
    spheres.radius.constants = {1.0};
    for (int i = 0; i < count; ++i) {  // a spiral
      const double z = 1.0 - 2.0 * (i + 0.5) / count, angle = 2.4 * i, radius = std::sqrt(1.0 - z * z);
      system.positions.insert(system.positions.end(), {radius * std::cos(angle), radius * std::sin(angle), z});
      system.masses.push_back(1.0);
      spheres.points.push_back(i);
    }
    system.constraints.push_back(spheres);
    system.forces.push_back(PairForces{.law = PairLaw::Coulomb, .strength = 1.0, .charges = {1.0}});

    const EquilibriumResult found = find_equilibrium(system);

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_NEAR(found.energy, energy, 1e-10);
    EXPECT_EQ(found.stability.zero_modes, 3u);
    EXPECT_EQ(found.stability.rigid_zero_modes, 3u);
    double sum = 0.0;
    for (const double lambda : found.multipliers) sum += lambda;
    EXPECT_NEAR(sum, -energy, 1e-9);
  }
}

/// A bead stands on a spring, a bond and a field, whose sum is small beside each of them alone.
TEST(Equilibrium, ResidualWithoutConstraintsIsToldBesideTheLargestSingleForce) {
  constexpr double mass = 2.0, stiffness = 500.0;
  System system;
  system.positions = {0.0, 0.0, 0.0, 0.0, 0.0, 0.9};
  system.masses = {1.0, mass};
  system.supports.push_back({"", {0}, {}});
  system.add_gravity({0.0, 0.0, -g});
  const EquilibriumOptions any{.accept = AcceptedEquilibria::Any};
  Bonds bonds{.name = "bond", .pairs = {{0, 1}}};
  bonds.stiffness = stiffness;
  bonds.rest_length = 1.0;
  const Force laws[] = {bonds, Springs{.name = "spring", .pairs = {{0, 1}}, .stiffness = stiffness, .rest_length = 1.0},
                        Potential{.name = "field", .points = {{1}}, .kernel = formula_potential("250*(z1-1)^2", 1)}};
  for (const Force& law : laws) {
    System held = system;
    held.forces.push_back(law);

    const EquilibriumResult found = find_equilibrium(held, any);

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_NEAR(found.positions[5], 1.0 - mass * g / stiffness, 1e-11);
    EXPECT_NEAR(found.largest_force, mass * g, 1e-9);
    EXPECT_LT(found.residual_force, 1e-10 * found.largest_force);
  }
}

/// The first row of a flat net has supports at both ends: that row is straight and cannot sag.
TEST(Equilibrium, NetFromAFlatStartHangsFromItsStraightRow) {
  constexpr int n = 12;
  System system;
  Rods rods{.name = "rods"};
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      system.positions.insert(system.positions.end(), {0.1 * column, 0.1 * row, 0.0});
      system.masses.push_back(0.1);
      const int point = row * n + column;
      if (column > 0) rods.pairs.push_back({point - 1, point});
      if (row > 0) rods.pairs.push_back({point - n, point});
    }
  }
  system.constraints.push_back(rods);
  system.supports.push_back({"", {0, n - 1}, {}});
  system.add_gravity({0.0, 0.0, -g});

  const EquilibriumResult found = find_equilibrium(system, {.solver = {.threads = 1}});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_LE(found.residual_force, 1e-10 * found.largest_force);
  for (int point = 0; point < n * n; ++point)
    EXPECT_NEAR(found.positions[static_cast<std::size_t>(3 * point + 2)], -0.1 * (point / n), 1e-9);
  EXPECT_TRUE(std::ranges::any_of(found.left_out, [](const std::string& what) {
    return what.find("held rigid by prestress") != std::string::npos;
  }));

  // The tensions of the straight row are not determined: its multipliers are NaN, and modes do without them.
  const Modes shaken = modes(system, found.positions, {.count = 3, .multipliers = found.multipliers});
  ASSERT_TRUE(shaken.outcome.ok()) << shaken.outcome.what;
  EXPECT_EQ(shaken.unstable_directions, 0u);
  EXPECT_NEAR(shaken.omega.front(), std::sqrt(found.stability.lowest_omega2), 1e-8);
}

TEST(Equilibrium, FreeIslandUnderGravityHasNoEquilibrium) {
  System system = make_pendulum({0.5, 0.0, 0.0});
  system.positions.insert(system.positions.end(), {3.0, 0.0, 0.0, 4.0, 0.0, 0.0});
  system.masses.insert(system.masses.end(), {1.0, 1.0});
  std::get<Rods>(system.constraints[0]).pairs.push_back({2, 3});

  const EquilibriumResult found = find_equilibrium(system);

  EXPECT_EQ(found.stability.status, Stability::None);
  EXPECT_NE(found.outcome.what.find("gravity pulls the free island 1 (of point 2)"), std::string::npos)
      << found.outcome.what;
}

// A bead in the middle of a straight wire swings across it with omega^2 = 2 T/(m l), by the tension that is given
// alone.
TEST(Equilibrium, StraightWireIsStiffByItsPrestress) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0};
  system.masses = {1.0, 2.0, 1.0};
  system.supports.push_back({"", {0, 2}, {}});
  system.constraints.push_back(Rods{.name = "wire", .pairs = {{0, 1}, {1, 2}}});

  const EquilibriumResult found = find_equilibrium(system, {.prestress = {{"wire", {10.0}}}});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.self_stress_states, 1u);
  EXPECT_NEAR(-found.multipliers[0], 10.0, 1e-12);
  EXPECT_NEAR(found.stability.lowest_omega2, 2.0 * 10.0 / (2.0 * 0.5), 1e-10);
}

TEST(Equilibrium, IsNotConservativeUnderAForceWithoutPotential) {
  System system;
  system.positions = {0.3, -0.2, 0.1};
  system.masses = {1.0};
  system.forces.push_back(FormulaForce{.name = "held", .points = {0}, .kernel = formula_force({"-2*x", "-y", "-z"})});
  system.forces.push_back(
      FormulaForce{.name = "follower", .points = {0}, .kernel = formula_force({"1+x-2*y^3-y", "x", "0*z"})});

  const EquilibriumResult refused = find_equilibrium(system);
  const EquilibriumResult found = find_equilibrium(system, {.accept = AcceptedEquilibria::Any});

  EXPECT_EQ(refused.stability.status, Stability::NotConservative);
  EXPECT_FALSE(refused.outcome.ok());
  EXPECT_NE(refused.outcome.what.find("forces without a potential act (follower)"), std::string::npos)
      << refused.outcome.what;
  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  ASSERT_EQ(found.left_out.size(), 1u);
  EXPECT_NE(found.left_out[0].find("(follower)"), std::string::npos) << found.left_out[0];
  const std::string refusal = modes(system, found.positions).outcome.what;
  EXPECT_NE(refusal.find("forces without a potential (follower)"), std::string::npos) << refusal;
  EXPECT_NEAR(found.positions[0], found.positions[1], 1e-10);  // x = y, 2 x + 2 x^3 = 1
  EXPECT_NEAR(2.0 * found.positions[0] + 2.0 * std::pow(found.positions[0], 3), 1.0, 1e-9);
}

std::string refusal(const System& system, const EquilibriumOptions& options = {}) {
  try {
    (void)find_equilibrium(system, options);
  } catch (const InputError& error) {
    return error.where();
  }
  return "accepted";
}

TEST(Equilibrium, RefusesWrongOptionsByTheirPlace) {
  System rough = make_pendulum({0.5, 0.0, 0.0});
  rough.constraints.push_back(Planes{.name = "floor", .points = {1}, .normal = Vector3{0, 1, 0}});
  rough.friction.push_back(Coulomb{.at = {"floor"}, .coefficient = 0.1});
  EXPECT_EQ(refusal(rough), "/friction/0");
  EXPECT_EQ(refusal(rough, {.ignore_friction = true}), "accepted");
  EXPECT_EQ(refusal(make_pendulum({1, 0, 0}), {.force_tolerance = 0.0}), "/equilibrium/force_tolerance");
  EXPECT_EQ(refusal(make_pendulum({1, 0, 0}), {.max_iterations = 0}), "/equilibrium/max_iterations");
  EXPECT_EQ(refusal(make_pendulum({1, 0, 0}), {.load_steps = 0}), "/equilibrium/load_steps");
  EXPECT_EQ(refusal(make_pendulum({1, 0, 0}), {.prestress = {{"cable", {1.0}}}}), "/equilibrium/prestress/cable");
  EXPECT_EQ(refusal(make_pendulum({1, 0, 0}), {.prestress = {{"rods", {1.0, 2.0}}}}), "/equilibrium/prestress/rods");
}

TEST(Equilibrium, LoadStepsFindTheSame) {
  const EquilibriumResult found =
      find_equilibrium(make_hanging_chain(10, 0.1, 0.1, {0.7, 0.25, 0.0}, 0.2), {.load_steps = 3});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_NEAR(found.positions[4], -0.07880061449296589028, 1e-11);
}

/// Some of the rods and springs are compressed in a soft equilibrium. Full steps bend too far, and descent creeps
/// unless the compressed ones' negative stiffness is counted.
TEST(Equilibrium, SoftTangleIsFound) {
  System system;
  system.positions = {-0.606, 0.477,  0.965,  -0.598, -0.615, -0.189, 0.887,  0.611,  -0.479, -0.1,
                      0.231,  -0.432, 0.16,   -0.975, -0.573, 0.508,  -0.095, 0.319,  0.32,   -0.876,
                      0.566,  0.555,  -0.396, -0.631, -0.413, -0.656, 0.21,   -0.514, 0.36,   -0.849,
                      -0.597, -0.75,  -0.738, 0.76,   -0.939, 0.66,   0.345,  -0.801, 0.002};
  system.masses = {2.19, 0.345, 7.845, 8.835, 1.473, 0.181, 0.327, 0.842, 0.25, 0.285, 1.764, 0.153, 7.094};
  system.supports = {{"", {0, 1}, {}}};
  system.constraints = {Rods{"rods", {{1, 2}, {1, 3}, {3, 4}, {0, 5}, {4, 6}, {2, 7}, {3, 8}, {7, 10}}}};
  Springs springs{.name = "springs",
                  .pairs = {{1, 9}, {4, 11}, {11, 12}, {5, 8}, {0, 5}, {1, 2}, {2, 3}, {10, 3}},
                  .stiffness = 450.0};
  springs.rest_length.constants = {0.898, 0.785, 0.908, 1.262, 0.853, 2.021, 1.068, 0.743};
  system.forces = {springs};
  system.add_gravity({0.0, 0.0, -g});

  const EquilibriumResult found = find_equilibrium(system);

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.stability.status, Stability::Stable);
  EXPECT_LE(found.residual_force, 1e-10 * found.largest_force);
}

}  // namespace
}  // namespace tanor
