/// Observables of a host: closed forms, agreement with those of a Simulation, edits, images, and the calls of
/// <tanor.h>.

#include <gtest/gtest.h>
#include <tanor.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <tanor/constrainer.hpp>
#include <tanor/motion.hpp>

#include "errors.hpp"
#include "host/c_handle.hpp"
#include "host/velocity_verlet.hpp"
#include "measures.hpp"
#include "random_systems.hpp"

namespace tanor::host {
namespace {

/// A pendulum on a support, off the vertical, that swings, and a bead beside it.
struct Swing {
  double length = 0.5, mass = 2.0, g = 9.81, angle = 0.4, rate = 3.0;
  std::vector<double> masses{infinity, mass, 1.5};
  std::vector<double> r{0, 0, 0, length* std::sin(angle), 0, -length* std::cos(angle), 7, 8, 9};
  std::vector<double> v{0, 0, 0, length* rate* std::cos(angle), 0, length* rate* std::sin(angle), 0.1, -0.2, 0.3};
  std::vector<double> f{0.25, 0.5, -0.75, 0, 0, -mass* g, 1.5, 3.0, -4.5};
  double tension = mass * (length * rate * rate + g * std::cos(angle));

  HostState state(double time = 0.0) const { return {.positions = r, .velocities = v, .forces = f, .time = time}; }
  Constrainer make() const { return {masses, {Rods{{}, {{0, 1}}, {}, {}}}, r}; }
};

std::vector<double> values_of(Constrainer& constrainer, const std::string& text, const HostState& at) {
  const std::size_t number = constrainer.add_observable({.text = text});
  const ConstraintReport report = constrainer.observe(at);
  EXPECT_TRUE(report.outcome.ok()) << report.outcome.what;
  return constrainer.observed()[number].values;
}

TEST(HostObservables, OfAPendulumAreClosedForms) {
  const Swing swing;
  Constrainer constrainer = swing.make();
  const auto value = [&](const std::string& text) { return values_of(constrainer, text, swing.state()).at(0); };
  const double s = std::sin(swing.angle), c = std::cos(swing.angle), T = swing.tension;

  EXPECT_NEAR(value("max tension(rod0)"), T, 1e-12 * T);
  EXPECT_NEAR(value("-multiplier(rod0[0])/2"), T / 2.0, 1e-12 * T);
  // The support carries the pull of the rod and the force of the host on it.
  EXPECT_NEAR(value("load(support0).x"), T * s + 0.25, 1e-12 * T);
  EXPECT_NEAR(value("load(support0).y"), 0.5, 1e-12 * T);
  EXPECT_NEAR(value("load(support0[0]).z"), -T * c - 0.75, 1e-12 * T);
  // The support pushes back at the origin, (-1, 0, 0) away from the axis.
  EXPECT_NEAR(value("moment(support0, y, [1, 0, 0])"), T * c + 0.75, 1e-12 * T);
  EXPECT_NEAR(value("reaction(1).x"), -T * s, 1e-12 * T);
  EXPECT_NEAR(value("acceleration(1).z"), T * c / swing.mass - swing.g, 1e-12 * T);
  EXPECT_NEAR(value("acceleration(2).z"), -3.0, 1e-15);
  EXPECT_EQ(value("acceleration(0).norm"), 0.0);
  const double kinetic = 0.5 * swing.mass * std::pow(swing.length * swing.rate, 2) + 0.75 * 0.14;
  EXPECT_NEAR(value("kinetic()"), kinetic, 1e-14);
  EXPECT_NEAR(value("temperature()"), 2.0 * kinetic / 5.0, 1e-14);  // two points with a rod
  EXPECT_NEAR(value("distance(support0, 1) + t"), 0.5, 1e-15);
}

/// A bead of weight m g on a plane, x away from the axis.
TEST(HostObservables, ForceAndMomentOfAGuideAreThoseOfItsBead) {
  const double weight = 3.0, x = 0.7;
  const std::vector<double> masses{1.2}, r{x, 0.2, 0}, v{0, 0, 0}, f{0.3, 0, -weight};
  Constrainer constrainer(masses, {Planes{"floor", {0}, {0, 0, 1}}}, r);
  const HostState at{.positions = r, .velocities = v, .forces = f};

  EXPECT_NEAR(values_of(constrainer, "force(floor)", at).at(2), weight, 1e-14);
  EXPECT_NEAR(values_of(constrainer, "moment(floor, y, [0, 0, 0])", at).at(0), -x * weight, 1e-14);
}

TEST(HostObservables, ExtremesHaveTheirTimesAndMembers) {
  const Swing swing;
  std::vector<double> masses = swing.masses, r = swing.r, v = swing.v, f = swing.f;
  masses[2] = infinity;
  r = {0, 0, 0, 0, 0, -1, 1, 0, -1};
  v = std::vector<double>(9, 0.0);
  Constrainer constrainer(masses, {Rods{"legs", {{0, 1}, {1, 2}}, {}, {}}}, r);
  constrainer.add_observable({.name = "most", .text = "max tension(legs)"});
  EXPECT_TRUE(std::isnan(constrainer.observed()[0].values[0]));

  for (int k = 0; k < 5; ++k) {
    f = {0, 0, 0, -4.0 + 3.0 * k, 0, -5, 0, 0, 0};  // legs[0] pulls with 5, legs[1] with 4, 1, -2, …
    const HostState at{.positions = r, .velocities = v, .forces = f, .time = 0.5 * k};
    ASSERT_TRUE(constrainer.observe(at).outcome.ok());
  }
  const Observed& most = constrainer.observed()[0];
  EXPECT_EQ(most.name, "most");
  EXPECT_NEAR(most.values[0], 5.0, 1e-14);
  EXPECT_EQ(most.member, "legs[0]");
  f = {0, 0, 0, -6, 0, -5, 0, 0, 0};
  ASSERT_TRUE(constrainer.observe({.positions = r, .velocities = v, .forces = f, .time = 9.0}).outcome.ok());
  EXPECT_NEAR(most.largest[0].value, 6.0, 1e-14);
  EXPECT_EQ(most.largest[0].time, 9.0);
  EXPECT_EQ(most.largest[0].member, "legs[1]");
  EXPECT_NEAR(most.least[0].value, 5.0, 1e-14);
  EXPECT_EQ(most.least[0].member, "legs[0]");
}

/// It is the call of `solve` and no more: same bits, one factorization.
TEST(HostObservables, ObserveIsASolveToTheLastBit) {
  const Tailed host;
  const std::vector<double> f{3, -1, 2, 0.5, 4, -2, 1, 1, -3, 2, -2, 0.25};
  std::vector<double> w(12), other_w(12), lambda(4), other_lambda(4), forces(12), other_forces(12), stress(36),
      other_stress(36);
  Constrainer solved = host.make_constrainer(), observed = host.make_constrainer();
  observed.add_observable({.text = "tension(rod0)"});

  const ConstraintReport report = solved.solve(
      {.positions = host.r, .velocities = host.v, .forces = f, .accelerations = w, .wanted = {lambda, forces, stress}});
  const ConstraintReport other = observed.observe({.positions = host.r,
                                                   .velocities = host.v,
                                                   .forces = f,
                                                   .accelerations = other_w,
                                                   .wanted = {other_lambda, other_forces, other_stress}});

  EXPECT_EQ(other_w, w);
  EXPECT_EQ(other_lambda, lambda);
  EXPECT_EQ(other_forces, forces);
  EXPECT_EQ(other_stress, stress);
  EXPECT_EQ(other.virial, report.virial);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(observed.observed()[0].values[k], -lambda[k]) << k;
  EXPECT_EQ(observed.counters().factorizations, solved.counters().factorizations);
  EXPECT_EQ(observed.counters().solves, solved.counters().solves);
}

TEST(HostObservables, WhatNeedsNoForcesIsNotSolved) {
  const Tailed host;
  Constrainer constrainer = host.make_constrainer();
  constrainer.add_observable({.text = "distance(0, 3)"});
  const HostState at{.positions = host.r, .velocities = host.v};

  ASSERT_TRUE(constrainer.observe(at).outcome.ok());
  EXPECT_NEAR(constrainer.observed()[0].values[0], std::sqrt(0.25 + 3.24 + 0.09), 1e-14);
  EXPECT_EQ(constrainer.counters().solves, 0U);
  constrainer.add_observable({.text = "tension(rod0)"});
  EXPECT_EQ(error_of([&] { (void)constrainer.observe(at); }), "forces are missing");
}

TEST(HostObservables, BadTextsAreRefusedAndChangeNothing) {
  const Swing swing;
  Constrainer constrainer = swing.make();
  constrainer.add_observable({.text = "tension(rod0)"});
  const auto refuse = [&](const std::string& text) {
    return error_of([&] { constrainer.add_observable({.text = text}); });
  };
  EXPECT_EQ(refuse("max tension(rod1)"),
            "formula \"max tension(rod1)\": column 13: no constraints or forces are named 'rod1' (did you mean rod0?); "
            "there are rod0");
  EXPECT_EQ(refuse("tension(rod0[1])"), "formula \"tension(rod0[1])\": column 9: rod0 has 1 member, counted from 0");
  for (const std::string text : {"energy()", "potential()", "pressure()", "virial()", "friction(1)", "potential(rod0)"})
    EXPECT_EQ(refuse(text), "formula \"" + text + "\": column 1: " + text.substr(0, text.find('(')) +
                                " needs each of the forces, and a host gives their sum on each point alone");
  EXPECT_EQ(constrainer.observed().size(), 1U);
  EXPECT_EQ(error_of([&] { constrainer.remove_observable(1); }), "there is no observable 1");
}

// ---- edits ----

/// A chain of five points on a support, straight down.
struct Hanging {
  std::vector<double> masses{infinity, 1, 1, 1, 1}, r, v, f;
  Hanging() : v(15, 0.0) {
    for (int k = 0; k < 5; ++k) {
      r.insert(r.end(), {0.0, 0.0, -1.0 * k});
      f.insert(f.end(), {0.0, 0.0, k > 0 ? -10.0 : 0.0});
    }
  }
  HostState state(double time = 0.0) const { return {.positions = r, .velocities = v, .forces = f, .time = time}; }
};

TEST(HostObservables, EditsKeepTheNamesOfWhatIsLeft) {
  const Hanging host;
  Constrainer constrainer(host.masses, {Rods{"chain", {{0, 1}, {1, 2}, {2, 3}, {3, 4}}, {}, {}}}, host.r);
  constrainer.add_observable({.text = "tension(chain)"});
  constrainer.add_observable({.text = "max tension(chain)"});
  constrainer.add_observable({.text = "tension(chain[3])"});
  ASSERT_TRUE(constrainer.observe(host.state(1.0)).outcome.ok());
  const auto found = [&](std::size_t k) -> const Observed& { return constrainer.observed()[k]; };
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(found(0).values[k], 10.0 * (4.0 - static_cast<double>(k)), 1e-12);

  const std::vector<ConstraintId> middle{1};
  constrainer.remove(middle);
  ASSERT_TRUE(constrainer.observe(host.state(2.0)).outcome.ok());
  EXPECT_EQ(found(0).members, (std::vector<std::string>{"chain[0]", "chain[2]", "chain[3]"}));
  EXPECT_NEAR(found(0).values[0], 10.0, 1e-12);  // its own weight; the rest falls freely
  EXPECT_NEAR(found(0).values[1], 0.0, 1e-12);
  EXPECT_NEAR(found(1).values[0], 10.0, 1e-12);
  EXPECT_NEAR(found(1).largest[0].value, 40.0, 1e-12);  // of before
  EXPECT_EQ(found(1).largest[0].time, 1.0);
  EXPECT_NEAR(found(2).values[0], 0.0, 1e-12);
  EXPECT_NEAR(found(2).largest[0].value, 10.0, 1e-12);
  EXPECT_EQ(error_of([&] { constrainer.add_observable({.text = "tension(chain[1])"}); }),
            "formula \"tension(chain[1])\": column 9: chain[1] was removed");

  const std::vector<ConstraintId> last{3};
  constrainer.remove(last);
  std::vector<double> w(15, 7.0);
  HostState at = host.state(3.0);
  at.accelerations = w;
  EXPECT_EQ(error_of([&] { (void)constrainer.observe(at); }),
            "formula \"tension(chain[3])\": column 9: chain[3] was removed");
  EXPECT_EQ(w, std::vector<double>(15, 7.0));
  constrainer.remove_observable(2);
  ASSERT_TRUE(constrainer.observe(at).outcome.ok());
  EXPECT_EQ(found(0).members, (std::vector<std::string>{"chain[0]", "chain[2]"}));

  const std::vector<ConstraintId> rest{0, 2};
  constrainer.remove(rest);
  EXPECT_EQ(error_of([&] { (void)constrainer.observe(at); }),
            "formula \"tension(chain)\": column 9: 'chain' was removed");
  const ConstraintId fresh = constrainer.add(Rods{"chain", {{0, 1}}, {}, {}});
  EXPECT_EQ(fresh, 4);
  ASSERT_TRUE(constrainer.observe(host.state(4.0)).outcome.ok());
  EXPECT_NEAR(found(1).values[0], 10.0, 1e-12);
  EXPECT_EQ(found(1).member, "chain[0]");
  EXPECT_NEAR(found(1).largest[0].value, 40.0, 1e-12);
}

TEST(HostObservables, PointsHaveTheHostsPresentNumbers) {
  Hanging host;
  Constrainer constrainer(host.masses, {Rods{"chain", {{0, 1}, {1, 2}}, {}, {}}}, host.r);
  for (const char* text : {"position(1).z", "tension(chain[1])", "load(support0).z"})
    constrainer.add_observable({.text = text});
  ASSERT_TRUE(constrainer.observe(host.state()).outcome.ok());
  EXPECT_EQ(constrainer.observed()[0].values[0], -1.0);

  // Point 4 leaves, 1 becomes 0 and 0 becomes 3.
  const std::vector<std::int64_t> from{1, 2, 3, 0};
  host.masses = {1, 1, 1, infinity};
  host.r = {0, 0, -1, 0, 0, -2, 0, 0, -3, 0, 0, 0};
  host.v.assign(12, 0.0);
  host.f = {0, 0, -10, 0, 0, -10, 0, 0, -10, 0, 0, 0};
  constrainer.renumber(from, host.masses, host.r);
  ASSERT_TRUE(constrainer.observe(host.state()).outcome.ok());
  EXPECT_EQ(constrainer.observed()[0].values[0], -2.0);
  EXPECT_NEAR(constrainer.observed()[1].values[0], 10.0, 1e-12);
  EXPECT_NEAR(constrainer.observed()[2].values[0], -20.0, 1e-12);
  EXPECT_EQ(error_of([&] { constrainer.add_observable({.text = "position(4)"}); }),
            "formula \"position(4)\": column 10: there is no point 4; they are 0 to 3");
}

// ---- periodic cells ----

/// A bent molecule that the host has cut at the faces of its cell, and the same in one piece.
TEST(HostObservables, MoleculesAreWholeInAPeriodicCell) {
  const std::vector<double> masses{1.0, 2.0, 1.5, 0.5},
      whole{2.7, 1, 0.2, 3.4, 1.3, -0.1, 4.1, 0.8, 0.3, 4.4, 1.6, 0.1};
  const std::vector<double> v{0.1, 0.2, 0, 0, -0.3, 0.1, 0.2, 0.2, -0.1, 0, 0.4, 0},
      f{1, 0, 2, 0, -3, 1, 2, 1, 0, 0, 1, 1};
  const PeriodicCell cell{.edges = {{{3, 0, 0}, {0.5, 4, 0}, {0, 0, 5}}}};
  std::vector<double> cut = whole;
  cut[3] -= 3.0, cut[5] += 5.0, cut[6] -= 3.0, cut[9] -= 3.0;
  const std::vector<Constraint> constraints{Rods{"bonds", {{0, 1}, {1, 2}}, {}, {}}, Angles{"bend", {{1, 2, 3}}}};
  Constrainer in_cell(masses, constraints, cut, {.cell = cell}), free(masses, constraints, whole);

  for (const char* text : {"tension(bonds)", "distance(0, 2)", "angle(0, 1, 2)", "moment(bend, [1, 2, 3])",
                           "moment(bonds[0], z)", "force(bend)", "position(all)", "kinetic()"}) {
    const std::vector<double> a = values_of(in_cell, text, {.positions = cut, .velocities = v, .forces = f});
    const std::vector<double> b = values_of(free, text, {.positions = whole, .velocities = v, .forces = f});
    EXPECT_LE(largest_difference(a, b), 1e-12) << text;
  }
  // Three of twelve degrees go to the constraints, and three to the motion of all.
  const double kinetic = values_of(free, "2*kinetic()/2", {.positions = whole, .velocities = v, .forces = f})[0];
  EXPECT_NEAR(values_of(in_cell, "temperature()", {.positions = cut, .velocities = v, .forces = f})[0],
              2.0 * kinetic / 6.0, 1e-14);
}

/// A ring of rods that closes round the cell. Points 1 and 2 stand at the images nearest to point 0, and the rod
/// between them pulls at the image of point 2, a further on, so that a moment -a x F is left.
TEST(HostObservables, RodsThatCloseRoundTheCellPullAtTheImage) {
  const std::vector<double> masses{1.0, 2.0, 1.5}, r{0.2, 1.0, 0.5, 1.1, 1.4, 0.4, 2.2, 0.7, 0.6};
  const std::vector<double> v(9, 0.0), f{1, 2, 0, -3, 1, 0.5, 2, -2, 1};
  Constrainer constrainer(masses, {Rods{"ring", {{0, 1}, {1, 2}, {2, 0}}, {}, {}}}, r,
                          {.cell = {.edges = {{{3, 0, 0}, {0, 4, 0}, {0, 0, 5}}}}});
  constrainer.add_observable({.text = "moment(ring, z)"});
  for (const double a : {3.0, 3.01}) {
    constrainer.set_cell({.edges = {{{a, 0, 0}, {0, 4, 0}, {0, 0, 5}}}});
    std::vector<double> lambda(3);
    ASSERT_TRUE(constrainer.observe({.positions = r, .velocities = v, .forces = f, .wanted = {.multipliers = lambda}})
                    .outcome.ok());
    const double dx = r[6] - r[3], dy = r[7] - r[4], dz = r[8] - r[5];
    const double pull_y = lambda[1] * dy / std::sqrt(dx * dx + dy * dy + dz * dz);
    EXPECT_NEAR(constrainer.observed()[0].values[0], -a * pull_y, 1e-12 * std::abs(lambda[1])) << a;
  }
}

// ---- against Simulation ----

TEST(HostObservables, AgreeWithThoseOfASimulation) {
  for (const std::uint32_t seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    RandomSystem random = make_random_system(14, seed, {.time_dependent = false});
    System& system = random.system;
    system.positions = random.positions;
    system.velocities = random.velocities;
    Dynamics dynamics(system);
    std::vector<double> masses = system.masses, f(random.positions.size());
    ASSERT_TRUE(
        dynamics
            .solve({.time = 0.0, .positions = random.positions, .velocities = random.velocities}, {.active_forces = f})
            .outcome.ok());
    std::vector<Index> supports;
    for (const Support& support : system.supports) {
      for (const Index point : support.points) {
        masses[static_cast<std::size_t>(point)] = infinity;
        supports.push_back(point);
      }
    }
    std::ranges::sort(supports);
    system.supports.clear();
    if (!supports.empty()) system.supports.push_back({.points = supports});
    Constrainer constrainer(masses, system.constraints, random.positions);
    if (seed % 2 == 0) constrainer.expect_edits();  // parts that share supports
    Simulation simulation(system);
    std::vector<std::string> texts{"reaction(all)", "acceleration(all)", "velocity(all)",  "position(all)",
                                   "kinetic()",     "temperature()",     "angle(0, 3, 7)", "distance(1, 9)*t + 2"};
    if (!supports.empty()) texts.insert(texts.end(), {"load(support0)", "each load(support0)", "moment(support0, y)"});
    for (std::size_t k = 0; k < system.constraints.size(); ++k) {
      const std::string name = constraint_name(system, k);
      for (const std::string before : {"multiplier(", "force("}) texts.push_back(before + name + ")");
      texts.push_back("moment(" + name + ", [1, 2, -1], [0.3, 0.1, -0.5])");
      if (std::holds_alternative<Rods>(system.constraints[k])) texts.push_back("min tension(" + name + ")");
    }
    for (const std::string& text : texts) {
      constrainer.add_observable({.text = text});
      simulation.add_observable({.text = text});
    }
    ASSERT_TRUE(constrainer.observe({.positions = random.positions, .velocities = random.velocities, .forces = f})
                    .outcome.ok());
    const std::span<const Observed> expected = simulation.observe();
    const double size = largest(simulation.reactions()) + largest(simulation.multipliers());
    for (std::size_t k = 0; k < texts.size(); ++k) {
      const Observed& own = constrainer.observed()[k];
      EXPECT_LE(largest_difference(own.values, expected[k].values), 1e-9 * std::max(1.0, size)) << texts[k];
      EXPECT_EQ(column_names(own), column_names(expected[k]));
      EXPECT_EQ(own.member, expected[k].member) << texts[k];
    }
  }
}

// ---- from C ----

tn_const_points const_array(const std::vector<double>& array) {
  return {array.data(), 0, nullptr};
}

TEST(CObservables, TellValuesNamesAndExtremes) {
  const Swing swing;
  tn_system* made = nullptr;
  ASSERT_EQ(tn_create(&made, 3, swing.masses.data(), const_array(swing.r), nullptr), TN_OK);
  const Handle handle(made);
  const std::int32_t pair[] = {0, 1};
  ASSERT_EQ(tn_add_rods(made, 1, pair, nullptr, nullptr, nullptr), TN_OK);
  std::size_t tension = 9, load = 9;
  ASSERT_EQ(tn_add_observable(made, "max tension(rod0)", &tension), TN_OK) << tn_last_error(made);
  ASSERT_EQ(tn_add_observable(made, "load(support0)", &load), TN_OK) << tn_last_error(made);
  EXPECT_EQ(tension, 0U);
  EXPECT_EQ(load, 1U);
  EXPECT_EQ(tn_add_observable(made, "max tenson(rod0)", nullptr), TN_EINVAL);
  EXPECT_STREQ(tn_last_error(made),
               "formula \"max tenson(rod0)\": column 5: 'tenson' is no quantity (did you mean tension?)");
  EXPECT_EQ(tn_add_observable(made, nullptr, nullptr), TN_EINVAL);

  std::vector<double> w(9), f = swing.f;
  tn_report report{};
  report.size = sizeof(report);
  const tn_points to_w{w.data(), 0, nullptr};
  for (const double time : {0.0, 1.5}) {
    f[5] = -swing.mass * swing.g * (1.0 + time);
    ASSERT_EQ(
        tn_observe(made, time, const_array(swing.r), const_array(swing.v), const_array(f), to_w, nullptr, &report),
        TN_OK)
        << tn_last_error(made);
  }
  const double T = swing.tension, more = T + 1.5 * swing.mass * swing.g * std::cos(swing.angle);
  EXPECT_NEAR(w[8], -3.0, 1e-15);
  std::size_t size = 0;
  ASSERT_EQ(tn_observed(made, load, nullptr, &size), TN_OK);
  ASSERT_EQ(size, 3U);
  std::array<double, 3> values{};
  size = 2;
  EXPECT_EQ(tn_observed(made, load, values.data(), &size), TN_EINVAL);
  EXPECT_EQ(values[0], 0.0);
  EXPECT_STREQ(tn_last_error(made), "there is room for 2 of 3 values");
  ASSERT_EQ(tn_observed(made, load, values.data(), &size), TN_OK);
  EXPECT_NEAR(values[0], more * std::sin(swing.angle) + 0.25, 1e-12 * more);

  std::array<char, 32> name{};
  ASSERT_EQ(tn_column_name(made, load, 2, name.data(), name.size()), TN_OK);
  EXPECT_STREQ(name.data(), "load(support0).z");
  EXPECT_EQ(tn_column_name(made, load, 3, name.data(), name.size()), TN_EINVAL);
  ASSERT_EQ(tn_column_name(made, tension, 0, name.data(), 6), TN_OK);
  EXPECT_STREQ(name.data(), "max t");

  double value = 0.0, time = -1.0;
  ASSERT_EQ(tn_extreme(made, tension, 0, TN_LEAST, &value, &time, name.data(), name.size()), TN_OK);
  EXPECT_NEAR(value, T, 1e-12 * T);
  EXPECT_EQ(time, 0.0);
  EXPECT_STREQ(name.data(), "rod0[0]");
  ASSERT_EQ(tn_extreme(made, tension, 0, TN_LARGEST, &value, &time, nullptr, 0), TN_OK);
  EXPECT_NEAR(value, more, 1e-12 * T);
  EXPECT_EQ(time, 1.5);
  EXPECT_EQ(tn_extreme(made, tension, 1, TN_LARGEST, &value, &time, nullptr, 0), TN_EINVAL);
  EXPECT_EQ(tn_extreme(made, tension, 0, static_cast<tn_which>(0), &value, &time, nullptr, 0), TN_EINVAL);
  EXPECT_EQ(tn_extreme(made, 2, 0, TN_LEAST, &value, &time, nullptr, 0), TN_EINVAL);
  name = {};
  ASSERT_EQ(tn_observed_member(made, tension, name.data(), name.size()), TN_OK);
  EXPECT_STREQ(name.data(), "rod0[0]");
  ASSERT_EQ(tn_observed_member(made, load, name.data(), name.size()), TN_OK);
  EXPECT_STREQ(name.data(), "");
  EXPECT_EQ(tn_observed_member(made, 2, name.data(), name.size()), TN_EINVAL);
  EXPECT_EQ(tn_observed_member(made, tension, nullptr, 0), TN_EINVAL);
  EXPECT_STREQ(tn_last_error(made), "there is no room for the name of a member");

  ASSERT_EQ(tn_remove_observable(made, tension), TN_OK);
  ASSERT_EQ(tn_column_name(made, 0, 0, name.data(), name.size()), TN_OK);
  EXPECT_STREQ(name.data(), "load(support0).x");
}

/// Released from the horizontal, a pendulum pulls with 3 m g at the bottom. To look at it changes no bit of the motion.
TEST(CObservables, WatchARunOfTheLibrary) {
  const double m = 2.0, g = 9.81, length = 0.5;
  const std::vector<double> masses{infinity, m}, start{0, 0, 0, length, 0, 0};
  struct Run {
    tn_system* system = nullptr;
    std::vector<double> x, v, f;
    bool looks;
  };
  const auto go = [&](bool looks) {
    Run run{.x = start, .v = std::vector<double>(6, 0.0), .f = {0, 0, 0, 0, 0, -m * g}, .looks = looks};
    EXPECT_EQ(tn_create(&run.system, 2, masses.data(), const_array(start), nullptr), TN_OK);
    const std::int32_t pair[] = {0, 1};
    EXPECT_EQ(tn_add_rods(run.system, 1, pair, nullptr, nullptr, nullptr), TN_OK);
    EXPECT_EQ(tn_add_observable(run.system, "tension(rod0)", nullptr), TN_OK);
    tn_loop loop{};
    loop.size = sizeof(loop);
    loop.dt = 1e-3;
    loop.steps = 600;
    loop.x = {run.x.data(), 0, nullptr};
    loop.v = {run.v.data(), 0, nullptr};
    loop.f = {run.f.data(), 0, nullptr};
    loop.user = &run;
    loop.observe = [](void* user, const tn_progress* now) {
      const Run& at = *static_cast<Run*>(user);
      if (!at.looks) return 1;
      return tn_observe(at.system, now->time, const_array(at.x), const_array(at.v), const_array(at.f), {}, nullptr,
                        nullptr) == TN_OK
                 ? 1
                 : 0;
    };
    std::size_t steps = 0;
    EXPECT_EQ(tn_run(run.system, &loop, &steps), TN_OK) << tn_last_error(run.system);
    EXPECT_EQ(steps, 600U);
    return run;
  };
  const Run looked = go(true), blind = go(false);
  const Handle first(looked.system), second(blind.system);
  EXPECT_EQ(looked.x, blind.x);
  EXPECT_EQ(looked.v, blind.v);
  double value = 0.0, time = 0.0;
  ASSERT_EQ(tn_extreme(looked.system, 0, 0, TN_LARGEST, &value, &time, nullptr, 0), TN_OK);
  EXPECT_NEAR(value, 3.0 * m * g, 1e-4 * m * g);
  EXPECT_NEAR(time, 1.8540746773 * std::sqrt(length / g), 1e-3);  // a quarter of the period, K(1/2) sqrt(l/g)
}

TEST(CObservables, SayWhatWasRemoved) {
  const Swing swing;
  tn_system* made = nullptr;
  ASSERT_EQ(tn_create(&made, 3, swing.masses.data(), const_array(swing.r), nullptr), TN_OK);
  const Handle handle(made);
  const std::int32_t pairs[] = {0, 1, 1, 2};
  std::int64_t ids[2];
  ASSERT_EQ(tn_add_rods(made, 2, pairs, nullptr, nullptr, ids), TN_OK);
  ASSERT_EQ(tn_add_observable(made, "tension(rod0[1])", nullptr), TN_OK);
  ASSERT_EQ(tn_remove(made, 1, &ids[1]), TN_OK);
  const auto observe = [&] {
    return tn_observe(made, 0.0, const_array(swing.r), const_array(swing.v), const_array(swing.f), {}, nullptr,
                      nullptr);
  };
  EXPECT_EQ(observe(), TN_EINVAL);
  EXPECT_STREQ(tn_last_error(made), "formula \"tension(rod0[1])\": column 9: rod0[1] was removed");
  ASSERT_EQ(tn_remove_observable(made, 0), TN_OK);
  EXPECT_EQ(observe(), TN_OK);
}

}  // namespace
}  // namespace tanor::host
