/// The tests check the messages of validation about points, masses, supports and names.

#include <gtest/gtest.h>

#include "system/everything.hpp"

namespace tanor {
namespace {

using namespace everything;

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
