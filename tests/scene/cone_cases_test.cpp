/// Contacts to one side with friction (G) with digits: instants of events to 1e-12, states to 1e-11.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "cases/reference_case.hpp"
#include "measures.hpp"

namespace tanor::cases {
namespace {

constexpr double g = 9.81;
const MotionOptions precise{.method = Method::Dop853, .rtol = 1e-13, .atol = 1e-15};

/// Points above planes to one side, each with its friction; z is up.
struct Rough {
  System system;

  Index add(Vector3 r, Vector3 v, double mass = 1.0) {
    const Index point = system.add_point({.position = r, .velocity = v}).index;
    system.masses[static_cast<std::size_t>(point)] = mass;
    return point;
  }
  void add_gravity() { system.forces.push_back(Gravity{.acceleration = {0.0, 0.0, -g}}); }
  void add_floor(const std::string& name, std::vector<Index> points, Vector3 normal, double mu, double e = 0.0,
                 double offset = 0.0) {
    system.constraints.push_back(Planes{.name = name,
                                        .points = std::move(points),
                                        .normal = normal,
                                        .offset = offset,
                                        .side = OneSide::AtLeast,
                                        .restitution = e});
    system.friction.push_back(Coulomb{.at = {name}, .coefficient = mu});
  }
};

std::vector<ContactEvent> list_events(const Simulation& simulation) {
  return simulation.report().contact_events;
}

// ---- breaks ----

/// Three blocks on a floor: a spring presses the first one, which sticks until it breaks. The second one slides and the
/// third one sticks, whatever breaks.
TEST(ConeCases, ABreakLetsAContactSlipAndTheOthersGoOn) {
  constexpr double mu = 0.2, t_break = 0.25, t_end = 0.5;
  Rough rough;
  for (const auto& [x, v] : {std::pair(0.0, 0.0), {10.0, 2.0}, {20.0, 0.0}}) rough.add({x, 0.0, 0.0}, {v, 0.0, 0.0});
  rough.system.supports = {Support{.points = {rough.add({0.0, 0.0, 1.0}, {})}}};
  rough.add_gravity();
  rough.system.forces.push_back(Springs{.name = "spring", .pairs = {{0, 3}}, .stiffness = 10.0, .rest_length = 2.0});
  rough.system.forces.push_back(ConstantForce{.points = {0}, .force = Vector3{3.0, 0.0, 0.0}});
  rough.system.forces.push_back(ConstantForce{.points = {2}, .force = Vector3{1.0, 0.0, 0.0}});
  rough.add_floor("floor", {0, 1, 2}, {0.0, 0.0, 1.0}, mu);
  Simulation simulation(rough.system, precise, {.threads = 1});
  simulation.add_event({.when = "t > 0.25", .action = EventAction::Break, .of = "spring[0]"});
  const Outcome outcome = simulation.advance_to(t_end);
  ASSERT_TRUE(outcome.ok()) << outcome.what;
  const std::vector<ContactEvent> events = list_events(simulation);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].change, ContactChange::Slip);
  EXPECT_EQ(events[0].equations, std::vector<std::size_t>{0});
  EXPECT_EQ(events[0].time, simulation.passages()[0].time);
  const double free = t_end - t_break;
  EXPECT_NEAR(simulation.positions()[0], 0.5 * (3.0 - mu * g) * free * free, 1e-9);
  EXPECT_NEAR(simulation.positions()[3], 10.0 + 2.0 * t_end - 0.5 * mu * g * t_end * t_end, 1e-9);
  EXPECT_NEAR(simulation.positions()[6], 20.0, 1e-9);
}

// ---- G2 ----

TEST(ConeCases, ThrownUpAnInclineAPointStopsAndSticks) {
  const nlohmann::json file = read_case("G2_incline_thrown_sticks");
  const double a = number(file.at("plane_angle")), speed = number(file.at("speed"));
  Rough rough;
  rough.add({0.0, 0.0, 0.0}, {speed * std::cos(a), 0.0, speed * std::sin(a)});
  rough.add_gravity();
  rough.add_floor("incline", {0}, {-std::sin(a), 0.0, std::cos(a)}, number(file.at("mu")));
  Simulation simulation(rough.system, precise, {.threads = 1});
  for (const nlohmann::json& state : file.at("states")) {
    const Outcome outcome = simulation.advance_to(number(state.at("t")));
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    const double along = number(state.at("along")), v = number(state.at("along_velocity"));
    EXPECT_LT(largest_difference(simulation.positions(), std::vector{along * std::cos(a), 0.0, along * std::sin(a)}),
              1e-12);
    EXPECT_LT(largest_difference(simulation.velocities(), std::vector{v * std::cos(a), 0.0, v * std::sin(a)}), 1e-12);
  }
  const std::vector<ContactEvent> events = list_events(simulation);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].change, ContactChange::Stick);
  EXPECT_NEAR(events[0].time, number(file.at("stop_time")), 1e-12);
  EXPECT_NEAR(-simulation.report().energy.work_of_friction, number(file.at("energy_lost_until_stop_per_mass")), 1e-11);
}

TEST(ConeCases, PulledUpAnInclineAPointSlipsWhereFrictionReachesItsLimit) {
  const nlohmann::json file = read_case("G2_incline_pulled_mu06");
  const double a = number(file.at("plane_angle")), mass = number(file.at("mass")), rate = number(file.at("pull_rate"));
  Rough rough;
  rough.add({0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, mass);
  rough.add_gravity();
  const auto along_slope = [&](double part) { return ScalarFunction::formula("k*t", {{"k", rate * part}}); };
  const VectorFunction pull(along_slope(std::cos(a)), 0.0, along_slope(std::sin(a)));
  rough.system.forces.push_back(ConstantForce{.points = {0}, .force = pull});
  rough.add_floor("incline", {0}, {-std::sin(a), 0.0, std::cos(a)}, number(file.at("mu")));
  Simulation simulation(rough.system, precise, {.threads = 1});
  for (const nlohmann::json& state : file.at("states")) {
    const Outcome outcome = simulation.advance_to(number(state.at("t")));
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    const double along = number(state.at("along")), v = number(state.at("along_velocity"));
    EXPECT_NEAR(simulation.positions()[0], along * std::cos(a), 1e-11);
    EXPECT_NEAR(simulation.velocities()[2], v * std::sin(a), 1e-11);
    EXPECT_NEAR(simulation.multipliers()[0], number(state.at("normal_force")), 1e-10);
    const double friction =
        simulation.friction_forces()[0] * std::cos(a) + simulation.friction_forces()[2] * std::sin(a);
    EXPECT_NEAR(friction, number(state.at("friction_along")), 1e-10);
  }
  const std::vector<ContactEvent> events = list_events(simulation);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].change, ContactChange::Slip);
  EXPECT_NEAR(events[0].time, number(file.at("slip_time")), 1e-11);
}

// ---- G6 ----

/// The groove runs along x, tilted down by beta; its walls lean apart by the half angle on both sides.
TEST(ConeCases, APointSlidesDownAGrooveOfTwoWalls) {
  const nlohmann::json file = read_case("G6_groove_slides");
  const double half = number(file.at("half_angle")), beta = number(file.at("tilt")), mass = number(file.at("mass"));
  const Vector3 down{std::cos(beta), 0.0, -std::sin(beta)}, up{std::sin(beta), 0.0, std::cos(beta)};
  const auto wall = [&](double side) {
    return Vector3{std::sin(half) * up[0], side * std::cos(half), std::sin(half) * up[2]};
  };
  Rough rough;
  const double speed = number(file.at("speed"));
  rough.add({0.0, 0.0, 0.0}, {speed * down[0], 0.0, speed * down[2]}, mass);
  rough.add_gravity();
  rough.add_floor("left", {0}, wall(1.0), number(file.at("mu")));
  rough.add_floor("right", {0}, wall(-1.0), number(file.at("mu")));
  Simulation simulation(rough.system, precise, {.threads = 1});
  for (const nlohmann::json& state : file.at("states")) {
    const Outcome outcome = simulation.advance_to(number(state.at("t")));
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    const double along = number(state.at("along")), v = number(state.at("along_velocity"));
    EXPECT_LT(largest_difference(simulation.positions(), std::vector{along * down[0], 0.0, along * down[2]}), 1e-12);
    EXPECT_LT(largest_difference(simulation.velocities(), std::vector{v * down[0], 0.0, v * down[2]}), 1e-12);
    for (const double N : simulation.multipliers().first(2))
      EXPECT_NEAR(N, number(file.at("normal_force_each")), 1e-11);
  }
  EXPECT_TRUE(list_events(simulation).empty());
}

// ---- G8 ----

Rough make_chain(const nlohmann::json& file) {
  Rough rough;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::vector<double> r = numbers(file.at("positions")[k]), v = numbers(file.at("velocities")[k]);
    rough.add({r[0], 0.0, r[1]}, {v[0], 0.0, v[1]});
  }
  rough.system.constraints.push_back(Rods{.pairs = {{0, 1}, {1, 2}}});
  rough.add_gravity();
  rough.add_floor("floor", {0, 1, 2}, {0.0, 0.0, 1.0}, number(file.at("mu")));
  return rough;
}

std::vector<double> upright(const nlohmann::json& list) {
  std::vector<double> result;
  const std::vector<double> flat = numbers(list);
  for (std::size_t k = 0; k + 1 < flat.size(); k += 2) result.insert(result.end(), {flat[k], 0.0, flat[k + 1]});
  return result;
}

TEST(ConeCases, AChainFallsOntoARoughFloorBeadByBead) {
  const nlohmann::json file = read_case("G8_chain3_on_floor");
  Simulation simulation(make_chain(file).system, precise, {.threads = 1});
  for (const nlohmann::json& state : file.at("states")) {
    const Outcome outcome = simulation.advance_to(number(state.at("t")));
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_LT(largest_difference(simulation.positions(), upright(state.at("r"))), 1e-11) << state.at("t");
    EXPECT_LT(largest_difference(simulation.velocities(), upright(state.at("v"))), 1e-11) << state.at("t");
  }
  const std::vector<ContactEvent> events = list_events(simulation);
  std::size_t k = 0;
  for (const nlohmann::json& wanted : file.at("events")) {
    ASSERT_LT(k, events.size());
    const bool touches = wanted.at("fired")[0].get<std::string>().starts_with("touches");
    EXPECT_EQ(events[k].change, touches ? ContactChange::Touch : ContactChange::Slip) << k;
    EXPECT_NEAR(events[k].time, number(wanted.at("t")), 1e-12) << k;
    if (touches) {
      double impulse = 0.0;
      for (const nlohmann::json& each : wanted.at("impulses_n_t")) impulse += number(each[0]);
      EXPECT_NEAR(std::accumulate(events[k].impulses.begin(), events[k].impulses.end(), 0.0), impulse, 1e-11);
      EXPECT_NEAR(events[k].energy_lost, number(wanted.at("energy_lost")), 1e-11);
    }
    ++k;
  }
  const EnergyReport& energy = simulation.report().energy;
  EXPECT_NEAR(energy.now - energy.start, energy.work_of_friction + energy.work_of_impacts, 1e-11);
}

/// A long chain falls obliquely onto a rough floor and comes to rest: many beads touch at once.
TEST(ConeCases, LongChainsComeToRestOnARoughFloor) {
  constexpr double angle = 0.6, link = 0.05;
  for (const int beads : {20, 50}) {
    Rough rough;
    Rods links{.name = "links"};
    std::vector<Index> all;
    for (Index i = 0; i < beads; ++i) {
      all.push_back(rough.add({link * i * std::cos(angle), 0.0, 0.02 + link * i * std::sin(angle)}, {}, 0.1));
      if (i > 0) links.pairs.push_back({i - 1, i});
    }
    rough.system.constraints.push_back(links);
    rough.add_gravity();
    rough.add_floor("floor", all, {0.0, 0.0, 1.0}, 0.4);
    Simulation simulation(rough.system, {.method = Method::Dop853}, {.threads = 1});
    const Outcome outcome = simulation.advance_to(1.5);
    ASSERT_TRUE(outcome.ok()) << beads << ": " << outcome.what;
    EXPECT_LT(largest(simulation.velocities()), 0.5);
    const EnergyReport& energy = simulation.report().energy;
    EXPECT_LT(energy.work_of_friction, 0.0);
    EXPECT_NEAR(energy.now - energy.start, energy.work_of_friction + energy.work_of_impacts, 1e-6 * energy.start);
    EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
  }
}

/// A box on more rods than it needs slides down an incline or sticks there; it does not creep.
TEST(ConeCases, ABoxOnAnInclineSlidesOrStaysWhereItIs) {
  constexpr double slope = 0.3;
  for (const double mu : {0.2, 0.5}) {
    Rough rough;
    Rods body{.name = "body"};
    for (Index i = 0; i < 8; ++i) {
      rough.add({0.2 * (i / 4), 0.2 * (i / 2 % 2), 0.1 * (i % 2)}, {});
      for (Index j = 0; j < i; ++j) body.pairs.push_back({j, i});
    }
    rough.system.constraints.push_back(body);
    rough.system.add_gravity({g * std::sin(slope), 0.0, -g * std::cos(slope)});
    rough.add_floor("ramp", {0, 2, 4, 6}, {0.0, 0.0, 1.0}, mu);
    Simulation simulation(rough.system, precise, {.threads = 1});
    const Outcome outcome = simulation.advance_to(1.0);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
    const double a = std::max(0.0, g * (std::sin(slope) - mu * std::cos(slope)));
    EXPECT_NEAR(simulation.positions()[0], 0.5 * a, a > 0.0 ? 1e-11 : 1e-14);
    EXPECT_NEAR(simulation.velocities()[0], a, a > 0.0 ? 1e-11 : 1e-14);
  }
}

TEST(ConeCases, ThreadsFindTheSameBits) {
  const nlohmann::json file = read_case("G8_chain3_on_floor");
  std::vector<double> first;
  for (const int threads : {1, 2, 3}) {
    Simulation simulation(make_chain(file).system, precise, {.threads = threads});
    ASSERT_TRUE(simulation.advance_to(0.5).ok());
    const std::vector<double> now(simulation.positions().begin(), simulation.positions().end());
    if (first.empty()) first = now;
    EXPECT_EQ(now, first) << threads;
  }
}

// ---- G10 ----

/// The lower end is at the origin, and the upper one leans by the angle above the floor.
System make_dumbbell(const nlohmann::json& each) {
  const double a = number(each.at("angle")), w = number(each.at("angular_velocity"));
  const double speed = each.at("slides").get<std::string>() == "-x" ? -1.0 : 1.0;
  Rough rough;
  rough.add({0.0, 0.0, 0.0}, {speed, 0.0, 0.0});
  rough.add({std::cos(a), 0.0, std::sin(a)}, {speed - w * std::sin(a), 0.0, w * std::cos(a)});
  rough.system.constraints.push_back(Rods{.pairs = {{0, 1}}});
  rough.add_gravity();
  rough.add_floor("floor", {0}, {0.0, 0.0, 1.0}, number(each.at("mu")));
  return rough.system;
}

TEST(ConeCases, ADumbbellHasOneMotionOrSeveralOrJams) {
  const nlohmann::json file = read_case("G10_painleve_dumbbell");
  for (const nlohmann::json& each : file.at("instances")) {
    const std::string verdict = each.at("verdict");
    const Simulation simulation(make_dumbbell(each), precise, {.threads = 1});
    const std::vector<ContactEvent> events = list_events(simulation);
    if (verdict == "several") {
      EXPECT_EQ(simulation.outcome().status, Status::NotUnique);
      EXPECT_NE(simulation.outcome().what.find("lifts off with the acceleration 5.336"), std::string::npos)
          << simulation.outcome().what;
      EXPECT_NE(simulation.outcome().what.find("presses with 20.27"), std::string::npos) << simulation.outcome().what;
      continue;
    }
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    if (verdict == "none") {
      ASSERT_FALSE(events.empty());
      EXPECT_EQ(events[0].change, ContactChange::Jam);
      EXPECT_NEAR(events[0].impulses.at(0), number(each.at("impulse_without_collision").at("P_n")), 1e-12);
      EXPECT_NEAR(simulation.velocities()[0], 0.0, 1e-12);
      continue;
    }
    EXPECT_TRUE(events.empty());
    const nlohmann::json& force = each.at("forces")[0];
    const double N = number(force.at("N"));
    EXPECT_NEAR(simulation.multipliers()[1], N, 1e-12 * (1.0 + N));
    if (force.contains("a_t")) EXPECT_NEAR(simulation.accelerations()[0], number(force.at("a_t")), 1e-12 * (1.0 + N));
  }
}

// ---- G16 ----

TEST(ConeCases, RestitutionIsCappedWhereFrictionWouldFeedEnergy) {
  const nlohmann::json file = read_case("G16_energy_double_pendulum");
  for (const nlohmann::json& each : file.at("instances")) {
    const std::vector<double> angles = numbers(each.at("angles")), rates = numbers(each.at("rates"));
    Rough rough;
    Vector3 r{}, v{};
    const Index support = rough.system.add_support({0.0, 0.0, 0.0}).index;
    for (std::size_t k = 0; k < 2; ++k) {
      r = {r[0] + std::sin(angles[k]), 0.0, r[2] - std::cos(angles[k])};
      v = {v[0] + std::cos(angles[k]) * rates[k], 0.0, v[2] + std::sin(angles[k]) * rates[k]};
      rough.add(r, v);
    }
    rough.system.constraints.push_back(Rods{.pairs = {{support, 1}, {1, 2}}});
    const double e = number(each.at("restitution")), u = number(each.at("u_before")[0]);
    rough.add_floor("floor", {2}, {0.0, 0.0, 1.0}, number(each.at("mu")), e, r[2]);
    const Simulation simulation(rough.system, precise, {.threads = 1});
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    const std::vector<ContactEvent> events = list_events(simulation);
    ASSERT_FALSE(events.empty());
    const nlohmann::json& results = each.at("results");
    const bool is_capped = results.contains("newton_capped");
    EXPECT_EQ(events[0].restitution_capped, is_capped);
    if (is_capped) {
      const double part = number(results.at("newton_capped").at("largest_restitution_without_energy_gain"));
      EXPECT_NEAR(simulation.velocities()[8] / -u, part, 1e-12);
      EXPECT_NEAR(events[0].energy_lost, 0.0, 1e-10);  // the terms that cancel are 1e4 times the energy
      EXPECT_GE(events[0].energy_lost, 0.0);
      continue;
    }
    const nlohmann::json& law = results.at("newton_moreau")[0];
    EXPECT_NEAR(events[0].impulses.at(0), number(law.at("impulse")[0]), 1e-11);
    EXPECT_NEAR(events[0].energy_lost, -number(law.at("energy_change")), 1e-11);
    const std::vector<double> after = numbers(law.at("w_after"));
    const double vz = std::sin(angles[0]) * after[0] + std::sin(angles[1]) * after[1];
    EXPECT_NEAR(simulation.velocities()[8], vz, 1e-11);
  }
}

// ---- refusals ----

TEST(ConeCases, AnUnknownLawAtAGapIsRefusedByName) {
  const auto refusal = [](const auto& change, Method method = Method::Dop853) -> std::string {
    Rough rough;
    rough.add({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0});
    rough.add_floor("floor", {0}, {0.0, 0.0, 1.0}, 0.3);
    change(&rough.system);
    try {
      const Simulation simulation(rough.system, {.method = method, .step = 0.01}, {.threads = 1});
    } catch (const InputError& error) {
      return error.where() + ": " + error.what();
    }
    return "";
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  const auto law = [](System* system) -> Coulomb& { return std::get<Coulomb>(system->friction[0]); };
  EXPECT_EQ(refusal([](System*) {}), "");
  const std::string limit = refusal([&](System* system) { law(system).static_coefficient = 0.5; });
  EXPECT_TRUE(has(limit, "/friction/0/static_coefficient") && has(limit, "leave it out")) << limit;
  const std::string full = refusal([&](System* system) { law(system).reaction = Coulomb::Reaction::Full; });
  EXPECT_TRUE(has(full, "/friction/0") && has(full, "Coulomb's exact law")) << full;
  const std::string wire = refusal([&](System* system) {
    system->constraints.push_back(
        Planes{.name = "wall", .points = {0}, .normal = Vector3{0.0, 1.0, 0.0}, .side = OneSide::AtLeast});
    law(system).at.push_back("wall");
  });
  EXPECT_TRUE(has(wire, "/friction/0/at") && has(wire, "a law of its own")) << wire;
  const std::string both = refusal([&](System* system) {
    system->constraints.push_back(Planes{.name = "wall", .points = {0}, .normal = Vector3{0.0, 1.0, 0.0}});
    system->friction.push_back(Coulomb{.at = {"wall"}, .coefficient = 0.1});
  });
  EXPECT_TRUE(has(both, "/friction/1/at") && has(both, "to both sides")) << both;
  const std::string rattle = refusal([](System*) {}, Method::Rattle);
  EXPECT_TRUE(has(rattle, "/motion/method") && has(rattle, "rattle")) << rattle;
}

}  // namespace
}  // namespace tanor::cases
