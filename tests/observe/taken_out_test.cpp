#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <tanor/kernel.hpp>
#include <tanor/motion.hpp>
#include <tanor/warnings.hpp>

#include "errors.hpp"
#include "measures.hpp"
#include "observe/arguments.hpp"
#include "observe/cable.hpp"

namespace tanor {
namespace {

/// Three bobs of 1 kg hang from a hook and from two more ones, and a bead of 1 kg lies on a floor.
System make_hooks(const std::string& floor = "floor") {
  System system;
  RodGroup rods = system.add_rods("rods");
  for (const double x : {0.0, 1.0, 2.0}) {
    const Point top = system.add_point({.position = {x, 0.0, 0.0}, .mass = 1.0});
    rods.join(top, system.add_point({.position = {x, 0.0, -1.0}, .mass = 1.0}));
  }
  const Point bead = system.add_point({.position = {3.0, 0.0, 0.0}, .mass = 1.0});
  system.supports.push_back({.name = "hook", .points = {0}});
  system.supports.push_back({.name = "two", .points = {2, 4}});
  system.constraints.push_back(Planes{.name = floor, .points = {bead.index}, .normal = Vector3{0, 0, 1}});
  system.add_gravity({0.0, 0.0, -10.0});
  return system;
}

/// The support and the floor have one name, and the passage tells which of them went, also after a snapshot.
TEST(TakenOut, APassageTellsThePlaceOfWhatWent) {
  for (const auto& [when, place] : {std::pair("any load(hook).norm > 5", "supports/0/0"),
                                    {"force(hook).norm > 5", "constraints/1/0"},
                                    {"t > -1", "supports/1"}}) {
    const auto make = [&] {
      Simulation simulation(make_hooks("hook"));
      simulation.add_event(
          {.when = when, .action = EventAction::Release, .of = when[0] == 't' ? "two" : std::string()});
      simulation.add_event({.when = "t > 0.05"});
      return simulation;
    };
    Simulation simulation = make(), resumed = make();
    const Outcome outcome = simulation.advance_to(0.1);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    resumed.restore(simulation.save());
    for (const Simulation* const each : {&simulation, &resumed}) {
      ASSERT_EQ(each->passages().size(), 2u) << when;
      EXPECT_EQ(each->passages()[0].taken, place);
      EXPECT_EQ(each->passages()[1].taken, "") << "a report takes nothing";
    }
  }
}

TEST(TakenOut, WhyANumberIsNotKnownIsToldOfItsOwnThing) {
  Simulation simulation(make_hooks("hook"));
  for (const char* text : {"load(hook).z", "force(hook)"}) simulation.add_observable({.text = text});
  for (const char* when : {"load(hook).z < t - 10.1", "force(hook).z > 10.2 - t"})  // 10 N both
    simulation.add_event({.when = when, .action = EventAction::Release});
  ASSERT_TRUE(simulation.advance_to(0.3).ok());
  EXPECT_EQ(simulation.observe()[0].unknown, "released at t = 0.1");
  EXPECT_EQ(simulation.observe()[1].unknown, "released at t = 0.2");
}

/// A group names up to three members that went.
TEST(TakenOut, AGroupNamesItsMembersThatWent) {
  Simulation simulation(make_hooks());
  for (const char* text :
       {"tension(rods)", "max tension(rods)", "tension(rods[0]) + tension(rods[1])", "each load(two)"})
    simulation.add_observable({.text = text});
  const auto reasons = [&] {
    std::vector<std::string> list;
    for (const Observed& each : simulation.observe()) list.push_back(each.unknown);
    return list;
  };
  for (const auto& [when, of] : {std::pair("t > 0.1", "rods[1]"), {"t > 0.2", "rods[0]"}, {"t > 0.25", "two[1]"}})
    simulation.add_event({.when = when, .action = *of == 'r' ? EventAction::Break : EventAction::Release, .of = of});
  EXPECT_EQ(reasons(), std::vector<std::string>(4));
  ASSERT_TRUE(simulation.advance_to(0.3).ok());
  EXPECT_EQ(reasons(), (std::vector<std::string>{"rods[0] broken at t = 0.2, rods[1] broken at t = 0.1", "",
                                                 "rods[0] broken at t = 0.2, rods[1] broken at t = 0.1",
                                                 "two[1] released at t = 0.25"}));
  simulation.add_event({.when = "t > 0.4", .action = EventAction::Break, .of = "rods[2]"});
  ASSERT_TRUE(simulation.advance_to(0.5).ok());
  EXPECT_EQ(reasons()[1], "rods[0] broken at t = 0.2, rods[1] broken at t = 0.1, rods[2] broken at t = 0.4");
}

/// A formula whose terms are known and that has no value says so.
TEST(TakenOut, AFormulaWithoutAValueIsNotDefined) {
  Simulation simulation(make_hooks());
  for (const char* text : {"1/position(1).x", "sqrt(position(1).z)", "1/position(3).x"})
    simulation.add_observable({.text = text});
  const std::span<const Observed> found = simulation.observe();
  for (const std::size_t k : {0u, 1u}) {
    EXPECT_TRUE(std::isnan(found[k].values[0])) << k;
    EXPECT_EQ(found[k].unknown, "not defined") << k;
  }
  EXPECT_EQ(found[2].unknown, "");
}

/// An observer that looks at observables, as reports do, leaves what events do to their own instants.
TEST(TakenOut, ALookInsideAnAdvanceActsOnNothing) {
  Simulation simulation(make_hooks("hook"), {.method = Method::Rk4, .step = 1e-3}, {.threads = 1});
  for (const char* text : {"load(hook).z", "force(hook)"}) simulation.add_observable({.text = text});
  for (const char* when : {"load(hook).z < t - 10.1", "force(hook).z > 10.2 - t"})
    simulation.add_event({.when = when, .action = EventAction::Release});
  ASSERT_TRUE(simulation.advance_to(0.3, [&](const MotionReport&) { return !simulation.observe().empty(); }).ok());
  ASSERT_EQ(simulation.passages().size(), 2u);
  for (const Passage& passage : simulation.passages()) EXPECT_FALSE(passage.taken.empty()) << passage.time;
}

/// Series and equations agree on what is left, among several groups and in a net.
TEST(TakenOut, ASeriesLeavesOutWhatWent) {
  System system;
  constexpr Index side = 4;
  Rods rods{.name = "net"};
  for (Index i = 0; i < side * side; ++i) {
    const double x = i % side, y = i / side;
    (void)(i == 0 ? system.add_support({x, y, 0.0}) : system.add_point({{x, y, 0.0}}));
    if (i % side > 0) rods.pairs.push_back({i - 1, i});
    if (i >= side) rods.pairs.push_back({i - side, i});
  }
  const Index bead = system.add_point({{5.0, 0.0, 0.0}}).index, ball = system.add_point({{8.0, 0.0, 1.0}}).index;
  system.constraints = {
      Spheres{.name = "ball", .points = {ball}, .center = {8.0, 0.0, 0.0}}, rods,
      Planes{.name = "floor", .points = {bead}, .normal = {0.1, 0.0, 1.0}, .offset = 0.5},
      Lines{.name = "wire", .points = {side * side - 1}, .origin = {3.0, 3.0, 0.0}, .direction = {0.0, 0.0, 1.0}}};
  system.add_gravity({0.0, 0.0, -9.81});
  const auto fall = [&](Method method, const std::string& of, EventAction action) {
    Simulation simulation(system, {.method = method, .rtol = 1e-12, .atol = 1e-13}, {.threads = 1});
    simulation.add_event({.when = "t > 0.05", .action = action, .of = of});
    const Outcome outcome = simulation.advance_to(0.2);
    EXPECT_TRUE(outcome.ok()) << of << ": " << outcome.what;
    return std::vector<double>(simulation.positions().begin(), simulation.positions().end());
  };
  for (const auto& [of, action] : {std::pair{"net[7]", EventAction::Break},
                                   {"net[0]", EventAction::Break},
                                   {"ball", EventAction::Release},
                                   {"floor", EventAction::Release},
                                   {"wire", EventAction::Release}})
    EXPECT_LT(largest_difference(fall(Method::Taylor, of, action), fall(Method::Dop853, of, action)), 1e-9) << of;
}

/// Nothing of what went is evaluated, also if the start was corrected, if the motion begins late, if a guide turns or
/// is a formula with t that has corners, and after a snapshot.
TEST(TakenOut, WhatWentIsLeftOutWhateverItWas) {
  const auto fall = [](System system, double t_start, EventAction action, const std::string& of) {
    const Event event{.when = "t > " + std::to_string(t_start + 0.05), .action = action, .of = of};
    const auto make = [&] {
      Simulation simulation(system, {.start = StartMode::Project}, {}, t_start);
      simulation.add_event(event);
      return simulation;
    };
    Simulation simulation = make(), resumed = make();
    const Outcome outcome = simulation.advance_to(t_start + 0.1);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    resumed.restore(simulation.save());
    for (Simulation* const each : {&simulation, &resumed}) {
      const Outcome rest = each->advance_to(t_start + 0.2);
      ASSERT_TRUE(rest.ok()) << rest.what;
      EXPECT_LT(each->positions()[5], -0.09);  // half of g (0.15 s)^2 at least
      EXPECT_LT(each->report().violation.position, 1e-9);
      EXPECT_TRUE(each->certify().passed()) << each->certify().line();
    }
    EXPECT_EQ(std::vector<double>(simulation.positions().begin(), simulation.positions().end()),
              std::vector<double>(resumed.positions().begin(), resumed.positions().end()));
  };
  System system;
  const Point hook = system.add_support({0.0, 0.0, 0.0}), bob = system.add_point({.position = {1.0, 0.0, 0.0}});
  system.add_gravity({0.0, 0.0, -of_earth});
  const std::vector<std::array<Index, 2>> pair{{hook.index, bob.index}};
  system.constraints = {Rods{.name = "g", .pairs = pair, .length = 1.001}};
  fall(system, 0.0, EventAction::Break, "g[0]");
  system.constraints = {Rods{.name = "g", .pairs = pair, .length = ScalarFunction::formula("0.9+0.1*sqrt(t-1)")}};
  fall(system, 2.0, EventAction::Break, "g[0]");
  system.constraints = {Planes{.name = "g", .points = {bob.index}, .normal = Vector3{0.0, 1.0, 1.0}, .offset = 1e-5}};
  fall(system, 0.0, EventAction::Release, "g[0]");
  system.constraints = {Planes{
      .name = "g",
      .points = {bob.index},
      .normal = {ScalarFunction::formula("0"), ScalarFunction::formula("sin(t)"), ScalarFunction::formula("cos(t)")}}};
  fall(system, 0.0, EventAction::Release, "g[0]");
  system.constraints = {
      UserConstraints{.name = "g", .tuples = {{bob.index}}, .kernel = formula_constraint("z1-0.01*abs(sin(30*t))", 1)}};
  fall(system, 0.0, EventAction::Release, "g[0]");
}

/// The tensions of a line of rods between supports are not determined, whoever is asked.
TEST(TakenOut, ForcesThatPrestressLeavesOpenAreNotKnown) {
  System system;
  const Point left = system.add_support({0.0, 0.0, 0.0}), middle = system.add_point({.position = {1.0, 0.0, 0.0}}),
              right = system.add_support({2.0, 0.0, 0.0}), bob = system.add_point({.position = {1.0, 0.0, -1.0}});
  RodGroup rods = system.add_rods("rods");
  rods.join(left, middle);
  rods.join(middle, right);
  rods.join(middle, bob);
  system.add_gravity({0.0, 0.0, -of_earth});
  Simulation simulation(system);
  Dynamics dynamics(system);
  for (const Solution& at : {simulation.solution(), dynamics.solution({.positions = system.positions})}) {
    EXPECT_TRUE(std::isnan(at.multipliers[0]) && std::isnan(at.multipliers[1]));
    EXPECT_TRUE(std::isfinite(at.multipliers[2]));
    EXPECT_TRUE(std::isnan(at.support_forces[2]));
  }
  EXPECT_TRUE(std::isnan(simulation.multipliers()[0]));
  EXPECT_NEAR(simulation.multipliers()[2], -of_earth, 1e-12);
}

/// Nothing is known of the forces of what is gone as a whole, and what is left of an entry has its own.
TEST(TakenOut, ForcesOfSupportsThatAreGoneAreNotKnown) {
  Simulation simulation(make_hooks());
  for (const char* text : {"load(hook)", "moment(hook, y)", "load(two).z", "moment(two, y)", "each load(two)"})
    simulation.add_observable({.text = text});
  for (const auto& [when, of] : {std::pair("t > 0.1", "two[0]"), {"t > 0.2", "two[1]"}, {"t > 0.2", "hook"}})
    simulation.add_event({.when = when, .action = EventAction::Release, .of = of});
  const auto values = [&](std::size_t k) { return simulation.observe()[k].values; };
  EXPECT_NEAR(values(2)[0], -20.0, 1e-12);
  EXPECT_NEAR(values(3)[0], -30.0, 1e-12);
  ASSERT_TRUE(simulation.advance_to(0.15).ok());
  EXPECT_NEAR(values(2)[0], -10.0, 1e-12);
  EXPECT_NEAR(values(3)[0], -20.0, 1e-12);
  EXPECT_TRUE(std::isnan(values(4)[2]));
  EXPECT_NEAR(values(4)[5], -10.0, 1e-12);
  ASSERT_TRUE(simulation.advance_to(0.3).ok());
  ASSERT_EQ(simulation.passages().size(), 3u);
  for (std::size_t k = 0; k < 5; ++k)
    for (const double value : values(k)) EXPECT_TRUE(std::isnan(value)) << simulation.observe()[k].name;
  EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
}

/// A rod without a length that its points could have: there is no start, and no number of it.
TEST(TakenOut, NoNumberIsKnownBeforeAStart) {
  System system = make_cable(2);
  system.constraints.push_back(Rods{.name = "long", .pairs = {{0, 2}}, .length = 7.0});
  Simulation simulation(system, {.start = StartMode::Project});
  ASSERT_FALSE(simulation.outcome().ok());
  for (const char* text : {"load(hook)", "max tension(links)", "2*kinetic()"})
    simulation.add_observable({.text = text});
  for (const Observed& each : simulation.observe())
    for (const double value : each.values) EXPECT_TRUE(std::isnan(value)) << each.name;
}

/// The rank falls where the rod breaks, not where the next step ends.
TEST(TakenOut, TheRankChangesWhereARodBreaks) {
  Simulation simulation(make_cable(3), {.method = Method::Rattle, .step = 0.01});
  simulation.add_event({.when = "t > 0.033", .action = EventAction::Break, .of = "links[2]"});
  ASSERT_TRUE(simulation.advance_to(0.1).ok());
  const RankChanges& changes = simulation.report().rank_changes;
  ASSERT_EQ(changes.count, 1u);
  EXPECT_EQ(changes.first[0].time, simulation.passages()[0].time);
  EXPECT_EQ(changes.first[0].rank, 2u);
  EXPECT_EQ(changes.start, 3u);
  EXPECT_EQ(changes.now, 2u);
}

TEST(TakenOut, SupportsOfOneNameAreToldSo) {
  System system;
  for (int k = 0; k < 4; ++k) system.add_point({.position = {1.0 * k, 0.0, 0.0}});
  for (const char* name : {"hook", "support3", "hook", ""})
    system.supports.push_back({.name = name, .points = {static_cast<Index>(system.supports.size())}});
  EXPECT_TRUE(default_observables(system).empty());
  const std::string left_out = " too, so that their loads are not observed by themselves";
  EXPECT_EQ(find_warnings(system),
            (std::vector<std::string>{"supports/2: 'hook' is the name of supports/0" + left_out,
                                      "supports/3: 'support3' is the name of supports/1" + left_out}));
  for (const std::string& warning : find_warnings(system))
    EXPECT_EQ(std::ranges::count(Simulation(system).plan().left_out, warning), 1);
}

TEST(TakenOut, DefaultsOfManyGroupsAreOneOfEach) {
  constexpr std::size_t count = 300;
  System system;
  for (std::size_t k = 0; k < count; ++k) {
    const auto point = static_cast<Index>(2 * k);
    for (const double z : {0.0, -1.0}) system.add_point({.position = {1.0 * static_cast<double>(k), 0.0, z}});
    const std::string number = std::to_string(k);
    system.supports.push_back({.name = "hook" + number, .points = {point}});
    system.constraints.push_back(Rods{.name = "rod" + number, .pairs = {{point, point + 1}}});
  }
  Solution at;
  at.positions = system.positions;
  at.multipliers.resize(count);
  for (auto* array : {&at.velocities, &at.reactions, &at.support_forces}) array->resize(at.positions.size());
  const std::vector<Observable> wanted = default_observables(system);
  EXPECT_EQ(observe(system, wanted, at).size(), 2 * count);
}

/// Half of the members of a group are gone, and the others keep their numbers.
TEST(TakenOut, HalfOfAGroupIsLeft) {
  constexpr std::size_t count = 300;
  System system;
  Springs springs{.name = "springs", .stiffness = 1.0};
  std::vector<double> lengths;
  std::vector<detail::Thing> gone;
  for (std::size_t k = 0; k < 2 * count; ++k) {
    springs.pairs.push_back({0, static_cast<Index>(k + 1)});
    lengths.push_back(static_cast<double>(k));
    if (k % 2 == 0) gone.push_back({detail::Thing::List::Forces, 0, k});
  }
  springs.rest_length = lengths;
  system.forces.push_back(springs);
  const System left = detail::Things(system, gone).what_is_left();
  const auto& rest = std::get<Springs>(left.forces[0]);
  ASSERT_EQ(rest.pairs.size(), count);
  EXPECT_EQ(rest.pairs[1][1], 4);
  EXPECT_EQ(rest.rest_length.constants[1], 3.0);
}

/// A bob hangs on a point that prestress holds. It falls when its rod breaks, and the point stays held; `any` knows no
/// member of the line.
TEST(TakenOut, APointThatPrestressHeldStaysHeld) {
  System system;
  RodGroup line = system.add_rods("line"), hanger = system.add_rods("hanger");
  const Point left = system.add_support({0.0, 0.0, 0.0}), right = system.add_support({2.0, 0.0, 0.0});
  const Point middle = system.add_point({.position = {1.0, 0.0, 0.0}, .mass = 1.0});
  const Point bob = system.add_point({.position = {1.0, 0.0, -1.0}, .mass = 1.0});
  line.join(left, middle);
  line.join(middle, right);
  hanger.join(middle, bob);
  system.add_gravity({0.0, 0.0, -10.0});
  Simulation simulation(system);
  simulation.add_event({.when = "any tension(line) > 100", .action = EventAction::Break});
  simulation.add_event({.when = "t > 0.1", .action = EventAction::Break, .of = "hanger[0]"});
  simulation.add_observable({.text = "tension(hanger[0])"});
  simulation.add_observable({.text = "tension(line)"});
  EXPECT_THROW((void)simulation.add_event({.when = "max tension(line) > 100"}), InputError);
  const Outcome outcome = simulation.advance_to(0.3);
  ASSERT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_NEAR(simulation.positions()[11], -1.0 - 0.5 * 10.0 * 0.04, 1e-12);
  EXPECT_EQ(simulation.positions()[8], 0.0);
  EXPECT_EQ(simulation.accelerations()[8], 0.0);
  EXPECT_EQ(simulation.observe()[0].unknown, "broken at t = 0.1");
  EXPECT_EQ(simulation.observe()[1].unknown, "left to a prestress");
  EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
}

}  // namespace
}  // namespace tanor
