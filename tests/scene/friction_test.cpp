#include <cmath>
#include <ostream>

#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

/// Returns a scene of three points: 0 on a floor, 1 on the wire of a ball and a sheet, and a rod from 1 to 2.
std::string rough_scene(const std::string& friction, const std::string& more = "") {
  return R"({"tanor_scene": 1, "points": {"positions": [[0,0,0],[1,0,0],[2,0,0]]}, "parameters": {"u": 0.5},
    "constraints": [{"name": "floor", "kind": "plane", "points": [0], "normal": [0,0,1]},
                    {"name": "ball", "kind": "sphere", "points": [1], "center": [0,0,0]},
                    {"name": "sheet", "kind": "plane", "points": [1], "normal": [0,1,0]},
                    {"name": "rods", "kind": "rod", "pairs": [[1,2]]},
                    {"kind": "plane", "points": [1], "normal": [1,0,0], "offset": 1}],
    "friction": [)" +
         friction + "]" + (more.empty() ? "" : ", " + more) + "}";
}

template <class Law>
Law read_law(const std::string& fields) {
  return std::get<Law>(parse(rough_scene("{" + fields + "}")).system.friction.at(0));
}

using Names = std::vector<std::string>;

TEST(Friction, CoulombIsExactByDefault) {
  const auto coulomb = read_law<Coulomb>(R"("kind": "coulomb", "at": "floor", "coefficient": 0.3)");

  EXPECT_EQ(coulomb.name, "") << "the library makes the default name";
  EXPECT_EQ(coulomb.at, Names{"floor"});
  EXPECT_EQ(coulomb.coefficient, 0.3);
  EXPECT_FALSE(coulomb.static_coefficient) << "that of sliding";
  EXPECT_FALSE(coulomb.regularisation);
  EXPECT_EQ(coulomb.reaction, Coulomb::Reaction::Guide);
  EXPECT_EQ(at(coulomb.velocity, 1.0), Vector3{});
}

TEST(Friction, CoulombHasAllItsNumbers) {
  const auto coulomb = read_law<Coulomb>(R"json("kind": "coulomb", "name": "rough", "at": ["ball", "sheet"],
    "coefficient": 0.3, "static_coefficient": 0.4, "law": "exact", "reaction": "full",
    "velocity": {"formula": ["u*t", "0", "cos(t)"]})json");

  EXPECT_EQ(coulomb.name, "rough");
  EXPECT_EQ(coulomb.at, (Names{"ball", "sheet"}));
  EXPECT_EQ(coulomb.static_coefficient, 0.4);
  EXPECT_FALSE(coulomb.regularisation);
  EXPECT_EQ(coulomb.reaction, Coulomb::Reaction::Full);
  EXPECT_EQ(at(coulomb.velocity, 3.0), (Vector3{1.5, 0, std::cos(3.0)}));
}

TEST(Friction, CoulombMayBeRegularised) {
  const auto coulomb = read_law<Coulomb>(
      R"("kind": "coulomb", "at": "floor", "coefficient": 0, "law": {"regularised": 1e-3}, "reaction": "guide")");

  EXPECT_EQ(coulomb.regularisation, 1e-3);
  EXPECT_EQ(coulomb.reaction, Coulomb::Reaction::Guide);
}

TEST(Friction, ViscousHasACoefficientAndAVelocity) {
  const auto viscous =
      read_law<Viscous>(R"("kind": "viscous", "name": "oil", "at": ["floor"], "coefficient": 2, "velocity": [0,1,0])");

  EXPECT_EQ(viscous.name, "oil");
  EXPECT_EQ(viscous.at, Names{"floor"});
  EXPECT_EQ(viscous.coefficient, 2.0);
  EXPECT_EQ(at(viscous.velocity, 9.0), (Vector3{0, 1, 0}));
}

TEST(Friction, EntriesKeepTheirOrder) {
  const Scene scene = parse(rough_scene(R"({"kind": "viscous", "at": "floor", "coefficient": 2},
                                           {"kind": "coulomb", "at": "floor", "coefficient": 0.1})"));

  ASSERT_EQ(scene.system.friction.size(), 2u);
  EXPECT_EQ(friction_name(scene.system, 0), "viscous0");
  EXPECT_EQ(friction_name(scene.system, 1), "coulomb1");
}

/// Default names count groups in the scene's list, although the rods of the chain stand first in the system.
TEST(Friction, GuidesAreNamedAsInTheScene) {
  const Scene scene = parse(R"({"tanor_scene": 1, "generate": {"kind": "chain", "count": 2},
    "constraints": [{"kind": "plane", "points": [0], "normal": [0,0,1]}],
    "friction": [{"kind": "coulomb", "at": "plane0", "coefficient": 0.1}]})");

  EXPECT_EQ(num_contacts(scene.system, 0), 1u);
}

TEST(Friction, MethodOfTheSolverIsRead) {
  const auto method = [](const std::string& solver) {
    return parse(rough_scene("", R"("solver": {)" + solver + "}")).solver.friction;
  };

  EXPECT_EQ(method(""), FrictionMethod::Auto);
  EXPECT_EQ(method(R"("friction": "auto")"), FrictionMethod::Auto);
  EXPECT_EQ(method(R"("friction": "fixed_point")"), FrictionMethod::FixedPoint);
  EXPECT_EQ(method(R"("friction": "anderson")"), FrictionMethod::Anderson);
  EXPECT_EQ(method(R"("friction": "newton")"), FrictionMethod::Newton);
  EXPECT_EQ(method(R"("friction": "enumeration")"), FrictionMethod::Enumeration);
}

/// One broken rule of docs/scene-format.md.
struct BadFriction {
  const char* rule;
  std::string friction, error;
};
void PrintTo(const BadFriction& bad, std::ostream* stream) {
  *stream << bad.friction;
}

class BadFrictionTest : public testing::TestWithParam<BadFriction> {};

TEST_P(BadFrictionTest, GivesOneErrorThatNamesItsPlace) {
  EXPECT_EQ(error_of(rough_scene(GetParam().friction)), "scene.json: " + GetParam().error);
}

// clang-format off
const BadFriction bad_friction[] = {
    {"NoObject", R"("rough")",
     R"(/friction/0: found string "rough", wanted an object)"},
    {"KindIsMissing", R"({"at": "floor"})",
     R"(/friction/0/kind: missing, wanted one of coulomb, viscous)"},
    {"KindIsUnknown", R"({"kind": "stribeck", "at": "floor"})",
     R"(/friction/0/kind: found string "stribeck", wanted one of coulomb, viscous)"},
    {"KeyIsUnknown", R"({"kind": "coulomb", "at": "floor", "coefficient": 0.3, "mu": 0.3})",
     R"(/friction/0/mu: found the unknown key "mu" (did you mean coefficient?), wanted one of kind, name, at, coefficient, )"
     R"(static_coefficient, law, velocity, reaction)"},
    {"KeyOfAnotherKind", R"({"kind": "viscous", "at": "floor", "coefficient": 0.3, "law": "exact"})",
     R"(/friction/0/law: found the unknown key "law", wanted one of kind, name, at, coefficient, velocity)"},
    {"KeyIsDuplicate", R"({"kind": "viscous", "at": "floor", "coefficient": 0.3, "at": "wire"})",
     R"(/friction/0/at: found the key "at" twice, wanted once)"},
    {"NameIsNoString", R"({"kind": "viscous", "name": 1, "at": "floor", "coefficient": 0.3})",
     R"(/friction/0/name: found number 1, wanted a string)"},
    {"GuideIsMissing", R"({"kind": "coulomb", "coefficient": 0.3})",
     R"(/friction/0/at: missing, wanted the name of a constraint or a list of names)"},
    {"GuideIsANumber", R"({"kind": "coulomb", "at": 0, "coefficient": 0.3})",
     R"(/friction/0/at: found number 0, wanted the name of a constraint or a list of names)"},
    {"GuideInTheListIsANumber", R"({"kind": "coulomb", "at": ["floor", 1], "coefficient": 0.3})",
     R"(/friction/0/at/1: found number 1, wanted a string)"},
    {"ListOfGuidesIsEmpty", R"({"kind": "coulomb", "at": [], "coefficient": 0.3})",
     R"(/friction/0/at: is empty; it names the constraints that the friction acts at)"},
    {"GuideIsUnknown", R"({"kind": "coulomb", "at": "rink", "coefficient": 0.3})",
     R"(/friction/0/at: "rink" is the name of no constraint; a plane, sphere, line, circle, ellipsoid, helix or formula of single )"
     R"(points is right)"},
    {"GuideInTheListIsUnknown", R"({"kind": "coulomb", "at": ["floor", "rink"], "coefficient": 0.3})",
     R"(/friction/0/at/1: "rink" is the name of no constraint; a plane, sphere, line, circle, ellipsoid, helix or formula of single )"
     R"(points is right)"},
    {"RodsGuideNothing", R"({"kind": "viscous", "at": "floor", "coefficient": 1}, {"kind": "coulomb", "at": "rods", )"
    R"("coefficient": 0.3})",
     R"(/friction/1/at: "rods" is of kind rod; a plane, sphere, line, circle, ellipsoid, helix or formula of single points is right)"},
    {"GuideTwice", R"({"kind": "coulomb", "at": ["floor", "floor"], "coefficient": 0.3})",
     R"(/friction/0/at/1: "floor" is named by /friction/0/at/0 already; a guide is named once)"},
    {"PointCannotSlide", R"({"kind": "coulomb", "at": ["ball", "sheet", "plane4"], "coefficient": 0.3})",
     R"(/friction/0/at/2: with "plane4" point 1 has 3 equations and cannot slide; 1 (a surface) or 2 (a wire) are )"
     R"(right)"},
    {"CoefficientIsMissing", R"({"kind": "coulomb", "at": "floor"})",
     R"(/friction/0/coefficient: missing, wanted a number >= 0)"},
    {"CoefficientIsNegative", R"({"kind": "coulomb", "at": "floor", "coefficient": -0.3})",
     R"(/friction/0/coefficient: found number -0.3, wanted a number >= 0)"},
    {"CoefficientIsAString", R"({"kind": "viscous", "at": "floor", "coefficient": "0.3"})",
     R"(/friction/0/coefficient: found string "0.3", wanted a number >= 0)"},
    {"CoefficientOverflows", R"({"kind": "viscous", "at": "floor", "coefficient": 1e999})",
     R"(/friction/0/coefficient: found 1e999, wanted a finite number)"},
    {"StaticCoefficientIsLess", R"({"kind": "coulomb", "at": "floor", "coefficient": 0.3, "static_coefficient": 0.2})",
     R"(/friction/0/static_coefficient: static_coefficient 0.2 is less than the coefficient 0.3; it is at least as )"
     R"(large)"},
    {"StaticCoefficientIsNegative", R"({"kind": "coulomb", "at": "floor", "coefficient": 0.3, "static_coefficient": )"
    R"(-1})",
     R"(/friction/0/static_coefficient: found number -1, wanted a number >= 0)"},
    {"StaticCoefficientWithoutStick", R"({"kind": "coulomb", "at": "floor", "coefficient": 0.3, )"
    R"("static_coefficient": 0.4, "law": {"regularised": 1}})",
     R"(/friction/0/static_coefficient: stands beside a regularised law, which has no stick; leave it out, or take )"
     R"(the exact law)"},
    {"LawIsUnknown", R"({"kind": "coulomb", "at": "floor", "coefficient": 0.3, "law": "smooth"})",
     R"(/friction/0/law: found string "smooth", wanted "exact" or {"regularised": v0})"},
    {"LawIsANumber", R"({"kind": "coulomb", "at": "floor", "coefficient": 0.3, "law": 1e-3})",
     R"(/friction/0/law: found number 0.001, wanted "exact" or {"regularised": v0})"},
    {"LawIsEmpty", R"({"kind": "coulomb", "at": "floor", "coefficient": 0.3, "law": {}})",
     R"(/friction/0/law/regularised: missing, wanted a number > 0)"},
    {"LawHasAnUnknownKey", R"({"kind": "coulomb", "at": "floor", "coefficient": 0.3, "law": {"regularized": 1}})",
     R"(/friction/0/law/regularized: found the unknown key "regularized" (did you mean regularised?), wanted one of regularised)"},
    {"RegularisationIsZero", R"({"kind": "coulomb", "at": "floor", "coefficient": 0.3, "law": {"regularised": 0}})",
     R"(/friction/0/law/regularised: found number 0, wanted a number > 0)"},
    {"ReactionIsUnknown", R"({"kind": "coulomb", "at": "floor", "coefficient": 0.3, "reaction": "all"})",
     R"(/friction/0/reaction: found string "all", wanted one of guide, full)"},
    {"VelocityHasTwoNumbers", R"({"kind": "coulomb", "at": "floor", "coefficient": 0.3, "velocity": [1, 2]})",
     R"(/friction/0/velocity: found a list of 2, wanted 3 numbers [x, y, z])"},
    {"VelocityChangesTooFast", R"({"kind": "coulomb", "at": "floor", "coefficient": 0.3, "velocity": {"formula": )"
    R"(["1e200*t", "0", "0"]}})",
     R"(/friction/0/velocity: velocity x at t = 0 has the value 0 and the derivatives 1e+200 and 0; their squares )"
     R"(must stay finite)"},
    {"NameOfAConstraint", R"({"kind": "viscous", "name": "ball", "at": "floor", "coefficient": 1})",
     R"(/friction/0/name: "ball" is the name of /constraints/1 already; a name is used once)"},
};
// clang-format on

INSTANTIATE_TEST_SUITE_P(Contract, BadFrictionTest, testing::ValuesIn(bad_friction),
                         [](const auto& bad) { return std::string(bad.param.rule); });

TEST(BadFrictionSceneTest, FrictionThatIsNoListIsNamed) {
  EXPECT_EQ(error_of(three_points(R"("friction": {"kind": "coulomb"})")),
            "scene.json: /friction: found an object, wanted a list of friction laws");
}

TEST(BadFrictionSceneTest, GuidesAmongCoordinatesAloneAreRefused) {
  EXPECT_EQ(error_of(three_points(R"("coordinates": [{"kind": "free", "points": "all"}],
                                     "friction": [{"kind": "coulomb", "at": "free0", "coefficient": 0.3}])")),
            "scene.json: /friction/0/at: \"free0\" names no constraint: there are none, and coordinates are no guides; "
            "a plane, sphere, line, circle, ellipsoid, helix or formula of single points is right");
}

TEST(BadFrictionSceneTest, UnknownMethodIsNamed) {
  EXPECT_EQ(error_of(three_points(R"("solver": {"friction": "guess"})")),
            "scene.json: /solver/friction: found string \"guess\", wanted one of auto, fixed_point, anderson, newton, "
            "enumeration");
}

}  // namespace
}  // namespace tanor::scene
