/// The tests check the messages of validation about forces.

#include <gtest/gtest.h>

#include "system/everything.hpp"

namespace tanor {
namespace {

using namespace everything;

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

/// Returns the message where the points push each other as well.
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

}  // namespace
}  // namespace tanor
