/// The tests find forces of a given motion: closed forms, round trips, and motions that the system cannot have.

#include <tanor/inverse_dynamics.hpp>

#include <cmath>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "base/parallel.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

/// Makes a bead of 2 kg on a rod of 1 m, with its weight along -y.
System make_heavy_pendulum() {
  System system = scenes::make_pendulum({1.0, 0.0, 0.0}, 2.0);
  system.forces = {Gravity{"weight", {0.0, -9.81, 0.0}}};
  return system;
}

/// Returns the angle that the pendulum is to follow, measured from x.
Jet<2> angle(double t) {
  return 0.4 * sin(2.0 * Jet<2>::variable(t));
}

MotionState turn(double t) {
  const Jet<2> a = angle(t), x = cos(a), y = sin(a);
  const auto row = [&](int k) { return std::vector<double>{0, 0, 0, x.derivative(k), y.derivative(k), 0}; };
  return {row(0), row(1), row(2)};
}

TEST(InverseDynamics, ControlOfAPendulumIsItsClosedForm) {
  InverseDynamics problem(make_heavy_pendulum());

  const MotionForces forces = problem.evaluate(0.7, turn(0.7));

  ASSERT_TRUE(forces.outcome.ok());
  const Jet<2> a = angle(0.7);
  const double c = std::cos(a.value()), s = std::sin(a.value());
  // The control is u = m (a'' + g cos a) along (-sin a, cos a); tension = m (a'^2 - g sin a).
  const double control = 2.0 * (a.derivative(2) + 9.81 * c);
  const double tension = 2.0 * (a.derivative(1) * a.derivative(1) - 9.81 * s);
  EXPECT_NEAR(forces.control_forces[3], -control * s, 1e-14 * 20.0);
  EXPECT_NEAR(forces.control_forces[4], control * c, 1e-14 * 20.0);
  EXPECT_NEAR(forces.largest_control, std::abs(control), 1e-14 * 20.0);
  EXPECT_EQ(forces.controlled_point, 1);
  EXPECT_NEAR(forces.multipliers[0], -tension, 1e-14 * 20.0);
  EXPECT_NEAR(forces.reactions[3], -tension * c, 1e-14 * 20.0);
  EXPECT_NEAR(forces.support_forces[0], tension * c, 1e-14 * 20.0);
  EXPECT_LT(forces.position.largest, 1e-15);
  EXPECT_LT(forces.velocity.largest, 1e-15);
  EXPECT_LT(forces.acceleration.largest, 1e-14);
}

TEST(InverseDynamics, CoordinatesAloneGiveTheSameForces) {
  System system = make_heavy_pendulum();
  system.constraints.clear();
  system.coordinates = {ChainAngles{"angle", {1}, 0, {}, {0.0, 0.0, 1.0}}};
  InverseDynamics by_constraints(make_heavy_pendulum()), by_coordinates(system);

  const MotionForces expected = by_constraints.evaluate(0.3, turn(0.3));
  const MotionForces forces = by_coordinates.evaluate(0.3, turn(0.3));

  ASSERT_TRUE(forces.outcome.ok());
  EXPECT_TRUE(forces.multipliers.empty());
  EXPECT_LT(forces.position.largest, 1e-15);
  EXPECT_LT(forces.velocity.largest, 1e-14);
  EXPECT_LT(forces.acceleration.largest, 1e-13);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(forces.control_forces[i], expected.control_forces[i], 1e-13);
    EXPECT_NEAR(forces.reactions[i], expected.reactions[i], 1e-13);
    EXPECT_NEAR(forces.support_forces[i], expected.support_forces[i], 1e-13);
  }
}

TEST(InverseDynamics, PlacesAreThoseOfTheCoordinatesInTheUsersOrder) {
  // The entries are listed against the inner order of kinds: a line, then a free point.
  System system;
  system.positions = {0.0, 0.0, 0.0, 5.0, 6.0, 7.0};
  system.masses = {1.0, 1.0};
  system.coordinates = {
      LineCoordinates{"slide", {0}, {ScalarFunction::formula("t^2"), 0.0, 0.0}, Vector3{0.0, 2.0, 0.0}},
      FreeCoordinates{"free", {1}}};
  InverseDynamics problem(system);

  const MotionState points = problem.place(3.0, {{0.5, 1.0, 2.0, 3.0}, {0.25, 4.0, 5.0, 6.0}, {0.125, 7.0, 8.0, 9.0}});

  EXPECT_EQ(points.value, (std::vector<double>{9.0, 0.5, 0.0, 1.0, 2.0, 3.0}));
  EXPECT_EQ(points.rate, (std::vector<double>{6.0, 0.25, 0.0, 4.0, 5.0, 6.0}));
  EXPECT_EQ(points.acceleration, (std::vector<double>{2.0, 0.125, 0.0, 7.0, 8.0, 9.0}));
}

TEST(InverseDynamics, PlacesOfCirclesThatRestAndOfThoseThatBreatheAreTold) {
  // Two families of one kind are listed against their inner order.
  System system;
  system.positions = {1.0, 0.0, 0.0, 5.0, 0.0, 0.0};
  system.masses = {1.0, 1.0};
  const Vector3 axis{0.0, 0.0, 1.0};
  system.coordinates = {CircleCoordinates{"rests", {0}, {}, axis, 1.0},
                        CircleCoordinates{"breathes", {1}, {}, axis, ScalarFunction::formula("5 + t")}};
  InverseDynamics problem(system);
  const double quarter = 0.5 * M_PI;

  const MotionState points = problem.place(1.0, {{0.0, quarter}, {0.0, 0.0}, {0.0, 0.0}});

  // The first axis e1 of a circle about z is x.
  const double expected[] = {1.0, 0.0, 0.0, 0.0, 6.0, 0.0};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(points.value[i], expected[i], 1e-15) << i;
}

// ---- round trips -------------------------------------------------------------------------------------------------

/// Largest errors of a motion that is tabulated and turned into forces, away from the ends, where splines are
/// one-sided.
struct RoundTrip {
  double control = 0.0, reactions = 0.0, position = 0.0;  ///< largest errors
  double size = 0.0;                                      ///< the size of the reactions

  RoundTrip(const System& system, double h, std::size_t steps) {
    Simulation simulation(system, {.method = Method::Dopri5, .rtol = 1e-13, .atol = 1e-14});
    std::vector<double> times, values;
    std::vector<std::vector<double>> reactions_there;
    for (std::size_t k = 0; k <= steps; ++k) {
      if (k > 0) {
        EXPECT_TRUE(simulation.advance_to(static_cast<double>(k) * h).ok());
      }
      times.push_back(simulation.time());
      values.insert(values.end(), simulation.positions().begin(), simulation.positions().end());
      reactions_there.emplace_back(simulation.reactions().begin(), simulation.reactions().end());
    }
    const MotionTable table(times, values, system.positions.size());
    InverseDynamics problem(system);
    for (std::size_t k = 20; k + 20 < times.size(); ++k) {
      const MotionForces forces = problem.evaluate(times[k], table.at(times[k]));
      EXPECT_TRUE(forces.outcome.ok());
      control = std::max(control, forces.largest_control);
      position = std::max(position, forces.position.largest);
      for (std::size_t i = 0; i < forces.reactions.size(); ++i) {
        reactions = larger(reactions, std::abs(forces.reactions[i] - reactions_there[k][i]));
        size = std::max(size, std::abs(reactions_there[k][i]));
      }
    }
  }
};

/// Makes two beads that hang on one another and are let go to the side.
System make_double_pendulum() {
  System system = scenes::make_chain_through({{0, 0, 0}, {1, 0, 0}, {1, -1, 0.2}});
  system.masses = {1.0, 1.0, 0.5};
  system.forces = {Gravity{"", {0.0, -9.81, 0.0}}};
  return system;
}

TEST(InverseDynamics, RoundTripOfAChainNeedsNoControlAndFindsItsReactions) {
  const RoundTrip trip(make_double_pendulum(), 0.002, 300);

  EXPECT_LT(trip.control, 1e-6);
  EXPECT_LT(trip.reactions, 1e-6 * trip.size);
  EXPECT_LT(trip.position, 1e-11);
}

TEST(InverseDynamics, RoundTripErrorFallsWithTheFourthPowerOfTheSampling) {
  const RoundTrip coarse(make_double_pendulum(), 0.008, 75), fine(make_double_pendulum(), 0.004, 150);

  EXPECT_GT(coarse.control / fine.control, 10.0);  // 16 in the limit
}

TEST(InverseDynamics, RoundTripOfARodOfChangingLengthNeedsNoControl) {
  System system = make_heavy_pendulum();
  system.constraints = {Rods{"rod", {{0, 1}}, ScalarFunction::formula("1 + 0.3*sin(2*t)"), {}}};
  system.velocities = {0, 0, 0, 0.6, 0.0, 0.0};

  const RoundTrip trip(system, 0.002, 300);

  EXPECT_LT(trip.control, 1e-6);
  EXPECT_LT(trip.reactions, 1e-6 * trip.size);
}

TEST(InverseDynamics, ControlForceAppliedBringsTheProgrammedMotionBack) {
  System system = make_heavy_pendulum();
  InverseDynamics problem(system);
  std::vector<double> times, control[3];
  for (int k = 0; k <= 400; ++k) {
    times.push_back(0.005 * k);
    const MotionForces forces = problem.evaluate(times.back(), turn(times.back()));
    for (std::size_t c = 0; c < 3; ++c) control[c].push_back(forces.control_forces[3 + c]);
  }
  system.velocities = turn(0.0).rate;
  system.forces.push_back(
      ConstantForce{"control",
                    {1},
                    {ScalarFunction::table(times, control[0]), ScalarFunction::table(times, control[1]),
                     ScalarFunction::table(times, control[2])}});
  Simulation simulation(system, {.method = Method::Dopri5, .rtol = 1e-12, .atol = 1e-13});

  ASSERT_TRUE(simulation.advance_to(2.0).ok());

  const MotionState wanted = turn(2.0);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(simulation.positions()[i], wanted.value[i], 1e-8);
    EXPECT_NEAR(simulation.velocities()[i], wanted.rate[i], 1e-8);
  }
}

// ---- motions that are none ---------------------------------------------------------------------------------------

TEST(InverseDynamics, NamesTheRowThatAMotionBreaksAndByHowMuch) {
  InverseDynamics problem(make_double_pendulum());
  // The second rod is 1 % too long, and its bead is 0.25 m/s and 3 m/s^2 off along it.
  const double l = std::sqrt(1.04);
  MotionState state{make_double_pendulum().positions, std::vector<double>(9, 0.0), std::vector<double>(9, 0.0)};
  const double along[3] = {0.0, -1.0 / l, 0.2 / l};
  for (std::size_t c = 0; c < 3; ++c) {
    state.value[6 + c] += 0.01 * l * along[c];
    state.rate[6 + c] = 0.25 * along[c];
  }
  state.acceleration = std::vector<double>(9, 0.0);
  for (std::size_t c = 0; c < 3; ++c) state.acceleration[6 + c] = 3.0 * along[c];

  const MotionForces forces = problem.evaluate(0.0, state);

  EXPECT_NEAR(forces.position.largest, 0.01, 1e-14);
  EXPECT_EQ(forces.position.where, "rods[1]");
  EXPECT_NEAR(forces.velocity.largest, 0.25, 1e-14);
  EXPECT_EQ(forces.velocity.where, "rods[1]");
  EXPECT_NEAR(forces.acceleration.largest, 3.0, 1e-13);  // |v|^2 is all along the rod
  EXPECT_EQ(forces.acceleration.where, "rods[1]");
  EXPECT_TRUE(forces.outcome.ok());
}

TEST(InverseDynamics, SupportsThatDoNotMoveAsPrescribedAreNamed) {
  InverseDynamics problem(make_heavy_pendulum());
  MotionState state = turn(0.0);
  state.value[2] = 0.5;  // the scene is 1 m large

  const MotionForces forces = problem.evaluate(0.0, state);

  EXPECT_NEAR(forces.position.largest, 0.5, 1e-15);
  EXPECT_EQ(forces.position.where, "point 0");
}

TEST(InverseDynamics, RedundantRodsShareTheLoadInEqualParts) {
  System system = make_heavy_pendulum();
  system.constraints.push_back(Rods{"twin", {{1, 0}}, {}, {}});
  InverseDynamics problem(system);

  const MotionForces forces = problem.evaluate(0.7, turn(0.7));
  const MotionForces single = InverseDynamics(make_heavy_pendulum()).evaluate(0.7, turn(0.7));

  ASSERT_TRUE(forces.outcome.ok()) << forces.outcome.what;
  ASSERT_EQ(forces.multipliers.size(), 2U);
  EXPECT_NEAR(forces.multipliers[0], 0.5 * single.multipliers[0], 1e-12);
  EXPECT_NEAR(forces.multipliers[1], 0.5 * single.multipliers[0], 1e-12);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(forces.reactions[i], single.reactions[i], 1e-12);
}

TEST(MotionTable, RefusesTimesThatDoNotIncrease) {
  EXPECT_THROW(MotionTable({0.0, 1.0, 1.0}, {1.0, 2.0, 3.0}, 1), InputError);
  EXPECT_THROW(MotionTable({0.0, 1.0}, {1.0, 2.0, 3.0}, 1), InputError);
}

}  // namespace
}  // namespace tanor
