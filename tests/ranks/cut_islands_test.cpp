/// Islands that lie on several ranks have the accelerations, reactions, steps and motion that they have on one.

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "ranks/on_ranks.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

using scenes::make_chain;
using scenes::make_lattice;
using scenes::make_net;

void expect_same_instant(const System& system, const std::vector<int>& owner, int num_ranks, double allowed) {
  MotionOptions options;
  options.start = StartMode::Project;
  options.method = Method::Dop853;
  const Ending expected = run_whole(system, options, 0.0), found = run_on_ranks(system, owner, num_ranks, options, 0.0);
  ASSERT_TRUE(expected.outcome.ok()) << expected.outcome.what;
  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_LE(difference(found.velocities, expected.velocities), allowed);
  EXPECT_LE(difference(found.accelerations, expected.accelerations), allowed);
  EXPECT_LE(difference(found.multipliers, expected.multipliers), allowed);
}

TEST(CutIslands, HaveTheAccelerationsAndMultipliersOfOneRank) {
  System chain = make_chain(300);
  System net = make_net(20, 17), lattice = make_lattice(8);
  expect_same_instant(chain, cut_along(chain, 0, 2), 2, 1e-12);
  expect_same_instant(chain, cut_along(chain, 0, 4), 4, 1e-12);
  expect_same_instant(net, cut_along(net, 0, 2), 2, 1e-12);
  expect_same_instant(lattice, cut_along(lattice, 2, 2), 2, 1e-12);
}

/// Each strip with its cut rods has more rods than freedoms.
TEST(CutIslands, StripsThatAreSingularByThemselvesAreSolved) {
  const System lattice = make_lattice(8);
  expect_same_instant(lattice, cut_along(lattice, 0, 4), 4, 1e-12);
}

/// These owners follow no geometry, so that a rank's part is in many pieces.
TEST(CutIslands, AnyOwnersGiveTheSameAccelerations) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 12; ++trial) {
    const System system = trial % 3 == 0 ? make_chain(12) : trial % 3 == 1 ? make_net(5, 4) : make_lattice(3);
    const int num_ranks = 2 + trial % 3;
    std::vector<int> owner(system.num_points());
    for (int& rank : owner) rank = static_cast<int>(random() % static_cast<unsigned>(num_ranks));
    for (int rank = 0; rank < num_ranks; ++rank) owner[static_cast<std::size_t>(3 + rank)] = rank;  // none is idle
    SCOPED_TRACE(trial);
    expect_same_instant(system, owner, num_ranks, 1e-11);
  }
}

TEST(CutIslands, MoveAsOnOneRank) {
  const System net = make_net(7, 6);
  const std::vector<int> halves = cut_along(net, 0, 2), strips = cut_along(net, 1, 3);
  for (const MotionOptions& options :
       {options_of(Method::Rattle, 1e-3), options_of(Method::Rk4, 1e-3), options_of(Method::Rattle4, 1e-3),
        options_of(Method::Dop853), options_of(Method::Dopri5)}) {
    const Ending one = run_whole(net, options, 0.05);
    ASSERT_TRUE(one.outcome.ok());
    for (const auto& [owner, num_ranks] : {std::pair(halves, 2), std::pair(strips, 3)}) {
      const Ending many = run_on_ranks(net, owner, num_ranks, options, 0.05);
      ASSERT_TRUE(many.outcome.ok()) << many.outcome.what;
      EXPECT_EQ(many.report.steps, one.report.steps) << name_of(options.method);
      EXPECT_EQ(many.report.rejected, one.report.rejected);
      EXPECT_LE(difference(many.positions, one.positions), 1e-9) << name_of(options.method);
      EXPECT_LE(difference(many.velocities, one.velocities), 1e-9);
      EXPECT_LE(many.report.violation.position, 1e-12);
      EXPECT_NEAR(many.report.energy.now, one.report.energy.now, 1e-9 * one.report.energy.scale);
    }
  }
}

/// A support that moves, drag and a force of time: each rank evaluates those of its own points.
TEST(CutIslands, DrivenChainsMoveAsOnOneRank) {
  for (const System& chain : {scenes::make_shaken_chain(9), scenes::make_breathing_chain(9),
                              scenes::make_chain_in_air(9), scenes::make_driven_chain(9)}) {
    const MotionOptions options = options_of(Method::Dop853);
    const Ending one = run_whole(chain, options, 0.2);
    const Ending two = run_on_ranks(chain, cut_along(chain, 0, 2), 2, options, 0.2);
    ASSERT_TRUE(two.outcome.ok()) << two.outcome.what;
    EXPECT_NEAR(static_cast<double>(two.report.steps), static_cast<double>(one.report.steps), 1.0);
    EXPECT_LE(difference(two.positions, one.positions), 1e-8);
    const EnergyReport &a = one.report.energy, &b = two.report.energy;
    EXPECT_NEAR(b.work_of_supports, a.work_of_supports, 1e-7 * a.scale);
    EXPECT_NEAR(b.work_of_forces, a.work_of_forces, 1e-7 * a.scale);
  }
}

/// Springs, bendings, energies that depend on time, and forces of tuples act between points of several ranks.
TEST(CutIslands, ForcesReachFromRankToRank) {
  const std::size_t count = 9;
  System damped = scenes::make_damped_chain(count), bent = scenes::make_shaken_chain(count), pulled = make_chain(count),
         loose = make_net(5, 4);
  Bendings bendings{.name = "bendings", .triples = {}, .law = BendingLaw::Cosine, .stiffness = 0.02};
  Potential potential{.name = "energies",
                      .points = {},
                      .kernel = formula_potential("(1 + 0.5*sin(9*t))*((x2 - x1)^2 + (y2 - y1)^2 + (z2 - z1)^2)", 2)};
  FormulaForce formula{.name = "twists",
                       .points = {},
                       .kernel = formula_tuple_force(
                           std::vector<std::string>{"0", "0.1*(z2 - z1)", "0.05*vx2", "0.02*x1", "0", "-0.03*vz1"}),
                       .tuples = {}};
  for (Index k = 1; k + 2 <= static_cast<Index>(count); ++k) {
    bendings.triples.push_back({k, k + 1, k + 2});
    potential.points.push_back({k, k + 2});
    formula.tuples.push_back({k, k + 1});
  }
  bent.forces.push_back(bendings);
  pulled.forces.push_back(potential);
  pulled.forces.push_back(formula);
  const Rods rods = std::get<Rods>(loose.constraints[0]);
  loose.constraints.clear();  // springs alone
  loose.forces.push_back(Springs{"springs", rods.pairs, 40.0, 0.3, 0.1});
  for (const System& system : {damped, bent, pulled, loose}) {
    const MotionOptions options = options_of(Method::Dop853);
    const Ending one = run_whole(system, options, 0.2);
    ASSERT_TRUE(one.outcome.ok()) << one.outcome.what;
    for (const int num_ranks : {2, 3}) {
      const Ending many = run_on_ranks(system, cut_along(system, 0, num_ranks), num_ranks, options, 0.2);
      ASSERT_TRUE(many.outcome.ok()) << many.outcome.what;
      EXPECT_NEAR(static_cast<double>(many.report.steps), static_cast<double>(one.report.steps), 1.0);
      EXPECT_LE(difference(many.positions, one.positions), 1e-8);
      EXPECT_LE(difference(many.accelerations, one.accelerations), 1e-7);
      const EnergyReport &a = one.report.energy, &b = many.report.energy;
      EXPECT_NEAR(b.now, a.now, 1e-8 * a.scale);
      EXPECT_NEAR(b.work_of_supports, a.work_of_supports, 1e-7 * a.scale);
      EXPECT_NEAR(b.work_of_forces, a.work_of_forces, 1e-7 * a.scale);
      EXPECT_NEAR(b.work_of_potentials, a.work_of_potentials, 1e-7 * a.scale);
    }
  }
}

TEST(CutIslands, RodsThatDependEndAllRanksWithOneMessage) {
  System flat = scenes::make_grid({6, 6, 1});  // a straight row of rods between two supports is redundant
  flat.supports = {{"ends", {0, 5}, {}}};
  const Ending ending = run_on_ranks(flat, cut_along(flat, 0, 2), 2, options_of(Method::Dop853), 0.0);
  EXPECT_EQ(ending.outcome.status, Status::Singular);
  EXPECT_NE(ending.outcome.what.find("depend"), std::string::npos) << ending.outcome.what;
}

/// Elimination leaves rounding of either sign in the row that is cut.
TEST(CutIslands, StraightRowBetweenSupportsIsSingularWhereverItIsCut) {
  constexpr Index num_points = 9;
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> mass(0.5, 2.0);
  for (int draw = 0; draw < 20; ++draw) {
    System row;
    Rods rods{.name = "rods"};
    for (Index i = 0; i < num_points; ++i) {
      row.positions.insert(row.positions.end(), {0.3 * i, 0.0, 0.0});
      row.masses.push_back(mass(generator));
      if (i > 0) rods.pairs.push_back({i - 1, i});
    }
    row.velocities.assign(row.positions.size(), 0.0);
    row.supports = {{"ends", {0, num_points - 1}, {}}};
    row.constraints = {rods};
    row.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
    std::vector<int> owner(num_points, 0);
    std::fill(owner.begin() + 2 + draw % 5, owner.end(), 1);

    const Ending ending = run_on_ranks(row, owner, 2, options_of(Method::Dop853), 0.0);

    EXPECT_EQ(ending.outcome.status, Status::Singular) << draw;
    EXPECT_NE(ending.outcome.what.find("depend"), std::string::npos) << ending.outcome.what;
  }
}

TEST(CutIslands, ForcesThatOneRankAloneCanComputeAreRefused) {
  System held = make_chain(6);  // what the support carries would be counted twice
  held.forces.push_back(
      Bendings{.name = "bendings", .triples = {{0, 2, 3}}, .law = BendingLaw::Cosine, .stiffness = 1});
  const auto take = [](const System& system) {
    ThreadWorld(2).run([&](Ranks& ranks) { (void)take_part(system, cut_along(system, 0, 2), ranks); });
  };
  EXPECT_THROW(take(held), InputError);
  System charged = make_chain(6), walled = make_chain(6);  // here the support is a charge as well
  charged.forces.push_back(PairForces{.name = "charges", .law = PairLaw::Coulomb, .charges = {1e-6}});
  walled.forces.push_back(PairForces{.name = "beads", .sigma = 0.05});  // the support is a bead as well
  EXPECT_THROW(take(charged), InputError);
  EXPECT_THROW(take(walled), InputError);
}

/// A table that ends at 0.05 s on one rank alone, of a support's motion, a length or a force, throws on all of them.
TEST(CutIslands, TableThatEndsOnOneRankEndsAllWithItsMessage) {
  const ScalarFunction ends = ScalarFunction::table({0.0, 0.02, 0.05}, {0.0, 0.0, 0.0}),
                       stays = ScalarFunction::table({0.0, 0.02, 0.05}, std::vector<double>(3, scenes::spacing));
  System shaken = make_chain(8), breathing = shaken, pushed = shaken;
  shaken.supports[0].displacement = {ends, 0.0, 0.0};
  std::get<Rods>(breathing.constraints[0]).length.functions.assign(8, scenes::spacing);
  std::get<Rods>(breathing.constraints[0]).length.constants.clear();
  std::get<Rods>(breathing.constraints[0]).length.functions.back() = stays;
  pushed.forces.push_back(ConstantForce{.name = "push", .points = {8}, .force = {ends, 0.0, 0.0}});
  const auto complain = [](const System& system, const MotionOptions& options, const std::vector<int>& owner,
                           int num_ranks) {
    std::vector<std::string> complaints(static_cast<std::size_t>(num_ranks));
    ThreadWorld(num_ranks).run([&](Ranks& ranks) {
      const RankSystem own = take_part(system, owner, ranks);
      Simulation simulation(own.system, own.part, options, one_thread());
      try {
        (void)simulation.advance_to(0.2);
      } catch (const InputError& error) {
        complaints[static_cast<std::size_t>(ranks.rank())] = error.where() + ": " + error.what();
      }
    });
    return complaints;
  };
  for (const System& system : {shaken, breathing, pushed}) {
    for (const MotionOptions& options : {options_of(Method::Dop853), options_of(Method::Rattle, 4e-3),
                                         options_of(Method::Taylor), options_of(Method::Rk4, 4e-3)}) {
      SCOPED_TRACE(name_of(options.method));
      const std::vector<int> whole(system.num_points(), 0);
      const std::string wanted = complain(system, options, whole, 1).front();
      const std::string what = wanted.substr(wanted.find(" is outside"));  // behind the time
      EXPECT_NE(what.find("0.05"), std::string::npos) << wanted;
      for (const std::string& found : complain(system, options, cut_along(system, 0, 3), 3))
        EXPECT_NE(found.find(what), std::string::npos) << found;
    }
  }
}

/// A run that two ranks saved continues on one and on four.
TEST(CutIslands, SavedMotionGoesOnOnAnyNumberOfRanks) {
  const System net = make_net(8, 5);
  for (const MotionOptions& options : {options_of(Method::Rattle, 1e-3), options_of(Method::Dop853)}) {
    std::vector<std::byte> progress;
    std::vector<double> positions(3 * net.num_points()), velocities(positions.size());
    const auto write = [](const RankSystem& own, std::span<const double> from, std::vector<double>* to) {
      for (std::size_t i = 0; i < own.num_owned; ++i)
        std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                    to->begin() + 3 * static_cast<std::ptrdiff_t>(own.points[i]));
    };
    ThreadWorld(2).run([&](Ranks& ranks) {
      const RankSystem own = take_part(net, cut_along(net, 0, 2), ranks);
      Simulation simulation(own.system, own.part, options, one_thread());
      ASSERT_TRUE(simulation.advance_to(0.04).ok());
      if (ranks.rank() == 0) progress = simulation.save_progress();
      write(own, simulation.positions(), &positions);
      write(own, simulation.velocities(), &velocities);
    });
    for (const Index support : net.supports[0].points)
      std::copy_n(net.positions.begin() + 3 * support, 3, positions.begin() + 3 * support);
    const Ending straight = run_whole(net, options, 0.08);
    for (const int num_ranks : {1, 4}) {
      std::vector<double> end(positions.size());
      std::size_t steps = 0;
      ThreadWorld(num_ranks).run([&](Ranks& ranks) {
        const RankSystem own = take_part(net, cut_along(net, 0, num_ranks), ranks);
        Simulation simulation(own.system, own.part, options, one_thread());
        std::vector<double> r, v;
        for (const Index point : own.points) {
          r.insert(r.end(), positions.begin() + 3 * point, positions.begin() + 3 * point + 3);
          v.insert(v.end(), velocities.begin() + 3 * point, velocities.begin() + 3 * point + 3);
        }
        simulation.restore_progress(progress, r, v);
        EXPECT_EQ(simulation.time(), 0.04);
        ASSERT_TRUE(simulation.advance_to(0.08).ok());
        write(own, simulation.positions(), &end);
        if (ranks.rank() == 0) steps = simulation.report().steps;
      });
      for (const Index support : net.supports[0].points)
        std::copy_n(net.positions.begin() + 3 * support, 3, end.begin() + 3 * support);
      EXPECT_LE(difference(end, straight.positions), 1e-8);
      EXPECT_NEAR(static_cast<double>(steps), static_cast<double>(straight.report.steps), 2.0);
    }
  }
}

}  // namespace
}  // namespace tanor
