/// Implicit methods on several ranks: whole islands move as on one rank, and every rank takes the same branches.

#include <cmath>
#include <optional>
#include <utility>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "dynamics/forms.hpp"
#include "motion/implicit_step.hpp"
#include "ranks/on_ranks.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

constexpr std::size_t points_of_pendulum = 3;
constexpr double stiffness = 1e6, damping = 1e3;

/// Makes double pendulums of three sorts in turn: a rod and a stiff spring, two rods and a soft spring, two stiff
/// springs without any constraint. They start level, so that no spring has to be stretched.
System make_pendulums(std::size_t count) {
  System system;
  Rods rods{"rods", {}, {}, {}};
  Springs springs{"springs", {}, stiffness, damping, scenes::spacing}, soft{"soft", {}, 3.0, 0.0, scenes::spacing};
  Support ceiling{"ceiling", {}, {}};
  for (std::size_t k = 0; k < count; ++k) {
    const double x = 2.0 * static_cast<double>(k), angle = 0.5 * static_cast<double>(k);
    const double dx = scenes::spacing * std::cos(angle), dy = scenes::spacing * std::sin(angle);
    const Index top = scenes::add_point({x, 0, 0}, &system);
    scenes::add_point({x + dx, dy, 0}, &system);
    scenes::add_point({x + 2.0 * dx, 2.0 * dy, 0}, &system);
    system.masses.back() *= 1.0 + 0.2 * static_cast<double>(k);
    ceiling.points.push_back(top);
    (k % 3 < 2 ? rods.pairs : springs.pairs).push_back({top, top + 1});
    (k % 3 == 1 ? rods.pairs : springs.pairs).push_back({top + 1, top + 2});
    if (k % 3 == 1) soft.pairs.push_back({top, top + 2});
  }
  system.supports = {ceiling};
  system.constraints = {rods};
  system.forces = {Gravity{"", {0, 0, -scenes::g}}, springs, soft};
  return system;
}

/// Gives whole pendulums to the ranks in turn. Of three ranks the last one has no constraint.
std::vector<int> give_whole(const System& system, int num_ranks) {
  std::vector<int> owner(system.num_points());
  for (std::size_t i = 0; i < owner.size(); ++i) owner[i] = static_cast<int>(i / points_of_pendulum) % num_ranks;
  return owner;
}

MotionOptions implicit_options(Method method) {
  MotionOptions options = options_of(method, method == Method::GeneralizedAlpha ? 2e-3 : 0.0);
  options.rtol = 1e-7;
  options.atol = 1e-9;
  return options;
}

/// Expects the same steps and the same end on two and three ranks as on one.
void expect_same_on_ranks(const System& system, const MotionOptions& options, double t_end, double allowed) {
  const Ending one = run_whole(system, options, t_end);
  ASSERT_TRUE(one.outcome.ok()) << one.outcome.what;
  for (const int num_ranks : {2, 3}) {
    SCOPED_TRACE(num_ranks);
    const Ending many = run_on_ranks(system, give_whole(system, num_ranks), num_ranks, options, t_end);
    ASSERT_TRUE(many.outcome.ok()) << many.outcome.what;
    EXPECT_EQ(many.report.method, one.report.method);
    EXPECT_EQ(many.report.steps, one.report.steps);
    EXPECT_EQ(many.report.rejected, one.report.rejected);
    EXPECT_LE(difference(many.positions, one.positions), allowed);
    EXPECT_LE(difference(many.velocities, one.velocities), 10.0 * allowed);
    EXPECT_NEAR(many.report.energy.now, one.report.energy.now, 10.0 * allowed * one.report.energy.scale);
  }
}

TEST(ImplicitIslands, MoveAsOnOneRank) {
  const System system = make_pendulums(6);
  expect_same_on_ranks(system, implicit_options(Method::Radau5), 0.3, 1e-10);
  expect_same_on_ranks(system, implicit_options(Method::GeneralizedAlpha), 0.1, 1e-10);
}

/// The support moves, and a damper loses energy: ranks sum the works.
TEST(ImplicitIslands, WorkIsThatOfOneRank) {
  System system = make_pendulums(4);
  std::get<Springs>(system.forces[2]).damping = 0.2;
  system.supports[0].displacement = {ScalarFunction::formula("0.01*(1-cos(20*t))"), ScalarFunction(0.0),
                                     ScalarFunction(0.0)};
  for (const Method method : {Method::Radau5, Method::GeneralizedAlpha}) {
    const Ending one = run_whole(system, implicit_options(method), 0.1),
                 two = run_on_ranks(system, give_whole(system, 2), 2, implicit_options(method), 0.1);
    const EnergyReport &a = one.report.energy, &b = two.report.energy;
    EXPECT_GT(std::abs(a.work_of_supports), 1e-3 * a.scale);
    EXPECT_GT(std::abs(a.work_of_forces), 1e-5 * a.scale);
    EXPECT_NEAR(b.work_of_supports, a.work_of_supports, 1e-8 * a.scale);
    EXPECT_NEAR(b.work_of_forces, a.work_of_forces, 1e-8 * a.scale);
  }
}

TEST(ImplicitIslands, AutoChoosesAsOnOneRank) {
  const System system = make_pendulums(6);
  MotionOptions options = implicit_options(Method::Auto);
  expect_same_on_ranks(system, options, 0.1, 1e-10);
  EXPECT_EQ(run_whole(system, options, 0.0).report.method, Method::Radau5);
  options.step = 2e-3;
  expect_same_on_ranks(system, options, 0.05, 1e-10);
  EXPECT_EQ(run_whole(system, options, 0.0).report.method, Method::GeneralizedAlpha);

  // The stiff springs lie on one rank of two, which names them to the other.
  std::vector<int> owner = give_whole(system, 3);
  for (int& rank : owner) rank = rank == 1 ? 1 : 0;
  EXPECT_EQ(run_on_ranks(system, owner, 2, options, 0.0).report.method_reason.rfind("stiff: springs swings by", 0), 0u);
}

/// Makes two soft pendulums and a point that falls through a strong drag, of which no spring tells.
System make_honey() {
  System system = make_pendulums(2);
  system.forces[1] = Springs{"springs", std::get<Springs>(system.forces[1]).pairs, 30.0, 0.0, scenes::spacing};
  const Index drop = scenes::add_point({9, 0, 0}, &system);
  system.forces.push_back(Drag{.name = "honey", .points = {drop}, .linear = 1e6});
  return system;
}

TEST(ImplicitIslands, StiffnessIsDetectedOnTheWay) {
  const System system = make_honey();
  MotionOptions options = options_of(Method::Auto);
  options.rtol = 1e-6;
  const Ending one = run_whole(system, options, 0.2),
               two = run_on_ranks(system, part_the_last(system, 0), 2, options, 0.2);
  ASSERT_TRUE(two.outcome.ok()) << two.outcome.what;
  EXPECT_EQ(one.report.method, Method::Radau5) << one.report.method_reason;
  EXPECT_EQ(two.report.method, Method::Radau5);
  EXPECT_EQ(two.report.steps, one.report.steps);
  EXPECT_EQ(two.report.rejected, one.report.rejected);
  EXPECT_LE(difference(two.positions, one.positions), 1e-8);
}

/// Newton's matrix does not know pair forces. Those of one rank keep all of them from a trial step.
TEST(ImplicitIslands, PairForcesOfOneRankRuleOutTrials) {
  System system = make_honey();
  system.forces.push_back(PairForces{.name = "beads", .points = {1, 2}, .epsilon = 1e-3, .sigma = 0.01});
  MotionOptions options = options_of(Method::Auto);
  options.rtol = 1e-6;
  const Ending one = run_whole(system, options, 1e-3),
               two = run_on_ranks(system, part_the_last(system, 0), 2, options, 1e-3);
  ASSERT_TRUE(two.outcome.ok()) << two.outcome.what;
  EXPECT_GT(one.report.steps, 500u);
  EXPECT_FALSE(traits_of(one.report.method).is_implicit);
  EXPECT_EQ(two.report.method, one.report.method);
}

TEST(ImplicitIslands, ViolationIsTheLargestOfAllRanks) {
  ThreadWorld(2).run([](Ranks& ranks) {
    Forms forms(scenes::make_pendulum(), one_thread(), 0.0, {}, &ranks);
    ImplicitStep implicit({}, *forms.main);
    const Model& model = forms.model;
    std::vector<double> r(3 * model.num_points()), xi(model.num_rows());
    model.numbering.gather_points(model.system.positions, r);
    r[0] *= ranks.rank() == 0 ? 1.0 : 1.01;
    const double violation = implicit.evaluate_positions(0.0, r.data(), xi.data());
    EXPECT_GT(violation, 1e-3);
    EXPECT_EQ(forms.main->largest(violation), violation);
    EXPECT_EQ(-forms.main->largest(-violation), violation);
  });
}

/// A force that ends at some time, on one rank alone, ends the motion on all of them.
TEST(ImplicitIslands, FailureOfOneRankEndsAll) {
  System system = make_pendulums(4);
  system.forces.push_back(FormulaForce{"ends", {1}, formula_force({"sqrt(0.05 - t)", "0", "0"})});
  for (const Method method : {Method::Radau5, Method::GeneralizedAlpha}) {
    const Ending one = run_whole(system, implicit_options(method), 0.1);
    const Ending two = run_on_ranks(system, give_whole(system, 2), 2, implicit_options(method), 0.1);
    EXPECT_FALSE(one.outcome.ok());
    EXPECT_EQ(two.outcome.status, one.outcome.status) << two.outcome.what;
    EXPECT_NEAR(two.report.time, one.report.time, 1e-6);
  }
}

/// A step begins with Newton's matrix at its end, where the table of one rank has no value.
TEST(ImplicitIslands, TableThatEndsOnOneRankEndsAllWithItsMessage) {
  System system = make_pendulums(2);
  Rods& rods = std::get<Rods>(system.constraints[0]);
  Rods breathing{"breathing", {rods.pairs.front()}, {}, {}};
  rods.pairs.erase(rods.pairs.begin());
  breathing.length.functions = {
      ScalarFunction::table({0.0, 0.02, 0.05}, {scenes::spacing, scenes::spacing, scenes::spacing})};
  system.constraints.emplace_back(breathing);
  ThreadWorld(2).run([&](Ranks& ranks) {
    const RankSystem own = take_part(system, give_whole(system, 2), ranks);
    MotionOptions options = implicit_options(Method::GeneralizedAlpha);
    options.step = 0.1;
    Simulation simulation(own.system, own.part, options, one_thread());
    EXPECT_THROW((void)simulation.advance_to(0.2), InputError);
  });
}

/// The support of the first rank ends its motion. The second one has none that moves.
TEST(ImplicitIslands, SupportWhoseTableEndsOnOneRankEndsAllWithItsMessage) {
  System system = make_pendulums(2);
  system.supports = {{"shaken", {0}, {}}, {"still", {3}, {}}};
  system.supports[0].displacement = {ScalarFunction::table({0.0, 0.02, 0.05}, {0.0, 0.0, 0.0}), 0.0, 0.0};
  for (MotionOptions options :
       {implicit_options(Method::GeneralizedAlpha), implicit_options(Method::Radau5), options_of(Method::Dop853),
        options_of(Method::Rattle, 1e-4), options_of(Method::Auto)}) {
    SCOPED_TRACE(name_of(options.method));
    int num_told = 0;
    ThreadWorld(2).run([&](Ranks& ranks) {
      const RankSystem own = take_part(system, give_whole(system, 2), ranks);
      Simulation simulation(own.system, own.part, options, one_thread());
      try {
        (void)simulation.advance_to(0.1);
      } catch (const InputError& error) {
        if (ranks.rank() == 1) ++num_told;
        EXPECT_NE(std::string(error.what()).find("0.05"), std::string::npos) << error.what();
      }
    });
    EXPECT_EQ(num_told, 1) << "the rank without a support that moves";
  }
}

/// With this unstable force a M - df/dx is exactly 0 in a step of 1/2 s, so that the factorization of the first rank
/// fails. Halves of the step are made on both.
TEST(ImplicitIslands, SingularMatrixOfOneRankRejectsTheStepOfAll) {
  System system = make_honey();
  system.masses.back() = 1.0;
  const auto top = static_cast<Index>(system.num_points() - 1);
  system.forces.back() = FormulaForce{"unstable", {top}, formula_force({"16*(x - 9)", "0", "0"})};
  MotionOptions options = options_of(Method::GeneralizedAlpha, 0.5);
  options.spectral_radius = 1.0;
  const Ending one = run_whole(system, options, 0.5),
               two = run_on_ranks(system, part_the_last(system, 0), 2, options, 0.5);
  EXPECT_GT(one.report.rejected, 0u);
  EXPECT_EQ(two.report.rejected, one.report.rejected);
  EXPECT_EQ(two.report.steps, one.report.steps);
  EXPECT_EQ(two.outcome.status, one.outcome.status);
  EXPECT_LE(difference(two.positions, one.positions), 1e-10);
}

/// Rods that turn by radians in a step: Newton's iteration stalls on the rank that has them.
TEST(ImplicitIslands, StallOfOneRankRejectsTheStepOfAll) {
  System system = make_pendulums(4);
  system.velocities.assign(system.positions.size(), 0.0);
  for (const std::size_t i : {4u, 5u}) system.velocities[3 * i + 2] = 2.0 * static_cast<double>(i - 3);
  MotionOptions options = implicit_options(Method::GeneralizedAlpha);
  options.step = 0.1;
  const Ending one = run_whole(system, options, 0.2);
  const Ending two = run_on_ranks(system, give_whole(system, 2), 2, options, 0.2);
  EXPECT_GT(one.report.rejected, 0u);
  EXPECT_EQ(two.report.rejected, one.report.rejected);
  EXPECT_EQ(two.report.steps, one.report.steps);
  EXPECT_EQ(two.outcome.status, one.outcome.status);
}

/// Runs two ranks to 0.1 s and on to 0.2 s; with `saves`, from what each of them saved at 0.1 s.
std::vector<double> run_two_ranks(const System& system, const MotionOptions& options, bool saves) {
  std::vector<double> end(3 * system.num_points());
  ThreadWorld(2).run([&](Ranks& ranks) {
    const RankSystem own = take_part(system, give_whole(system, 2), ranks);
    std::optional<Simulation> simulation(std::in_place, own.system, own.part, options, one_thread());
    ASSERT_TRUE(simulation->advance_to(0.1).ok());
    if (saves) {
      const std::vector<std::byte> saved = simulation->save();
      simulation.emplace(own.system, own.part, options, one_thread());
      simulation->restore(saved);
    }
    ASSERT_TRUE(simulation->advance_to(0.2).ok());
    for (std::size_t i = 0; i < own.num_owned; ++i)
      std::copy_n(simulation->positions().begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                  end.begin() + 3 * static_cast<std::ptrdiff_t>(own.points[i]));
  });
  return end;
}

TEST(ImplicitIslands, SavedMotionGoesOnToTheLastBit) {
  const System system = make_pendulums(4);
  for (const Method method : {Method::Radau5, Method::GeneralizedAlpha, Method::Auto}) {
    const MotionOptions options = implicit_options(method);
    EXPECT_EQ(run_two_ranks(system, options, true), run_two_ranks(system, options, false)) << name_of(method);
  }
}

/// The motion that two ranks saved continues on one and on three with new matrices.
TEST(ImplicitIslands, SavedMotionGoesOnOnAnyNumberOfRanks) {
  const System system = make_pendulums(6);
  const MotionOptions options = implicit_options(Method::Radau5);
  const Ending straight = run_whole(system, options, 0.2);
  std::vector<std::byte> progress;
  ThreadWorld(2).run([&](Ranks& ranks) {
    const RankSystem own = take_part(system, give_whole(system, 2), ranks);
    Simulation simulation(own.system, own.part, options, one_thread());
    ASSERT_TRUE(simulation.advance_to(0.1).ok());
    if (ranks.rank() == 0) progress = simulation.save_progress();
  });
  const Ending half = run_on_ranks(system, give_whole(system, 2), 2, options, 0.1);
  for (const int num_ranks : {1, 3}) {
    ThreadWorld(num_ranks).run([&](Ranks& ranks) {
      const RankSystem own = take_part(system, give_whole(system, num_ranks), ranks);
      Simulation simulation(own.system, own.part, options, one_thread());
      const auto pick = [&](const std::vector<double>& from) {
        std::vector<double> result;
        for (const Index point : own.points)
          result.insert(result.end(), from.begin() + 3 * point, from.begin() + 3 * point + 3);
        return result;
      };
      simulation.restore_progress(progress, pick(half.positions), pick(half.velocities));
      ASSERT_TRUE(simulation.advance_to(0.2).ok());
      const std::vector<double> end(simulation.positions().begin(), simulation.positions().end());
      EXPECT_LE(difference(end, pick(straight.positions)), 1e-6);
      EXPECT_NEAR(static_cast<double>(simulation.report().steps), static_cast<double>(straight.report.steps), 5.0);
    });
  }
}

/// Gives each chain of four beads to one rank.
std::vector<int> give_chains(const System& system, int num_ranks) {
  std::vector<int> owner(system.num_points());
  for (std::size_t i = 0; i < owner.size(); ++i) owner[i] = static_cast<int>(i / 4) % num_ranks;
  return owner;
}

std::string refusal(const System& system, const std::vector<int>& owner, Method method) {
  try {
    (void)run_on_ranks(system, owner, 2, implicit_options(method), 0.0);
  } catch (const InputError& error) {
    return error.where() + ": " + error.what();
  }
  return {};
}

TEST(ImplicitIslands, NewtonsMatrixDoesNotReachOverRanks) {
  const System chain = scenes::make_chain(8), melt = scenes::make_melt(4);
  System loose = chain;
  loose.constraints.clear();
  loose.forces.push_back(Springs{"springs", {{2, 3}, {3, 4}, {4, 5}}, 40.0, 0.0, scenes::spacing});
  for (const Method method : {Method::Radau5, Method::GeneralizedAlpha}) {
    const std::string wanted = "Newton's matrix of " + std::string(name_of(method));
    const auto expect_refusal = [&](const System& system, const std::vector<int>& owner, const std::string& what) {
      const std::string found = refusal(system, owner, method);
      EXPECT_NE(found.find(what + " join points of several ranks"), std::string::npos) << found;
      EXPECT_NE(found.find(wanted), std::string::npos) << found;
    };
    expect_refusal(chain, deal(chain, 2), "constraints");
    expect_refusal(loose, deal(loose, 2), "forces such as springs");
    expect_refusal(melt, give_chains(melt, 2), "pair forces");
  }
  MotionOptions options = implicit_options(Method::Auto);
  std::get<Springs>(loose.forces.back()).stiffness = 1e9;
  EXPECT_FALSE(traits_of(run_on_ranks(loose, deal(loose, 2), 2, options, 0.0).report.method).is_implicit);
}

/// One rank alone has a rough contact, which the implicit methods do not know. All ranks refuse it.
TEST(ImplicitIslands, FrictionOfOneRankIsRefusedOnAll) {
  System system = make_pendulums(4);
  system.constraints.push_back(Planes{.name = "wall", .points = {1}, .normal = {0, 1, 0}, .offset = 0.0});
  system.friction = {Coulomb{.name = "rust", .at = {"wall"}, .coefficient = 0.3}};
  const std::string found = refusal(system, give_whole(system, 2), Method::Radau5);
  EXPECT_NE(found.find("does not know friction (rust)"), std::string::npos) << found;
}

}  // namespace
}  // namespace tanor
