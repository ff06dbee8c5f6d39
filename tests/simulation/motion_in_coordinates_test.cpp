/// The motions in coordinates have bodies that spin, charts that are left, and normals that turn. Further tests check
/// which form is chosen and what is refused.

#include <cmath>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "errors.hpp"
#include "reference.hpp"

namespace tanor {
namespace {

using reference::vector;

// ---- a spinning body ---------------------------------------------------------------------------------------------

/// Makes the points of a body that has no symmetry and spins with omega, without forces.
System make_spinning_body(const Vector3& omega) {
  System system;
  system.positions = {0.5, 0.1, 0, -0.4, 0.3, 0.1, 0, -0.6, 0.2, 0.1, 0.2, 0.7, -0.2, -0.1, -0.5};
  system.masses = {1.0, 0.5, 2.0, 0.7, 1.2};
  for (std::size_t i = 0; i < 15; i += 3) {
    const double* const r = &system.positions[i];
    system.velocities.insert(
        system.velocities.end(),
        {omega[1] * r[2] - omega[2] * r[1], omega[2] * r[0] - omega[0] * r[2], omega[0] * r[1] - omega[1] * r[0]});
  }
  system.coordinates = {RigidBody{"body", {0, 1, 2, 3, 4}}};
  return system;
}

Eigen::Vector3d angular_momentum(const System& system, std::span<const double> r, std::span<const double> v) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < system.num_points(); ++i) {
    sum +=
        system.masses[i] * reference::point(r, static_cast<Index>(i)).cross(reference::point(v, static_cast<Index>(i)));
  }
  return sum;
}

/// The body tumbles many times over: it meets no pole of any chart, and conserved quantities stay.
TEST(RigidBodyTest, FreeTopKeepsEnergyMomentumAndShape) {
  const System system = make_spinning_body({0.3, 7.0, -2.0});
  Simulation simulation(system, {.rtol = 1e-13, .atol = 1e-14});
  const Eigen::Vector3d before = angular_momentum(system, simulation.positions(), simulation.velocities());

  ASSERT_TRUE(simulation.advance_to(10.0).ok());

  const Eigen::Vector3d after = angular_momentum(system, simulation.positions(), simulation.velocities());
  EXPECT_LE((after - before).norm(), 1e-10 * before.norm());
  EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-10);
  for (Index i = 0; i < 5; ++i) {
    for (Index j = 0; j < i; ++j) {
      const double length = (reference::point(system.positions, i) - reference::point(system.positions, j)).norm();
      EXPECT_NEAR((reference::point(simulation.positions(), i) - reference::point(simulation.positions(), j)).norm(),
                  length, 1e-14);
    }
  }
}

/// A body of revolution without forces precesses evenly: its axis turns around L with |L|/I1 (Euler).
TEST(RigidBodyTest, SymmetricTopPrecessesAsEulerSays) {
  // Four points of 1 kg lie on a square of half-diagonal a: I1 = I2 = 2 a^2, I3 = 4 a^2.
  constexpr double a = 0.5, I1 = 2.0 * a * a, I3 = 4.0 * a * a, spin = 5.0, wobble = 1.0;
  System system;
  system.positions = {a, 0, 0, 0, a, 0, -a, 0, 0, 0, -a, 0};
  system.masses = {1, 1, 1, 1};
  for (std::size_t i = 0; i < 12; i += 3) {
    // The body spins with omega = (wobble, 0, spin).
    const double* const r = &system.positions[i];
    system.velocities.insert(system.velocities.end(), {-spin * r[1], spin * r[0] - wobble * r[2], wobble * r[1]});
  }
  system.coordinates = {RigidBody{"", {0, 1, 2, 3}}};
  Simulation simulation(system, {.rtol = 1e-13, .atol = 1e-14});
  const double t_end = 4.0;

  ASSERT_TRUE(simulation.advance_to(t_end).ok());

  const Eigen::Vector3d L(I1 * wobble, 0.0, I3 * spin);
  const Eigen::Vector3d axis = Eigen::AngleAxisd(L.norm() / I1 * t_end, L.normalized()) * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d found =
      (reference::point(simulation.positions(), 0) - reference::point(simulation.positions(), 2))
          .cross(reference::point(simulation.positions(), 1) - reference::point(simulation.positions(), 3))
          .normalized();
  EXPECT_LE((found - axis).norm(), 1e-10);
}

// ---- charts ------------------------------------------------------------------------------------------------------

/// The bead runs on a great circle over both poles of every axis, which is exactly known, through thousands of
/// recentrings.
TEST(SphereTest, FreeBeadRunsOnItsGreatCircle) {
  constexpr double speed = 3.0, t_end = 40.0;
  System system;
  system.positions = {0, 0, 1};
  system.velocities = {speed, 0, 0};
  system.masses = {1};
  system.coordinates = {SphereCoordinates{"", {0}, Vector3{0, 0, 0}, 1.0}};
  Simulation simulation(system, {.method = Method::Rk4, .step = 1e-3});

  ASSERT_TRUE(simulation.advance_to(t_end).ok());

  EXPECT_NEAR(simulation.positions()[0], std::sin(speed * t_end), 1e-9);
  EXPECT_EQ(simulation.positions()[1], 0.0);
  EXPECT_NEAR(simulation.positions()[2], std::cos(speed * t_end), 1e-9);
  EXPECT_EQ(simulation.report().steps, 40'000u);
}

/// The normal of a plane and a circle turns through all axes, also the one that was chosen as helper: beads without
/// forces agree with the normal form.
TEST(TurningNormalTest, MotionIsThatOfTheNormalForm) {
  const VectorFunction normal = {ScalarFunction::formula("sin(2*t)*cos(3*t)"),
                                 ScalarFunction::formula("sin(2*t)*sin(3*t)"), ScalarFunction::formula("cos(2*t)")};
  System system;
  system.positions = {0.6, 0.2, 0, 0.5, 0, 0};
  system.masses = {1, 2};
  system.constraints = {Planes{"sheet", {0}, normal, 0.0}, Circles{"wire", {1}, Vector3{0, 0, 0}, normal, 0.5}};
  system.forces = {Gravity{"", {0, 0, -9.81}}, Springs{"", {{0, 1}}, 5.0, 0.0, 0.1}};
  System both = system;
  both.coordinates = {PlaneCoordinates{"", {0}, normal, 0.0},
                      CircleCoordinates{"", {1}, Vector3{0, 0, 0}, normal, 0.5}};
  const MotionOptions options{.rtol = 1e-12, .atol = 1e-13, .start = StartMode::Project};
  Simulation by_constraints(system, options), by_coordinates(both, options, {.form = Form::Tangent});

  for (const double t : {0.7, 1.5, 3.0}) {
    ASSERT_TRUE(by_constraints.advance_to(t).ok());
    ASSERT_TRUE(by_coordinates.advance_to(t).ok());

    EXPECT_LE((vector(by_coordinates.positions()) - vector(by_constraints.positions())).norm(), 1e-9) << "t = " << t;
    EXPECT_LE((vector(by_coordinates.reactions()) - vector(by_constraints.reactions())).norm(), 1e-7) << "t = " << t;
  }
}

// ---- choices and refusals ----------------------------------------------------------------------------------------

/// Makes points on a helix, each held by rods to three earlier ones: a rigid body of 3n - 6 rods.
System make_framework(std::size_t num_points, bool with_coordinates) {
  System system;
  Rods rods{"frame", {}, {}, {}};
  RigidBody body{"body", {}};
  for (std::size_t i = 0; i < num_points; ++i) {
    const double x = static_cast<double>(i);
    system.positions.insert(system.positions.end(), {0.1 * std::cos(2.0 * x), 0.1 * std::sin(2.0 * x), 0.05 * x});
    system.masses.push_back(1.0);
    for (std::size_t k = 1; k <= std::min<std::size_t>(i, 3); ++k) {
      rods.pairs.push_back({static_cast<Index>(i - k), static_cast<Index>(i)});
    }
    body.points.push_back(static_cast<Index>(i));
  }
  system.constraints = {rods};
  if (with_coordinates) system.coordinates = {body};
  return system;
}

TEST(ChoiceTest, RigidBodyOfManyPointsIsSolvedInTangentForm) {
  const Dynamics dynamics(make_framework(1000, true));

  EXPECT_EQ(dynamics.plan().form, Form::Tangent);
  EXPECT_EQ(dynamics.plan().coordinates, 6u);
  EXPECT_EQ(dynamics.plan().equations, 2994u);
  // The counts are 576,193 and 60,107; docs/solvers.md has the times.
  EXPECT_GE(dynamics.plan().normal_flops, 9.0 * dynamics.plan().tangent_flops);
}

TEST(ChoiceTest, LongChainIsSolvedInNormalForm) {
  System chain;
  Rods rods{"rods", {}, 0.1, {}};
  ChainAngles angles{"", {}, 0, 0.1, {}};
  for (Index i = 0; i <= 200; ++i) {
    chain.positions.insert(chain.positions.end(), {0.1 * i, 0, 0});
    chain.masses.push_back(1.0);
    if (i == 0) continue;
    rods.pairs.push_back({i - 1, i});
    angles.points.push_back(i);
  }
  chain.supports = {{"", {0}, {}}};
  chain.constraints = {rods};
  chain.coordinates = {angles};

  EXPECT_EQ(Dynamics(chain).plan().form, Form::Normal);
  EXPECT_EQ(Dynamics(chain, {.form = Form::Tangent}).plan().form, Form::Tangent);
}

TEST(RefusalTest, FormsThatTheSystemDoesNotHaveAreRefused) {
  System constraints = make_framework(4, false), coordinates = make_framework(4, true);
  coordinates.constraints.clear();

  EXPECT_EQ(error_of([&] { Dynamics(constraints, {.form = Form::Tangent}); }),
            "/solver/form: the tangent form needs coordinates; none are given");
  EXPECT_EQ(error_of([&] { Dynamics(coordinates, {.form = Form::Both}); }),
            "/solver/form: both forms need constraints too; coordinates alone are given");
  EXPECT_EQ(error_of([&] { Simulation(coordinates, {.method = Method::Rattle, .step = 1e-3}); }),
            "/motion/method: rattle projects onto constraints, the tangent form has none; rk4, dopri5 and dop853 "
            "step in coordinates");
  EXPECT_EQ(Simulation(make_framework(1000, true), {.method = Method::Rattle, .step = 1e-3}).plan().form, Form::Normal);
}

TEST(RefusalTest, ConstraintsThatTheCoordinatesBreakAreNamed) {
  // A rod to a support at its centre allows a bead to go round a circle of radius 1; a rod to another place does not.
  System system;
  system.positions = {0, 0, 0, 1, 0, 0, 0.5, 0, 0};
  system.masses = {1, 1, 1};
  system.supports = {{"", {0, 2}, {}}};
  system.coordinates = {CircleCoordinates{"", {1}, Vector3{0, 0, 0}, Vector3{0, 0, 1}, 1.0}};
  system.constraints = {Rods{"spoke", {{0, 1}}, {}, {}}};
  std::vector<double> r = system.positions, v(9, 0.0);
  for (const Form form : {Form::Auto, Form::Normal, Form::Tangent}) {
    system.constraints = {Circles{"rim", {1}, Vector3{0, 0, 0}, Vector3{0, 0, 1}, 1.0}};
    EXPECT_EQ(error_of([&] {
                (void)Dynamics(system, {.form = form})
                    .start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Check);
              }),
              "no error");
    system.constraints = {Circles{"rim", {1}, Vector3{0, 0, 0}, Vector3{0, 0, 1}, ScalarFunction::formula("1 + t^2")}};
    EXPECT_NE(error_of([&] {
                (void)Dynamics(system, {.form = form})
                    .start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Check);
              }).find("/coordinates: the accelerations that the coordinates describe violate rim[0].1"),
              std::string::npos);
    system.constraints = {Rods{"spoke", {{0, 1}}, 1.1, {}}};
    EXPECT_NE(error_of([&] {
                (void)Dynamics(system, {.form = form})
                    .start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Check);
              }).find("/coordinates: the places that the coordinates describe violate spoke[0]"),
              std::string::npos);
    system.constraints = {Linears{"wall", {{1}}, {{1, 1, 0}}, 1.0}};
    EXPECT_NE(error_of([&] {
                (void)Dynamics(system, {.form = form})
                    .start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Check);
              }).find("/coordinates: the coordinates move along the gradient of wall[0]"),
              std::string::npos);
  }
}

/// Returns the message of a start in a form.
std::string complaint_at_start(const System& system, Form form) {
  return error_of([&] {
    std::vector<double> r = system.positions, v(r.size(), 0.0);
    (void)Dynamics(system, {.form = form}).start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Check);
  });
}

TEST(RefusalTest, CoordinatesNarrowerThanTheConstraintsAreRefused) {
  // A plane holds beads 1 and 2; the coordinates hold bead 2 on a circle in it. K'A = 0, and yet the forms differ.
  System system;
  system.positions = {0, 0, 0, 3, 1, 0, 1, 0, 0};
  system.masses = {1, 1e-3, 1e3};
  system.supports = {{"", {0}, {}}};
  system.constraints = {Planes{"floor", {1, 2}, Vector3{0, 0, 1}, 0.0}};
  const PlaneCoordinates first{"", {1}, Vector3{0, 0, 1}, 0.0};
  for (const Form form : {Form::Auto, Form::Normal, Form::Tangent, Form::Both}) {
    system.coordinates = {first, PlaneCoordinates{"", {2}, Vector3{0, 0, 1}, 0.0}};
    EXPECT_EQ(complaint_at_start(system, form), "no error");
    system.coordinates = {first, CircleCoordinates{"", {2}, Vector3{0, 0, 0}, Vector3{0, 0, 1}, 1.0}};
    EXPECT_EQ(
        complaint_at_start(system, form),
        "/coordinates: the coordinates are narrower than the constraints, which let point 2 move where no "
        "coordinate leads: rank K = 2 and rank A = 3 do not add up to 3n = 6; both must describe the same motion");
    // These coordinates are wider: the bead rises from the floor.
    system.coordinates = {first, FreeCoordinates{"", {2}}};
    EXPECT_NE(complaint_at_start(system, form).find("at point 2: they are wider than the constraints"),
              std::string::npos);
  }
}

TEST(RefusalTest, DependentRowsDoNotCountAsALackOfCoordinates) {
  // A crank has three rods between two supports, and one of them is given twice.
  System bar;
  bar.positions = {0, 0, 0, 1, 0, 0, 3, 0, 0};
  bar.masses = {1, 1, 1};
  bar.supports = {{"", {0, 2}, {}}};
  bar.constraints = {Rods{"crank", {{0, 1}, {0, 1}}, {}, {}}, Planes{"page", {1}, Vector3{0, 0, 1}, 0.0}};
  bar.coordinates = {CircleCoordinates{"", {1}, Vector3{0, 0, 0}, Vector3{0, 0, 1}, 1.0}};
  for (const Form form : {Form::Normal, Form::Tangent}) EXPECT_EQ(complaint_at_start(bar, form), "no error");
}

TEST(RefusalTest, ASingularConfigurationIsAcceptedForItsRegularNeighbours) {
  // A parallelogram lies flat: K lacks a rank there but not nearby, and its crank's angle leads on.
  System flat;
  flat.positions = {0, 0, 0, 1, 0, 0, 3, 0, 0, 2, 0, 0};
  flat.masses = {1, 1, 1, 1};
  flat.supports = {{"", {0, 3}, {}}};
  flat.constraints = {Rods{"bars", {{0, 1}, {1, 2}, {3, 2}}, {}, {}}, Planes{"page", {1, 2}, Vector3{0, 0, 1}, 0.0}};
  const std::vector<std::string> names = {"a"}, x = {"cos(a)", "sin(a)", "0", "2+cos(a)", "sin(a)", "0"};
  flat.coordinates = {UserCoordinates{"crank", {{1, 2}}, formula_coordinates(names, x), {0.0}, {1.0}}};
  EXPECT_EQ(complaint_at_start(flat, Form::Tangent), "no error");
}

TEST(RefusalTest, CoordinateThatMovesNothingIsNamed) {
  System system;
  system.positions = {1, 0, 0};
  system.masses = {1};
  const std::vector<std::string> names = {"a", "b"}, components = {"cos(a)", "sin(a)", "0"};
  system.coordinates = {UserCoordinates{"wheel", {{0}}, formula_coordinates(names, components), {0.0, 0.0}, {}}};
  Dynamics dynamics(system);
  std::vector<double> w(3);

  const SolveReport report = dynamics.solve(
      {.time = 0.0, .positions = system.positions, .velocities = std::vector<double>(3, 0.0)}, {.accelerations = w});

  EXPECT_EQ(report.outcome.status, Status::Singular);
  EXPECT_NE(report.outcome.what.find("coordinate wheel[1] moves no point"), std::string::npos) << report.outcome.what;
}

/// The coordinates q, q - 2 pi and so on put the point at the same place.
TEST(CoordinatesOfAUser, KeepTheTurnOfTheStart) {
  const std::vector<std::string> names = {"q"}, components = {"cos(q)", "sin(q)", "0"};
  for (const double q : {0.5, 4.0, -9.0, 100.0}) {
    System system;
    system.positions = {std::cos(q), std::sin(q), 0.0};
    system.masses = {1.0};
    system.forces = {Gravity{"", {0.0, -9.81, 0.0}}};
    system.coordinates = {UserCoordinates{"wheel", {{0}}, formula_coordinates(names, components), {q}, {}}};
    Simulation simulation(system, {});

    EXPECT_NEAR(simulation.solution().coordinates[0], q, 1e-13);
    ASSERT_TRUE(simulation.advance_to(0.01).ok());
    EXPECT_NEAR(simulation.solution().coordinates[0], q - 0.5 * 9.81 * std::cos(q) * 1e-4, 1e-5);
  }
}

/// A bead swings on two rods. The circle of its coordinate lies a little aside, which counts as rounding of the input.
/// The normal form starts where the rods have their lengths, and so do its first accelerations.
TEST(MotionInCoordinates, TheNormalFormStartsWhereConstraintsAreMet) {
  System system;
  system.positions = {-1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0};
  system.velocities = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0};
  system.masses = {1.0, 1.0, 1.0};
  system.supports = {{"", {0, 1}, {}}};
  system.constraints = {Rods{"rods", {{0, 2}, {1, 2}}, std::sqrt(2.0), {}}};
  system.coordinates = {CircleCoordinates{"angle", {2}, Vector3{3e-10, 0.0, 0.0}, Vector3{1.0, 0.0, 0.0}, 1.0}};
  system.forces = {Gravity{"", {3.0, -9.81, 1.0}}};
  const SolverOptions normal{.form = Form::Normal, .linear_solver = LinearSolver::General};
  const Simulation simulation(system, {}, normal);
  Dynamics dynamics(system, normal);
  std::vector<double> w(9);

  const SolveReport report = dynamics.solve(
      {.time = 0.0, .positions = simulation.positions(), .velocities = simulation.velocities()}, {.accelerations = w});

  ASSERT_TRUE(report.outcome.ok() && simulation.outcome().ok());
  for (std::size_t c = 0; c < w.size(); ++c) EXPECT_NEAR(simulation.accelerations()[c], w[c], 1e-12) << c;
}

}  // namespace
}  // namespace tanor
