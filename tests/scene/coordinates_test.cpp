#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

/// Returns a scene of three points a metre apart on the x axis, of which point 0 is a support.
std::string with_coordinates(const std::string& entries, const std::string& more = "") {
  return three_points(R"("supports": [{"points": [0]}], "coordinates": [)" + entries + "]" + more);
}

TEST(CoordinatesTest, EveryKindIsRead) {
  const System system = parse(R"json({"tanor_scene": 1, "parameters": {"R": 2.5},
    "points": {"positions": [[0,0,0],[1,0,0],[2,0,0],[3,0,0],[4,0,0],[5,0,0],[6,0,0],[7,0,0],
      [8,1,0],[9,0,1],[2.5,0,0],[2.5,0,1]]},
    "supports": [{"points": [0]}],
    "coordinates": [
      {"kind": "free", "points": [1]},
      {"kind": "line", "name": "rail", "points": [2], "origin": [0,0,0], "direction": {"formula": ["1", "t", "0"]}},
      {"kind": "plane", "points": [3], "normal": [0,0,2], "offset": {"formula": "0.1*t"}},
      {"kind": "circle", "points": [4], "center": [0,0,0], "normal": [0,0,1], "radius": 4},
      {"kind": "sphere", "points": [5], "center": [1,0,0]},
      {"kind": "chain_angles", "points": [6], "anchor": 0, "length": 6, "normal": [0,0,1]},
      {"kind": "rigid_body", "points": [7,8,9]},
      {"kind": "formula", "points": [10,11], "q": {"a": 0, "h": 1}, "q_dot": {"h": 0.5},
       "x": ["R*cos(a)", "R*cos(a)"], "y": ["R*sin(a)", "R*sin(a)"], "z": ["0", "h"]}]})json")
                            .system;

  ASSERT_EQ(system.coordinates.size(), 8u);
  EXPECT_EQ(std::get<FreeCoordinates>(system.coordinates[0]).points, std::vector<Index>{1});
  EXPECT_EQ(std::get<LineCoordinates>(system.coordinates[1]).name, "rail");
  EXPECT_EQ(std::get<LineCoordinates>(system.coordinates[1]).direction(2.0)[1].value(), 2.0);
  EXPECT_EQ(std::get<PlaneCoordinates>(system.coordinates[2]).offset.functions[0](3.0).value(), 0.1 * 3.0);
  EXPECT_EQ(std::get<CircleCoordinates>(system.coordinates[3]).radius.constants, std::vector<double>{4.0});
  EXPECT_TRUE(std::get<SphereCoordinates>(system.coordinates[4]).radius.is_initial());
  const auto& chain = std::get<ChainAngles>(system.coordinates[5]);
  EXPECT_EQ(chain.anchor, 0);
  EXPECT_EQ(chain.normal, (Vector3{0, 0, 1}));
  EXPECT_EQ(std::get<RigidBody>(system.coordinates[6]).points, (std::vector<Index>{7, 8, 9}));
  const auto& user = std::get<UserCoordinates>(system.coordinates[7]);
  EXPECT_EQ(user.tuples, (std::vector<std::vector<Index>>{{10, 11}}));
  EXPECT_EQ(user.q, (std::vector<double>{0, 1}));
  EXPECT_EQ(user.q_dot, (std::vector<double>{0, 0.5}));
  std::vector<double> r(6), v(6), psi(6);
  user.kernel.evaluate(user.kernel.context.get(),
                       {1, 0.0, user.q.data(), user.q_dot.data(), r.data(), v.data(), psi.data(), nullptr});
  EXPECT_EQ(r, (std::vector<double>{2.5, 0, 0, 2.5, 0, 1}));
  EXPECT_EQ(v, (std::vector<double>{0, 0, 0, 0, 0, 0.5}));
}

TEST(CoordinatesTest, FormOfTheSolverIsRead) {
  const auto form = [](const std::string& name) {
    return parse(three_points(R"("solver": {"form": ")" + name + "\"}")).solver.form;
  };
  EXPECT_EQ(form("auto"), Form::Auto);
  EXPECT_EQ(form("normal"), Form::Normal);
  EXPECT_EQ(form("tangent"), Form::Tangent);
  EXPECT_EQ(form("both"), Form::Both);
}

TEST(CoordinatesTest, MissingTextsOfAFormulaAreZero) {
  const System system =
      parse(with_coordinates(
                R"({"kind": "free", "points": [1]}, {"kind": "formula", "points": [2], "q": {"s": 2}, "x": "s"})"))
          .system;

  const auto& user = std::get<UserCoordinates>(system.coordinates[1]);
  std::vector<double> r(3);
  user.kernel.evaluate(user.kernel.context.get(),
                       {1, 0.0, user.q.data(), user.q.data(), r.data(), nullptr, nullptr, nullptr});
  EXPECT_EQ(r, (std::vector<double>{2, 0, 0}));
}

struct Mistake {
  const char *name, *entries, *message;

  friend std::ostream& operator<<(std::ostream& out, const Mistake& mistake) { return out << mistake.name; }
};

class WrongCoordinatesTest : public testing::TestWithParam<Mistake> {};

TEST_P(WrongCoordinatesTest, GetOneLineThatSaysWhatAndWhere) {
  EXPECT_EQ(error_of(with_coordinates(GetParam().entries)), std::string("scene.json: ") + GetParam().message);
}

// clang-format off
const Mistake mistakes[] = {
    {"UnknownKind", R"({"kind": "torus", "points": [1]})",
     R"(/coordinates/0/kind: found string "torus", wanted one of free, line, plane, circle, sphere, chain_angles, )"
     R"(rigid_body, formula)"},
    {"UnknownKey", R"({"kind": "free", "points": [1,2], "radius": 1})",
     R"(/coordinates/0/radius: found the unknown key "radius", wanted one of kind, name, points)"},
    {"PointThatMovesIsMissing", R"({"kind": "free", "points": [1]})",
     "/coordinates: point 2 moves and no entry covers it; every point that moves is covered once"},
    {"PointIsCoveredTwice", R"({"kind": "free", "points": [1, 2]}, {"kind": "sphere", "points": [2], "center": )"
    R"([0,0,0]})",
     "/coordinates/1/points/0: point 2 is covered by /coordinates/0 already; every point that moves is covered once"},
    {"PointIsCoveredTwiceByOne", R"({"kind": "free", "points": [1, 2, 1]})",
     "/coordinates/0/points/2: point 1 is covered by /coordinates/0 already; every point that moves is covered once"},
    {"SupportIsCovered", R"({"kind": "free", "points": [1, 2, 0]})",
     "/coordinates/0/points/2: point 0 belongs to /supports/0 already: its motion is prescribed, "
     "no coordinates move it"},
    {"NormalIsZero", R"({"kind": "free", "points": [1]}, {"kind": "plane", "points": [2], "normal": [0,0,0]})",
     "/coordinates/1/normal: normal [0, 0, 0] is zero; it must have a direction"},
    {"RadiusIsNegative", R"({"kind": "free", "points": [1]}, {"kind": "sphere", "points": [2], "center": [0,0,0], )"
    R"("radius": -1})",
     "/coordinates/1/radius: radius -1 is not positive"},
    {"PointAtTheCenter", R"({"kind": "free", "points": [1]}, {"kind": "sphere", "points": [2], "center": [2,0,0], )"
    R"("radius": 1})",
     "/coordinates/1/points/0: point 2: it is at the center and has no direction there"},
    {"PointOnTheAxis", R"({"kind": "free", "points": [1]}, {"kind": "circle", "points": [2], "center": [2,0,1], )"
    R"("normal": [0,0,1], "radius": 1})",
     "/coordinates/1/points/0: point 2: it is on the axis and has no angle there"},
    {"AnchorMoves", R"({"kind": "free", "points": [1]}, {"kind": "chain_angles", "points": [2], "anchor": 1})",
     "/coordinates/1/anchor: point 1 is not a support; a chain's anchor is one, fixed or moving"},
    {"AnchorIsMissing", R"({"kind": "chain_angles", "points": [1, 2]})",
     "/coordinates/0/anchor: missing, wanted a whole number from 0 to 2"},
    {"ChainNormalIsZero", R"({"kind": "chain_angles", "points": [1, 2], "anchor": 0, "normal": [0,0,0]})",
     "/coordinates/0/normal: found a list of 3, wanted a normal that is not zero; without one directions are spatial"},
    {"BodyOfTwo", R"({"kind": "rigid_body", "points": [1, 2]})",
     "/coordinates/0/points: 2 points; a rigid body has at least 3 that are not on one line"},
    {"NameIsUsedTwice", R"({"kind": "free", "name": "a", "points": [1]}, {"kind": "free", "name": "a", "points": [2]})",
     R"(/coordinates/1/name: "a" is the name of /coordinates/0 already; a name is used once)"},
    {"FormulaHasAnError", R"({"kind": "formula", "points": [1,2], "q": {"a": 1}, "x": ["a", "2*+"], "y": ["0","0"]})",
     R"(/coordinates/0/x/1: formula "2*+": column 4: found the end, expected a number, a name or '(')"},
    {"FormulaHasAnErrorInItsOnlyText", R"({"kind": "free", "points": [1]}, {"kind": "formula", "points": [2], "q": )"
    R"({"a": 1}, "x": "a", "z": "b"})",
     R"(/coordinates/1/z: formula "b": column 1: 'b' is not known; known names: a, t, pi and the functions sqrt, )"
     R"(exp, log, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, abs, min, max)"},
    {"FormulaHasTooFewTexts", R"({"kind": "formula", "points": [1,2], "q": {"a": 1}, "x": "a"})",
     R"(/coordinates/0/x: found string "a", wanted a list of 2 formulas, one a point)"},
    {"FormulaHasNoCoordinates", R"({"kind": "formula", "points": [1,2], "q": {}})",
     "/coordinates/0/q: there are no coordinates; a map has at least one"},
    {"CoordinateIsNamedLikeTime", R"({"kind": "free", "points": [1]}, {"kind": "formula", "points": [2], "q": {"t": )"
    R"(1}, "x": "t"})",
     "/coordinates/1/q: the coordinate 't' has the name of time"},
    {"RateOfNoCoordinate", R"({"kind": "free", "points": [1]}, {"kind": "formula", "points": [2], "q": {"a": 1}, )"
    R"("q_dot": {"b": 1}, "x": "a"})",
     R"(/coordinates/1/q_dot/b: found number 1, wanted a coordinate of q, one of "a")"},
    {"RateOfNoneOfCoordinatesWithOddNames",
     R"({"kind": "free", "points": [1]},
        {"kind": "formula", "points": [2], "q": {"a\rq9": 1, "c, d": 0}, "q_dot": {"b": 1}, "x": "a"})",
     R"(/coordinates/1/q_dot/b: found number 1, wanted a coordinate of q, one of "a\u000dq9", "c, d")"},
    {"NameOfACoordinateCutsTheLine",
     R"({"kind": "free", "points": [1]}, {"kind": "formula", "points": [2], "q": {"bad\u0000q9": 1}, "x": "1"})",
     R"(/coordinates/1/q: the coordinate 'bad\x00q9' has no name of letters, digits and '_' that is neither a )"
     R"(function )"
     "nor pi"},
    {"FormulaIsNotFinite", R"({"kind": "free", "points": [1]}, {"kind": "formula", "points": [2], "q": {"a": 0}, )"
    R"("x": "1/a"})",
     "/coordinates/1/q: [2]: the map has a position inf at the start"},
};
// clang-format on

INSTANTIATE_TEST_SUITE_P(CoordinatesTest, WrongCoordinatesTest, testing::ValuesIn(mistakes),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(WrongCoordinatesTest, BodyOnOneLineIsRefused) {
  EXPECT_EQ(error_of(three_points(R"("coordinates": [{"kind": "rigid_body", "points": "all"}])")),
            "scene.json: /coordinates/0/points: all 3 points are on one line, through points 0 and 2; a rigid body "
            "needs one beside it");
}

}  // namespace
}  // namespace tanor::scene
