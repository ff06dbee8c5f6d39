/// The cases are solved once more in coordinates.

#include <functional>

#include <gtest/gtest.h>
#include <tanor/dynamics.hpp>

#include "cases/reference_motion.hpp"

namespace tanor::cases {
namespace {

/// Makes coordinates of one or more points as formulas in the plane z = 0. They are named a, b, …; `q` is their
/// start.
UserCoordinates in_plane(const std::vector<Index>& points, const std::vector<std::string>& names,
                         const std::vector<std::string>& xy, const std::vector<double>& q,
                         const std::vector<double>& q_dot) {
  std::vector<std::string> components;
  for (std::size_t i = 0; i < xy.size(); i += 2) components.insert(components.end(), {xy[i], xy[i + 1], "0"});
  return {"", {points}, formula_coordinates(names, components), q, q_dot};
}

Coordinates planar_chain(const Instant& start, Parameter length) {
  ChainAngles chain{"", {}, 0, std::move(length), {0, 0, 1}};
  for (std::size_t k = 0; k < start.r.size() / 3; ++k) chain.points.push_back(static_cast<Index>(k + 1));
  return chain;
}

/// Makes the right angle at the origin with s (-yb, xb) on the left, and an axle of length 1.
Coordinates car_axis(const Instant&) {
  const std::string xb = "sqrt(1 - (0.1*sin(10*t))^2)", yb = "(0.1*sin(10*t))";
  // At the start yb' = cos(10 t), and the left bead moves with s (-yb', 0) = (-0.5, 0) without a rate of s.
  return in_plane({2, 3}, {"s", "a"}, {"-s*" + yb, "s*" + xb, "-s*" + yb + " + cos(a)", "s*" + xb + " + sin(a)"},
                  {0.5, 0.0}, {0.0, 0.0});
}

/// Makes the angles of both ropes and the length of the left one.
Coordinates atwood(const Instant& start) {
  const double x = start.r[0] + 1.0, y = start.r[1], l = std::hypot(x, y), X = start.r[3] - 1.0, Y = start.r[4];
  const double vx = start.v[0], vy = start.v[1], VX = start.v[3], VY = start.v[4], L = std::hypot(X, Y);
  return in_plane({0, 1}, {"a", "b", "l"}, {"-1 + l*sin(a)", "-l*cos(a)", "1 + (3-l)*sin(b)", "-(3-l)*cos(b)"},
                  {std::atan2(x, -y), std::atan2(X, -Y), l},
                  {(x * vy - y * vx) / (l * l), (X * VY - Y * VX) / (L * L), (x * vx + y * vy) / l});
}

/// Makes r = (cos 5t sin q, sin 5t sin q, -cos q), up to the choice of q, as a circle whose plane turns.
Coordinates hoop(const Instant&) {
  return CircleCoordinates{
      "", {0}, Vector3{0, 0, 0}, {ScalarFunction::formula("sin(5*t)"), ScalarFunction::formula("-cos(5*t)"), 0.0}, 1.0};
}

struct CoordinateCase {
  std::string name;  // the name of the case that it describes once more
  std::function<Coordinates(const Instant&)> coordinates;
  bool is_planar = false;  // its constraints let points leave the plane, its coordinates do not, so a page holds them

  friend std::ostream& operator<<(std::ostream& out, const CoordinateCase& given) { return out << given.name; }
};

std::vector<CoordinateCase> coordinate_cases() {
  return {
      {"01_planar_pendulum", [](const Instant& start) { return planar_chain(start, 1.0); }, true},
      {"01_pendulum_on_circle",
       [](const Instant&) {
         return CircleCoordinates{"", {0}, Vector3{0, 0, 0}, Vector3{0, 0, 1}, 1.0};
       }},
      {"02_spherical_pendulum",
       [](const Instant&) {
         return ChainAngles{"", {1}, 0, 1.0, {}};
       }},
      {"02_pendulum_on_sphere",
       [](const Instant&) {
         return SphereCoordinates{"", {0}, Vector3{0, 0, 0}, 1.0};
       }},
      {"03_rotating_hoop", hoop},
      {"03_rotating_hoop_by_formulas", hoop},
      {"05_atwood_swinging", atwood, true},
      {"07_chain2", [](const Instant& start) { return planar_chain(start, 1.0); }, true},
      {"07_chain2_in_plane", [](const Instant& start) { return planar_chain(start, 1.0); }},
      {"08_chain10", [](const Instant& start) { return planar_chain(start, 0.1); }, true},
      {"11_variable_length",
       [](const Instant& start) { return planar_chain(start, ScalarFunction::formula("1 + 0.3*sin(2*t)")); }, true},
      {"12_car_axis", car_axis, true},
  };
}

/// Adds the constraint z = 0 of all moving points behind the others.
void hold_in_plane(System* system) {
  std::vector<char> moves(system->num_points(), 1);
  for (const Support& support : system->supports) {
    for (const Index i : support.points) moves[static_cast<std::size_t>(i)] = 0;
  }
  Planes page{"page", {}, Vector3{0, 0, 1}, 0.0};
  for (std::size_t i = 0; i < moves.size(); ++i) {
    if (moves[i] != 0) page.points.push_back(static_cast<Index>(i));
  }
  system->constraints.push_back(page);
}

class CoordinateCaseTest : public testing::TestWithParam<CoordinateCase> {
 protected:
  const CaseScene& scene = *std::find_if(moving_cases().begin(), moving_cases().end(),
                                         [&](const CaseScene& candidate) { return candidate.name == GetParam().name; });
  const ReferenceMotion reference{scene};
  System make_system() const {
    System system = scene.build(reference.start());
    system.coordinates = {GetParam().coordinates(reference.start())};
    if (GetParam().is_planar) hold_in_plane(&system);
    return system;
  }
};

TEST_P(CoordinateCaseTest, MotionReactionsAndMultipliersHaveTenDigits) {
  Simulation simulation(make_system(), {.method = Method::Dopri5, .rtol = 1e-12, .atol = 1e-14},
                        {.form = Form::Tangent});
  const auto copy = [](std::span<const double> array) { return std::vector<double>(array.begin(), array.end()); };

  for (const Instant& instant : reference.instants()) {
    ASSERT_TRUE(simulation.advance_to(instant.t).ok()) << simulation.outcome().what;

    const Answer answer{.t = simulation.time(),
                        .positions = copy(simulation.positions()),
                        .velocities = copy(simulation.velocities()),
                        .accelerations = copy(simulation.accelerations()),
                        .multipliers = copy(simulation.multipliers().first(scene.multipliers(instant).size())),
                        .reactions = copy(simulation.reactions()),
                        .support_forces = copy(simulation.support_forces())};
    EXPECT_LT(reference.error(answer, instant), 1e-10) << "t = " << instant.t;
    EXPECT_LE(simulation.report().violation.position, 1e-12);
    EXPECT_LE(simulation.report().violation.velocity, 1e-12);
  }
}

TEST_P(CoordinateCaseTest, BothFormsAgreeToTwelveDigits) {
  const System system = make_system();
  Dynamics dynamics(system, {.form = Form::Both});
  std::vector<double> w(system.positions.size());
  Simulation simulation(system, {.method = Method::Dopri5, .rtol = 1e-12, .atol = 1e-14}, {.form = Form::Tangent});
  for (const Instant& instant : reference.instants()) {
    ASSERT_TRUE(simulation.advance_to(instant.t).ok());

    const SolveReport report =
        dynamics.solve({.time = instant.t, .positions = simulation.positions(), .velocities = simulation.velocities()},
                       {.accelerations = w});

    ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
    EXPECT_LE(report.forms_disagreement, 1e-12) << "t = " << instant.t;
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, CoordinateCaseTest, testing::ValuesIn(coordinate_cases()),
                         [](const auto& instance) { return instance.param.name; });

/// The hoop is described in three ways, by constraints of the built-in kinds, by formulas and by coordinates.
TEST(RotatingHoopTest, CoordinatesGiveTheAnswerOfTheConstraints) {
  const std::vector<Instant> trajectory = read_trajectory("03_rotating_hoop");
  System alone = make_rotating_hoop(trajectory.front());
  alone.constraints.clear();
  alone.coordinates = {hoop(trajectory.front())};
  Dynamics built_in(make_rotating_hoop(trajectory.front())),
      formulas(make_rotating_hoop_by_formulas(trajectory.front())), coordinates(alone);
  for (const Instant& instant : trajectory) {
    std::vector<double> w[3] = {instant.w, instant.w, instant.w}, eta[3] = {instant.w, instant.w, instant.w};

    ASSERT_TRUE(built_in
                    .solve({.time = instant.t, .positions = instant.r, .velocities = instant.v},
                           {.accelerations = w[0], .reactions = eta[0]})
                    .outcome.ok());
    ASSERT_TRUE(formulas
                    .solve({.time = instant.t, .positions = instant.r, .velocities = instant.v},
                           {.accelerations = w[1], .reactions = eta[1]})
                    .outcome.ok());
    ASSERT_TRUE(coordinates
                    .solve({.time = instant.t, .positions = instant.r, .velocities = instant.v},
                           {.accelerations = w[2], .reactions = eta[2]})
                    .outcome.ok());

    for (const int other : {0, 1}) {
      EXPECT_LE(largest_difference(w[2], w[other]), 1e-12 * largest(w[2])) << "t = " << instant.t;
      EXPECT_LE(largest_difference(eta[2], eta[other]), 1e-12 * largest(eta[2])) << "t = " << instant.t;
    }
  }
}

/// Case 06 is a chain that closes. The coordinates are the angles of the first eight rods. The ninth bead is on the
/// lower side where the circles around the eighth bead and the right support meet.
Coordinates hanging_chain(const System& system) {
  constexpr Index num_angles = 8;
  std::vector<Index> points;
  std::vector<std::string> names, places;
  std::vector<double> angles;
  std::string x = "0", y = "0";
  for (Index k = 1; k <= num_angles; ++k) {
    const Vector3 rod = difference(point(system.positions, static_cast<std::size_t>(k)),
                                   point(system.positions, static_cast<std::size_t>(k - 1)));
    names.push_back("a" + std::to_string(k));
    angles.push_back(std::atan2(rod[1], rod[0]));
    x += " + 0.1*cos(" + names.back() + ")";
    y += " + 0.1*sin(" + names.back() + ")";
    points.push_back(k);
    places.insert(places.end(), {x, y});
  }
  // The ninth bead is the middle between bead 8 and the support, plus h times their difference, turned by a right
  // angle.
  const std::string X = "(" + x + ")", Y = "(" + y + ")";
  const std::string h = "sqrt(0.01/((0.8-" + X + ")^2 + " + Y + "^2) - 0.25)";
  points.push_back(num_angles + 1);
  places.insert(places.end(), {"(0.8+" + X + ")/2 - " + h + "*" + Y, Y + "/2 - " + h + "*(0.8-" + X + ")"});
  return in_plane(points, names, places, angles, std::vector<double>(angles.size(), 0.0));
}

class CatenaryInCoordinatesTest : public testing::TestWithParam<Form> {};

TEST_P(CatenaryInCoordinatesTest, FindsRestAndTwelveDigitsOfTheTensions) {
  System system = make_catenary();
  system.coordinates = {hanging_chain(system)};
  Dynamics dynamics(system, {.form = GetParam()});
  std::vector<double> w(33), lambda(10);

  const SolveReport report =
      dynamics.solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                     {.accelerations = w, .multipliers = lambda});

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  expect_rest_with_tensions(w, lambda);
  if (GetParam() == Form::Both) {
    EXPECT_LE(report.forms_disagreement, 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, CatenaryInCoordinatesTest, testing::Values(Form::Tangent, Form::Both),
                         [](const auto& instance) { return instance.param == Form::Both ? "both" : "tangent"; });

TEST(CatenaryTest, ChainBetweenSupportsStaysAtRestInCoordinates) {
  System system = make_catenary();
  system.coordinates = {hanging_chain(system)};
  hold_in_plane(&system);
  Simulation simulation(system, {.method = Method::Dopri5, .rtol = 1e-10, .atol = 1e-12}, {.form = Form::Tangent});

  ASSERT_TRUE(simulation.advance_to(1.0).ok()) << simulation.outcome().what;

  EXPECT_LT(largest_difference(simulation.positions(), system.positions), 1e-11);
  EXPECT_LT(largest(simulation.velocities()), 1e-10);
}

}  // namespace
}  // namespace tanor::cases
