#include <cmath>
#include <set>

#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

Scene generate(const std::string& keys, const std::string& more = "") {
  return parse(R"({"tanor_scene": 1, "generate": {)" + keys + "}" + (more.empty() ? "" : ", " + more) + "}");
}

Vector3 position(const Scene& scene, std::size_t k) {
  const double* r = &scene.system.positions[3 * k];
  return {r[0], r[1], r[2]};
}

/// Returns the number of connected parts of the graph of rods.
std::size_t num_parts(const Scene& scene) {
  std::vector<std::size_t> part(scene.system.num_points());
  for (std::size_t k = 0; k < part.size(); ++k) part[k] = k;
  const auto root = [&](std::size_t k) {
    while (part[k] != k) k = part[k] = part[part[k]];
    return k;
  };
  for (const auto& [i, j] : rods_of(scene).pairs)
    part[root(static_cast<std::size_t>(i))] = root(static_cast<std::size_t>(j));
  std::set<std::size_t> roots;
  for (std::size_t k = 0; k < part.size(); ++k) roots.insert(root(k));
  return roots.size();
}

/// Expects what every kind of generated scene has.
void check(const Scene& scene, std::size_t num_points, std::size_t num_rods, double spacing, double mass) {
  const System& system = scene.system;
  EXPECT_EQ(system.positions.size(), 3 * num_points);
  EXPECT_EQ(system.masses, std::vector<double>(num_points, mass));
  EXPECT_EQ(rods_of(scene).name, "rods");
  EXPECT_TRUE(rods_of(scene).length.is_initial());
  ASSERT_EQ(rods_of(scene).pairs.size(), num_rods);
  for (std::size_t k = 0; k < num_rods; ++k)
    EXPECT_NEAR(rod_length(system, rods_of(scene), k), spacing, 1e-13 * (1 + spacing * 100));
}

TEST(Generate, ChainRunsAlongItsDirection) {
  const Scene scene = generate(R"("kind": "chain", "count": 4, "spacing": 0.5, "mass": 2, "direction": [0, 3, -4])");

  check(scene, 5, 4, 0.5, 2.0);
  EXPECT_EQ(scene.source, "generate: chain");
  EXPECT_EQ(position(scene, 0), Vector3{});
  EXPECT_NEAR(position(scene, 4)[1], 1.2, 1e-15);
  EXPECT_NEAR(position(scene, 4)[2], -1.6, 1e-15);
  EXPECT_TRUE(scene.system.supports.empty());
}

TEST(Generate, AnchoredChainHangsOnAFixedSupport) {
  const Scene scene = generate(R"("kind": "chain", "anchored": true)", R"("supports": [{"points": [10]}])");

  check(scene, 11, 10, 0.1, 0.1);
  ASSERT_EQ(scene.system.supports.size(), 2u);
  EXPECT_EQ(scene.system.supports[0].points, std::vector<Index>{0});
  EXPECT_TRUE(scene.system.supports[0].displacement.is_constant());
  EXPECT_EQ(scene.system.supports[1].points, std::vector<Index>{10});
}

TEST(Generate, RingIsAClosedPolygon) {
  const Scene scene = generate(R"("kind": "ring", "count": 6, "spacing": 2)");

  check(scene, 6, 6, 2.0, 0.1);
  EXPECT_NEAR(position(scene, 0)[0], 2.0, 1e-14) << "the radius of a hexagon is its edge";
  EXPECT_EQ(rods_of(scene).pairs[5], (std::array<Index, 2>{5, 0}));
}

TEST(Generate, NetHasRodsAlongBothDirections) {
  const Scene scene = generate(R"("kind": "net", "columns": 4, "rows": 3)");

  check(scene, 12, 3 * 3 + 4 * 2, 0.1, 0.1);
  EXPECT_DOUBLE_EQ(position(scene, 11)[0], 0.3);
  EXPECT_DOUBLE_EQ(position(scene, 11)[1], 0.2);
  EXPECT_EQ(position(scene, 11)[2], 0.0);
  EXPECT_EQ(num_parts(scene), 1u);
}

TEST(Generate, LatticeHasRodsAlongThreeAxes) {
  const Scene scene = generate(R"("kind": "lattice", "size": [2, 3, 4])");

  check(scene, 24, 1 * 3 * 4 + 2 * 2 * 4 + 2 * 3 * 3, 0.1, 0.1);
  EXPECT_DOUBLE_EQ(position(scene, 23)[0], 0.1);
  EXPECT_DOUBLE_EQ(position(scene, 23)[1], 0.2);
  EXPECT_DOUBLE_EQ(position(scene, 23)[2], 0.3);
  EXPECT_EQ(num_parts(scene), 1u);
}

TEST(Generate, TreeHasNoLoops) {
  const Scene scene = generate(R"("kind": "tree", "count": 500, "seed": 3)");

  check(scene, 501, 500, 0.1, 0.1);
  EXPECT_EQ(num_parts(scene), 1u) << "501 points, 500 rods and one part: a tree";
}

TEST(Generate, ClustersAreSeparate) {
  const Scene scene = generate(R"("kind": "clusters", "clusters": 9, "count": 5)");

  check(scene, 9 * 6, 9 * 5, 0.1, 0.1);
  EXPECT_EQ(num_parts(scene), 9u);
}

TEST(Generate, MeltFillsACube) {
  const Scene scene = generate(R"("kind": "melt", "chains": 50, "count": 20, "spacing": 0.97, "mass": 1)");

  check(scene, 50 * 21, 50 * 20, 0.97, 1.0);
  EXPECT_EQ(num_parts(scene), 50u);
  const double edge = 0.97 * std::cbrt(50 * 21 / 0.85);
  for (const double coordinate : scene.system.positions) {
    EXPECT_GE(coordinate, 0.0);
    EXPECT_LE(coordinate, edge);
  }
}

// By equipartition each of the 3n - rods degrees of freedom carries kT/2.
TEST(Generate, MeltHasItsTemperatureAndKeepsItsRods) {
  const Scene scene = generate(R"("kind": "melt", "chains": 400, "count": 20, "mass": 0.5, "temperature": 2)");

  const std::vector<double>& v = scene.system.velocities;
  ASSERT_EQ(v.size(), 3u * 400 * 21);
  double twice_energy = 0.0;
  for (const double component : v) twice_energy += 0.5 * component * component;
  const double degrees_of_freedom = 400 * (3 * 21 - 20);
  EXPECT_NEAR(twice_energy / degrees_of_freedom, 2.0, 5 * 2.0 * std::sqrt(2 / degrees_of_freedom))
      << "5 standard deviations";
  for (const auto& [i, j] : rods_of(scene).pairs) {
    const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
    double stretch_rate = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      stretch_rate += (position(scene, b)[axis] - position(scene, a)[axis]) * (v[3 * b + axis] - v[3 * a + axis]);
    EXPECT_NEAR(stretch_rate, 0.0, 1e-13);
  }
}

TEST(Generate, MeltOfEnergiesIsABeadSpringModelThatBeginsApart) {
  const Scene scene = generate(
      R"("kind": "melt", "bonds": "energies", "chains": 30, "count": 19, "spacing": 0.5, "mass": 2, "temperature": 3,
      "epsilon": 4, "bending": 0.7)");
  const System& system = scene.system;
  ASSERT_EQ(system.num_points(), 600u);
  EXPECT_TRUE(system.constraints.empty());
  ASSERT_EQ(system.forces.size(), 3u);
  const auto& bonds = std::get<Bonds>(system.forces[0]);
  const auto& beads = std::get<PairForces>(system.forces[1]);
  const auto& bendings = std::get<Bendings>(system.forces[2]);
  EXPECT_EQ(bonds.name + beads.name + bendings.name, "bondsbeadsbendings");
  EXPECT_EQ(bonds.pairs.size(), 30u * 19u);
  EXPECT_EQ(bendings.triples.size(), 30u * 18u);
  EXPECT_EQ(bonds.law, BondLaw::Fene);
  EXPECT_EQ(bendings.law, BendingLaw::Cosine);
  EXPECT_EQ(beads.law, PairLaw::Wca);
  EXPECT_EQ(bonds.stiffness.constants, std::vector{30.0 * 4.0 / 0.25});
  EXPECT_EQ(bonds.limit.constants, std::vector{0.75});
  EXPECT_EQ(bendings.stiffness.constants, std::vector{0.7});
  EXPECT_EQ(beads.epsilon, 4.0);
  EXPECT_EQ(beads.sigma, 0.5);

  // There are 0.85 beads a spacing^3, but for what the last layer of the lattice leaves empty.
  const double density = 600.0 * 0.125 / (beads.box[0] * beads.box[1] * beads.box[2]);
  EXPECT_LE(density, 0.85 * (1 + 1e-12));
  EXPECT_GT(density, 0.75);
  const double pitch = 0.5 / std::cbrt(0.85);
  for (const auto& [i, j] : bonds.pairs) {
    EXPECT_EQ(j, i + 1);
    EXPECT_NE(i % 20, 19);
    const Vector3 a = position(scene, static_cast<std::size_t>(i)), b = position(scene, static_cast<std::size_t>(j));
    EXPECT_NEAR(std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]), pitch, 1e-12);
  }
  double nearest = HUGE_VAL, square = 0.0;
  for (std::size_t i = 0; i < 600; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      double distance2 = 0.0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double d = position(scene, i)[axis] - position(scene, j)[axis];
        distance2 += std::pow(d - beads.box[axis] * std::round(d / beads.box[axis]), 2);
      }
      nearest = std::min(nearest, std::sqrt(distance2));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) square += std::pow(system.velocities[3 * i + axis], 2);
  }
  EXPECT_NEAR(nearest, pitch, 1e-12);
  EXPECT_NEAR(2.0 * square / 1800.0, 3.0, 0.4);  // m <v^2> = kT a component
}

TEST(Generate, MeltOfEnergiesMovesWithoutRods) {
  const Scene scene =
      generate(R"("kind": "melt", "bonds": "energies", "chains": 9, "count": 24, "spacing": 1, "mass": 1)");
  Simulation simulation(scene.system, {.method = Method::Rattle, .step = 0.003});

  ASSERT_TRUE(simulation.advance_to(0.6).ok()) << simulation.outcome().what;

  const EnergyReport& energy = simulation.report().energy;
  EXPECT_LT(std::abs(energy.now - energy.start), 2e-3 * energy.kinetic);
  EXPECT_GT(energy.kinetic, 0.5 * 1.5 * 225);
}

TEST(Generate, MeltOfRodsTakesNoNumbersOfEnergies) {
  for (const char* key : {"epsilon", "bending"}) {
    try {
      (void)generate(std::string(R"("kind": "melt", ")") + key + R"(": 1)");
      FAIL() << key;
    } catch (const InputError& error) {
      EXPECT_NE(error.where().find(std::string("/generate/") + key), std::string::npos) << error.where();
    }
  }
}

TEST(Generate, SeedDecidesEverything) {
  for (const char* kind : {"tree", "clusters", "melt"}) {
    const std::string keys = std::string(R"("kind": ")") + kind + R"(", "seed": )";
    const Scene one = generate(keys + "1"), again = generate(keys + "1"), other = generate(keys + "2");

    EXPECT_EQ(one.system.positions, again.system.positions) << kind;
    EXPECT_EQ(one.system.velocities, again.system.velocities) << kind;
    EXPECT_EQ(rods_of(one).pairs, rods_of(again).pairs) << kind;
    EXPECT_NE(one.system.positions, other.system.positions) << kind;
  }
}

// The numbers are those of an independent program with its own Mersenne Twister.
TEST(Generate, SeedGivesTheSameOnEveryMachine) {
  const Scene scene = generate(R"("kind": "melt", "seed": 1)");

  const double expected[] = {0.06771674435365689, 0.06899665343258116,   0.22823102952401553,
                             0.13838440318163153, 0.0010824024473445326, 0.20838823463803077};
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(scene.system.positions[k], expected[k], 1e-15);
}

TEST(Generate, DefaultNamesCountInTheScenesList) {
  const Scene scene = generate(R"("kind": "chain")", R"("constraints": [
    {"kind": "plane", "points": [0], "normal": [0, 0, 1]}, {"kind": "plane", "points": [1], "normal": [0, 0, 1]}])");

  EXPECT_EQ(constraint_name(scene.system, 0), "rods");
  EXPECT_EQ(constraint_name(scene.system, 1), "plane0");
  EXPECT_EQ(constraint_name(scene.system, 2), "plane1");
}

}  // namespace
}  // namespace tanor::scene
