/// The tests break the rules of friction and check the place that each message names.

#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <tanor/system.hpp>
#include <tanor/user_kernel.hpp>

#include "system/mistake.hpp"

namespace tanor {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

FrictionKernel make_law(int num_multipliers) {
  const auto nothing = [](const auto&, const auto&, double, const auto& lambda) {
    using T = std::decay_t<decltype(lambda[0])>;
    return std::array<T, 3>{};
  };
  return num_multipliers == 1 ? make_friction_kernel<1>(nothing) : make_friction_kernel<2>(nothing);
}

/// Makes a rough system: point 0 on a floor, 1 on a ball, 2 on a wire, 3 on a ring, 4 in a bowl. Rods join them to a
/// chain, and support 5 stands on the floor too. Each guide is rough; a wall beside the floor is not.
System make_rough_system() {
  System system;
  system.positions = {0, 1, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 16, 0, 2, 0};
  system.masses.assign(6, 1.0);
  system.supports = {{"post", {5}, {}}};
  const ConstraintKernel bowl = formula_constraint("z1 - x1^2 - y1^2", 1);
  const ConstraintKernel gear = formula_constraint("x1 + x2", 2);
  system.constraints = {
      Planes{"floor", {0, 5}, Vector3{0, 0, 1}},      Spheres{"ball", {1}, {}, 1.0},
      Lines{"wire", {2}, {}, Vector3{1, 0, 0}},       Circles{"ring", {3}, {}, Vector3{0, 0, 1}, 3.0},
      UserConstraints{"bowl", {{4}}, bowl},           Rods{"rods", {{0, 1}, {1, 2}, {2, 3}, {3, 4}}},
      UserConstraints{"gear", {{0, 1}}, gear},        Planes{"wall", {0}, Vector3{1, 0, 0}},
      Planes{"cupboard", {0}, Vector3{0, 1, 0}, 1.0}, Lines{"pole", {5}, Vector3{0, 2, 0}, Vector3{0, 0, 1}},
      Linears{"sum", {{0}}, {Vector3{1, 1, 1}}, 1.0}, Spheres{"", {1}, {}, 1.0},
  };
  system.friction = {
      Coulomb{.name = "rough", .at = {"floor", "ball", "wire", "ring", "bowl"}, .coefficient = 0.3},
      Viscous{.name = "oil", .at = {"wire"}, .coefficient = 2.0},
      UserFriction{.name = "felt", .at = {"floor", "wall"}, .kernel = make_law(2)},
  };
  return system;
}

Coulomb& rough(System& system) {
  return std::get<Coulomb>(system.friction[0]);
}
Viscous& oil(System& system) {
  return std::get<Viscous>(system.friction[1]);
}
UserFriction& felt(System& system) {
  return std::get<UserFriction>(system.friction[2]);
}

TEST(ValidateTest, FrictionOfAGoodSystemPasses) {
  EXPECT_NO_THROW(validate(make_rough_system()));
}

/// Friction ignores supports: one on the floor is no contact, and three equations at it are no error.
TEST(ValidateTest, SupportsOnAGuideAreNoContacts) {
  System system = make_rough_system();
  rough(system).at = {"floor", "pole"};

  EXPECT_NO_THROW(validate(system));
  EXPECT_EQ(num_contacts(system, 0), 1u);
}

TEST(ValidateTest, ContactsAreCountedEntryByEntry) {
  System system = make_rough_system();
  EXPECT_EQ(num_contacts(system, 0), 5u);
  EXPECT_EQ(num_contacts(system, 1), 1u);
  EXPECT_EQ(num_contacts(system, 2), 1u) << "floor and wall guide one point together";

  oil(system).coefficient = 0.0;

  EXPECT_EQ(num_contacts(system, 1), 0u) << "without effect";
}

TEST(ValidateTest, GuidesMayHaveDefaultNames) {
  System system = make_rough_system();
  oil(system).at = {"sphere11"};

  EXPECT_NO_THROW(validate(system));
}

TEST(ValidateTest, DefaultNamesOfFrictionAndConstraintsDoNotMeet) {
  System system = make_rough_system();
  std::get<UserConstraints>(system.constraints[4]).name = "formula2";
  rough(system).at = {"floor"};
  felt(system).name = "";  // "formula2" by default

  EXPECT_NO_THROW(validate(system));
}

TEST(ValidateTest, VelocityOfAGuideIsCheckedAtTheStart) {
  System system = make_rough_system();
  oil(system).velocity = {ScalarFunction::formula("1/(t - 2)"), 0.0, 0.0};

  EXPECT_NO_THROW(validate(system));
  EXPECT_THROW(validate(system, 2.0), InputError);
}

TEST(ValidateTest, LawsWithoutStickMayShareAGuide) {
  System system = make_rough_system();
  system.friction.push_back(Coulomb{.name = "more", .at = {"ball"}, .coefficient = 0.1, .regularisation = 1e-3});
  system.friction.push_back(Viscous{.name = "grease", .at = {"ball"}, .coefficient = 0.1});

  EXPECT_NO_THROW(validate(system));
}

class FrictionMistakeTest : public testing::TestWithParam<Mistake> {};

TEST_P(FrictionMistakeTest, IsNamedWithItsPlace) {
  expect_named_with_its_place(GetParam(), make_rough_system());
}

const Mistake friction_mistakes[] = {
    {"NoGuides", [](System& s) { oil(s).at.clear(); },
     "/friction/1/at: is empty; it names the constraints that the friction acts at"},
    {"UnknownGuide", [](System& s) { rough(s).at[3] = "rink"; },
     "/friction/0/at/3: \"rink\" is the name of no constraint; a plane, sphere, line, circle, ellipsoid, helix or "
     "formula of single "
     "points is right"},
    {"NameOfAForce",
     [](System& s) {
       s.forces = {Gravity{"gravity", {0, 0, -9.81}}};
       oil(s).at = {"gravity"};
     },
     "/friction/1/at/0: \"gravity\" is the name of no constraint; a plane, sphere, line, circle, ellipsoid, helix or "
     "formula of single "
     "points is right"},
    {"RodsGuideNothing",
     [](System& s) {
       oil(s).at = {"wire", "rods"};
     },
     "/friction/1/at/1: \"rods\" is of kind rod; a plane, sphere, line, circle, ellipsoid, helix or formula of single "
     "points is right"},
    {"LinearGuidesNothing", [](System& s) { oil(s).at = {"sum"}; },
     "/friction/1/at/0: \"sum\" is of kind linear; a plane, sphere, line, circle, ellipsoid, helix or formula of "
     "single points is right"},
    {"FormulaOfTwoPoints", [](System& s) { oil(s).at = {"gear"}; },
     "/friction/1/at/0: \"gear\" is of kind formula; a plane, sphere, line, circle, ellipsoid, helix or formula of "
     "single points is "
     "right"},
    {"GuideTwice",
     [](System& s) {
       rough(s).at = {"floor", "ball", "floor"};
     },
     "/friction/0/at/2: \"floor\" is named by /friction/0/at/0 already; a guide is named once"},
    {"PointThatCannotSlide",
     [](System& s) {
       rough(s).at = {"ball", "floor", "wall", "cupboard"};
     },
     "/friction/0/at/3: with \"cupboard\" point 0 has 3 equations and cannot slide; 1 (a surface) or 2 (a wire) are "
     "right"},
    {"CoefficientIsNegative", [](System& s) { rough(s).coefficient = -0.1; },
     "/friction/0/coefficient: coefficient -0.1 is negative"},
    {"CoefficientIsNoNumber", [](System& s) { rough(s).coefficient = nan; },
     "/friction/0/coefficient: coefficient nan is not finite"},
    {"CoefficientOfViscousIsInfinite", [](System& s) { oil(s).coefficient = infinity; },
     "/friction/1/coefficient: coefficient inf is not finite"},
    {"CoefficientOfViscousIsNegative", [](System& s) { oil(s).coefficient = -2.0; },
     "/friction/1/coefficient: coefficient -2 is negative"},
    {"StaticCoefficientIsLess", [](System& s) { rough(s).static_coefficient = 0.25; },
     "/friction/0/static_coefficient: static_coefficient 0.25 is less than the coefficient 0.3; it is at least as "
     "large"},
    {"StaticCoefficientIsNoNumber", [](System& s) { rough(s).static_coefficient = nan; },
     "/friction/0/static_coefficient: static_coefficient nan is not finite"},
    {"RegularisationIsZero", [](System& s) { rough(s).regularisation = 0.0; },
     "/friction/0/law/regularised: regularised 0 is not positive"},
    {"RegularisationIsNoNumber", [](System& s) { rough(s).regularisation = nan; },
     "/friction/0/law/regularised: regularised nan is not finite"},
    {"StaticCoefficientWithoutStick",
     [](System& s) {
       rough(s).regularisation = 1e-3;
       rough(s).static_coefficient = 0.4;
     },
     "/friction/0/static_coefficient: stands beside a regularised law, which has no stick; leave it out, or take the "
     "exact law"},
    {"TwoLawsWithStickAtOneGuide",
     [](System& s) {
       s.friction.push_back(Coulomb{.name = "more", .at = {"wall", "ball"}, .coefficient = 0.1});
     },
     "/friction/3/at/1: points stick at \"ball\" by /friction/0 already; give one entry with the sum of the "
     "coefficients"},
    {"VelocityIsNoNumber",
     [](System& s) {
       felt(s).velocity = Vector3{0, nan, 0};
     },
     "/friction/2/velocity: velocity y nan is not finite"},
    {"NoLaw", [](System& s) { felt(s).kernel.evaluate = nullptr; },
     "/friction/2/law: is missing: there is no function to call"},
    {"LawOfASurfaceOnAWire", [](System& s) { felt(s).kernel = make_law(1); },
     "/friction/2/law: a law of 1 multiplier, and point 0 has 2 guide equations; one multiplier for each is right"},
    {"LawOfAWireOnASurface", [](System& s) { felt(s).at = {"ball"}; },
     "/friction/2/law: a law of 2 multipliers, and point 1 has 1 guide equation; one multiplier for each is right"},
    {"NameOfAnotherFriction", [](System& s) { oil(s).name = "rough"; },
     "/friction/1/name: \"rough\" is the name of /friction/0 already; a name is used once"},
    {"NameOfAConstraint", [](System& s) { rough(s).name = "wall"; },
     "/friction/0/name: \"wall\" is the name of /constraints/7 already; a name is used once"},
    {"NameOfAForceAsOwn",
     [](System& s) {
       s.forces = {Gravity{"gravity", {0, 0, -9.81}}};
       rough(s).name = "gravity";
     },
     "/friction/0/name: \"gravity\" is the name of /forces/0 already; a name is used once"},
    {"CoordinatesAloneHaveNoGuide",
     [](System& s) {
       s.constraints.clear();
       s.coordinates = {FreeCoordinates{"free", {0, 1, 2, 3, 4}}};
     },
     "/friction/0/at/0: \"floor\" names no constraint: there are none, and coordinates are no guides; a plane, sphere, "
     "line, circle, ellipsoid, helix or formula of single points is right"},
};

INSTANTIATE_TEST_SUITE_P(Validate, FrictionMistakeTest, testing::ValuesIn(friction_mistakes), name_of);

}  // namespace
}  // namespace tanor
