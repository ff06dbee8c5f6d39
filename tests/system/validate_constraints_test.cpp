/// The tests check the messages of validation about constraints.

#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "system/everything.hpp"

namespace tanor {
namespace {

using namespace everything;

/// A change to the system of `everything`, and the message of validation after it at a time, s.
struct Message {
  std::string what;
  std::function<void(System&)> change;
  double time = 0.0;
};

void expect_messages(const std::vector<Message>& messages) {
  for (const Message& each : messages) EXPECT_EQ(error_after(each.change, each.time), each.what);
}

// ---- constraints: members ----

TEST(Validate, ConstraintsNamePointsOfTheScene) {
  const std::string rule = " is out of range: the scene has 8 points, 0 to 7";

  expect_messages({
      {"/constraints/0/pairs/1: point 8" + rule,
       [](System& s) {
         constraint<Rods>(s, 0).pairs[1] = {1, 8};
       }},
      {"/constraints/1/points/1: point -1" + rule, [](System& s) { constraint<Planes>(s, 1).points[1] = -1; }},
      {"/constraints/2/points/0: point 8" + rule, [](System& s) { constraint<Spheres>(s, 2).points[0] = 8; }},
      {"/constraints/3/points/0: point 8" + rule, [](System& s) { constraint<Lines>(s, 3).points[0] = 8; }},
      {"/constraints/4/points/0: point 8" + rule, [](System& s) { constraint<Circles>(s, 4).points[0] = 8; }},
      {"/constraints/5/triples/1: point 8" + rule, [](System& s) { constraint<Angles>(s, 5).triples[1][2] = 8; }},
      {"/constraints/6/pairs/0: point 8" + rule, [](System& s) { constraint<Pulleys>(s, 6).pairs[0][0] = 8; }},
      {"/constraints/7/tuples/1: point 8" + rule, [](System& s) { constraint<Linears>(s, 7).tuples[1][0] = 8; }},
  });
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
  expect_messages({
      {"/constraints/0/pairs/2: [4, 4] names point 4 twice; a rod joins two different points",
       [](System& s) {
         constraint<Rods>(s, 0).pairs[2] = {4, 4};
       }},
      {"/constraints/5/triples/0: [1, 2, 1] names point 1 twice; an angle needs three different points",
       [](System& s) {
         constraint<Angles>(s, 5).triples[0] = {1, 2, 1};
       }},
      {"/constraints/6/pairs/0: [1, 1] names point 1 twice; a pulley joins two different points",
       [](System& s) {
         constraint<Pulleys>(s, 6).pairs[0] = {1, 1};
       }},
      {"/constraints/7/tuples/1: [6, 6] names point 6 twice; the points of a tuple differ",
       [](System& s) {
         constraint<Linears>(s, 7).tuples[1] = {6, 6};
       }},
  });
}

TEST(Validate, ConstraintsMayJoinSupportsAlone) {
  expect_messages({
      {"valid",
       [](System& s) {
         constraint<Rods>(s, 0).pairs[1] = {0, 7};
         constraint<Planes>(s, 1).points[1] = 7;
       }},
  });
}

// ---- constraints: values ----

TEST(Validate, ParametersAreOneForAllOrOneEach) {
  expect_messages({
      {"/constraints/0/length: 2 values for 3 members; one for all or one for each is right",
       [](System& s) {
         constraint<Rods>(s, 0).length = std::vector<double>{1, 2};
       }},
      {"/constraints/0/length: 4 values for 3 members; one for all or one for each is right",
       [](System& s) { constraint<Rods>(s, 0).length = std::vector<ScalarFunction>(4, 1.0); }},
      {"valid", [](System& s) { constraint<Rods>(s, 0).length = 1.0; }},
      {"valid",
       [](System& s) {
         constraint<Rods>(s, 0).length = std::vector<double>{1, 2, 3};
       }},
      {"valid", [](System& s) { constraint<Rods>(s, 0).length = std::vector<ScalarFunction>(3, 1.0); }},
  });
}

TEST(Validate, ParametersAreConstantsOrFunctionsNotBoth) {
  expect_messages({
      {"/constraints/0/length: length: both constants and functions are given; only one of them is right",
       [](System& s) {
         constraint<Rods>(s, 0).length.constants = {1};
         constraint<Rods>(s, 0).length.functions = {formula("1 + t")};
       }},
  });
}

TEST(Validate, RodLengthsArePositive) {
  expect_messages({
      {"/constraints/0/length: length -1 is not positive", [](System& s) { constraint<Rods>(s, 0).length = -1.0; }},
      {"/constraints/0/length/1: length 0 is not positive",
       [](System& s) {
         constraint<Rods>(s, 0).length = std::vector<double>{1, 0, 1};
       }},
      {"/constraints/0/length: length nan is not finite", [](System& s) { constraint<Rods>(s, 0).length = nan; }},
      {"/constraints/0/length: length at t = 0: 0 is not positive",
       [](System& s) { constraint<Rods>(s, 0).length = formula("3*t"); }},
      {"valid", [](System& s) { constraint<Rods>(s, 0).length = formula("3*t"); }, 1.0},
  });
}

TEST(Validate, InitialRodLengthsArePositive) {
  const auto coincide = [](System& s) {
    for (int k = 0; k < 3; ++k) s.positions[3 * 2 + k] = s.positions[3 * 1 + k];
  };

  expect_messages({
      {"/constraints/0/pairs/1: [1, 2]: the initial length is 0; a rod's length is positive", coincide},
      {"valid",
       [&](System& s) {
         coincide(s);
         s.constraints.resize(1);
         constraint<Rods>(s, 0).length = 1.0;
       }},
      {"valid",
       [&](System& s) {
         coincide(s);
         s.constraints.resize(1);
         constraint<Rods>(s, 0).offsets = {{}, {1, 0, 0}, {}};
       }},
  });
}

TEST(Validate, OffsetsAreOneEachAndFinite) {
  expect_messages({
      {"/constraints/0/offsets: 1 offset for 3 rods; one for each is right",
       [](System& s) {
         constraint<Rods>(s, 0).offsets = {{1, 0, 0}};
       }},
      {"/constraints/0/offsets/2: offset [0, 0, nan] is not finite",
       [](System& s) {
         constraint<Rods>(s, 0).offsets = {{}, {}, {0, 0, nan}};
       }},
  });
}

TEST(Validate, NormalsAndDirectionsAreNotZero) {
  expect_messages({
      {"/constraints/1/normal: normal [0, 0, 0] is zero; it must have a direction",
       [](System& s) { constraint<Planes>(s, 1).normal = {}; }},
      {"/constraints/1/normal: normal [0, 0, 0] at t = 0 is zero; it must have a direction",
       [](System& s) {
         constraint<Planes>(s, 1).normal = {formula("t"), 0.0, 0.0};
       }},
      {"/constraints/1/normal: normal [1e-200, 0, 0] is too short: its square is zero; it must have a direction",
       [](System& s) {
         constraint<Planes>(s, 1).normal = Vector3{1e-200, 0, 0};
       }},
      {"/constraints/3/direction: direction [0, 0, 0] is zero; it must have a direction",
       [](System& s) { constraint<Lines>(s, 3).direction = {}; }},
      {"/constraints/4/normal: normal [0, 0, 0] is zero; it must have a direction",
       [](System& s) { constraint<Circles>(s, 4).normal = {}; }},
  });
}

TEST(Validate, VectorsOfConstraintsAreFinite) {
  const Vector3 wrong = {0, infinity, 1};

  expect_messages({
      {"/constraints/1/normal: normal y inf is not finite",
       [&](System& s) { constraint<Planes>(s, 1).normal = wrong; }},
      {"/constraints/2/center: center y inf is not finite",
       [&](System& s) { constraint<Spheres>(s, 2).center = wrong; }},
      {"/constraints/3/origin: origin y inf is not finite", [&](System& s) { constraint<Lines>(s, 3).origin = wrong; }},
      {"/constraints/3/direction: direction y inf is not finite",
       [&](System& s) { constraint<Lines>(s, 3).direction = wrong; }},
      {"/constraints/4/center: center y inf is not finite",
       [&](System& s) { constraint<Circles>(s, 4).center = wrong; }},
      {"/constraints/4/normal: normal y inf is not finite",
       [&](System& s) { constraint<Circles>(s, 4).normal = wrong; }},
      {"/constraints/6/a: a [0, inf, 1] is not finite", [&](System& s) { constraint<Pulleys>(s, 6).a = wrong; }},
      {"/constraints/6/b: b [0, inf, 1] is not finite", [&](System& s) { constraint<Pulleys>(s, 6).b = wrong; }},
  });
}

TEST(Validate, PlaneOffsetsAreFinite) {
  expect_messages({
      {"/constraints/1/offset: offset inf is not finite",
       [](System& s) { constraint<Planes>(s, 1).offset = infinity; }},
      {"valid", [](System& s) { constraint<Planes>(s, 1).offset = -3.0; }},
  });
}

TEST(Validate, RadiiArePositive) {
  expect_messages({
      {"/constraints/2/radius: radius 0 is not positive", [](System& s) { constraint<Spheres>(s, 2).radius = 0.0; }},
      {"/constraints/4/radius: radius at t = 0: -1 is not positive",
       [](System& s) { constraint<Circles>(s, 4).radius = formula("t - 1"); }},
  });
}

TEST(Validate, APointWithInitialRadiusIsNotAtTheCenterOfItsSphere) {
  expect_messages({
      {"/constraints/2/points/0: point 3: it is at the center: the initial radius is 0; a radius is positive",
       [](System& s) {
         const double* r = &s.positions[3 * 3];
         constraint<Spheres>(s, 2).center = Vector3{r[0], r[1], r[2]};
       }},
  });
}

TEST(Validate, APointWithInitialRadiusIsNotOnTheAxisOfItsCircle) {
  // A slanted axis passes through the point, whose distance is a rounding error and not 0.
  expect_messages({
      {"/constraints/4/points/0: point 5: it is on the axis: the initial radius is 0; a radius is positive",
       [](System& s) {
         const double* r = &s.positions[3 * 5];
         constraint<Circles>(s, 4).center = Vector3{0.1, -0.2, 0.7};
         constraint<Circles>(s, 4).normal = Vector3{(r[0] - 0.1) / 3, (r[1] + 0.2) / 3, (r[2] - 0.7) / 3};
       }},
  });
}

TEST(Validate, CosinesLieBetweenMinusOneAndOne) {
  expect_messages({
      {"/constraints/5/cosine: cosine 1.5 is not between -1 and 1",
       [](System& s) { constraint<Angles>(s, 5).cosine = 1.5; }},
      {"/constraints/5/cosine/1: cosine -1.01 is not between -1 and 1",
       [](System& s) {
         constraint<Angles>(s, 5).cosine = std::vector<double>{-1, -1.01};
       }},
      {"valid", [](System& s) { constraint<Angles>(s, 5).cosine = -0.999999; }},
  });
}

TEST(Validate, StraightAnglesAreRefused) {
  const std::string rule =
      " is that of a straight triple, whose angle cannot be held by its cosine; use a line or rods";
  const auto place = [](System& s, int point, const Vector3& position) {
    for (int k = 0; k < 3; ++k) s.positions[3 * point + k] = position[k];
  };

  expect_messages({
      {"/constraints/5/cosine: cosine 1" + rule, [](System& s) { constraint<Angles>(s, 5).cosine = 1.0; }},
      {"/constraints/5/cosine/1: cosine -1" + rule,
       [](System& s) {
         constraint<Angles>(s, 5).cosine = std::vector<double>{0.5, -1};
       }},
      {"/constraints/5/cosine: cosine at t = 0: 1" + rule,
       [](System& s) { constraint<Angles>(s, 5).cosine = formula("cos(t)"); }},
      {"valid", [](System& s) { constraint<Angles>(s, 5).cosine = formula("cos(t)"); }, 1.0},
      // The arms are straight, and folded back, along axes; then they are straight to rounding along a slanted line.
      {"/constraints/5/triples/0: [0, 1, 2]: the initial cosine -1" + rule,
       [&](System& s) {
         place(s, 0, {0, 0, 0});
         place(s, 1, {1, 0, 0});
         place(s, 2, {3, 0, 0});
       }},
      {"/constraints/5/triples/0: [0, 1, 2]: the initial cosine 1" + rule,
       [&](System& s) {
         place(s, 0, {2, 0, 0});
         place(s, 1, {1, 0, 0});
         place(s, 2, {3, 0, 0});
       }},
  });
  EXPECT_NE(error_after([&](System& s) {
              place(s, 0, {0.1, 0.2, 0.7});
              place(s, 1, {0.3, 0.6, 2.1});
              place(s, 2, {0.7, 1.4, 4.9});
            }).find(rule),
            std::string::npos);
}

TEST(Validate, PointsOfAnInitialAngleAreDistinctInSpace) {
  for (const auto& pair : {std::array{0, 1}, std::array{1, 2}, std::array{0, 2}}) {
    expect_messages({
        {"/constraints/0/triples/0: [0, 1, 2]: two of the points are at the same place: there is no initial angle",
         [&](System& s) {
           for (int k = 0; k < 3; ++k) s.positions[3 * pair[0] + k] = s.positions[3 * pair[1] + k];
           s.constraints = {s.constraints[5]};
         }},
    });
  }
}

TEST(Validate, PulleysHaveARatio) {
  expect_messages({
      {"/constraints/6/ratio: ratio 0 must not be zero", [](System& s) { constraint<Pulleys>(s, 6).ratio = 0; }},
      {"/constraints/6/ratio: ratio inf is not finite", [](System& s) { constraint<Pulleys>(s, 6).ratio = infinity; }},
  });
}

TEST(Validate, PointsOfAPulleyAreNotAtItsRollers) {
  expect_messages({
      {"/constraints/6/pairs/0: [1, 4]: the second point is at b; the rope has no direction",
       [](System& s) {
         s.constraints[6] = Pulleys{"", {{1, 4}}, {9, 9, 9}, {4, 0.3 + 16.0 / 7, 0.1 - std::sin(4.0)}, {}, 1};
       }},
      {"/constraints/6/pairs/0: [1, 4]: the first point is at a; the rope has no direction",
       [](System& s) {
         s.constraints[6] = Pulleys{"", {{1, 4}}, {1, 0.3 + 1.0 / 7, 0.1 - std::sin(1.0)}, {9, 9, 9}, {}, 1};
       }},
  });
}

TEST(Validate, LinearTuplesHaveOneCoefficientAPoint) {
  expect_messages({
      {"/constraints/7/tuples/1: 3 points for 2 coefficients; one for each is right",
       [](System& s) {
         constraint<Linears>(s, 7).tuples[1] = {4, 5, 6};
       }},
      {"/constraints/7/tuples/1: []: a tuple has at least one point",
       [](System& s) { constraint<Linears>(s, 7).tuples[1] = {}; }},
      {"/constraints/7/coefficients: there are none; a tuple has at least one point",
       [](System& s) {
         s.constraints[7] = Linears{"sum", {{}, {}}, {}, 0.5};
       }},
  });
}

TEST(Validate, LinearCoefficientsAreFiniteAndNotZero) {
  expect_messages({
      {"/constraints/7/coefficients/1: coefficient [0, 0, 0] is zero; leave the point out of the tuples",
       [](System& s) {
         constraint<Linears>(s, 7).coefficients[1] = {0, 0, 0};
       }},
      {"/constraints/7/coefficients/1: coefficient [0, 1e-170, 0] is too short: its square is zero; leave the "
       "point out of the tuples",
       [](System& s) {
         constraint<Linears>(s, 7).coefficients[1] = {0, 1e-170, 0};
       }},
      {"/constraints/7/coefficients/0: coefficient [0, nan, 0] is not finite",
       [](System& s) {
         constraint<Linears>(s, 7).coefficients[0] = {0, nan, 0};
       }},
      {"/constraints/7/value: value nan is not finite", [](System& s) { constraint<Linears>(s, 7).value = nan; }},
  });
}

}  // namespace
}  // namespace tanor
