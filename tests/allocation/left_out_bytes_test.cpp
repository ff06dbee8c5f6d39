/// A scene takes no memory for parts that it does not need. Each test compares the bytes that are held with the bytes
/// that the omitted part would take at least.

#include <gtest/gtest.h>

#include <tanor/tanor.hpp>

#include "allocation/counting_allocator.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

using allocation::AllocationCounter;

constexpr Index num_beads = 1000;
constexpr std::ptrdiff_t number = sizeof(double);

/// Makes sliding beads, each on a circle of its own.
System make_beads_on_circles() {
  System system;
  for (Index i = 0; i < num_beads; ++i) {
    system.positions.insert(system.positions.end(), {1.0, 0.0, 1.0 * i});
    system.velocities.insert(system.velocities.end(), {0.0, 1.0, 0.0});
    system.masses.push_back(1.0 + i % 3);
    const Vector3 center{0.0, 0.0, 1.0 * i}, normal{0.0, 0.0, 1.0};
    system.constraints.push_back(Circles{"wire" + std::to_string(i), {i}, center, normal, 1.0});
    system.coordinates.push_back(CircleCoordinates{"", {i}, center, normal, 1.0});
  }
  system.forces = {Gravity{"", {-1.0, 0.0, 0.0}}};
  return system;
}

/// Counts the bytes that a Dynamics holds after one solve.
struct Solved {
  AllocationCounter counter;
  Dynamics dynamics;
  std::ptrdiff_t bytes;

  explicit Solved(System system, const SolverOptions& options = {}) : dynamics(std::move(system), options), bytes(0) {
    EXPECT_TRUE(dynamics.solve(state()).outcome.ok());
    bytes = counter.bytes();
  }
  StateView state() const {
    return {.time = 0.0, .positions = dynamics.system().positions, .velocities = dynamics.system().velocities};
  }
  std::ptrdiff_t factor_bytes() const { return static_cast<std::ptrdiff_t>(dynamics.plan().factor_nonzeros) * number; }
};

TEST(LeftOutBytes, AllocatedBytesAreCountedAndGivenBack) {
  const AllocationCounter counter;
  {
    const std::vector<double> array(1000);
    EXPECT_GE(counter.bytes(), 1000 * number);
  }
  EXPECT_EQ(counter.bytes(), 0);
}

TEST(LeftOutBytes, GammaTakesNoBytesBeforeTheSplitOrWhereAllMassesAreEqual) {
  const auto measure_split = [](double last_mass) {
    System chain = scenes::make_chain(num_beads);
    chain.masses.back() = last_mass * chain.masses.back();
    Solved solved(chain);
    const AllocationCounter counter;
    EXPECT_TRUE(solved.dynamics.split(solved.state()).outcome.ok());
    return std::pair{counter.bytes(), solved.factor_bytes()};
  };

  const auto [with_gamma, factor] = measure_split(7.0);
  const auto [equal_masses, same_factor] = measure_split(1.0);

  EXPECT_GE(factor, 2 * (num_beads - 2) * number);  // tridiagonal
  EXPECT_GE(with_gamma, factor);
  EXPECT_LE(equal_masses, with_gamma - factor);
}

TEST(LeftOutBytes, CoordinatesAloneHoldNoS) {
  System alone = make_beads_on_circles();
  alone.constraints.clear();
  System constraints_alone = make_beads_on_circles();
  constraints_alone.coordinates.clear();

  const Solved both(make_beads_on_circles(), {.form = Form::Tangent}), tangent(alone), normal(constraints_alone);

  // H has one number per bead, S has three in its triangle.
  EXPECT_EQ(tangent.dynamics.plan().pattern_nonzeros, static_cast<std::size_t>(num_beads));
  EXPECT_EQ(normal.dynamics.plan().pattern_nonzeros, 3 * static_cast<std::size_t>(num_beads));
  EXPECT_LE(tangent.bytes, both.bytes - normal.factor_bytes());
}

TEST(LeftOutBytes, LongPathsStayInLanesFromTheFirstProjectionOn) {
  constexpr Index num_rods = 20'000;
  Solved solved(scenes::make_chain(num_rods), {.linear_solver = LinearSolver::Paths, .threads = 1});
  const System& chain = solved.dynamics.system();
  std::vector<double> velocities = chain.velocities;
  const AllocationCounter counter;

  EXPECT_TRUE(solved.dynamics.project_velocities({0.0, chain.positions, velocities}).outcome.ok());

  // Two directions, a point, a multiplier and a sum of each rod but for those of one group, which a solve holds, too.
  const std::ptrdiff_t of_rod = (3 * 3 + 2) * number, of_group = 8 * 65;
  EXPECT_GE(counter.bytes(), (num_rods - of_group) * of_rod);
}

TEST(LeftOutBytes, SmoothGuidesTakeNoBytesForFriction) {
  System smooth = make_beads_on_circles();
  smooth.coordinates.clear();
  System creeping = smooth, sticking = smooth;
  Coulomb coulomb{.name = "rust", .at = {}, .coefficient = 0.1};
  for (Index i = 0; i < num_beads; ++i) coulomb.at.push_back("wire" + std::to_string(i));
  sticking.friction = {coulomb};
  coulomb.regularisation = 1e-3;
  creeping.friction = {coulomb};

  const Solved none(smooth), regularised(creeping), exact(sticking);

  // Without friction, and with a law that never sticks, S has the triangle of two rows per bead. With a law that sticks
  // each bead may have a third row.
  EXPECT_EQ(none.dynamics.plan().pattern_nonzeros, 3 * static_cast<std::size_t>(num_beads));
  EXPECT_EQ(regularised.dynamics.plan().pattern_nonzeros, 3 * static_cast<std::size_t>(num_beads));
  EXPECT_EQ(exact.dynamics.plan().pattern_nonzeros, 6 * static_cast<std::size_t>(num_beads));
  EXPECT_EQ(none.dynamics.counters().friction_solves, 0U);
  EXPECT_EQ(exact.dynamics.counters().friction_solves, 2U) << "once for the modes, once for the answer";
  // A law reads the normals of its guides, and keeps its force.
  const std::ptrdiff_t law = num_beads * 9 * number;
  EXPECT_LE(none.bytes, regularised.bytes - law);
  EXPECT_LE(regularised.bytes, exact.bytes - 4 * num_beads * number);
}

TEST(LeftOutBytes, RunsWithoutObservablesTakeNoBytesForThem) {
  const auto measure = [](bool observes) {
    System chain = scenes::make_chain(num_beads);
    const AllocationCounter counter;
    Simulation simulation(std::move(chain), {.method = Method::Rattle, .step = 1e-3}, {.threads = 1});
    if (observes) simulation.add_observable({.text = "max tension(rods)", .every_step = true});
    EXPECT_TRUE(simulation.advance_to(0.01).ok());
    return counter.bytes();
  };
  // An answer of its own: positions, velocities, accelerations, two kinds of forces, multipliers.
  EXPECT_LE(measure(false) + 16 * num_beads * number, measure(true));
}

TEST(LeftOutBytes, StepsWithConstantKTakeNoBytes) {
  // The beads lie on a plane, so that S is diagonal, in closed form, and a step needs nothing more.
  System beads;
  for (Index i = 0; i < num_beads; ++i) {
    beads.positions.insert(beads.positions.end(), {1.0 * i, 0.0, 0.0});
    beads.masses.push_back(1.0);
  }
  beads.velocities.assign(beads.positions.size(), 0.0);
  Planes floor{"floor", {}, Vector3{0.0, 0.0, 1.0}, 0.0};
  for (Index i = 0; i < num_beads; ++i) floor.points.push_back(i);
  beads.constraints = {floor};
  beads.forces = {Gravity{"", {1.0, 0.0, -9.81}}};
  Simulation simulation(beads, {.step = 1e-2});
  ASSERT_TRUE(simulation.advance_to(0.05).ok());
  const AllocationCounter counter;

  ASSERT_TRUE(simulation.advance_to(1.0).ok());

  EXPECT_EQ(simulation.plan().factor_nonzeros, static_cast<std::size_t>(num_beads));
  EXPECT_EQ(simulation.report().counters.factorizations, 1U);
  EXPECT_LE(counter.bytes(), 0);
}

}  // namespace
}  // namespace tanor
