/// A scene file cannot spell these coordinates wrongly, but a program can.

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>
#include <tanor/system.hpp>

#include "system/mistake.hpp"

namespace tanor {
namespace {

/// Makes two points: one free, one on a line by a formula.
System make_points_on_coordinates() {
  System system;
  system.positions = {0, 0, 0, 1, 0, 0};
  system.masses = {1, 1};
  const std::vector<std::string> names = {"s"}, components = {"1 + s", "0", "0"};
  system.coordinates = {FreeCoordinates{"a", {0}},
                        UserCoordinates{"b", {{1}}, formula_coordinates(names, components), {0.0}, {0.5}}};
  return system;
}

UserCoordinates& user(System& system) {
  return std::get<UserCoordinates>(system.coordinates[1]);
}

class CoordinateMistakeTest : public testing::TestWithParam<Mistake> {};

TEST_P(CoordinateMistakeTest, IsNamedWithItsPlace) {
  expect_named_with_its_place(GetParam(), make_points_on_coordinates());
}

const Mistake coordinate_mistakes[] = {
    {"NoFunction", [](System& s) { user(s).kernel.evaluate = nullptr; },
     "/coordinates/1/x: is missing: there is no function to call"},
    {"NoCoordinates", [](System& s) { user(s).kernel.num_coordinates = 0; },
     "/coordinates/1/q: a map of no coordinates; at least 1 is right"},
    {"NoPoints", [](System& s) { user(s).kernel.num_points = 0; },
     "/coordinates/1/x: a map to no point; at least 1 is right"},
    {"TupleOfAnotherSize",
     [](System& s) {
       user(s).tuples = {{1, 1}};
     },
     "/coordinates/1/points: 2 points for a map to 1 point"},
    {"NumberOfQ",
     [](System& s) {
       user(s).q = {0.0, 1.0};
     },
     "/coordinates/1/q: 2 numbers; one for each coordinate of each tuple, 1, are right"},
    {"NumberOfRates",
     [](System& s) {
       user(s).q_dot = {0.0, 1.0};
     },
     "/coordinates/1/q_dot: 2 numbers; one for each coordinate of each tuple, 1, are right"},
    {"RateIsNoNumber", [](System& s) { user(s).q_dot = {std::numeric_limits<double>::quiet_NaN()}; },
     "/coordinates/1/q_dot/0: q_dot nan is not finite"},
    {"PointIsOutOfRange", [](System& s) { std::get<FreeCoordinates>(s.coordinates[0]).points = {2}; },
     "/coordinates/0/points/0: point 2 is out of range: the scene has 2 points"},
    {"NameOfAnotherEntry", [](System& s) { user(s).name = "a"; },
     "/coordinates/1/name: \"a\" is the name of /coordinates/0 already; a name is used once"},
    {"BodyOnALineInSpace",
     [](System& s) {
       s.positions = {1, 2, 3, 2, 4, 6, 0.1, 0.2, 0.3};
       s.masses = {1, 1, 1};
       s.coordinates = {RigidBody{"body", {0, 1, 2}}};
     },
     "/coordinates/0/points: all 3 points are on one line, through points 0 and 1; a rigid body needs one beside it"},
};

INSTANTIATE_TEST_SUITE_P(Validate, CoordinateMistakeTest, testing::ValuesIn(coordinate_mistakes), name_of);

TEST(ValidateTest, CoordinatesOfAGoodSystemPass) {
  EXPECT_NO_THROW(validate(make_points_on_coordinates()));
}

/// Coordinates and constraints that describe the same may have equal names.
TEST(ValidateTest, CoordinatesMayBeNamedAsConstraints) {
  System system = make_points_on_coordinates();
  system.constraints = {Lines{"b", {1}, {}, Vector3{1, 0, 0}}};

  EXPECT_NO_THROW(validate(system));
}

}  // namespace
}  // namespace tanor
