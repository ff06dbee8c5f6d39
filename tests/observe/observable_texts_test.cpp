/// Texts and names of observables: what is refused, what is shown without a word.

#include <gtest/gtest.h>

#include <tanor/motion.hpp>

#include "errors.hpp"
#include "observe/cable.hpp"

namespace tanor {
namespace {

TEST(Observables, BadTextsAreRefusedWithTheirPlace) {
  System system = make_cable(3);
  (void)system.add_rods("none");
  const auto refuse = [&](const std::string& text) {
    return error_of([&] { check_observable(system, {.text = text}); });
  };
  EXPECT_EQ(
      refuse("tenson(links)"),
      "formula \"tenson(links)\": column 1: 'tenson' is not known (did you mean tension?); known names: t, pi and "
      "the functions sqrt, exp, log, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, abs, min, max, and "
      "of things sum, each, any, tension, utilisation, force, moment, load, multiplier, reaction, friction, position, "
      "velocity, acceleration, distance, angle, energy, kinetic, potential, temperature, pressure, virial");
  EXPECT_EQ(refuse("max tenson(links)"),
            "formula \"max tenson(links)\": column 5: 'tenson' is no quantity (did you mean tension?)");
  EXPECT_EQ(
      refuse("max tension(lnks)"),
      "formula \"max tension(lnks)\": column 13: no constraints or forces are named 'lnks' (did you mean links?); "
      "there are links, none, gravity0");
  for (const std::string word : {"", "max ", "sum ", "each "})
    EXPECT_NE(refuse(word + "tension(none)").find("tension(none) has no members"), std::string::npos);
  EXPECT_EQ(refuse("tension(links[3])"),
            "formula \"tension(links[3])\": column 9: links has 3 members, counted from 0");
  EXPECT_EQ(refuse("moment(hook)"),
            "formula \"moment(hook)\": column 1: a moment needs an axis: moment(hook, z, [0, 0, 0])");
  EXPECT_EQ(refuse("pressure()"),
            "formula \"pressure()\": column 1: pressure needs a periodic cell, and the system has none");
  EXPECT_EQ(refuse("2*load(hook)"),
            "formula \"2*load(hook)\": column 3: a vector stands in a formula; take one of its parts, .x, .y, .z, or "
            ".norm");
  EXPECT_EQ(refuse("position(9)"), "formula \"position(9)\": column 10: there is no point 9; they are 0 to 3");
  EXPECT_EQ(refuse("tension(gravity0)"),
            "formula \"tension(gravity0)\": column 9: 'gravity0' has no tension; rods, ropes, pulleys, springs and "
            "bonds have "
            "one");
  EXPECT_NE(refuse("2*tension(links)").find("say max, min or sum"), std::string::npos);
  EXPECT_NE(refuse("load(hook).w").find("there is no part .w"), std::string::npos);
  EXPECT_NE(refuse("sinn(t)").find("'sinn' is not known (did you mean sin?)"), std::string::npos);
  EXPECT_NE(refuse("maxx tension(links)").find("'maxx' is not known (did you mean max?)"), std::string::npos);
  EXPECT_NE(refuse("lode(hook).z/2").find("'lode' is not known; known names: t, "), std::string::npos);
  EXPECT_NE(refuse("torque(hook)").find("'torque' is not known (did you mean moment?)"), std::string::npos);
  EXPECT_NE(refuse("sum(tension(links))").find("sum stands before a quantity"), std::string::npos);
  EXPECT_EQ(refuse("temperature"),
            "formula \"temperature\": column 1: temperature has no brackets behind it; temperature() is right");
  EXPECT_EQ(refuse("temperature(0)"),
            "formula \"temperature(0)\": column 1: temperature takes nothing in its brackets");
  EXPECT_EQ(
      refuse("tension(links[-1])"),
      "formula \"tension(links[-1])\": column 9: '-1' is no number of a member; those of links are counted from 0");
  EXPECT_NE(refuse("any tension(links)").find("conditions"), std::string::npos);
}

/// The whole condition is quoted, and columns are counted in it.
TEST(Observables, FaultsOfConditionsHaveTheirPlaceInAll) {
  const System system = make_cable(3);
  const auto refuse = [&](const std::string& when) { return error_of([&] { check_event(system, {.when = when}); }); };
  EXPECT_TRUE(refuse("5 < 1 + tenson(links[0])")
                  .starts_with("formula \"5 < 1 + tenson(links[0])\": column 9: 'tenson' is not known (did you mean "
                               "tension?); known"));
  EXPECT_EQ(refuse("t + > 5"), "formula \"t + > 5\": column 5: found '>', expected a number, a name or '('");
  EXPECT_EQ(refuse("5 < "), "formula \"5 < \": column 5: found the end, expected a number, a name or '('");
  EXPECT_TRUE(refuse("5 < 2*tension(lnks)").starts_with("formula \"5 < 2*tension(lnks)\": column 15: no const"));
  EXPECT_EQ(
      refuse("any tension(links)/2 > 5"),
      "formula \"any tension(links)/2 > 5\": column 1: a formula needs one number of these 3; say max, min or sum "
      "in place of any, or name one member");
  EXPECT_NE(refuse("any tension(links) > any tension(links)").find("any on one side"), std::string::npos);
}

/// Whatever an entry is named, the run shows its tension without a word.
TEST(Observables, NamesMayHoldAnything) {
  for (const std::string name : {"Bob's", "'links'", "a, 'b", "it''s, (1]", "'", "\"", "a > b's", "b[3]'s"}) {
    System system = make_cable(2);
    std::get<Rods>(system.constraints[0]).name = name;
    const std::vector<Observable> wanted = default_observables(system);
    Simulation simulation(system);
    for (const Observable& each : wanted) simulation.add_observable(each);
    const std::span<const Observed> seen = simulation.observe();
    EXPECT_NEAR(seen[0].values[0], 2 * 0.5 * of_earth, 1e-12) << wanted[0].text;
    EXPECT_EQ(seen[0].member, name + "[0]");
    EXPECT_NO_THROW(check_event(system, {.when = wanted[0].text + " > 2"})) << wanted[0].text;
    EXPECT_NO_THROW(check_event(system, {.when = "2 < " + wanted[0].text})) << wanted[0].text;
  }
}

TEST(Observables, NamesThatResultsCannotHoldAreRefused) {
  const System system = make_cable(2);
  EXPECT_EQ(error_of([&] { check_observable(system, {.name = "t", .text = "kinetic()"}); }),
            "/name: \"t\" is the name of the time in results; give another name");
  EXPECT_EQ(error_of([&] { check_observable(system, {.text = "t"}); }),
            "formula \"t\": column 1: \"t\" is the name of the time in results; give another name");
  for (const auto& [name, shown] : {std::pair("a\nb", "a\\x0ab"), {"\x7f", "\\x7f"}, {"\x1b[7m", "\\x1b[7m"}}) {
    const std::string problem =
        "the name \"" + std::string(shown) + "\" holds a line break or another control character";
    EXPECT_EQ(error_of([&] { check_observable(system, {.name = name, .text = "kinetic()"}); }), "/name: " + problem);
    EXPECT_EQ(error_of([&] { check_event(system, {.name = name, .when = "t > 1"}); }), "/name: " + problem);
    System named = system;
    named.supports[0].name = name;
    EXPECT_EQ(error_of([&] { validate(named); }), "/supports/0/name: " + problem);
    named = system;
    std::get<Rods>(named.constraints[0]).name = name;
    EXPECT_EQ(error_of([&] { validate(named); }), "/constraints/0/name: " + problem);
  }
}

TEST(Observables, QuotesMakeANameOfANumber) {
  System system = make_cable(3);
  system.supports[0].name = "3";
  Simulation simulation(system);
  for (const char* const text : {"position('3')", "position(3)"}) simulation.add_observable({.text = text});
  const std::span<const Observed> found = simulation.observe();
  EXPECT_EQ(found[0].values, std::vector<double>(system.positions.begin(), system.positions.begin() + 3));
  EXPECT_EQ(found[1].values, std::vector<double>(system.positions.begin() + 9, system.positions.begin() + 12));
  EXPECT_NE(
      error_of([&] { check_observable(system, {.text = "position('all')"}); }).find("no supports are named 'all'"),
      std::string::npos);
}

/// Defaults may be asked for, with steps and letters; their names with another text may not.
TEST(Observables, AnObservableThatIsThereIsFound) {
  const System system = make_cable(2);
  Simulation simulation(system, {.method = Method::Rk4, .step = 0.01});
  for (const Observable& each : default_observables(system)) simulation.add_observable(each);
  EXPECT_EQ(simulation.add_observable({.text = "min tension(links)", .every_step = true}), 1u);
  ASSERT_EQ(simulation.observe().size(), 3u);
  EXPECT_EQ(error_of([&] { simulation.add_observable({.name = "load(hook)", .text = "kinetic()"}); }),
            "two observables are named \"load(hook)\"");
  EXPECT_EQ(simulation.add_observable({.text = "t/2 + 1", .unit = ""}), 3u);
  EXPECT_EQ(simulation.add_observable({.text = "t/2 + 1", .unit = "h"}), 3u);
  EXPECT_EQ(simulation.observe()[3].unit, "h");
  EXPECT_EQ(error_of([&] { simulation.add_observable({.text = "t/2 + 1", .unit = "d"}); }),
            "two observables are named \"t/2 + 1\"");
  for (const bool every_step : {false, true})
    EXPECT_EQ(simulation.add_observable({.text = "(t - 0.05)^2", .every_step = every_step}), 4u);
  ASSERT_TRUE(simulation.advance_to(0.1).ok());
  EXPECT_LE(simulation.observe()[4].least[0].value, 1e-4);  // at a step; 2.5e-3 at both ends
}

TEST(Observables, WordsBeforeNoQuantityTellTheQuantities) {
  EXPECT_NE(error_of([&] {
              check_observable(make_cable(2), {.text = "each links"});
            }).find("'links' is no quantity; they are tension, "),
            std::string::npos);
}

TEST(Observables, DefaultsAreTensionsAndLoads) {
  std::vector<std::string> texts;
  for (const Observable& each : default_observables(make_cable(3))) texts.push_back(each.text);
  EXPECT_EQ(texts, (std::vector<std::string>{"max tension(links)", "min tension(links)", "load(hook)"}));
}

/// Beads of 1 kg and 2 kg on a floor, another one on a wire, two on a rope: all have their forces without a word.
TEST(Observables, DefaultsOfGuidesAndRopesAreTheirForces) {
  System system;
  for (const double x : {0.0, 1.0, 2.0, 3.0, 4.0}) system.add_point({.position = {x, 0.0, 0.0}, .mass = 1.0 + x});
  system.constraints.push_back(Planes{.name = "floor", .points = {0, 1}, .normal = Vector3{0, 0, 1}});
  system.constraints.push_back(Lines{.name = "wire", .points = {2}, .direction = Vector3{1, 0, 0}});
  system.constraints.push_back(Pulleys{.name = "rope", .pairs = {{3, 4}}, .a = {3, 0, 1}, .b = {4, 0, 1}});
  system.constraints.push_back(Planes{.name = "unused", .normal = Vector3{0, 0, 1}});
  system.add_gravity({0.0, 0.0, -10.0});
  std::vector<std::string> texts;
  Simulation simulation(system);
  for (const Observable& each : default_observables(system)) {
    texts.push_back(each.text);
    simulation.add_observable(each);
  }
  EXPECT_EQ(texts, (std::vector<std::string>{"max force(floor)", "min force(floor)", "force(wire)", "tension(rope)"}));
  const std::span<const Observed> found = simulation.observe();
  EXPECT_NEAR(found[0].values[0], 20.0, 1e-12);
  EXPECT_EQ(found[0].member, "floor[1]");
  EXPECT_NEAR(found[1].values[0], 10.0, 1e-12);
  EXPECT_NEAR(found[2].values[2], 30.0, 1e-12);
  EXPECT_NEAR(found[3].values[0], 2.0 * 4.0 * 5.0 / 9.0 * 10.0, 1e-11);
}

/// A name of two things is refused where both may be meant, and nothing is asked of it without a word.
TEST(Observables, NamesOfTwoThingsAreRefused) {
  System system = make_cable(2);
  system.supports[0].name = "links";
  const auto refuse = [&](const std::string& text) {
    return error_of([&] { check_observable(system, {.text = text}); });
  };
  EXPECT_EQ(
      refuse("moment(links, z)"),
      "formula \"moment(links, z)\": column 8: 'links' is the name of supports/0 and of constraints/0; give one of "
      "them another");
  EXPECT_NO_THROW(check_observable(system, {.text = "load(links).z"})) << "only a support has one";
  system.forces.push_back(Springs{.name = "links", .pairs = {{0, 1}}, .stiffness = 1.0, .rest_length = 1.0});
  EXPECT_NE(refuse("max tension(links)").find("constraints/0 and of forces/1"), std::string::npos);
  EXPECT_NE(refuse("2*tension(links[1])").find("constraints/0 and of forces/1"), std::string::npos);
  ASSERT_EQ(default_observables(system).size(), 1u);
  EXPECT_EQ(default_observables(system)[0].text, "load(links)");
}

/// Without brackets the name is that of the parameter.
TEST(Observables, AParameterMayHaveTheNameOfAQuantity) {
  const System system = make_cable(2);
  Simulation simulation(system);
  simulation.add_observable({.text = "load(hook).z/energy - energy*energy()", .parameters = {{"energy", 2.0}}});
  simulation.add_observable({.text = "energy()"});
  const std::span<const Observed> found = simulation.observe();
  EXPECT_NEAR(found[0].values[0], -0.5 * of_earth - 2.0 * found[1].values[0], 1e-12);
}

/// A rod turns with v = 2 at both ends and drifts with u = 1/2: its pull 2 v^2 takes the pressure of the turning away.
TEST(Observables, DefaultsOfAPeriodicCellAreTemperatureAndPressureToo) {
  System system;
  system.add_point({.position = {1.0, 1.0, 1.0}, .velocity = {0.5, 2.0, 0.0}});
  system.add_point({.position = {2.0, 1.0, 1.0}, .velocity = {0.5, -2.0, 0.0}});
  system.constraints.push_back(Rods{.name = "rod", .pairs = {{0, 1}}});
  const auto list_defaults = [&] {
    std::vector<std::string> texts;
    for (const Observable& each : default_observables(system)) texts.push_back(each.text);
    return texts;
  };
  system.cell = Cell{.xx = 4.0, .yy = 4.0};
  EXPECT_EQ(list_defaults(), (std::vector<std::string>{"tension(rod)"}));  // a slab has no volume
  system.cell->zz = 4.0;
  EXPECT_EQ(list_defaults(), (std::vector<std::string>{"tension(rod)", "temperature()", "pressure()"}));
  Simulation simulation(system);
  for (const Observable& each : default_observables(system)) simulation.add_observable(each);
  const std::span<const Observed> found = simulation.observe();
  EXPECT_NEAR(find(found, "temperature()").values[0], 8.5 / (6.0 - 1.0 - 3.0), 1e-13);
  EXPECT_NEAR(find(found, "pressure()").values[0], 2.0 * 0.25 / (3.0 * 64.0), 1e-13);
}

}  // namespace
}  // namespace tanor
