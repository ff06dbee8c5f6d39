#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tanor/tanor.hpp>

#include "long_tests.hpp"
#include "scenes.hpp"

/// \file Many contacts that stick at once give way one after another: bent chains of beads and rods on a rough floor,
/// and beads on a rough line that springs join. The normal forces do not depend on friction there, so that at each
/// instant exactly one acceleration obeys the law (Moreau). No such run may end before its time.
///
///       o---o         o---o
///      /     \       /     \    o -> pulled
///     o       o---o-o       o--/
namespace tanor {
namespace {

using scenes::g;
constexpr double mu = 0.3, m = 0.1, L = 0.1;

enum class Bend { Wave, Zigzag, Arc };
enum class Pull { Support, SupportToAndFro, ForceThatGrows, ForceToAndFro };

/// Makes a bent chain whose last bead is a support, or is pulled by a force.
System make_dragged_chain(std::size_t count, Bend bend, Pull pull) {
  System system;
  Rods rods{"rods", {}, {}, {}};
  Planes floor{"floor", {}, Vector3{0.0, 0.0, 1.0}, 0.0};
  const bool has_support = pull == Pull::Support || pull == Pull::SupportToAndFro;
  double x = 0.0, y = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const auto index = static_cast<double>(k);
    system.positions.insert(system.positions.end(), {x, y, 0.0});
    system.masses.push_back(m);
    if (k > 0) rods.pairs.push_back({static_cast<Index>(k) - 1, static_cast<Index>(k)});
    if (!has_support || k + 1 < count) floor.points.push_back(static_cast<Index>(k));
    const double angle = bend == Bend::Wave     ? 0.9 * std::sin(0.45 * index)
                         : bend == Bend::Zigzag ? (k % 2 == 0 ? -0.6 : 0.6)
                                                : 4.7 * index / static_cast<double>(count);
    x += L * std::cos(angle);
    y += L * std::sin(angle);
  }
  system.velocities.assign(3 * count, 0.0);
  const auto last = static_cast<Index>(count - 1);
  const double weight = mu * m * g * static_cast<double>(count);
  const auto pull_with = [&](const std::string& force) {
    system.forces.push_back(ConstantForce{"pull", {last}, VectorFunction{ScalarFunction::formula(force), 0.0, 0.0}});
  };
  system.forces = {Gravity{"", {0.0, 0.0, -g}}};
  if (pull == Pull::Support)
    system.supports = {{"hand", {last}, VectorFunction{ScalarFunction::formula("0.2*t*t/(1+t)"), 0.0, 0.0}}};
  if (pull == Pull::SupportToAndFro)
    system.supports = {{"hand", {last}, VectorFunction{ScalarFunction::formula("0.2*(1-cos(2*t))"), 0.0, 0.0}}};
  if (pull == Pull::ForceThatGrows) pull_with(std::to_string(0.5 * weight) + "*t");
  if (pull == Pull::ForceToAndFro) pull_with(std::to_string(1.2 * weight) + "*sin(2*t)");
  system.constraints = {rods, floor};
  system.friction = {Coulomb{.name = "", .at = {"floor"}, .coefficient = mu}};
  return system;
}

void expect_to_arrive(const System& system, const MotionOptions& options, double t_end, std::size_t least_events) {
  Simulation simulation(system, options);

  ASSERT_TRUE(simulation.advance_to(t_end).ok()) << simulation.outcome().what;

  EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-8);
  EXPECT_LT(simulation.report().energy.work_of_friction, 0.0);
  EXPECT_GE(simulation.report().events, least_events);
  // Rods and floor hold.
  const auto r = simulation.positions();
  for (std::size_t k = 0; k + 1 < system.masses.size(); ++k) {
    EXPECT_NEAR(std::hypot(r[3 * k + 3] - r[3 * k], r[3 * k + 4] - r[3 * k + 1]), L, 1e-9);
    EXPECT_NEAR(r[3 * k + 2], 0.0, 1e-9);
  }
}

TEST(DraggedChain, ABentChainOnAFloorIsDrawnByItsEnd) {
  for (const std::size_t count : {20u, 30u, 50u}) {
    if (count == 50 && !tests_are_long()) continue;
    for (const Bend bend : {Bend::Wave, Bend::Zigzag, Bend::Arc}) {
      SCOPED_TRACE(std::to_string(count) + " beads, bend " + std::to_string(static_cast<int>(bend)));
      expect_to_arrive(make_dragged_chain(count, bend, Pull::Support), {}, 5.0, 10);
    }
  }
}

TEST(DraggedChain, TwoHundredBeadsAreDrawnForFiveSeconds) {
  const bool is_long = tests_are_long();
  const std::size_t count = is_long ? 200 : 100;
  expect_to_arrive(make_dragged_chain(count, Bend::Wave, Pull::Support), {}, is_long ? 5.0 : 1.0, 10);
}

TEST(DraggedChain, AForceThatGrowsFreesOneBeadAfterTheOther) {
  for (const Bend bend : {Bend::Wave, Bend::Zigzag, Bend::Arc}) {
    SCOPED_TRACE("bend " + std::to_string(static_cast<int>(bend)));
    expect_to_arrive(make_dragged_chain(20, bend, Pull::ForceThatGrows), {}, 3.0, 10);
  }
}

TEST(DraggedChain, ChainsPulledToAndFroStopAndLeaveAgain) {
  for (const Method method : {Method::Auto, Method::Dopri5}) {
    for (const Pull pull : {Pull::SupportToAndFro, Pull::ForceToAndFro}) {
      for (const std::size_t count : {12u, 20u}) {
        if (count > 12 && (method == Method::Dopri5 || !tests_are_long())) continue;
        for (const Bend bend : {Bend::Wave, Bend::Zigzag, Bend::Arc}) {
          SCOPED_TRACE(std::to_string(count) + " beads, bend " + std::to_string(static_cast<int>(bend)) + ", pull " +
                       std::to_string(static_cast<int>(pull)) + ", " + std::string(name_of(method)));
          expect_to_arrive(make_dragged_chain(count, bend, pull), {.method = method, .rtol = 1e-10}, 2.5, 10);
        }
      }
    }
  }
}

/// The rods keep their angles of about 0.6 rad, so that K is far from losing rank all the way.
TEST(DraggedChain, ContactsThatSlideAreNoSingularConfigurations) {
  for (const Pull pull : {Pull::Support, Pull::SupportToAndFro}) {
    Simulation simulation(make_dragged_chain(12, Bend::Zigzag, pull),
                          {.method = Method::Dop853, .rtol = 1e-9, .atol = 1e-12});

    ASSERT_TRUE(simulation.advance_to(1.0).ok()) << simulation.outcome().what;

    EXPECT_GE(simulation.report().events, 10U);
    EXPECT_EQ(simulation.report().singular_passages.count, 0U);
  }
}

TEST(DraggedChain, MethodsAgreeOnWhereItEnds) {
  const System system = make_dragged_chain(12, Bend::Arc, Pull::Support);
  Simulation one(system, {.method = Method::Dopri5, .rtol = 1e-9}),
      other(system, {.method = Method::Dop853, .rtol = 1e-10});

  ASSERT_TRUE(one.advance_to(2.0).ok()) << one.outcome().what;
  ASSERT_TRUE(other.advance_to(2.0).ok()) << other.outcome().what;

  for (std::size_t i = 0; i < 36; ++i) EXPECT_NEAR(one.positions()[i], other.positions()[i], 1e-6) << i;
}

TEST(DraggedChain, FiftyBeadsThatSpringsJoinArePulledToAndFroOnALine) {
  for (const double stiffness : {20.0, 100.0, 1000.0}) {
    constexpr std::size_t count = 50;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> mass(0.05, 0.15);
    System system;
    Lines line{"line", {}, Vector3{}, Vector3{1.0, 0.0, 0.0}};
    Springs springs{"", {}, stiffness, 0.0, L};
    for (std::size_t k = 0; k < count; ++k) {
      system.positions.insert(system.positions.end(), {L * static_cast<double>(k), 0.0, 0.0});
      system.masses.push_back(mass(random));
      line.points.push_back(static_cast<Index>(k));
      if (k > 0) springs.pairs.push_back({static_cast<Index>(k) - 1, static_cast<Index>(k)});
    }
    system.velocities.assign(3 * count, 0.0);
    system.constraints = {line};
    system.forces = {
        Gravity{"", {0.0, 0.0, -g}}, springs,
        ConstantForce{"pull", {count - 1}, VectorFunction{ScalarFunction::formula("3.5*sin(3*t)"), 0.0, 0.0}}};
    system.friction = {Coulomb{.name = "", .at = {"line"}, .coefficient = mu}};
    Simulation simulation(system, {.rtol = 1e-10});

    ASSERT_TRUE(simulation.advance_to(5.0).ok()) << stiffness << ": " << simulation.outcome().what;

    EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-8) << stiffness;
    EXPECT_GE(simulation.report().events, 50u);
  }
}

}  // namespace
}  // namespace tanor
