#include <ostream>

#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

/// A scene that breaks one rule of docs/scene-format.md, and the error it gives.
struct BadInput {
  const char* rule;
  std::string scene;
  std::string error;
};
void PrintTo(const BadInput& input, std::ostream* stream) {
  *stream << input.scene;
}

class BadInputTest : public testing::TestWithParam<BadInput> {};

TEST_P(BadInputTest, GivesOneErrorThatNamesItsPlace) {
  const std::string error = error_of(GetParam().scene);

  EXPECT_EQ(error.find('\n'), std::string::npos) << "an error is one line";
  EXPECT_EQ(error, GetParam().error);
}

/// Returns the names of all methods in the order of the table.
std::string join_names_of_methods() {
  std::string result;
  for (const MethodTraits& each : methods()) result += (result.empty() ? "" : ", ") + std::string(each.name);
  return result;
}

// clang-format off
const BadInput bad_inputs[] = {
    {"TextIsEmpty", R"()",
     R"(scene.json: line 1, column 1: not JSON: syntax error while parsing value - unexpected end of input; )"
     R"(expected '[', '{', or a literal)"},
    {"TextIsNoJson", "{\"tanor_scene\": 1,\n  \"points\": nothing}",
     R"(scene.json: line 2, column 14: not JSON: found "nothing", syntax error while parsing value - invalid literal)"},
    {"TextEndsEarly", R"({"tanor_scene": 1)",
     R"(scene.json: line 1, column 17: not JSON: syntax error while parsing object - unexpected end of input; )"
     R"(expected '}')"},
    {"TextHasTextBehindIt", R"({} {})",
     R"(scene.json: line 1, column 4: not JSON: syntax error while parsing value - unexpected '{'; expected end of )"
     R"(input)"},
    {"TextHasAWrongNumber", R"({"tanor_scene": 01})",
     R"(scene.json: line 1, column 18: not JSON: syntax error while parsing object - unexpected number literal; )"
     R"(expected '}')"},
    {"TextHasAWrongLiteral", R"({"tanor_scene": True})",
     R"(scene.json: line 1, column 17: not JSON: found "True", syntax error while parsing value - invalid literal)"},
    {"TextHasAnOpenString", R"({"tanor_scene: 1})",
     R"(scene.json: line 1, column 17: not JSON: syntax error while parsing object key - invalid string: missing )"
     R"(closing quote; expected string literal)"},
    {"TextIsNanAsKey", R"({NaN: 1})",
     R"(scene.json: line 1, column 2: not JSON: found "NaN", syntax error while parsing object key - invalid )"
     R"(literal; expected string literal)"},
    {"TextIsAList", R"([1, 2])",
     R"(scene.json: found a list of 2, wanted an object)"},
    {"NumberOverflows", R"({"tanor_scene": 1, "points": {"positions": [[0, 1e999, 0]]}})",
     R"(scene.json: /points/positions/0/1: found 1e999, wanted a finite number)"},
    {"NumberIsNan", R"({"tanor_scene": 1, "points": {"positions": [[0, NaN, 0]]}})",
     R"(scene.json: /points/positions/0/1: found NaN, wanted a finite number)"},
    {"NumberIsSpelledNanAlone", R"({"tanor_scene": nan})",
     R"(scene.json: /tanor_scene: found nan, wanted a finite number)"},
    {"NumberIsInfinite", R"({"tanor_scene": 1, "points": {"positions": [[0, 0, -Infinity]]}})",
     R"(scene.json: /points/positions/0/2: found -Infinity, wanted a finite number)"},
    {"KeyIsDuplicate", R"({"tanor_scene": 1, "points": {"positions": [[0, 0, 0]]}, "points": {}})",
     R"(scene.json: /points: found the key "points" twice, wanted once)"},
    {"KeyIsDuplicateDeepInside", three_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1]], "a/b~c": 1, )"
    R"("a/b~c": 2}])"),
     R"(scene.json: /constraints/0/a~1b~0c: found the key "a/b~c" twice, wanted once)"},
    {"KeyIsUnknown", three_points(R"("frictoin": [])"),
     R"(scene.json: /frictoin: found the unknown key "frictoin" (did you mean friction?), wanted one of tanor_scene, name, parameters, )"
     R"(points, generate, import, supports, constraints, coordinates, forces, friction, cell, observe, events, units, motion, solver, equilibrium, modes)"},
    {"KeyIsUnknownInside", three_points(R"("constraints": [{"kind": "plane", "points": [0], "normal": [0,0,1], )"
    R"("centre": [0,0,0]}])"),
     R"(scene.json: /constraints/0/centre: found the unknown key "centre", wanted one of kind, name, points, )"
     R"(normal, offset, side, restitution)"},
    {"KeyHasControlCharacters", three_points(R"("a\nb": 1)"),
     R"(scene.json: /a\u000ab: found the unknown key "a\u000ab", wanted one of tanor_scene, name, parameters, )"
     R"(points, generate, import, supports, constraints, coordinates, forces, friction, cell, observe, events, units, motion, solver, equilibrium, modes)"},
    {"VersionIsMissing", R"({"points": {"positions": [[0,0,0]]}})",
     R"(scene.json: /tanor_scene: missing, wanted 1, the version of the scene format)"},
    {"VersionIsUnknown", R"({"tanor_scene": 2, "points": {"positions": [[0,0,0]]}})",
     R"(scene.json: /tanor_scene: found number 2, wanted 1, the version of the scene format)"},
    {"VersionIsNoNumber", R"({"tanor_scene": "1", "points": {"positions": [[0,0,0]]}})",
     R"(scene.json: /tanor_scene: found string "1", wanted 1, the version of the scene format)"},
    {"NameIsNoString", three_points(R"("name": 7)"),
     R"(scene.json: /name: found number 7, wanted a string)"},
    {"NameIsEmpty", three_points(R"("name": "")"),
     R"(scene.json: /name: found string "", wanted a name)"},
    {"NameHasATab", three_points(R"("name": "a\tb")"),
     R"(scene.json: /name: the name "a\x09b" holds a line break or another control character)"},
    {"ThereAreNoPoints", R"({"tanor_scene": 1})",
     R"(scene.json: /points: missing, wanted one of points, generate, import)"},
    {"ListOfPositionsIsEmpty", R"({"tanor_scene": 1, "points": {"positions": []}})",
     R"(scene.json: /points/positions: found a list of 0, wanted at least one point)"},
    {"PositionsAreMissing", R"({"tanor_scene": 1, "points": {}})",
     R"(scene.json: /points/positions: missing, wanted a list of vectors [x, y, z] or {"file": "…"})"},
    {"ThereAreTwoSources", three_points(R"("generate": {"kind": "chain"})"),
     R"(scene.json: /generate: found beside /points, wanted one of points, generate, import)"},
    {"PointsAreNoObject", R"({"tanor_scene": 1, "points": [[0,0,0]]})",
     R"(scene.json: /points: found a list of 1, wanted an object)"},
    {"PositionHasTwoCoordinates", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0],[1,2]]}})",
     R"(scene.json: /points/positions/1: found a list of 2, wanted 3 numbers [x, y, z])"},
    {"CoordinateIsNoNumber", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0],[1,2,"3"]]}})",
     R"(scene.json: /points/positions/1/2: found string "3", wanted a number)"},
    {"CoordinateIsNull", R"({"tanor_scene": 1, "points": {"positions": [[0,0,null]]}})",
     R"(scene.json: /points/positions/0/2: found null, wanted a number)"},
    {"VelocitiesAreTooFew", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0],[1,0,0]], "velocities": )"
    R"([[0,0,0]]}})",
     R"(scene.json: /points/velocities: found 1 of them, wanted 2, one a point)"},
    {"MassesAreTooFew", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0],[1,0,0]], "masses": [1]}})",
     R"(scene.json: /points/masses: found 1 of them, wanted 2, one a point)"},
    {"MassIsNegative", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0],[1,0,0]], "masses": [1, -1]}})",
     R"(scene.json: /points/masses/1: mass -1 is not positive)"},
    {"MassOfAllIsZero", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0],[1,0,0]], "masses": 0}})",
     R"(scene.json: /points/masses: mass 0 is not positive)"},
    {"MassIsAString", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0]], "masses": "heavy"}})",
     R"(scene.json: /points/masses: found string "heavy", wanted a number, a list of numbers or {"file": "…"})"},
    {"PointIsOutOfRange", three_points(R"("supports": [{"points": [0, 3]}])"),
     R"(scene.json: /supports/0/points/1: found number 3, wanted a whole number from 0 to 2)"},
    {"PointIsNegative", three_points(R"("supports": [{"points": [-1]}])"),
     R"(scene.json: /supports/0/points/0: found number -1, wanted a whole number from 0 to 2)"},
    {"PointIsNoWholeNumber", three_points(R"("supports": [{"points": [0.5]}])"),
     R"(scene.json: /supports/0/points/0: found number 0.5, wanted a whole number from 0 to 2)"},
    {"PointsAreAWrongWord", three_points(R"("supports": [{"points": "every"}])"),
     R"(scene.json: /supports/0/points: found string "every", wanted a list of points, "all" or {"first", "count", )"
     R"("stride"})"},
    {"RangeOfPointsIsTooLong", three_points(R"("supports": [{"points": {"first": 1, "count": 3}}])"),
     R"(scene.json: /supports/0/points/count: found number 3, wanted a whole number from 0 to 2)"},
    {"RangeOfPointsHasNoStride", three_points(R"("supports": [{"points": {"stride": 0}}])"),
     R"(scene.json: /supports/0/points/stride: found number 0, wanted a whole number from 1 to 3)"},
    {"RangeOfPointsHasAnUnknownKey", three_points(R"("supports": [{"points": {"last": 2}}])"),
     R"(scene.json: /supports/0/points/last: found the unknown key "last", wanted one of first, count, stride)"},
    {"SupportsAreNoList", three_points(R"("supports": {"points": [0]})"),
     R"(scene.json: /supports: found an object, wanted a list of supports)"},
    {"SupportIsNoObject", three_points(R"("supports": [0])"),
     R"(scene.json: /supports/0: found number 0, wanted an object)"},
    {"SupportLacksItsPoints", three_points(R"("supports": [{"motion": "fixed"}])"),
     R"(scene.json: /supports/0/points: missing, wanted a list of points, "all" or {"first", "count", "stride"})"},
    {"SupportMovesByAWrongWord", three_points(R"("supports": [{"points": [0], "motion": "free"}])"),
     R"(scene.json: /supports/0/motion: found string "free", wanted "fixed", {"formula": ["…", "…", "…"]} or )"
     R"({"table": "…"})"},
    {"PointIsSupportedTwice", three_points(R"("supports": [{"points": [0]}, {"points": [1, 0]}])"),
     R"(scene.json: /supports/1/points/1: point 0 belongs to /supports/0 already; a point has one prescribed motion)"},
    {"ConstraintHasNoKind", three_points(R"("constraints": [{"pairs": [[0,1]]}])"),
     R"(scene.json: /constraints/0/kind: missing, wanted one of rod, plane, sphere, line, circle, angle, pulley, )"
     R"(linear, ellipsoid, helix, rope, formula)"},
    {"ConstraintKindIsUnknown", three_points(R"("constraints": [{"kind": "rods", "pairs": [[0,1]]}])"),
     R"(scene.json: /constraints/0/kind: found string "rods" (did you mean rod?), wanted one of rod, plane, sphere, line, circle, )"
     R"(angle, pulley, linear, ellipsoid, helix, rope, formula)"},
    {"EquationHasAnError", three_points(R"json("constraints": [{"kind": "formula", "points": [[0, 1]], )json"
    R"json("equation": "sqrt(x1 +* y2)"}])json"),
     R"json(scene.json: /constraints/0/equation: formula "sqrt(x1 +* y2)": column 10: found '*', expected a )json"
     R"json(number, a name or '(')json"},
    {"EquationNamesAPointThatItsTuplesLack", three_points(R"("constraints": [{"kind": "formula", "points": [[0], )"
    R"([1]], "equation": "x1 - x2"}])"),
     R"(scene.json: /constraints/0/equation: formula "x1 - x2": column 6: 'x2' is not known (did you mean x1?); known names: x1, y1, )"
     R"(z1, t, pi and the functions sqrt, exp, log, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, abs, )"
     R"(min, max)"},
    {"EquationIsMissing", three_points(R"("constraints": [{"kind": "formula", "points": [[0]]}])"),
     R"(scene.json: /constraints/0/equation: missing, wanted a string)"},
    {"TuplesOfAFormulaDiffer", three_points(R"("constraints": [{"kind": "formula", "points": [[0, 1], [2]], )"
    R"("equation": "x1"}])"),
     R"(scene.json: /constraints/0/points/1: found a list of 1, wanted 2 points, as in the first tuple)"},
    {"TupleOfAFormulaIsEmpty", three_points(R"("constraints": [{"kind": "formula", "points": [[]], "equation": )"
    R"("x1"}])"),
     R"(scene.json: /constraints/0/points/0: found a list of 0, wanted at least one point)"},
    {"FormulaNamesAPointTwice", three_points(R"("constraints": [{"kind": "formula", "points": [[0, 1], [2, 2]], )"
    R"("equation": "x1 - x2"}])"),
     R"(scene.json: /constraints/0/points/1: [2, 2] names point 2 twice; the points of a tuple differ)"},
    {"FormulaHoldsNothing", three_points(R"("constraints": [{"kind": "formula", "points": [[1], [0]], "equation": )"
    R"("x1^2 + y1^2"}])"),
     R"(scene.json: /constraints/0/points/1: point 0: its gradient is zero at the start: it holds nothing there)"},
    {"ValueOfAFormulaIsNotFinite", three_points(R"json("constraints": [{"kind": "formula", "points": [[1]], )json"
    R"json("equation": "log(x1 - 1) + y1"}])json"),
     R"(scene.json: /constraints/0/points/0: point 1: the function is -inf at the start)"},
    {"GradientOfAFormulaIsNotFinite", three_points(R"json("constraints": [{"kind": "formula", "points": [[1]], )json"
    R"json("equation": "sqrt(y1) + x1 - 1"}])json"),
     R"(scene.json: /constraints/0/points/0: point 1: its gradient has the component inf at the start)"},
    {"ForceFormulaHasAnError", three_points(R"("forces": [{"kind": "formula", "points": [0], "x": "vx", "y": "1 + )"
    R"(w"}])"),
     R"(scene.json: /forces/0/y: formula "1 + w": column 5: 'w' is not known; known names: x, y, z, vx, vy, vz, t, )"
     R"(pi and the functions sqrt, exp, log, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, abs, min, max)"},
    {"ForceFormulaIsNotFinite", three_points(R"("forces": [{"kind": "formula", "points": [1, 0], "x": "1/x"}])"),
     R"(scene.json: /forces/0/points/1: point 0: the force is [inf, 0, 0] at the start)"},
    {"PairNamesAPointTwice", three_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1],[1,1]]}])"),
     R"(scene.json: /constraints/0/pairs/1: [1, 1] names point 1 twice; a rod joins two different points)"},
    {"PairHasThreePoints", three_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1,2]]}])"),
     R"(scene.json: /constraints/0/pairs/0: found a list of 3, wanted a pair of points [i, j])"},
    {"PairsAreMissing", three_points(R"("constraints": [{"kind": "rod"}])"),
     R"(scene.json: /constraints/0/pairs: missing, wanted a list of pairs of points)"},
    {"PairIsOutOfRange", three_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1],[1,7]]}])"),
     R"(scene.json: /constraints/0/pairs/1/1: found number 7, wanted a whole number from 0 to 2)"},
    {"LengthIsNegative", three_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1]], "length": -1}])"),
     R"(scene.json: /constraints/0/length: length -1 is not positive)"},
    {"LengthsAreTooFew", three_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1],[1,2]], "length": [1]}])"),
     R"(scene.json: /constraints/0/length: found a list of 1, wanted one number, or a list of 2)"},
    {"LengthIsAWrongWord", three_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1]], "length": "short"}])"),
     R"(scene.json: /constraints/0/length: found string "short", wanted "initial", a number, a list of numbers, )"
     R"({"formula": "…"} or {"table": "…"})"},
    {"OffsetsAreTooFew", three_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1],[1,2]], "offsets": )"
    R"([[1,0,0]]}])"),
     R"(scene.json: /constraints/0/offsets: found a list of 1, wanted 2 vectors, one a pair)"},
    {"NormalIsZero", three_points(R"("constraints": [{"kind": "plane", "points": [0], "normal": [0,0,0]}])"),
     R"(scene.json: /constraints/0/normal: normal [0, 0, 0] is zero; it must have a direction)"},
    {"NormalIsMissing", three_points(R"("constraints": [{"kind": "plane", "points": [0]}])"),
     R"(scene.json: /constraints/0/normal: missing, wanted 3 numbers [x, y, z], {"formula": ["…", "…", "…"]} or )"
     R"({"table": "…"})"},
    {"DirectionIsZero", three_points(R"("constraints": [{"kind": "line", "points": [0], "origin": [0,0,0], )"
    R"("direction": [0,0,0]}])"),
     R"(scene.json: /constraints/0/direction: direction [0, 0, 0] is zero; it must have a direction)"},
    {"RadiiAreMissing", three_points(R"("constraints": [{"kind": "ellipsoid", "points": [1], "center": [0,0,0]}])"),
     R"(scene.json: /constraints/0/radii: missing, wanted 3 numbers [x, y, z])"},
    {"ARadiusIsZero", three_points(R"("constraints": [{"kind": "ellipsoid", "points": [1], "center": [0,0,0], )"
    R"("radii": [1,0,1]}])"),
     R"(scene.json: /constraints/0/radii: radii y 0 is not positive)"},
    {"AxesOfAnEllipsoidAreParallel", three_points(R"("constraints": [{"kind": "ellipsoid", "points": [1], "center": )"
    R"([0,0,0], "radii": [1,2,1], "axes": [[1,0,0], [2,0,0]]}])"),
     R"(scene.json: /constraints/0/points/0: point 1: its axes are parallel; they span a plane)"},
    {"NoPointIsShown", three_points(R"("motion": {"t_end": 1, "output_points": []})"),
     R"(scene.json: /motion/output_points: found a list of 0, wanted one point at least)"},
    {"APointIsShownTwice", three_points(R"("motion": {"t_end": 1, "output_points": [2, 1, 2]})"),
     R"(scene.json: /motion/output_points: names point 2 twice)"},
    {"AxesOfAnEllipsoidAreThree", three_points(R"("constraints": [{"kind": "ellipsoid", "points": [1], "center": )"
    R"([0,0,0], "radii": [1,2,1], "axes": [[1,0,0], [0,1,0], [0,0,1]]}])"),
     R"(scene.json: /constraints/0/axes: found a list of 3, wanted 2 vectors [x, y, z])"},
    {"AxisOfAnEllipsoidIsZero", three_points(R"("constraints": [{"kind": "ellipsoid", "points": [1], "center": )"
    R"([0,0,0], "radii": [1,2,1], "axes": [[1,0,0], [0,0,0]]}])"),
     R"(scene.json: /constraints/0/axes/1: vector [0, 0, 0] is zero; it must have a direction)"},
    {"RadiusOfAHelixIsNegative", three_points(R"("constraints": [{"kind": "helix", "points": [1], "origin": [0,0,0], )"
    R"("axis": [0,0,1], "radius": -1, "pitch": 1}])"),
     R"(scene.json: /constraints/0/radius: found number -1, wanted a number > 0)"},
    {"PitchIsZero", three_points(R"("constraints": [{"kind": "helix", "points": [1], "origin": [0,0,0], )"
    R"("axis": [0,0,1], "radius": 1, "pitch": 0}])"),
     R"(scene.json: /constraints/0/pitch: pitch 0 must not be zero)"},
    {"AxisOfAHelixIsZero", three_points(R"("constraints": [{"kind": "helix", "points": [1], "origin": [0,0,0], )"
    R"("axis": [0,0,0], "radius": 1, "pitch": 1}])"),
     R"(scene.json: /constraints/0/axis: axis [0, 0, 0] is zero; it must have a direction)"},
    {"BeadIsOnTheAxisOfItsHelix", three_points(R"("constraints": [{"kind": "helix", "points": [0], "origin": )"
    R"([0,0,0], "axis": [0,0,1], "radius": 1, "pitch": 1}])"),
     R"(scene.json: /constraints/0/points/0: point 0: it is on the axis and has no angle there)"},
    {"TupleDoesNotFitItsCoefficients", three_points(R"("constraints": [{"kind": "linear", "tuples": [[0,1],[2]], )"
    R"("coefficients": [[1,0,0],[-1,0,0]]}])"),
     R"(scene.json: /constraints/0/tuples/1: found a list of 1, wanted 2 points, one a coefficient)"},
    {"NameIsUsedTwice", three_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1]], "name": "a"}, {"kind": )"
    R"("rod", "pairs": [[1,2]], "name": "a"}])"),
     R"(scene.json: /constraints/1/name: "a" is the name of /constraints/0 already; a name is used once)"},
    {"FormulaHasAnError", three_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1]], "length": {"formula": )"
    R"("1 + sin(omega*t"}}], "parameters": {"omega": 3})"),
     R"(scene.json: /constraints/0/length/formula: formula "1 + sin(omega*t": column 16: found the end, expected an )"
     R"(operator or ')': sin takes 1 argument)"},
    {"FormulaNamesSomethingUnknown", three_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1]], "length": )"
    R"({"formula": "1 + q"}}])"),
     R"(scene.json: /constraints/0/length/formula: formula "1 + q": column 5: 'q' is not known; known names: t, pi )"
     R"(and the functions sqrt, exp, log, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, abs, min, max)"},
    {"FormulaOfAVectorHasTwoStrings", three_points(R"("supports": [{"points": [0], "motion": {"formula": ["t", )"
    R"("0"]}}])"),
     R"(scene.json: /supports/0/motion/formula: found a list of 2, wanted 3 strings, formulas of x, y, z)"},
    {"FormulaOfAVectorHasAnError", three_points(R"("supports": [{"points": [0], "motion": {"formula": ["t", "0", )"
    R"("*"]}}])"),
     R"(scene.json: /supports/0/motion/formula/2: formula "*": column 1: found '*', expected a number, a name or '(')"},
    {"FormulaIsNotFinite", three_points(R"("forces": [{"kind": "constant", "points": [0], "force": {"formula": )"
    R"(["1/0", "0", "0"]}}])"),
     R"(scene.json: /forces/0/force: force x inf is not finite)"},
    {"FormulaAndTable", three_points(R"("supports": [{"points": [0], "motion": {"formula": ["t", "0", "0"], )"
    R"("table": "a.csv"}}])"),
     R"(scene.json: /supports/0/motion: found an object, wanted one of the keys formula, table)"},
    {"TableCannotBeRead", three_points(R"("supports": [{"points": [0], "motion": {"table": "nowhere.csv"}}])"),
     R"(scene.json: /supports/0/motion/table: nowhere.csv cannot be read: No such file or directory)"},
    {"ParameterIsNoNumber", three_points(R"("parameters": {"omega": "3"})"),
     R"(scene.json: /parameters/omega: found string "3", wanted a number)"},
    {"ParameterIsNamedLikeTime", three_points(R"("parameters": {"t": 3})"),
     R"(scene.json: /parameters/t: formula "t": the constant 't' has the name of a variable)"},
    {"ForceKindIsUnknown", three_points(R"("forces": [{"kind": "wind"}])"),
     R"(scene.json: /forces/0/kind: found string "wind", wanted one of gravity, constant, spring, drag, formula, )"
     R"(pair, potential, bond, bending, torsion)"},
    {"LawIsMissing", three_points(R"("forces": [{"kind": "pair"}])"),
     R"(scene.json: /forces/0/law: missing, wanted one of wca, lj, log, coulomb, yukawa, morse)"},
    {"LawIsUnknown", three_points(R"("forces": [{"kind": "pair", "law": "buckingham"}])"),
     R"(scene.json: /forces/0/law: found string "buckingham", wanted one of wca, lj, log, coulomb, yukawa, morse)"},
    {"LawHasNoSuchNumber", three_points(R"("forces": [{"kind": "pair", "law": "log", "sigma": 1}])"),
     R"(scene.json: /forces/0/sigma: found beside the law "log", wanted with wca or lj only)"},
    {"LawHasItsOwnCutoff", three_points(R"("forces": [{"kind": "pair", "law": "wca", "cutoff": 2}])"),
     R"(scene.json: /forces/0/cutoff: found beside the law "wca", wanted with lj, yukawa or morse only)"},
    {"SigmaIsZero", three_points(R"("forces": [{"kind": "pair", "law": "lj", "sigma": 0}])"),
     R"(scene.json: /forces/0/sigma: found number 0, wanted a number > 0)"},
    {"PairsHaveNoPoints", three_points(R"("forces": [{"kind": "pair", "law": "lj", "points": []}])"),
     R"(scene.json: /forces/0/points: found a list of 0, wanted at least one point)"},
    {"PairsNameAPointTwice", three_points(R"("forces": [{"kind": "pair", "law": "lj", "points": [1, 0, 1]}])"),
     R"(scene.json: /forces/0/points/2: point 1 is named twice; a point makes no pair with itself)"},
    {"BoxIsTooShort", three_points(R"("forces": [{"kind": "pair", "law": "lj", "sigma": 0.5, "box": [3, 2, 0]}])"),
     R"(scene.json: /forces/0/box: box edge 2 is shorter than twice the cutoff; 2.5 or longer is right, or 0 along )"
     R"(an axis that is not periodic)"},
    {"BoxIsNoBox", three_points(R"("forces": [{"kind": "pair", "law": "lj", "box": "cube"}])"),
     R"(scene.json: /forces/0/box: found string "cube", wanted 3 numbers [lx, ly, lz] or "import")"},
    {"BoxIsNotImported", three_points(R"("forces": [{"kind": "pair", "law": "lj", "box": "import"}])"),
     R"(scene.json: /forces/0/box: found string "import", wanted [lx, ly, lz], for no file with a box is imported)"},
    {"ExcludedIsUnknown", three_points(R"("forces": [{"kind": "pair", "law": "lj", "exclude": "angles"}])"),
     R"(scene.json: /forces/0/exclude: found string "angles", wanted rods)"},
    {"PairIsAtOnePlace", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0],[1,0,0],[6,0,0]]}, "forces": )"
    R"([{"kind": "pair", "law": "wca", "box": [5, 0, 0]}]})",
     R"(scene.json: /forces/0: points 1 and 2 are at the same place; their force has no direction)"},
    {"AccelerationIsMissing", three_points(R"("forces": [{"kind": "gravity"}])"),
     R"(scene.json: /forces/0/acceleration: missing, wanted 3 numbers [x, y, z])"},
    {"StiffnessIsNegative", three_points(R"("forces": [{"kind": "spring", "pairs": [[0,1]], "stiffness": -2}])"),
     R"(scene.json: /forces/0/stiffness: found number -2, wanted a number >= 0)"},
    {"RestLengthDependsOnTime", three_points(R"("forces": [{"kind": "spring", "pairs": [[0,1]], "stiffness": 2, )"
    R"("rest_length": {"formula": "t"}}])"),
     R"(scene.json: /forces/0/rest_length: found an object, wanted "initial", a number or a list of numbers)"},
    {"StepIsZero", three_points(R"("motion": {"step": 0})"),
     R"(scene.json: /motion/step: found number 0, wanted a number > 0)"},
    {"ToleranceIsNegative", three_points(R"("motion": {"rtol": -1e-8})"),
     R"(scene.json: /motion/rtol: found number -1e-08, wanted a number > 0)"},
    {"EndIsNegative", three_points(R"("motion": {"t_end": -1})"),
     R"(scene.json: /motion/t_end: found number -1, wanted a time after t_start = 0)"},
    {"LongestStepIsZero", three_points(R"("motion": {"max_step": 0})"),
     R"(scene.json: /motion/max_step: found number 0, wanted a number > 0)"},
    {"OutputIntervalIsZero", three_points(R"("motion": {"output_every": 0})"),
     R"(scene.json: /motion/output_every: found number 0, wanted a number > 0)"},
    {"OutputPointIsOutOfRange", three_points(R"("motion": {"output_points": [5]})"),
     R"(scene.json: /motion/output_points/0: found number 5, wanted a whole number from 0 to 2)"},
    {"MethodIsUnknown", three_points(R"("motion": {"method": "euler"})"),
     R"(scene.json: /motion/method: found string "euler", wanted one of )" + join_names_of_methods()},
    {"StartIsUnknown", three_points(R"("motion": {"start": "jump"})"),
     R"(scene.json: /motion/start: found string "jump", wanted one of check, project)"},
    {"StabilisationIsUnknown", three_points(R"("motion": {"stabilisation": "baumgarte"})"),
     R"(scene.json: /motion/stabilisation: found string "baumgarte", wanted one of projection, none)"},
    {"FormIsUnknown", three_points(R"("solver": {"form": "dual"})"),
     R"(scene.json: /solver/form: found string "dual", wanted one of auto, normal, tangent, both)"},
    {"StrengthIsNotPositive", three_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1]], "breaks_at": -3}])"),
     R"(scene.json: /constraints/0/breaks_at: breaks_at -3 is not positive)"},
    {"StrengthsAreTooMany", three_points(R"("constraints": [{"kind": "rope", "paths": [[0,1]], "breaks_at": [1, 2]}])"),
     R"(scene.json: /constraints/0/breaks_at: found a list of 2, wanted one number, or a list of 1)"},
    {"StrengthOfAPlane", three_points(R"("constraints": [{"kind": "plane", "points": [0], "normal": [0,0,1], )"
    R"("breaks_at": 3}])"),
     R"(scene.json: /constraints/0/breaks_at: found the unknown key "breaks_at", wanted one of kind, name, points, )"
     R"(normal, offset, side, restitution)"},
    {"LimitOfContactIsZero", three_points(R"("solver": {"contact": {"max_events": 0}})"),
     R"(scene.json: /solver/contact/max_events: found number 0, wanted a whole number from 1 to 2147483647)"},
    {"LimitOfContactIsUnknown", three_points(R"("solver": {"contact": {"max_event": 10}})"),
     R"(scene.json: /solver/contact/max_event: found the unknown key "max_event" (did you mean max_events?), )"
     R"(wanted one of max_at_one_instant, max_events)"},
    {"BothNamesOfALinearSolver", three_points(R"("solver": {"linear_solver": "auto", "way": "paths"})"),
     R"(scene.json: /solver/way: found beside linear_solver, which is its new name)"},
    {"LinearSolverIsUnknown", three_points(R"("solver": {"linear_solver": "short"})"),
     R"(scene.json: /solver/linear_solver: found string "short", wanted one of auto, general, paths, trees, batches, closed_form, cholmod)"},
    {"OrderingIsUnknown", three_points(R"("solver": {"ordering": "random"})"),
     R"(scene.json: /solver/ordering: found string "random", wanted one of auto, amd, metis, nesdis, natural, axes, points)"},
    {"ThreadsAreNegative", three_points(R"("solver": {"threads": -1})"),
     R"(scene.json: /solver/threads: found number -1, wanted a whole number from 0 to 1024)"},
    {"CertificateIsUnknown", three_points(R"("solver": {"certificate": "sometimes"})"),
     R"(scene.json: /solver/certificate: found string "sometimes", wanted one of off, final, always)"},
    {"CertificateIntervalIsZero", three_points(R"("solver": {"certificate": {"every": 0}})"),
     R"(scene.json: /solver/certificate/every: found number 0, wanted a whole number from 1 to 2147483647)"},
    {"CertificateIsANumber", three_points(R"("solver": {"certificate": 5})"),
     R"(scene.json: /solver/certificate: found number 5, wanted "off", "final", "always" or {"every": N})"},
    {"GeneratorIsUnknown", R"({"tanor_scene": 1, "generate": {"kind": "rope"}})",
     R"(scene.json: /generate/kind: found string "rope", wanted one of chain, ring, net, lattice, tree, clusters, )"
     R"(melt)"},
    {"GeneratorHasAnUnknownKey", R"({"tanor_scene": 1, "generate": {"kind": "ring", "anchored": true}})",
     R"(scene.json: /generate/anchored: found the unknown key "anchored", wanted one of kind, spacing, mass, seed, )"
     R"(count)"},
    {"GeneratorMakesNoRods", R"({"tanor_scene": 1, "generate": {"kind": "chain", "count": 0}})",
     R"(scene.json: /generate/count: found number 0, wanted a whole number from 1 to 2147483646)"},
    {"GeneratorHasNegativeSpacing", R"({"tanor_scene": 1, "generate": {"kind": "chain", "spacing": -0.1}})",
     R"(scene.json: /generate/spacing: found number -0.1, wanted a number > 0)"},
    {"GeneratorHasZeroDirection", R"({"tanor_scene": 1, "generate": {"kind": "chain", "direction": [0,0,0]}})",
     R"(scene.json: /generate/direction: found the zero vector, wanted a direction)"},
    {"GeneratorMakesTooManyPoints", R"({"tanor_scene": 1, "generate": {"kind": "net", "columns": 100000, "rows": )"
    R"(100000}})",
     R"(scene.json: /generate/rows: found number 100000, wanted a whole number from 1 to 21473)"},
    {"GeneratorSizeHasTwoNumbers", R"({"tanor_scene": 1, "generate": {"kind": "lattice", "size": [2, 2]}})",
     R"(scene.json: /generate/size: found a list of 2, wanted 3 whole numbers [a, b, c])"},
    {"AnchoredIsNoBoolean", R"({"tanor_scene": 1, "generate": {"kind": "chain", "anchored": 1}})",
     R"(scene.json: /generate/anchored: found number 1, wanted true or false)"},
    {"SupportMeetsTheGeneratedOne", R"({"tanor_scene": 1, "generate": {"kind": "chain", "anchored": true}, )"
    R"("supports": [{"points": [0]}]})",
     R"(scene.json: /supports/0/points/0: point 0 belongs to /generate already; a point has one prescribed motion)"},
    {"ConstraintBehindGeneratedRods", R"({"tanor_scene": 1, "generate": {"kind": "chain"}, "constraints": [{"kind": )"
    R"("rod", "pairs": [[0,1],[2,2]]}]})",
     R"(scene.json: /constraints/0/pairs/1: [2, 2] names point 2 twice; a rod joins two different points)"},
    {"NameOfGeneratedRodsIsTaken", R"({"tanor_scene": 1, "generate": {"kind": "chain"}, "constraints": [{"kind": )"
    R"("plane", "name": "rods", "points": [0], "normal": [0,0,1]}]})",
     R"(scene.json: /constraints/0/name: "rods" is the name of /generate already; a name is used once)"},
    {"ImportLacksItsFile", R"({"tanor_scene": 1, "import": {"format": "lammps-data"}})",
     R"(scene.json: /import/file: missing, wanted a string)"},
    {"ImportFileCannotBeRead", R"({"tanor_scene": 1, "import": {"file": "nowhere.data"}})",
     R"(scene.json: /import/file: nowhere.data cannot be read: No such file or directory)"},
    {"ImportFormatIsUnknown", R"({"tanor_scene": 1, "import": {"file": "a.xyz", "format": "xyz"}})",
     R"(scene.json: /import/format: found string "xyz", wanted one of lammps-data, obj, ply, gro, pdb)"},
    {"ImportedBondsAreUnknown", R"({"tanor_scene": 1, "import": {"file": "a", "bonds": "glue"}})",
     R"(scene.json: /import/bonds: found string "glue", wanted one of rods, distance, none, energies)"},
    {"ImportedAnglesAreUnknown", R"({"tanor_scene": 1, "import": {"file": "a", "angles": "stiff"}})",
     R"(scene.json: /import/angles: found string "stiff", wanted one of free, rigid, energies)"},
};
// clang-format on

INSTANTIATE_TEST_SUITE_P(Rules, BadInputTest, testing::ValuesIn(bad_inputs),
                         [](const testing::TestParamInfo<BadInput>& input) { return std::string(input.param.rule); });

}  // namespace
}  // namespace tanor::scene
