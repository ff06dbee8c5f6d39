/// The tests cover what crosses ranks besides the equations of one instant: series in time, energies, pair forces, and
/// decisions about rows that depend on others.

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "long_tests.hpp"
#include "ranks/on_ranks.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

using scenes::make_chain;
using scenes::make_lattice;
using scenes::make_net;

TEST(Reach, CutIslandsMoveBySeriesInTime) {
  MotionOptions options = options_of(Method::Taylor);
  options.start = StartMode::Project;
  expect_same_motion(make_chain(24), options, 0.1, 1e-12);
  expect_same_motion(make_net(9, 6), options, 0.1, 1e-12);
  expect_same_motion(make_lattice(4), options, 0.02, 1e-12);
}

/// Forces and prescribed motions have series as well; `auto` takes them.
TEST(Reach, DrivenCutIslandsMoveBySeriesInTime) {
  System bent = scenes::make_shaken_chain(9);
  Bendings bendings{.name = "bendings", .triples = {}, .law = BendingLaw::Cosine, .stiffness = 0.02};
  Potential potential{.name = "energies",
                      .points = {},
                      .kernel = formula_potential("(1 + 0.5*sin(9*t))*((x2 - x1)^2 + (y2 - y1)^2 + (z2 - z1)^2)", 2)};
  for (Index k = 1; k + 2 <= 9; ++k) {
    bendings.triples.push_back({k, k + 1, k + 2});
    potential.points.push_back({k, k + 2});
  }
  bent.forces.push_back(bendings);
  bent.forces.push_back(potential);
  for (const System& chain : {scenes::make_shaken_chain(9), scenes::make_breathing_chain(9),
                              scenes::make_damped_chain(9), scenes::make_driven_chain(9), bent}) {
    expect_same_motion(chain, options_of(Method::Taylor), 0.1, 1e-11);
    expect_same_motion(chain, options_of(Method::Auto), 0.1, 1e-11);
  }
}

/// Energies cancel at rest, so that their scale comes from points that are moved, guests as well.
TEST(Reach, EnergyScaleIsThatOfOneRank) {
  System loose = make_net(7, 6);
  const Rods rods = std::get<Rods>(loose.constraints[0]);
  loose.constraints.clear();
  loose.forces = {Springs{.name = "springs", .pairs = rods.pairs, .stiffness = 1e9, .rest_length = scenes::spacing}};
  const MotionOptions options = options_of(Method::Rk4, 1e-6);
  EXPECT_GT(run_whole(loose, options, 2e-6).report.energy.scale, 1e-3) << "of points that are moved";
  expect_same_motion(loose, options, 2e-6, 1e-12);
}

/// Beads repel each other in a periodic box, and halos change while they move. Adaptive steps soon depend on the last
/// bit,
/// since forces have kinks at the cutoff, so that only a few of them are compared.
TEST(Reach, PairForcesReachFromRankToRank) {
  System melt = scenes::make_melt(8), attracting = melt;
  auto& law = std::get<PairForces>(attracting.forces[0]);
  law.law = PairLaw::Lj;
  law.exclude_rods = false;
  law.cutoff = 0.23;  // no distance of the lattice that they start from
  for (const System& system : {melt, attracting}) {
    MotionOptions options = options_of(Method::Dop853);
    options.start = StartMode::Project;
    expect_same_motion(system, options, 0.002, 1e-12);
    options = options_of(Method::Rattle, 2e-4);
    options.start = StartMode::Project;
    expect_same_motion(system, options, tests_are_long() ? 0.05 : 0.01, 1e-12);
  }
}

/// Makes chains whose points attract and repel each other at any distance, with a charge for each point.
System make_charged_chains() {
  System system = scenes::make_chain_along(5, {0.1, 0.02, 0.0});
  PairForces charges{.name = "charges", .law = PairLaw::Coulomb, .strength = 2e-3, .exclude_rods = true};
  Rods second{"second", {}, {}, {}};
  for (int i = 0; i < 5; ++i) {
    const Index point = scenes::add_point({0.11 * i, 0.15, 0.03 * (i % 2)}, &system);
    if (i > 0) second.pairs.push_back({point - 1, point});
  }
  system.constraints.push_back(second);
  for (std::size_t i = 0; i < system.num_points(); ++i)
    charges.charges.push_back((i % 3 == 0 ? -1.0 : 1.0) + 0.1 * static_cast<double>(i));
  system.supports.clear();
  system.forces = {charges};
  return system;
}

/// Returns the sum of m v over all points.
Vec3 momentum_of(const System& system, const std::vector<double>& velocities) {
  Vec3 sum{};
  for (std::size_t i = 0; i < system.num_points(); ++i) sum = sum + system.masses[i] * load(velocities.data(), i);
  return sum;
}

/// Without a cutoff every point feels all others, whose places all ranks are told.
TEST(Reach, PairForcesWithoutACutoffReachFromRankToRank) {
  const System charged = make_charged_chains();
  System swarm = charged, few = charged;
  auto& log = std::get<PairForces>(swarm.forces[0]);
  log.law = PairLaw::Log;
  log.charges.clear();
  auto& yukawa = std::get<PairForces>(few.forces[0]);
  yukawa.law = PairLaw::Yukawa;
  yukawa.length = 0.2;
  yukawa.charges.clear();
  yukawa.points = {0, 4, 6, 9};
  for (const System& system : {charged, swarm, few}) {
    const MotionOptions at_start = options_of(Method::Dop853);
    const Ending one = run_whole(system, at_start, 0.0), many = run_on_ranks(system, deal(system, 3), 3, at_start, 0.0);
    EXPECT_LE(difference(many.accelerations, one.accelerations), 1e-13);
    EXPECT_LE(difference(many.multipliers, one.multipliers), 1e-13);
    EXPECT_NEAR(many.report.energy.potential, one.report.energy.potential,
                1e-14 * std::abs(one.report.energy.potential));
    for (const MotionOptions& options :
         {options_of(Method::Auto), options_of(Method::Dop853), options_of(Method::Rattle, 1e-3)}) {
      SCOPED_TRACE(name_of(options.method));
      expect_same_motion(system, options, 0.1, 1e-10);
      const Ending two = run_on_ranks(system, deal(system, 2), 2, options, 0.1);
      EXPECT_LE(norm(momentum_of(system, two.velocities) - momentum_of(system, system.velocities)), 1e-13);
    }
  }
  EXPECT_EQ(run_whole(charged, options_of(Method::Auto), 0.0).report.method, Method::Taylor);
}

/// A rank without a point of the group, and one with a single point.
TEST(Reach, PairForcesWithoutACutoffMayBelongToSomeRanks) {
  System system = make_charged_chains();
  auto& charges = std::get<PairForces>(system.forces[0]);
  charges.points = {0, 1, 2};
  charges.charges = {-1.0, 0.5, 2.0};
  std::vector<int> owner(system.num_points(), 2);
  owner[0] = owner[1] = 0;
  owner[2] = 1;
  const MotionOptions options = options_of(Method::Dop853);
  const Ending one = run_whole(system, options, 0.1), many = run_on_ranks(system, owner, 3, options, 0.1);
  ASSERT_TRUE(many.outcome.ok()) << many.outcome.what;
  EXPECT_EQ(many.report.steps, one.report.steps);
  EXPECT_LE(difference(many.positions, one.positions), 1e-11);
  const double rounding = 1e-14 * std::abs(one.report.energy.potential);
  EXPECT_NEAR(many.report.energy.now, one.report.energy.now, rounding);
  EXPECT_NEAR(many.report.energy.potential, one.report.energy.potential, rounding);
}

/// Two charges that attract each other fall together: the message names them, on all ranks.
TEST(Reach, CollisionWithAPointOfAnotherRankIsNamed) {
  System system;
  for (const double x : {0.0, 0.1}) scenes::add_point({x, 0, 0}, &system);
  system.forces = {PairForces{.name = "charges", .law = PairLaw::Coulomb, .strength = -1e-3, .charges = {1.0}}};
  const MotionOptions options = options_of(Method::Dop853);
  const Ending one = run_whole(system, options, 10.0), two = run_on_ranks(system, {0, 1}, 2, options, 10.0);
  EXPECT_EQ(one.outcome.status, two.outcome.status);
  for (const Ending* ending : {&one, &two})
    EXPECT_NE(ending->outcome.what.find("charges: points 0 and 1"), std::string::npos) << ending->outcome.what;
  EXPECT_NEAR(two.report.time, one.report.time, 1e-6);
}

/// Rods in a row that fly towards each other meet within what would otherwise be one step.
TEST(Reach, MeetingsWithPointsOfOtherRanksAreNotPassedUnseen) {
  System system;
  Rods rods{"rods", {}, {}, {}};
  std::vector<double> velocities;
  for (int k = 0; k < 4; ++k) {
    const Index low = scenes::add_point({2.0 * k, 0.002 * k, 0.0}, &system),
                high = scenes::add_point({2.0 * k, 0.002 * k, 0.3}, &system);
    rods.pairs.push_back({low, high});
    for (int end = 0; end < 2; ++end) velocities.insert(velocities.end(), {k < 2 ? 20.0 : -20.0, 0.0, 0.1 * k});
  }
  system.velocities = velocities;
  system.constraints = {rods};
  system.forces = {PairForces{.name = "beads", .epsilon = 1.0, .sigma = 0.01}};
  const MotionOptions options = options_of(Method::Dop853);
  const Ending one = run_whole(system, options, 0.08);
  EXPECT_LT(one.velocities[6], 0.0) << "the inner ones have met";
  for (const int num_ranks : {2, 4}) {
    const Ending many = run_on_ranks(system, cut_along(system, 0, num_ranks), num_ranks, options, 0.08);
    ASSERT_TRUE(many.outcome.ok()) << many.outcome.what;
    EXPECT_NEAR(static_cast<double>(many.report.steps), static_cast<double>(one.report.steps), 4.0);
    EXPECT_LE(difference(many.positions, one.positions), 1e-8);
    EXPECT_LE(difference(many.velocities, one.velocities), 1e-7);
  }
}

/// Makes cubes in a row that all diagonals brace, hung up at one corner: of the 72 rods between 16 points 42 are
/// independent.
System make_braced_beam(int cubes) {
  System system = scenes::make_grid({cubes + 1, 2, 2});
  Rods& rods = std::get<Rods>(system.constraints[0]);
  rods.pairs.clear();
  const auto place = [&](Index i) { return &system.positions[3 * static_cast<std::size_t>(i)]; };
  const auto count = static_cast<Index>(system.num_points());
  for (Index i = 0; i < count; ++i)
    for (Index j = i + 1; j < count; ++j)
      if (std::hypot(place(i)[0] - place(j)[0], place(i)[1] - place(j)[1], place(i)[2] - place(j)[2]) <
          1.8 * scenes::spacing)
        rods.pairs.push_back({i, j});
  rods.length = {};  // as drawn
  for (std::size_t i = 0; i < system.num_points(); ++i) system.masses[i] = 0.1 + 0.01 * static_cast<double>(i % 5);
  return scenes::hang(system, {0});
}

TEST(Reach, RowsThatDependAreFoundOnAllRanks) {
  const System beam = make_braced_beam(3);
  for (const MotionOptions& options : {options_of(Method::Dop853), options_of(Method::Rattle, 1e-3)}) {
    expect_same_motion(beam, options, 0.05, 1e-12);
    const Ending one = run_whole(beam, options, 0.0);
    for (const int num_ranks : {2, 4}) {
      const Ending many = run_on_ranks(beam, cut_along(beam, 0, num_ranks), num_ranks, options, 0.0);
      EXPECT_LE(difference(many.multipliers, one.multipliers), 1e-11);
      EXPECT_EQ(many.report.rank_changes.now, one.report.rank_changes.now);
    }
  }
}

}  // namespace
}  // namespace tanor
