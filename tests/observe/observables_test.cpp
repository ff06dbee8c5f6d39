#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include <tanor/motion.hpp>

#include "errors.hpp"
#include "measures.hpp"
#include "observe/cable.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

TEST(Observables, TensionsAndLoadOfAHangingCableAreWeights) {
  Simulation simulation(make_cable(10));
  for (const char* text :
       {"max tension(links)", "min tension(links)", "load(hook)", "tension(links[9])", "tension(links)",
        "sum tension(links)", "load(hook).z/9.81", "load(hook).norm", "distance(0, 10)"})
    simulation.add_observable({.text = text});
  const std::span<const Observed> found = simulation.observe();
  const Observed& largest = find(found, "max tension(links)");
  EXPECT_NEAR(largest.values[0], 5.0 * of_earth, 1e-12);
  EXPECT_EQ(largest.member, "links[0]");
  EXPECT_EQ(largest.unit, "N");
  EXPECT_NEAR(find(found, "min tension(links)").values[0], 0.5 * of_earth, 1e-12);
  EXPECT_NEAR(find(found, "load(hook)").values[2], -5.0 * of_earth, 1e-12);
  EXPECT_EQ(find(found, "load(hook)").parts, (std::vector<std::string>{"x", "y", "z"}));
  EXPECT_NEAR(find(found, "tension(links[9])").values[0], 0.5 * of_earth, 1e-12);
  ASSERT_EQ(find(found, "tension(links)").values.size(), 10u);
  EXPECT_NEAR(find(found, "tension(links)").values[4], 3.0 * of_earth, 1e-12);
  EXPECT_NEAR(find(found, "sum tension(links)").values[0], 27.5 * of_earth, 1e-11);
  EXPECT_NEAR(find(found, "load(hook).z/9.81").values[0], -5.0, 1e-12);
  EXPECT_NEAR(find(found, "load(hook).norm").values[0], 5.0 * of_earth, 1e-12);
  EXPECT_NEAR(find(found, "distance(0, 10)").values[0], 1.0, 1e-14);
  EXPECT_EQ(column_names(find(found, "load(hook)"))[2], "load(hook).z");
  EXPECT_EQ(column_names(find(found, "tension(links)"))[3], "tension(links): links[3]");
}

/// A crank of radius R that turns by omega t drives a slider of mass m along x through a rod of length l. The torque of
/// the motor is m x_ddot dx/dphi, by virtual work.
TEST(Observables, TorqueOfASliderCrankIsThatOfVirtualWork) {
  const double R = 0.2, l = 0.7, omega = 3.0, m = 1.3;
  System system;
  const Point crank = system.add_support(
      {R, 0.0, 0.0},
      VectorFunction(ScalarFunction::formula("0.2*cos(3*t) - 0.2"), ScalarFunction::formula("0.2*sin(3*t)"), 0.0),
      "crank");
  const Point slider = system.add_point({.position = {R + l, 0.0, 0.0}, .mass = m});
  system.add_rods("rod").join(crank, slider);
  system.constraints.push_back(
      Lines{.name = "rail", .points = {slider.index}, .origin = Vector3{}, .direction = Vector3{1, 0, 0}});
  Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-12, .start = StartMode::Project});
  simulation.add_observable({.name = "torque", .text = "moment(crank, z, [0, 0, 0])", .every_step = true});
  simulation.add_observable({.name = "rail", .text = "force(rail)"});
  for (const double t : {0.3, 0.9, 1.7}) {
    ASSERT_TRUE(simulation.advance_to(t).ok());
    const double phi = omega * t, s = std::sin(phi), c = std::cos(phi);
    const double root = std::sqrt(l * l - R * R * s * s);
    const double x1 = -R * s - R * R * s * c / root;  // dx/dphi
    const double x2 = -R * c - R * R * (c * c - s * s) / root - R * R * R * R * s * s * c * c / (root * root * root);
    const std::span<const Observed> found = simulation.observe();
    EXPECT_NEAR(find(found, "torque").values[0], m * omega * omega * x2 * x1, 1e-9) << t;
    // The rail carries what the rod pushes across it.
    const double tension = -simulation.multipliers()[0];
    EXPECT_NEAR(find(found, "rail").values[1], -tension * R * s / l, 1e-9);
  }
  const Observed& torque = find(simulation.observe(), "torque");
  EXPECT_LT(torque.least[0].value, torque.values[0]);
  EXPECT_GT(torque.largest[0].value, torque.values[0]);
  EXPECT_GT(torque.largest[0].time, 0.0);
}

TEST(Observables, SpringsBondsAndPulleysHaveTensions) {
  System system;
  const Point a = system.add_support({0.0, 0.0, 0.0}), b = system.add_point({.position = {0.0, 0.0, -1.2}});
  system.forces.push_back(
      Springs{.name = "spring", .pairs = {{a.index, b.index}}, .stiffness = 30.0, .rest_length = 1.0});
  system.forces.push_back(Bonds{.name = "bond",
                                .pairs = {{a.index, b.index}},
                                .law = BondLaw::Morse,
                                .rest_length = 1.0,
                                .depth = 2.0,
                                .width = 1.5});
  const Point left = system.add_point({.position = {1.0, 0.0, -1.0}, .mass = 1.0});
  const Point right = system.add_point({.position = {2.0, 0.0, -1.0}, .mass = 3.0});
  system.constraints.push_back(
      Pulleys{.name = "rope", .pairs = {{left.index, right.index}}, .a = {1, 0, 0}, .b = {2, 0, 0}});
  system.add_gravity({0.0, 0.0, -of_earth});
  Simulation simulation(system);
  for (const char* text : {"tension(spring)", "tension(bond)", "tension(rope)", "force(rope)", "potential(spring)"})
    simulation.add_observable({.text = text});
  const std::span<const Observed> found = simulation.observe();
  EXPECT_NEAR(find(found, "tension(spring)").values[0], 6.0, 1e-12);
  const double e = std::exp(-1.5 * 0.2);
  EXPECT_NEAR(find(found, "tension(bond)").values[0], 2.0 * 2.0 * 1.5 * e * (1.0 - e), 1e-12);
  EXPECT_NEAR(find(found, "tension(rope)").values[0], 2.0 * 1.0 * 3.0 / 4.0 * of_earth, 1e-12);
  EXPECT_NEAR(find(found, "force(rope)").values[2], 2.0 * 1.5 * of_earth, 1e-11);
  EXPECT_NEAR(find(found, "potential(spring)").values[0], 0.5 * 30.0 * 0.04, 1e-13);
}

/// Dumbbells in a periodic box whose pairs reach through the faces: the virial by a double loop over pairs.
TEST(Observables, PressureOfDumbbellsIsThatOfADoubleLoop) {
  const double edge = 4.0;
  System system;
  system.cell = Cell{.xx = edge, .yy = edge, .zz = edge};
  system.units = units_from_name("lj");
  RodGroup rods = system.add_rods("rods");
  std::vector<std::array<Index, 2>> pairs;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double x = 0.1 + 1.33 * i, y = 0.07 + 1.33 * j, z = 0.2 + 0.9 * ((i + 2 * j) % 4);
      const Point a = system.add_point({.position = {x, y, z}, .velocity = {0.3 - 0.1 * j, 0.1 * i, 0.0}});
      const Point b = system.add_point({.position = {x, y, z + 0.95}, .velocity = {0.3 - 0.1 * j, 0.1 * i, 0.0}});
      rods.join(a, b);
      pairs.push_back({a.index, b.index});
    }
  system.forces.push_back(
      PairForces{.law = PairLaw::Lj, .sigma = 1.0, .cutoff = 1.9, .box = {edge, edge, edge}, .exclude_rods = true});
  Simulation simulation(system, {.rtol = 1e-9});
  for (const char* text : {"pressure()", "virial()", "temperature()"}) simulation.add_observable({.text = text});
  ASSERT_TRUE(simulation.advance_to(0.3).ok());

  const std::span<const double> r = simulation.positions(), v = simulation.velocities();
  std::array<double, 6> w{};
  const auto add = [&](const double* d, double over) {
    constexpr int first[] = {0, 1, 2, 0, 0, 1}, second[] = {0, 1, 2, 1, 2, 2};
    for (int k = 0; k < 6; ++k) w[static_cast<std::size_t>(k)] += over * d[first[k]] * d[second[k]];
  };
  double kinetic = 0.0;
  const auto n = static_cast<Index>(r.size() / 3);
  for (Index i = 0; i < n; ++i) {
    for (int axis = 0; axis < 3; ++axis) kinetic += 0.5 * v[3 * i + axis] * v[3 * i + axis];
    for (Index j = i + 1; j < n; ++j) {
      double d[3], r2 = 0.0;
      const bool is_rod = i % 2 == 0 && j == i + 1;
      for (int axis = 0; axis < 3; ++axis) {
        d[axis] = r[3 * j + axis] - r[3 * i + axis];
        if (!is_rod) d[axis] -= edge * std::round(d[axis] / edge);
        r2 += d[axis] * d[axis];
      }
      const double s6 = 1.0 / (r2 * r2 * r2);
      if (is_rod)
        add(d, simulation.multipliers()[static_cast<std::size_t>(i / 2)] / std::sqrt(r2));
      else if (r2 < 1.9 * 1.9)
        add(d, 24.0 * s6 * (2.0 * s6 - 1.0) / r2);
    }
  }
  const std::span<const Observed> found = simulation.observe();
  double size = 0.0;
  for (const double each : w) size = std::max(size, std::abs(each));
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(find(found, "virial()").values[k], w[k], 1e-11 * size) << k;
  EXPECT_NEAR(find(found, "pressure()").values[0], (2.0 * kinetic + w[0] + w[1] + w[2]) / (3.0 * 64.0), 1e-12 * size);
  EXPECT_NEAR(find(found, "temperature()").values[0], 2.0 * kinetic / (3.0 * 18.0 - 9.0 - 3.0), 1e-13);
}

/// A rod that turns has the same virial where it joins an image of its second point.
TEST(Observables, VirialOfARodThroughAFaceIsThatOfTheWholeMolecule) {
  const double edge = 4.0;
  std::vector<std::vector<double>> found;
  for (const double shift : {0.0, edge}) {
    System system;
    system.cell = Cell{.xx = edge, .yy = edge, .zz = edge};
    system.units = units_from_name("lj");
    system.add_point({.position = {0.1, 1.0, 1.0}, .velocity = {0.0, 1.0, 0.0}});
    system.add_point({.position = {-0.4 + shift, 1.0, 1.2}, .velocity = {0.0, -1.0, 0.0}});
    system.constraints.push_back(Rods{.name = "rods", .pairs = {{0, 1}}, .offsets = {{-shift, 0.0, 0.0}}});
    Simulation simulation(system, {.rtol = 1e-10});
    for (const char* text : {"virial()", "pressure()"}) simulation.add_observable({.text = text});
    simulation.observe();
    found.push_back(simulation.observe()[0].values);
    found.back().push_back(simulation.observe()[1].values[0]);
  }
  EXPECT_NEAR(found[0][0], -2.0 * 0.25 / 0.29, 1e-12);  // -T x^2/L with T/L = 2 v^2/L^2
  for (std::size_t k = 0; k < found[0].size(); ++k) EXPECT_NEAR(found[0][k], found[1][k], 1e-12) << k;
}

/// The tension of a pendulum follows from its state, T = m v^2/L + F.r/L, also at steps of methods that leave no forces
/// behind, or those before the constraints alone. A spring to (1, 3, 0) makes them differ from place to place.
class ObservablesAtSteps : public testing::TestWithParam<std::tuple<Method, double>> {};
INSTANTIATE_TEST_SUITE_P(Methods, ObservablesAtSteps,
                         testing::Combine(testing::Values(Method::Rattle, Method::Rattle4, Method::Rk4, Method::Dopri5,
                                                          Method::Taylor),
                                          testing::Values(0.0, 5.0)));

TEST_P(ObservablesAtSteps, TensionsAreThoseOfTheState) {
  {
    const auto [method, stiffness] = GetParam();
    System system;
    const Point hook = system.add_support({0.0, 0.0, 0.0}),
                bob = system.add_point({.position = {1.0, 0.0, 0.0}, .mass = 2.0}),
                wall = system.add_support({1.0, 3.0, 0.0});
    system.add_rods("rod").join(hook, bob);
    system.add_gravity({0.0, 0.0, -of_earth});
    if (stiffness > 0.0)
      system.forces.push_back(
          Springs{.name = "spring", .pairs = {{bob.index, wall.index}}, .stiffness = stiffness, .rest_length = 1.0});
    Simulation simulation(system, {.method = method, .step = has_fixed_steps(method) ? 1e-2 : 0.0});
    simulation.add_observable({.text = "max tension(rod)", .every_step = true});
    simulation.add_observable({.text = "tension(rod)"});
    double largest = 0.0, worst = 0.0;

    const Outcome outcome = simulation.advance_to(1.0, [&](const MotionReport&) {
      const Solution at = simulation.solution();
      const double *const v = at.velocities.data() + 3, *const r = at.positions.data() + 3;
      const double length = std::hypot(1.0 - r[0], 3.0 - r[1], r[2]);
      const double outwards = (1.0 - r[0]) * r[0] + (3.0 - r[1]) * r[1] - r[2] * r[2];
      const double tension = 2.0 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - of_earth * r[2]) +
                             stiffness * (length - 1.0) / length * outwards;
      largest = std::max(largest, tension);
      worst = std::max(worst, std::abs(simulation.observe(false)[1].values[0] - tension));
      return true;
    });

    ASSERT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_GT(largest, 40.0) << name_of(method);  // 6 g = 58.86 N at the bottom without the spring
    EXPECT_LT(worst, 1e-10) << name_of(method);
    EXPECT_NEAR(simulation.observe(false)[0].largest[0].value, largest, 1e-10) << name_of(method);
  }
}

/// Tensions of rods whose islands stand alone in lanes are solved for without accelerations. They are those of another
/// solver at the state of each step, as those of chains in pieces and of nets are. Springs make forces that change.
TEST(Observables, TensionsOfManyRodsAtStepsAreThoseOfAnotherSolver) {
  System hung = scenes::make_clusters(30);
  for (std::size_t i = 12; i < hung.masses.size(); i += 3) hung.masses[i] *= 0.01;
  hung.supports = {{"hooks", {}, {}}};
  for (Index cluster = 0; cluster < 30; ++cluster) hung.supports[0].points.push_back(11 * cluster);
  for (System system :
       {scenes::make_clusters(30), hung, scenes::make_chain_along(300, {0.1, 0.02, 0.0}), scenes::make_net(9, 9)}) {
    system.forces.push_back(Springs{.name = "spring", .pairs = {{0, 2}, {1, 4}}, .stiffness = 3.0});
    Simulation simulation(system, {.method = Method::Rattle, .step = 1e-3, .start = StartMode::Project});
    simulation.add_observable({.text = "each tension(rods)", .every_step = true});
    Dynamics reference(system, {.linear_solver = LinearSolver::Cholmod});
    std::vector<double> lambda(reference.num_equations());
    const Outcome outcome = simulation.advance_to(0.02, [&](const MotionReport&) {
      const std::vector<double> found = simulation.observe(false)[0].values;
      const Solution at = simulation.solution();
      const StateView state{.time = at.time, .positions = at.positions, .velocities = at.velocities};
      EXPECT_TRUE(reference.solve(state, {.multipliers = lambda}).outcome.ok());
      for (double& each : lambda) each = -each;
      EXPECT_LE(relative_difference(found, lambda), 1e-11) << at.time << ", " << lambda.size() << " rods";
      return true;
    });
    ASSERT_TRUE(outcome.ok()) << outcome.what;
  }
}

/// Steps of `rattle` end with K, its factor and the forces, those of adaptive methods with the accelerations, so that
/// tensions at every step evaluate no force anew.
TEST(Observables, TensionsAtStepsEvaluateNoForces) {
  const auto count_evaluations = [](Method method, bool observes) {
    std::size_t evaluations = 0;
    PotentialKernel weight{.num_points = 1, .thread_safe = false, .depends_on_time = false};
    weight.context = std::shared_ptr<void>(&evaluations, [](void*) {});
    weight.evaluate = [](const void* context, const PotentialBatch& batch) {
      for (std::size_t k = 0; k < batch.count; ++k) batch.energy[k] = of_earth * batch.r[3 * k + 2];
      if (batch.hessian != nullptr) std::fill_n(batch.hessian, 9 * batch.count, 0.0);
      if (batch.gradient == nullptr) return;
      ++*static_cast<std::size_t*>(const_cast<void*>(context));
      for (std::size_t k = 0; k < 3 * batch.count; ++k) batch.gradient[k] = k % 3 == 2 ? of_earth : 0.0;
    };
    System system;
    const Point hook = system.add_support({0.0, 0.0, 0.0}), bob = system.add_point({.position = {1.0, 0.0, 0.0}});
    system.add_rods("rod").join(hook, bob);
    system.forces.push_back(Potential{.name = "weight", .points = {{bob.index}}, .kernel = weight});
    Simulation simulation(system, {.method = method, .step = 1e-2});
    if (observes) simulation.add_observable({.text = "tension(rod)", .every_step = true});
    EXPECT_TRUE(simulation.advance_to(0.5).ok());
    return evaluations;
  };
  for (const Method method : {Method::Rattle, Method::Dopri5, Method::Dop853}) {
    const std::size_t plain = count_evaluations(method, false);
    EXPECT_GE(plain, 50u);
    EXPECT_EQ(count_evaluations(method, true), plain) << name_of(method);
  }
}

/// Numbers that were told are compared with a second evaluation, also where numbers cancel: of two hooks that carry the
/// same, of forces across the plane of a motion, of an energy of 0.
TEST(Observables, ACertificateSeesEachNumberThatIsWrong) {
  System system = scenes::make_melt(4);
  const double edge = 4.0 * scenes::spacing;
  system.cell = Cell{.xx = edge, .yy = edge, .zz = edge};
  PairForces& pairs = std::get<PairForces>(system.forces[0]);
  for (Index point = 0; point < 64; ++point) pairs.points.push_back(point);
  const Point left = system.add_support({50.0, 0.0, 0.0}, {}, "left");
  const Point bob = system.add_point({.position = {51.0, 0.0, -1.0}, .mass = 2.0});
  const Point right = system.add_support({52.0, 0.0, 0.0}, {}, "right");
  RodGroup links = system.add_rods("links");
  links.join(left, bob);
  links.join(bob, right);
  system.forces.push_back(ConstantForce{"weight", {bob.index}, Vector3{0.0, 0.0, -20.0}});
  Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-9, .start = StartMode::Project});
  for (const char* text : {"each tension(rods)", "max tension(links)", "load(left)", "load(left).z - load(right).z",
                           "load(right).y", "moment(links, y, [1, 2, 3])", "temperature()", "pressure()", "virial()",
                           "energy()", "2*kinetic() - potential()", "acceleration(3)", "distance(0, 1)"})
    simulation.add_observable({.text = text});
  ASSERT_TRUE(simulation.advance_to(0.02).ok()) << simulation.outcome().what;
  const std::span<const Observed> found = simulation.observe();
  ASSERT_TRUE(simulation.certify().passed()) << simulation.certify().line();
  for (const Observed& each : found) {
    std::vector<double>& values = const_cast<Observed&>(each).values;
    double size = 0.0;
    for (const double value : values) size = std::max(size, std::abs(value));
    const double right_one = std::exchange(values.back(), values.back() + 1e-4 * std::max(size, 1.0));
    const Certificate certificate = simulation.certify();
    EXPECT_FALSE(certificate.passed()) << each.name;
    EXPECT_EQ(certificate.checks.back().where, each.name);
    values.back() = right_one;
  }
  ASSERT_TRUE(simulation.certify().passed());
  // Energies that the motion has kept wrongly show in all that is made of them.
  const_cast<MotionReport&>(simulation.report()).energy.kinetic *= 1.0 + 1e-6;
  simulation.observe();
  EXPECT_FALSE(simulation.certify().passed());
}

/// A weight hangs on four legs, which could also pull with T0 + s, T1 - s, T2 + s, T3 - s. What that changes is not
/// told, what it leaves as it is, and what three legs tell, is.
TEST(Observables, ForcesThatAreNotUniqueAreNotTold) {
  const double weight = 2.0 * of_earth, of_all = weight * 1.25 / 0.75;  // legs of 1.25 m, 0.75 m below their feet
  System system;
  system.positions = {1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0, 0, 0, -0.75};
  system.masses = {1, 1, 1, 1, 2};
  system.supports = {{.name = "feet", .points = {0, 1, 2, 3}}};
  system.constraints.push_back(Rods{.name = "legs", .pairs = {{0, 4}, {1, 4}, {2, 4}, {3, 4}}});
  system.add_gravity({0.0, 0.0, -of_earth});
  Simulation simulation(system);
  for (const char* text : {"tension(legs)", "max tension(legs)", "load(feet[0])", "sum tension(legs)", "load(feet)",
                           "tension(legs[0]) - tension(legs[2])", "reaction(4)", "tension(legs[0])"})
    simulation.add_observable({.text = text});
  const auto expect = [&](const std::string& name, const std::vector<double>& values, const std::string& unknown) {
    const Observed& seen = find(simulation.observe(), name);
    EXPECT_EQ(seen.unknown, unknown) << name;
    ASSERT_EQ(seen.values.size(), values.size());
    for (std::size_t k = 0; k < values.size(); ++k) {
      EXPECT_EQ(std::isnan(seen.values[k]), std::isnan(values[k])) << name << k;
      if (std::isnan(values[k])) continue;
      EXPECT_NEAR(seen.values[k], values[k], 1e-11) << name << k;
    }
  };
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  expect("tension(legs)", {none, none, none, none}, "not unique");
  expect("max tension(legs)", {none}, "not unique");
  EXPECT_EQ(find(simulation.observe(), "max tension(legs)").member, "");
  expect("load(feet[0])", {none, 0.0, none}, "not unique");
  expect("sum tension(legs)", {of_all}, "");
  expect("load(feet)", {0.0, 0.0, -weight}, "");
  expect("tension(legs[0]) - tension(legs[2])", {0.0}, "");
  expect("reaction(4)", {0.0, 0.0, weight}, "");
  EXPECT_NEAR(simulation.multipliers()[0], -0.25 * of_all, 1e-11) << "the smallest ones";
  EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
  const Observable any{.text = "max tension(legs)"};
  EXPECT_EQ(observe(system, std::span(&any, 1), simulation.solution())[0].unknown, "not unique");
  EXPECT_EQ(simulation.observe(std::span(&any, 1))[0].unknown, "not unique");

  simulation.add_event({.when = "t > 0.1", .action = EventAction::Break, .of = "legs[3]"});
  ASSERT_TRUE(simulation.advance_to(0.2).ok());
  EXPECT_EQ(simulation.passages()[0].name, "t > 0.1") << "what has no name has its condition";
  expect("tension(legs[0])", {0.5 * of_all}, "");
  expect("tension(legs)", {0.5 * of_all, 0.0, 0.5 * of_all, none}, "legs[3] broken at t = 0.1");
  expect("max tension(legs)", {0.5 * of_all}, "");
}

TEST(Observables, AGroupOfWhichSomeBrokeAndOthersShareSaysBoth) {
  System system;
  const Point hook = system.add_support({0.0, 0.0, 0.0}), bob = system.add_point({.position = {0.0, 0.0, -1.0}});
  RodGroup rods = system.add_rods("rods");
  for (int k = 0; k < 3; ++k) rods.join(hook, bob);
  system.add_gravity({0.0, 0.0, -of_earth});
  Simulation simulation(system);
  simulation.add_observable({.text = "tension(rods)"});
  simulation.add_observable({.text = "tension(rods[1])"});
  simulation.add_event({.when = "t > 0.1", .action = EventAction::Break, .of = "rods[1]"});
  ASSERT_TRUE(simulation.advance_to(0.2).ok());
  const std::span<const Observed> found = simulation.observe();
  EXPECT_EQ(found[0].unknown, "rods[1] broken at t = 0.1, others not unique");
  EXPECT_EQ(found[1].unknown, "broken at t = 0.1");
}

/// Two beads that stick share a load through the rod between them as the law of friction says; two rods elsewhere share
/// theirs openly.
TEST(Observables, FrictionChoosesForItsOwnIslandAlone) {
  System system;
  const Point left = system.add_point({.position = {0.0, 0.0, 0.0}}), right = system.add_point({{1.0, 0.0, 0.0}}),
              hook = system.add_support({5.0, 0.0, 0.0}), bob = system.add_point({{5.0, 0.0, -1.0}});
  system.add_rods("between").join(left, right);
  RodGroup pair = system.add_rods("pair");
  for (int k = 0; k < 2; ++k) pair.join(hook, bob);
  system.constraints.push_back(
      Lines{.name = "wire", .points = {left.index, right.index}, .origin = {}, .direction = Vector3{1, 0, 0}});
  system.friction.push_back(Coulomb{.at = {"wire"}, .coefficient = 0.5});
  system.add_gravity({0.0, 0.0, -of_earth});
  system.forces.push_back(ConstantForce{.points = {left.index}, .force = {1.0, 0.0, 0.0}});
  EXPECT_TRUE(Dynamics(system).solve({.positions = system.positions}, {}).friction.sticking_is_indeterminate);
  Simulation simulation(system);
  for (const char* text : {"tension(between)", "tension(pair)", "sum tension(pair)"})
    simulation.add_observable({.text = text});
  const std::span<const Observed> found = simulation.observe();
  EXPECT_EQ(found[0].unknown, "");
  EXPECT_TRUE(std::isfinite(found[0].values[0]));
  EXPECT_EQ(found[1].unknown, "not unique");
  EXPECT_NEAR(found[2].values[0], of_earth, 1e-12);
}

TEST(Observables, AFormulaHasTheUnitThatIsGivenAndAQuantityItsOwn) {
  System system = make_cable(2);
  Simulation simulation(system);
  simulation.add_observable({.text = "-load(hook).z/9.81", .unit = "kg"});
  EXPECT_EQ(simulation.observe()[0].unit, "kg");
  const Observable other{.text = "max tension(links)", .unit = "lbf"};
  EXPECT_EQ(error_of([&] { check_observable(system, other); }),
            "/unit: \"lbf\": \"max tension(links)\" is in N already");
  EXPECT_EQ(error_of([&] { check_observable(system, {.text = "2*t", .unit = "s\n"}); }),
            "/unit: wanted letters on one line, without quotes");
  system.units = {};
  EXPECT_EQ(observe(system, std::vector{other}, simulation.solution())[0].unit, "lbf");
}

}  // namespace
}  // namespace tanor
