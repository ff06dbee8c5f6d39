#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <tanor/system.hpp>

namespace tanor {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

ScalarFunction formula(const char* text) {
  return ScalarFunction::formula(text);
}

/// Everything once, on 8 points in general position; point 0 is a support, point 7 another one that moves.
///
///   constraints  0 rods  1 floor  2 ball  3 wire  4 ring  5 bend  6 rope  7 sum      forces  0 … 3
System make_system() {
  System system;
  for (int i = 0; i < 8; ++i) {
    const double x = 1.0 * i;
    system.positions.insert(system.positions.end(), {x, 0.3 + x * x / 7, 0.1 - std::sin(x)});
  }
  system.velocities.assign(24, 0.0);
  system.masses.assign(8, 0.1);
  system.supports = {{"anchor", {0}, {}}, {"drive", {7}, {formula("0.1*sin(3*t)"), 0.0, 0.0}}};

  Rods rods{"rods", {{0, 1}, {1, 2}, {2, 3}}, {}, {}};
  Planes floor{"floor", {4, 5}, Vector3{0, 0, 2}, formula("0.1*t")};
  Spheres ball{"ball", {3}, {}, {}};
  Lines wire{"wire", {4, 6}, {}, Vector3{1, 0, 0}};
  Circles ring{"ring", {5}, {}, Vector3{0, 0, 1}, {}};
  Angles bend{"bend", {{0, 1, 2}, {1, 2, 3}}, {}};
  Pulleys rope{"rope", {{1, 4}}, {0, 0, 5}, {1, 0, 5}, {}, 2.0};
  Linears sum{"sum", {{1, 2}, {5, 6}}, {{1, 0, 0}, {0, 1, 0}}, 0.5};
  system.constraints = {rods, floor, ball, wire, ring, bend, rope, sum};

  Gravity gravity{"gravity", {0, 0, -9.81}};
  ConstantForce wind{"wind", {1, 2}, Vector3{1, 0, 0}};
  Springs springs{"springs", {{3, 6}}, 10.0, 0.1, {}};
  Drag air{"air", {1, 2, 3}, 0.1, 0.2};
  system.forces = {gravity, wind, springs, air};
  return system;
}

template <class Group>
Group& constraint(System& system, std::size_t group) {
  return std::get<Group>(system.constraints[group]);
}

template <class Group>
Group& force(System& system, std::size_t index) {
  return std::get<Group>(system.forces[index]);
}

/// "where: what" of the complaint about the system with one thing changed.
std::string error_after(const std::function<void(System&)>& change, double t = 0.0) {
  System system = make_system();
  change(system);
  try {
    validate(system, t);
  } catch (const InputError& error) {
    return error.where() + ": " + error.what();
  }
  return "valid";
}

TEST(Validate, AcceptsASystemWithEverything) {
  EXPECT_EQ(error_after([](System&) {}), "valid");
}

TEST(Validate, AcceptsASystemOfPointsAlone) {
  System system;
  system.positions = {0, 0, 0};
  system.masses = {1};

  EXPECT_NO_THROW(validate(system));
}

// ---- points ----

TEST(Validate, NeedsAPoint) {
  EXPECT_EQ(error_after([](System& s) { s = System(); }), "/points: there are none; a scene has at least one point");
}

TEST(Validate, ArraysFitTheNumberOfPoints) {
  EXPECT_EQ(error_after([](System& s) { s.positions.pop_back(); }),
            "/points/positions: 23 numbers for 8 points; three numbers for each point are right");
  EXPECT_EQ(error_after([](System& s) { s.velocities.resize(8); }),
            "/points/velocities: 8 numbers for 8 points; three numbers for each point are right");
  EXPECT_EQ(error_after([](System& s) { s.masses.clear(); }),
            "/points/positions: 24 numbers for 0 points; three numbers for each point are right");
  EXPECT_EQ(error_after([](System& s) { s.velocities.clear(); }), "valid");
}

TEST(Validate, PositionsAndVelocitiesAreFinite) {
  EXPECT_EQ(error_after([](System& s) {
              s.positions[3 * 6 + 1] = nan;
              s.positions[3 * 6 + 2] = 0.5;
            }),
            "/points/positions/6: position [6, nan, 0.5] is not finite");
  EXPECT_EQ(error_after([](System& s) { s.velocities[3 * 2] = infinity; }),
            "/points/velocities/2: velocity [inf, 0, 0] is not finite");
}

TEST(Validate, SquaresOfNumbersStayFinite) {
  const std::string rule = " is out of range: squares must stay finite";

  EXPECT_EQ(error_after([](System& s) {
              s.positions[3 * 6 + 1] = -2e100;
              s.positions[3 * 6 + 2] = 0.5;
            }),
            "/points/positions/6: position [6, -2e+100, 0.5]" + rule);
  EXPECT_EQ(error_after([](System& s) { s.velocities[3 * 2] = 1e160; }),
            "/points/velocities/2: velocity [1e+160, 0, 0]" + rule);
  EXPECT_EQ(error_after([](System& s) { s.masses[4] = 1e200; }), "/points/masses/4: mass 1e+200" + rule);
  EXPECT_EQ(error_after([](System& s) {
              s.supports[0].displacement = Vector3{0, 1e200, 0};
            }),
            "/supports/0/motion: displacement y 1e+200" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Rods>(s, 0).length = 1e200; }),
            "/constraints/0/length: length 1e+200" + rule);
  EXPECT_EQ(error_after([](System& s) {
              constraint<Rods>(s, 0).length = std::vector<double>{1, 1e200, 1};
            }),
            "/constraints/0/length/1: length 1e+200" + rule);
  EXPECT_EQ(error_after([](System& s) {
              constraint<Rods>(s, 0).offsets = {{}, {}, {0, 0, 1e101}};
            }),
            "/constraints/0/offsets/2: offset [0, 0, 1e+101]" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Spheres>(s, 2).radius = 1e200; }),
            "/constraints/2/radius: radius 1e+200" + rule);
  EXPECT_EQ(error_after([](System& s) {
              constraint<Lines>(s, 3).direction = Vector3{1e200, 0, 0};
            }),
            "/constraints/3/direction: direction x 1e+200" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Pulleys>(s, 6).ratio = -1e200; }),
            "/constraints/6/ratio: ratio -1e+200" + rule);
  EXPECT_EQ(error_after([](System& s) {
              force<ConstantForce>(s, 1).force = Vector3{1e200, 0, 0};
            }),
            "/forces/1/force: force x 1e+200" + rule);
  EXPECT_EQ(error_after([](System& s) { force<Springs>(s, 2).stiffness = 1e200; }),
            "/forces/2/stiffness: stiffness 1e+200" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Rods>(s, 0).length = 1e100; }), "valid");
}

TEST(Validate, SquaresOfDerivativesStayFinite) {
  EXPECT_EQ(error_after([](System& s) { s.supports[1].displacement.components[0] = formula("1e120*t"); }),
            "/supports/1/motion: displacement x at t = 0 has the value 0 and the derivatives 1e+120 and 0; "
            "their squares must stay finite");
}

TEST(Validate, MassesOfPointsThatMoveArePositive) {
  EXPECT_EQ(error_after([](System& s) { s.masses[4] = 0; }), "/points/masses/4: mass 0 is not positive");
  EXPECT_EQ(error_after([](System& s) { s.masses[4] = -1; }), "/points/masses/4: mass -1 is not positive");
  EXPECT_EQ(error_after([](System& s) { s.masses[4] = 5e-324; }), "/points/masses/4: mass 5e-324 is below 1e-100");
  EXPECT_EQ(error_after([](System& s) { s.masses[4] = infinity; }), "/points/masses/4: mass inf is not finite");
}

TEST(Validate, MassesOfSupportsAreIgnoredWhileFinite) {
  EXPECT_EQ(error_after([](System& s) { s.masses[0] = 0; }), "valid");
  EXPECT_EQ(error_after([](System& s) { s.masses[7] = -1; }), "valid");
  EXPECT_EQ(error_after([](System& s) { s.masses[7] = nan; }), "/points/masses/7: mass nan is not finite");
}

// ---- supports ----

TEST(Validate, SupportsNamePointsOfTheScene) {
  EXPECT_EQ(error_after([](System& s) {
              s.supports[0].points = {0, 1, 99};
            }),
            "/supports/0/points/2: point 99 is out of range: the scene has 8 points, 0 to 7");
  EXPECT_EQ(error_after([](System& s) { s.supports[1].points = {-1}; }),
            "/supports/1/points/0: point -1 is out of range: the scene has 8 points, 0 to 7");
}

TEST(Validate, APointIsInAtMostOneSupport) {
  EXPECT_EQ(error_after([](System& s) {
              s.supports[1].points = {7, 0};
            }),
            "/supports/1/points/1: point 0 belongs to /supports/0 already; a point has one prescribed motion");
  EXPECT_EQ(error_after([](System& s) {
              s.supports[1].points = {7, 7};
            }),
            "/supports/1/points/1: point 7 belongs to /supports/1 already; a point has one prescribed motion");
}

TEST(Validate, MotionsOfSupportsAreFinite) {
  EXPECT_EQ(error_after([](System& s) {
              s.supports[0].displacement = Vector3{0, nan, 0};
            }),
            "/supports/0/motion: displacement y nan is not finite");
  EXPECT_EQ(error_after([](System& s) { s.supports[1].displacement.components[2] = formula("1/t"); }),
            "/supports/1/motion: displacement z at t = 0 has the value inf and the derivatives -inf and nan; "
            "all must be finite");
}

TEST(Validate, VelocitiesOfSupportsAreFiniteAtTheStart) {
  EXPECT_EQ(error_after([](System& s) { s.supports[1].displacement.components[0] = formula("sqrt(t)"); }),
            "/supports/1/motion: displacement x at t = 0 has the value 0 and the derivatives inf and -inf; "
            "all must be finite");
}

TEST(Validate, TablesReachTheStart) {
  const auto use_table = [](System& s) {
    s.supports[1].displacement.components[0] = ScalarFunction::table({1, 2}, {0, 0});
  };

  EXPECT_EQ(error_after(use_table, 0.0),
            "/supports/1/motion: displacement x: t = 0 is outside the table, which reaches from 1 to 2");
  EXPECT_EQ(error_after(use_table, 1.5), "valid");
}

// ---- constraints: members ----

TEST(Validate, ConstraintsNamePointsOfTheScene) {
  const std::string rule = " is out of range: the scene has 8 points, 0 to 7";

  EXPECT_EQ(error_after([](System& s) {
              constraint<Rods>(s, 0).pairs[1] = {1, 8};
            }),
            "/constraints/0/pairs/1: point 8" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Planes>(s, 1).points[1] = -1; }),
            "/constraints/1/points/1: point -1" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Spheres>(s, 2).points[0] = 8; }),
            "/constraints/2/points/0: point 8" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Lines>(s, 3).points[0] = 8; }),
            "/constraints/3/points/0: point 8" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Circles>(s, 4).points[0] = 8; }),
            "/constraints/4/points/0: point 8" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Angles>(s, 5).triples[1][2] = 8; }),
            "/constraints/5/triples/1: point 8" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Pulleys>(s, 6).pairs[0][0] = 8; }),
            "/constraints/6/pairs/0: point 8" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Linears>(s, 7).tuples[1][0] = 8; }),
            "/constraints/7/tuples/1: point 8" + rule);
}

TEST(Validate, TheRangeOfASinglePointIsSaidInOneWord) {
  System system;
  system.positions = {0, 0, 0};
  system.masses = {1};
  system.supports = {{"", {1}, {}}};

  try {
    validate(system);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "point 1 is out of range: the scene has 1 point, 0");
  }
}

TEST(Validate, MembersJoinDistinctPoints) {
  EXPECT_EQ(error_after([](System& s) {
              constraint<Rods>(s, 0).pairs[2] = {4, 4};
            }),
            "/constraints/0/pairs/2: [4, 4] names point 4 twice; a rod joins two different points");
  EXPECT_EQ(error_after([](System& s) {
              constraint<Angles>(s, 5).triples[0] = {1, 2, 1};
            }),
            "/constraints/5/triples/0: [1, 2, 1] names point 1 twice; an angle needs three different points");
  EXPECT_EQ(error_after([](System& s) {
              constraint<Pulleys>(s, 6).pairs[0] = {1, 1};
            }),
            "/constraints/6/pairs/0: [1, 1] names point 1 twice; a pulley joins two different points");
  EXPECT_EQ(error_after([](System& s) {
              constraint<Linears>(s, 7).tuples[1] = {6, 6};
            }),
            "/constraints/7/tuples/1: [6, 6] names point 6 twice; the points of a tuple differ");
}

TEST(Validate, ConstraintsMayJoinSupportsAlone) {
  EXPECT_EQ(error_after([](System& s) {
              constraint<Rods>(s, 0).pairs[1] = {0, 7};
              constraint<Planes>(s, 1).points[1] = 7;
            }),
            "valid");
}

// ---- constraints: values ----

TEST(Validate, ParametersAreOneForAllOrOneEach) {
  EXPECT_EQ(error_after([](System& s) {
              constraint<Rods>(s, 0).length = std::vector<double>{1, 2};
            }),
            "/constraints/0/length: 2 values for 3 members; one for all or one for each is right");
  EXPECT_EQ(error_after([](System& s) { constraint<Rods>(s, 0).length = std::vector<ScalarFunction>(4, 1.0); }),
            "/constraints/0/length: 4 values for 3 members; one for all or one for each is right");
  EXPECT_EQ(error_after([](System& s) { constraint<Rods>(s, 0).length = 1.0; }), "valid");
  EXPECT_EQ(error_after([](System& s) { constraint<Rods>(s, 0).length = std::vector<double>{1, 2, 3}; }), "valid");
  EXPECT_EQ(error_after([](System& s) { constraint<Rods>(s, 0).length = std::vector<ScalarFunction>(3, 1.0); }),
            "valid");
}

TEST(Validate, ParametersAreConstantsOrFunctionsNotBoth) {
  EXPECT_EQ(error_after([](System& s) {
              constraint<Rods>(s, 0).length.constants = {1};
              constraint<Rods>(s, 0).length.functions = {formula("1 + t")};
            }),
            "/constraints/0/length: length: both constants and functions are given; only one of them is right");
}

TEST(Validate, RodLengthsArePositive) {
  EXPECT_EQ(error_after([](System& s) { constraint<Rods>(s, 0).length = -1.0; }),
            "/constraints/0/length: length -1 is not positive");
  EXPECT_EQ(error_after([](System& s) {
              constraint<Rods>(s, 0).length = std::vector<double>{1, 0, 1};
            }),
            "/constraints/0/length/1: length 0 is not positive");
  EXPECT_EQ(error_after([](System& s) { constraint<Rods>(s, 0).length = nan; }),
            "/constraints/0/length: length nan is not finite");
  EXPECT_EQ(error_after([](System& s) { constraint<Rods>(s, 0).length = formula("3*t"); }),
            "/constraints/0/length: length at t = 0: 0 is not positive");
  EXPECT_EQ(error_after([](System& s) { constraint<Rods>(s, 0).length = formula("3*t"); }, 1.0), "valid");
}

TEST(Validate, InitialRodLengthsArePositive) {
  const auto coincide = [](System& s) {
    for (int k = 0; k < 3; ++k) s.positions[3 * 2 + k] = s.positions[3 * 1 + k];
  };

  EXPECT_EQ(error_after(coincide),
            "/constraints/0/pairs/1: [1, 2]: the initial length is 0; a rod's length is positive");
  EXPECT_EQ(error_after([&](System& s) {
              coincide(s);
              s.constraints.resize(1);
              constraint<Rods>(s, 0).length = 1.0;
            }),
            "valid");
  EXPECT_EQ(error_after([&](System& s) {
              coincide(s);
              s.constraints.resize(1);
              constraint<Rods>(s, 0).offsets = {{}, {1, 0, 0}, {}};
            }),
            "valid");
}

TEST(Validate, OffsetsAreOneEachAndFinite) {
  EXPECT_EQ(error_after([](System& s) {
              constraint<Rods>(s, 0).offsets = {{1, 0, 0}};
            }),
            "/constraints/0/offsets: 1 offset for 3 rods; one for each is right");
  EXPECT_EQ(error_after([](System& s) {
              constraint<Rods>(s, 0).offsets = {{}, {}, {0, 0, nan}};
            }),
            "/constraints/0/offsets/2: offset [0, 0, nan] is not finite");
}

TEST(Validate, NormalsAndDirectionsAreNotZero) {
  EXPECT_EQ(error_after([](System& s) { constraint<Planes>(s, 1).normal = {}; }),
            "/constraints/1/normal: normal [0, 0, 0] is zero; it must have a direction");
  EXPECT_EQ(error_after([](System& s) {
              constraint<Planes>(s, 1).normal = {formula("t"), 0.0, 0.0};
            }),
            "/constraints/1/normal: normal [0, 0, 0] at t = 0 is zero; it must have a direction");
  EXPECT_EQ(error_after([](System& s) {
              constraint<Planes>(s, 1).normal = Vector3{1e-200, 0, 0};
            }),
            "/constraints/1/normal: normal [1e-200, 0, 0] is too short: its square is zero; it must have a direction");
  EXPECT_EQ(error_after([](System& s) { constraint<Lines>(s, 3).direction = {}; }),
            "/constraints/3/direction: direction [0, 0, 0] is zero; it must have a direction");
  EXPECT_EQ(error_after([](System& s) { constraint<Circles>(s, 4).normal = {}; }),
            "/constraints/4/normal: normal [0, 0, 0] is zero; it must have a direction");
}

TEST(Validate, VectorsOfConstraintsAreFinite) {
  const Vector3 wrong = {0, infinity, 1};

  EXPECT_EQ(error_after([&](System& s) { constraint<Planes>(s, 1).normal = wrong; }),
            "/constraints/1/normal: normal y inf is not finite");
  EXPECT_EQ(error_after([&](System& s) { constraint<Spheres>(s, 2).center = wrong; }),
            "/constraints/2/center: center y inf is not finite");
  EXPECT_EQ(error_after([&](System& s) { constraint<Lines>(s, 3).origin = wrong; }),
            "/constraints/3/origin: origin y inf is not finite");
  EXPECT_EQ(error_after([&](System& s) { constraint<Lines>(s, 3).direction = wrong; }),
            "/constraints/3/direction: direction y inf is not finite");
  EXPECT_EQ(error_after([&](System& s) { constraint<Circles>(s, 4).center = wrong; }),
            "/constraints/4/center: center y inf is not finite");
  EXPECT_EQ(error_after([&](System& s) { constraint<Circles>(s, 4).normal = wrong; }),
            "/constraints/4/normal: normal y inf is not finite");
  EXPECT_EQ(error_after([&](System& s) { constraint<Pulleys>(s, 6).a = wrong; }),
            "/constraints/6/a: a [0, inf, 1] is not finite");
  EXPECT_EQ(error_after([&](System& s) { constraint<Pulleys>(s, 6).b = wrong; }),
            "/constraints/6/b: b [0, inf, 1] is not finite");
}

TEST(Validate, PlaneOffsetsAreFinite) {
  EXPECT_EQ(error_after([](System& s) { constraint<Planes>(s, 1).offset = infinity; }),
            "/constraints/1/offset: offset inf is not finite");
  EXPECT_EQ(error_after([](System& s) { constraint<Planes>(s, 1).offset = -3.0; }), "valid");
}

TEST(Validate, RadiiArePositive) {
  EXPECT_EQ(error_after([](System& s) { constraint<Spheres>(s, 2).radius = 0.0; }),
            "/constraints/2/radius: radius 0 is not positive");
  EXPECT_EQ(error_after([](System& s) { constraint<Circles>(s, 4).radius = formula("t - 1"); }),
            "/constraints/4/radius: radius at t = 0: -1 is not positive");
}

TEST(Validate, APointWithInitialRadiusIsNotAtTheCenterOfItsSphere) {
  EXPECT_EQ(error_after([](System& s) {
              const double* r = &s.positions[3 * 3];
              constraint<Spheres>(s, 2).center = Vector3{r[0], r[1], r[2]};
            }),
            "/constraints/2/points/0: point 3: it is at the center: the initial radius is 0; a radius is positive");
}

TEST(Validate, APointWithInitialRadiusIsNotOnTheAxisOfItsCircle) {
  // A slanted axis through the point: its distance is a rounding error, not 0.
  EXPECT_EQ(error_after([](System& s) {
              const double* r = &s.positions[3 * 5];
              constraint<Circles>(s, 4).center = Vector3{0.1, -0.2, 0.7};
              constraint<Circles>(s, 4).normal = Vector3{(r[0] - 0.1) / 3, (r[1] + 0.2) / 3, (r[2] - 0.7) / 3};
            }),
            "/constraints/4/points/0: point 5: it is on the axis: the initial radius is 0; a radius is positive");
}

TEST(Validate, CosinesLieBetweenMinusOneAndOne) {
  EXPECT_EQ(error_after([](System& s) { constraint<Angles>(s, 5).cosine = 1.5; }),
            "/constraints/5/cosine: cosine 1.5 is not between -1 and 1");
  EXPECT_EQ(error_after([](System& s) {
              constraint<Angles>(s, 5).cosine = std::vector<double>{-1, -1.01};
            }),
            "/constraints/5/cosine/1: cosine -1.01 is not between -1 and 1");
  EXPECT_EQ(error_after([](System& s) { constraint<Angles>(s, 5).cosine = -0.999999; }), "valid");
}

TEST(Validate, StraightAnglesAreRefused) {
  const std::string rule =
      " is that of a straight triple, whose angle cannot be held by its cosine; use a line or rods";
  const auto place = [](System& s, int point, const Vector3& position) {
    for (int k = 0; k < 3; ++k) s.positions[3 * point + k] = position[k];
  };

  EXPECT_EQ(error_after([](System& s) { constraint<Angles>(s, 5).cosine = 1.0; }),
            "/constraints/5/cosine: cosine 1" + rule);
  EXPECT_EQ(error_after([](System& s) {
              constraint<Angles>(s, 5).cosine = std::vector<double>{0.5, -1};
            }),
            "/constraints/5/cosine/1: cosine -1" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Angles>(s, 5).cosine = formula("cos(t)"); }),
            "/constraints/5/cosine: cosine at t = 0: 1" + rule);
  EXPECT_EQ(error_after([](System& s) { constraint<Angles>(s, 5).cosine = formula("cos(t)"); }, 1.0), "valid");
  // Straight, and folded back, along axes; then straight to rounding along a slanted line.
  EXPECT_EQ(error_after([&](System& s) {
              place(s, 0, {0, 0, 0});
              place(s, 1, {1, 0, 0});
              place(s, 2, {3, 0, 0});
            }),
            "/constraints/5/triples/0: [0, 1, 2]: the initial cosine -1" + rule);
  EXPECT_EQ(error_after([&](System& s) {
              place(s, 0, {2, 0, 0});
              place(s, 1, {1, 0, 0});
              place(s, 2, {3, 0, 0});
            }),
            "/constraints/5/triples/0: [0, 1, 2]: the initial cosine 1" + rule);
  EXPECT_NE(error_after([&](System& s) {
              place(s, 0, {0.1, 0.2, 0.7});
              place(s, 1, {0.3, 0.6, 2.1});
              place(s, 2, {0.7, 1.4, 4.9});
            }).find(rule),
            std::string::npos);
}

TEST(Validate, PointsOfAnInitialAngleAreDistinctInSpace) {
  for (const auto& pair : {std::array{0, 1}, std::array{1, 2}, std::array{0, 2}}) {
    EXPECT_EQ(
        error_after([&](System& s) {
          for (int k = 0; k < 3; ++k) s.positions[3 * pair[0] + k] = s.positions[3 * pair[1] + k];
          s.constraints = {s.constraints[5]};
        }),
        "/constraints/0/triples/0: [0, 1, 2]: two of the points are at the same place: there is no initial angle");
  }
}

TEST(Validate, PulleysHaveARatio) {
  EXPECT_EQ(error_after([](System& s) { constraint<Pulleys>(s, 6).ratio = 0; }),
            "/constraints/6/ratio: ratio 0 must not be zero");
  EXPECT_EQ(error_after([](System& s) { constraint<Pulleys>(s, 6).ratio = infinity; }),
            "/constraints/6/ratio: ratio inf is not finite");
}

TEST(Validate, PointsOfAPulleyAreNotAtItsRollers) {
  EXPECT_EQ(error_after([](System& s) {
              s.constraints[6] = Pulleys{"", {{1, 4}}, {9, 9, 9}, {4, 0.3 + 16.0 / 7, 0.1 - std::sin(4.0)}, {}, 1};
            }),
            "/constraints/6/pairs/0: [1, 4]: the second point is at b; the rope has no direction");
  EXPECT_EQ(error_after([](System& s) {
              s.constraints[6] = Pulleys{"", {{1, 4}}, {1, 0.3 + 1.0 / 7, 0.1 - std::sin(1.0)}, {9, 9, 9}, {}, 1};
            }),
            "/constraints/6/pairs/0: [1, 4]: the first point is at a; the rope has no direction");
}

TEST(Validate, LinearTuplesHaveOneCoefficientAPoint) {
  EXPECT_EQ(error_after([](System& s) {
              constraint<Linears>(s, 7).tuples[1] = {4, 5, 6};
            }),
            "/constraints/7/tuples/1: 3 points for 2 coefficients; one for each is right");
  EXPECT_EQ(error_after([](System& s) { constraint<Linears>(s, 7).tuples[1] = {}; }),
            "/constraints/7/tuples/1: []: a tuple has at least one point");
  EXPECT_EQ(error_after([](System& s) {
              s.constraints[7] = Linears{"sum", {{}, {}}, {}, 0.5};
            }),
            "/constraints/7/coefficients: there are none; a tuple has at least one point");
}

TEST(Validate, LinearCoefficientsAreFiniteAndNotZero) {
  EXPECT_EQ(error_after([](System& s) {
              constraint<Linears>(s, 7).coefficients[1] = {0, 0, 0};
            }),
            "/constraints/7/coefficients/1: coefficient [0, 0, 0] is zero; leave the point out of the tuples");
  EXPECT_EQ(error_after([](System& s) {
              constraint<Linears>(s, 7).coefficients[1] = {0, 1e-170, 0};
            }),
            "/constraints/7/coefficients/1: coefficient [0, 1e-170, 0] is too short: its square is zero; leave the "
            "point out of the tuples");
  EXPECT_EQ(error_after([](System& s) {
              constraint<Linears>(s, 7).coefficients[0] = {0, nan, 0};
            }),
            "/constraints/7/coefficients/0: coefficient [0, nan, 0] is not finite");
  EXPECT_EQ(error_after([](System& s) { constraint<Linears>(s, 7).value = nan; }),
            "/constraints/7/value: value nan is not finite");
}

// ---- forces ----

TEST(Validate, ForcesNamePointsOfTheScene) {
  const std::string rule = " is out of range: the scene has 8 points, 0 to 7";

  EXPECT_EQ(error_after([](System& s) { force<ConstantForce>(s, 1).points[1] = 8; }),
            "/forces/1/points/1: point 8" + rule);
  EXPECT_EQ(error_after([](System& s) {
              force<Springs>(s, 2).pairs[0] = {3, -2};
            }),
            "/forces/2/pairs/0: point -2" + rule);
  EXPECT_EQ(error_after([](System& s) { force<Drag>(s, 3).points[2] = 8; }), "/forces/3/points/2: point 8" + rule);
}

TEST(Validate, SpringsJoinDistinctPoints) {
  EXPECT_EQ(error_after([](System& s) {
              force<Springs>(s, 2).pairs[0] = {3, 3};
            }),
            "/forces/2/pairs/0: [3, 3] names point 3 twice; a spring joins two different points");
}

TEST(Validate, NumbersOfForcesAreFinite) {
  EXPECT_EQ(error_after([](System& s) {
              force<Gravity>(s, 0).acceleration = {0, 0, nan};
            }),
            "/forces/0/acceleration: acceleration [0, 0, nan] is not finite");
  EXPECT_EQ(error_after([](System& s) {
              force<ConstantForce>(s, 1).force = Vector3{nan, 0, 0};
            }),
            "/forces/1/force: force x nan is not finite");
  EXPECT_EQ(error_after([](System& s) { force<Springs>(s, 2).stiffness = infinity; }),
            "/forces/2/stiffness: stiffness inf is not finite");
}

TEST(Validate, StiffnessDampingAndDragAreNotNegative) {
  EXPECT_EQ(error_after([](System& s) { force<Springs>(s, 2).stiffness = -1; }),
            "/forces/2/stiffness: stiffness -1 is negative");
  EXPECT_EQ(error_after([](System& s) { force<Springs>(s, 2).damping = -1; }),
            "/forces/2/damping: damping -1 is negative");
  EXPECT_EQ(error_after([](System& s) { force<Drag>(s, 3).linear = -1; }), "/forces/3/linear: linear -1 is negative");
  EXPECT_EQ(error_after([](System& s) { force<Drag>(s, 3).quadratic = -1; }),
            "/forces/3/quadratic: quadratic -1 is negative");
}

TEST(Validate, RestLengthsAreConstantAndNotNegative) {
  EXPECT_EQ(error_after([](System& s) { force<Springs>(s, 2).rest_length = -0.5; }),
            "/forces/2/rest_length: rest_length -0.5 is negative");
  EXPECT_EQ(error_after([](System& s) { force<Springs>(s, 2).rest_length = formula("1 + t"); }),
            "/forces/2/rest_length: rest_length depends on time; that of a spring is constant");
  EXPECT_EQ(error_after([](System& s) { force<Springs>(s, 2).rest_length = 0.0; }), "valid");
}

/// The complaint where the points push each other as well.
std::string error_with(
    const PairForces& pairs, const std::function<void(System&)>& change = [](System&) {}) {
  return error_after([&](System& s) {
    s.forces.push_back(pairs);
    change(s);
  });
}

TEST(Validate, NumbersOfPairsAreThoseOfTheirLaw) {
  EXPECT_EQ(error_with({}), "valid");
  EXPECT_EQ(error_with({.points = {3, 8}}),
            "/forces/4/points/1: point 8 is out of range: the scene has 8 points, 0 to 7");
  EXPECT_EQ(error_with({.points = {3, 2, 3}}),
            "/forces/4/points/2: point 3 is named twice; a point makes no pair with itself");
  EXPECT_EQ(error_with({.epsilon = 0.0}), "/forces/4/epsilon: epsilon 0 is not positive");
  EXPECT_EQ(error_with({.sigma = -1.0}), "/forces/4/sigma: sigma -1 is not positive");
  EXPECT_EQ(error_with({.law = PairLaw::Lj, .cutoff = 0.0}), "/forces/4/cutoff: cutoff 0 is not positive");
  EXPECT_EQ(error_with({.law = PairLaw::Wca, .cutoff = 2.0}),
            "/forces/4/cutoff: cutoff 2 is given to a law that has its own, 2^(1/6) sigma; leave it out");
  EXPECT_EQ(error_with({.law = PairLaw::Log, .cutoff = 2.0}),
            "/forces/4/cutoff: cutoff 2 is given to a law that has none; leave it out");
  EXPECT_EQ(error_with({.law = PairLaw::Log, .strength = nan}), "/forces/4/strength: strength nan is not finite");
}

TEST(Validate, BoxOfPairsHoldsTwiceTheCutoff) {
  EXPECT_EQ(error_with({.law = PairLaw::Lj, .sigma = 0.5, .box = {2.5, 0, 9}}), "valid");
  EXPECT_EQ(error_with({.law = PairLaw::Lj, .sigma = 0.5, .box = {2.4, 0, 9}}),
            "/forces/4/box: box edge 2.4 is shorter than twice the cutoff; 2.5 or longer is right, or 0 along an axis "
            "that is not periodic");
  EXPECT_EQ(error_with({.box = {9, -9, 9}}), "/forces/4/box: box edge -9 is negative");
  EXPECT_EQ(error_with({.box = {9, nan, 9}}), "/forces/4/box: box [9, nan, 9] is not finite");
  EXPECT_EQ(error_with({.law = PairLaw::Log, .box = {9, 9, 9}}),
            "/forces/4/box: box [9, 9, 9] is given to law log, whose force reaches every image; leave it out");
}

TEST(Validate, PointsThatPushEachOtherAreNotAtOnePlace) {
  const auto put_6_onto = [](Index point, double shift = 0.0) {
    return [=](System& s) {
      for (int k = 0; k < 3; ++k) s.positions[3 * 6 + k] = s.positions[3 * point + k];
      s.positions[3 * 6] += shift;
    };
  };
  const std::string same_place = " are at the same place; their force has no direction";

  EXPECT_EQ(error_with({.law = PairLaw::Log}, put_6_onto(5)), "/forces/4: points 5 and 6" + same_place);
  EXPECT_EQ(error_with({.points = {0, 2, 6}}, put_6_onto(5)), "valid") << "5 takes no part";
  EXPECT_EQ(error_with({.box = {32, 0, 0}}, put_6_onto(5, 64.0)), "/forces/4: points 5 and 6" + same_place);
  EXPECT_EQ(error_with({.box = {0, 32, 0}}, put_6_onto(5, 64.0)), "valid");
  const auto as_supports = [&](System& s) {
    put_6_onto(5)(s);
    s.supports.push_back({"", {5, 6}, {}});
  };
  EXPECT_EQ(error_with({}, as_supports), "valid");
}

TEST(Validate, PointsThatARodJoinsMayBeImagesOfOnePlace) {
  const auto join_images = [](System& s) {
    for (int k = 0; k < 3; ++k) s.positions[3 * 6 + k] = s.positions[3 * 5 + k];
    s.constraints.push_back(Rods{"image", {{6, 5}}, {}, {{0, 0, 32}}});
  };

  EXPECT_EQ(error_with({.exclude_rods = true}, join_images), "valid");
  EXPECT_NE(error_with({.exclude_rods = false}, join_images), "valid");
}

// ---- names ----

TEST(Validate, NamesOfConstraintsAndForcesAreUsedOnce) {
  EXPECT_EQ(error_after([](System& s) { constraint<Lines>(s, 3).name = "rods"; }),
            "/constraints/3/name: \"rods\" is the name of /constraints/0 already; a name is used once");
  EXPECT_EQ(error_after([](System& s) { force<Gravity>(s, 0).name = "floor"; }),
            "/forces/0/name: \"floor\" is the name of /constraints/1 already; a name is used once");
  EXPECT_EQ(error_after([](System& s) { force<Drag>(s, 3).name = "wind"; }),
            "/forces/3/name: \"wind\" is the name of /forces/1 already; a name is used once");
}

TEST(Validate, DefaultNamesCountAsNames) {
  EXPECT_EQ(error_after([](System& s) {
              constraint<Rods>(s, 0).name = "";
              constraint<Planes>(s, 1).name = "rod0";
            }),
            "/constraints/1/name: \"rod0\" is the name of /constraints/0 already; a name is used once");
}

}  // namespace
}  // namespace tanor
