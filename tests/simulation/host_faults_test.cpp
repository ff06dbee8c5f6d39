/// Hosts trap floating-point exceptions, ask at no time, use an object that was moved from, or call back.

#include <cfenv>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <tanor/inverse_dynamics.hpp>
#include <tanor/motion.hpp>

#include "errors.hpp"
#include "measures.hpp"
#include "rough_scenes.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

/// Makes a chain at rest and without a force, so that terms of its series are 0.
System make_resting_chain() {
  System system = scenes::make_chain(6);
  system.forces.clear();
  return system;
}

System make_sliding_block() {
  System system = scenes::make_block_on_rail(0.3);
  system.velocities = {1, 0, 0};
  return system;
}

System make_gas() {
  System system;
  for (int i = 0; i < 8; ++i)
    system.positions.insert(system.positions.end(), {1.2 * (i & 1), 1.2 * (i >> 1 & 1), 1.2 * (i >> 2)});
  system.velocities.assign(24, 0.0);
  system.velocities[0] = 0.5;
  system.masses.assign(8, 1.0);
  system.forces = {PairForces{.law = PairLaw::Lj}};
  return system;
}

System make_hoop() {
  System system;
  system.positions = {1, 0, 0};
  system.velocities = {0, 1, 0};
  system.masses = {1.0};
  system.coordinates = {CircleCoordinates{"", {0}, Vector3{}, Vector3{0, 0, 1}, 1.0}};
  return system;
}

/// Floating-point exceptions are trapped while the object lives.
class Traps {
 public:
  static constexpr int all = FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW;
  Traps() { feenableexcept(all); }
  ~Traps() { fedisableexcept(all); }
  Traps(const Traps&) = delete;
  Traps& operator=(const Traps&) = delete;
};

TEST(HostFaults, FloatingPointTrapsOfTheHostAreNotTriggered) {
  const Traps traps;  // an exception kills the test
  // The parallelogram passes through the configuration where it lies flat.
  const System parallelogram = scenes::make_four_bar(0.5 * M_PI, -2.0, 2.0);
  const System systems[] = {
      make_resting_chain(), scenes::make_chain(6), parallelogram, make_sliding_block(), make_gas(), make_hoop()};
  for (const System& system : systems) {
    for (const MethodTraits& each : methods()) {
      for (const int threads : {1, 3}) {
        MotionOptions motion{.method = each.method};
        if (each.has_fixed_steps) motion.step = 0.01;
        try {
          Simulation simulation(system, motion, {.threads = threads});
          (void)simulation.advance_to(1.0);
          (void)simulation.certify();
          (void)simulation.rank();
          simulation.restore(simulation.save());
        } catch (const InputError&) {  // a method that this system refuses
        }
        EXPECT_EQ(fegetexcept(), Traps::all) << "the host's own traps are back";
      }
    }
    Dynamics dynamics(system);
    std::vector<double> r = system.positions, v = system.velocities, w(r.size());
    v.resize(r.size());
    (void)dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Project);
    ASSERT_TRUE(dynamics.solve({.time = 0.0, .positions = r, .velocities = v}, {.accelerations = w}).outcome.ok());
    (void)dynamics.split({.time = 0.0, .positions = r, .velocities = v});
    (void)dynamics.reactions_by_cause({.time = 0.0, .positions = r, .velocities = v});
    EXPECT_TRUE(dynamics.certify({.time = 0.0, .positions = r, .velocities = v}).passed());
    (void)dynamics.project_positions({.time = 0.0, .positions = r});
    (void)dynamics.project_velocities({.time = 0.0, .positions = r, .velocities = v});
    (void)InverseDynamics(system).evaluate(0.0, {r, v, w});
    EXPECT_EQ(fegetexcept(), Traps::all);
  }
}

TEST(HostFaults, ATimeThatIsNotFiniteIsRefused) {
  const System system = scenes::make_chain(6);
  std::vector<double> r = system.positions, v(r.size()), w(r.size());
  for (const double t : {nan, std::numeric_limits<double>::infinity()}) {
    Dynamics dynamics(system);
    EXPECT_NE(error_of([&] {
                (void)dynamics.solve({.time = t, .positions = r, .velocities = v}, {.accelerations = w});
              }).find("is not a time"),
              std::string::npos);
    EXPECT_NE(error_of([&] { (void)dynamics.project_positions({.time = t, .positions = r}); }).find("is not a time"),
              std::string::npos);
    EXPECT_NE(error_of([&] {
                (void)dynamics.project_velocities({.time = t, .positions = r, .velocities = v});
              }).find("is not a time"),
              std::string::npos);
    EXPECT_NE(error_of([&] {
                (void)dynamics.start({.time = t, .positions = r, .velocities = v}, StartMode::Check);
              }).find("is not a time"),
              std::string::npos);
    EXPECT_NE(error_of([&] { (void)dynamics.position_violation({.time = t, .positions = r}); }).find("is not a time"),
              std::string::npos);
    EXPECT_NE(error_of([&] { (void)Simulation(system, {}, {}, t); }).find("is not a time"), std::string::npos);
    EXPECT_NE(error_of([&] { (void)Simulation(system).advance_to(t); }).find("does not lie after"), std::string::npos);
    EXPECT_NE(error_of([&] {
                (void)InverseDynamics(system).evaluate(t, {r, v, w});
              }).find("is not a time"),
              std::string::npos);
  }
}

TEST(HostFaults, AnObjectThatWasMovedFromSaysSo) {
  const System system = scenes::make_chain(6);
  const std::vector<double> r = system.positions, v(r.size());
  std::vector<double> w(r.size());
  Simulation simulation(system);
  Dynamics dynamics(system);
  InverseDynamics direct(system);
  MotionTable table({0.0, 1.0}, {0.0, 1.0}, 1);
  const Simulation other = std::move(simulation);
  const Dynamics another = std::move(dynamics);
  const InverseDynamics third = std::move(direct);
  const MotionTable fourth = std::move(table);

  // NOLINTBEGIN(bugprone-use-after-move): what it is about
  EXPECT_EQ(error_of([&] { (void)simulation.advance_to(1.0); }),
            "this Simulation was moved from: it can be assigned to or destroyed, no more");
  EXPECT_NE(error_of([&] { (void)simulation.positions(); }), "no error");
  EXPECT_NE(error_of([&] { (void)simulation.save(); }), "no error");
  EXPECT_NE(error_of([&] { (void)simulation.report(); }), "no error");
  EXPECT_NE(
      error_of([&] { (void)dynamics.solve({.time = 0.0, .positions = r, .velocities = v}, {.accelerations = w}); }),
      "no error");
  EXPECT_NE(error_of([&] { (void)dynamics.num_points(); }), "no error");
  EXPECT_NE(error_of([&] { (void)direct.evaluate(0.0, {r, v, w}); }), "no error");
  EXPECT_NE(error_of([&] { (void)table.at(0.5); }), "no error");
  simulation = Simulation(system);
  EXPECT_TRUE(simulation.advance_to(0.1).ok());
  // NOLINTEND(bugprone-use-after-move)
}

TEST(HostFaults, AnObserverMayNotAdvanceOrRestore) {
  Simulation simulation(scenes::make_chain(6), {.method = Method::Dop853});
  const std::vector<std::byte> start = simulation.save();
  int looks = 0;
  const Outcome outcome = simulation.advance_to(0.2, [&](const MotionReport&) {
    ++looks;
    EXPECT_NE(error_of([&] { (void)simulation.advance_to(1.0); }).find("advance_to was called inside advance_to"),
              std::string::npos);
    EXPECT_NE(error_of([&] { simulation.restore(start); }).find("restore was called inside advance_to"),
              std::string::npos);
    return true;
  });
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_GT(looks, 0);
  EXPECT_EQ(simulation.time(), 0.2);
  // An observer that throws leaves the object as usable as before.
  EXPECT_THROW(
      (void)simulation.advance_to(0.4, [](const MotionReport&) -> bool { throw std::runtime_error("enough"); }),
      std::runtime_error);
  EXPECT_TRUE(simulation.advance_to(0.5).ok());
}

TEST(HostFaults, ValuesOfNoEnumerationAreNamedWithoutTheBuildersFolders) {
  const System system = scenes::make_chain(6);
  const auto refuses = [](const std::string& error, const std::string& where) {
    EXPECT_EQ(error.find(where + ": 99 is no value of this enumeration"), 0u) << error;
  };
  refuses(error_of([&] { (void)Simulation(system, {.method = static_cast<Method>(99)}); }), "/motion/method");
  refuses(error_of([&] { (void)Simulation(system, {.stabilisation = static_cast<Stabilisation>(99)}); }),
          "/motion/stabilisation");
  refuses(error_of([&] { (void)Simulation(system, {.start = static_cast<StartMode>(99)}); }), "/motion/start");
  refuses(error_of([&] { (void)Dynamics(system, {.form = static_cast<Form>(99)}); }), "/solver/form");
  refuses(error_of([&] { (void)Dynamics(system, {.linear_solver = static_cast<LinearSolver>(99)}); }),
          "/solver/linear_solver");
  refuses(error_of([&] { (void)Dynamics(system, {.ordering = static_cast<Ordering>(99)}); }), "/solver/ordering");
  refuses(error_of([&] { (void)Dynamics(system, {.friction = static_cast<FrictionMethod>(99)}); }), "/solver/friction");
  System gas = make_gas();
  std::get<PairForces>(gas.forces[0]).law = static_cast<PairLaw>(99);
  refuses(error_of([&] { (void)Dynamics(gas); }), "/forces/0/law");
  System rough = make_sliding_block();
  std::get<Coulomb>(rough.friction[0]).reaction = static_cast<Coulomb::Reaction>(99);
  refuses(error_of([&] { (void)Dynamics(rough); }), "/friction/0/reaction");
}

}  // namespace
}  // namespace tanor
