/// The tests compare with the catenaries of MoorPy that inextensible rods can meet (B7), which are cases 1 to 4 of its
/// tests/test_catenary.py (NREL/MoorPy). In cases 1 to 3 a part of the line lies on the sea floor, which carries beads
/// and does not hold them down.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>

#include "cases/reference_case.hpp"

namespace tanor::cases {
namespace {

/// A line from an anchor at the origin to a fairlead, of rods and beads. Each bead has the weight of a rod.
struct Line {
  double x, z, length, weight;  // m, N/m
  int rods;

  System system() const {
    System result;
    Rods all{.name = "rods"};
    all.length.constants = {length / rods};
    // The flat part is shorter than it would be if the line were taut, with flat + |fairlead - (flat, 0)| = length.
    const double flat = 0.8 * (length * length - x * x - z * z) / (2.0 * (length - x));
    for (int i = 0; i <= rods; ++i) {
      // The beads start along the floor and then straight up to the fairlead.
      const double s = length * i / rods, rest = (s - flat) / (length - flat);
      result.positions.insert(result.positions.end(),
                              {s < flat ? s : flat + rest * (x - flat), 0.0, std::max(0.0, rest * z)});
      result.masses.push_back(weight * length / rods / 9.81);
      if (i > 0) all.pairs.push_back({i - 1, i});
    }
    result.supports = {Support{"", {0, rods}}};
    result.constraints = {all};
    result.forces = {Gravity{"", {0, 0, -9.81}}};
    return result;
  }
};

/// A line at rest, and the number of beads on the floor.
struct Rested {
  EquilibriumResult found;
  std::size_t on_floor;

  /// The force on the supports, N.
  double horizontal() const { return found.support_forces[0]; }
  double vertical_at(std::size_t point) const { return found.support_forces[3 * point + 2]; }
};

Rested rest(const Line& line, bool has_floor) {
  System system = line.system();
  Planes floor{"floor", {}, Vector3{0, 0, 1}, 0.0};
  for (Index i = 1; i < line.rods; ++i) floor.points.push_back(i);
  if (!has_floor) return {find_equilibrium(system, {.solver = {.threads = 1}}), 0};
  system.constraints.push_back(floor);
  Rested result{find_equilibrium(system, {.one_sided = {{"floor", OneSide::AtLeast}}, .solver = {.threads = 1}}), 0};
  result.on_floor = floor.points.size() - static_cast<std::size_t>(std::ranges::count(result.found.open, true));
  return result;
}

Line line_of(const nlohmann::json& given, int rods) {
  return {number(given.at("x")), number(given.at("z")), number(given.at("L")), number(given.at("w")), rods};
}

TEST(MooringLine, RestsOnTheFloorAsItsDiscreteClosedForm) {
  const nlohmann::json file = read_case("B7_moorpy_catenary");
  for (const nlohmann::json& each : file.at("discrete_case_2")) {
    const Line line = line_of(file.at("cases")[1], each.at("rods").get<int>());

    const Rested rested = rest(line, true);

    ASSERT_TRUE(rested.found.outcome.ok()) << rested.found.outcome.what;
    EXPECT_EQ(rested.on_floor, each.at("last_bead_on_floor").get<std::size_t>());
    EXPECT_NEAR(rested.horizontal(), number(each.at("H")), 1e-9 * number(each.at("H")));
    const double top = number(each.at("V_top_rod"));
    EXPECT_NEAR(-rested.vertical_at(static_cast<std::size_t>(line.rods)), top, 1e-9 * top);
    // The floor carries the part that the first lifted rod does not carry.
    const std::size_t touching = static_cast<std::size_t>(line.rods) + rested.on_floor - 1;
    const double floor = number(each.at("floor_reaction_on_it"));
    EXPECT_NEAR(rested.found.multipliers[touching], floor, 1e-9 * number(each.at("H")));
    if (!each.contains("tensions")) continue;
    const std::vector<double> tensions = numbers(each.at("tensions"));
    for (std::size_t i = 0; i < tensions.size(); ++i)
      EXPECT_NEAR(-rested.found.multipliers[i], tensions[i], 1e-9 * tensions[i]) << i;
    if (!each.contains("nodes")) continue;
    for (std::size_t i = 0; i < each.at("nodes").size(); ++i) {
      EXPECT_NEAR(rested.found.positions[3 * (i + 1)], number(each.at("nodes")[i][0]), 1e-8);
      EXPECT_NEAR(rested.found.positions[3 * (i + 1) + 2], number(each.at("nodes")[i][1]), 1e-8);
    }
  }
}

/// A line of rods approaches the catenary with the square of their length, so that two lines determine the limit.
/// MoorPy's lines stretch a little and its tolerance is finite, which gives 6e-7.
TEST(MooringLine, HasTheForcesOfMoorPyWithManyRods) {
  const nlohmann::json file = read_case("B7_moorpy_catenary");
  for (std::size_t k = 0; k < 4; ++k) {
    const nlohmann::json& each = file.at("cases")[k];
    const auto& moorpy = each.at("moorpy");
    const Line line = line_of(each, 2000);

    const Rested rested = rest(line, moorpy[4].get<double>() > 0.0);

    ASSERT_TRUE(rested.found.outcome.ok()) << rested.found.outcome.what;
    const double bead = line.weight * line.length / line.rods, H = -moorpy[2].get<double>(),
                 V = -moorpy[3].get<double>();
    EXPECT_NEAR(rested.horizontal(), H, 6e-7 * H) << "case " << k + 1;
    // The support carries half of a rod that no bead has.
    const double top = rested.vertical_at(static_cast<std::size_t>(line.rods));
    EXPECT_NEAR(-top + 0.5 * bead, V, 6e-7 * V) << "case " << k + 1;
    const nlohmann::json& limit = each.at("inextensible");
    const double H_limit = number(limit.at("H")), V_limit = number(limit.at(k == 3 ? "V_B" : "V_top"));
    EXPECT_NEAR(rested.horizontal(), H_limit, 2e-7 * H_limit) << "case " << k + 1;
    EXPECT_NEAR(-top + 0.5 * bead, V_limit, 2e-7 * V_limit) << "case " << k + 1;
    const double lying = line.length / line.rods * static_cast<double>(rested.on_floor);
    EXPECT_NEAR(lying, moorpy[4].get<double>(), line.length / line.rods) << "case " << k + 1;
  }
}

}  // namespace
}  // namespace tanor::cases
