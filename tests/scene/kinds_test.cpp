#include <cmath>

#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

using Pairs = std::vector<std::array<Index, 2>>;
using Triples = std::vector<std::array<Index, 3>>;

/// Returns the only constraint of a scene of three points. The supports do not matter here.
template <class Group>
Group read_constraint(const std::string& fields) {
  return std::get<Group>(
      parse(three_points(R"("parameters": {"omega": 3}, "constraints": [{)" + fields + "}]")).system.constraints.at(0));
}

template <class Group>
Group read_force(const std::string& fields) {
  return std::get<Group>(parse(three_points(R"("forces": [{)" + fields + "}]")).system.forces.at(0));
}

// ---- constraints ----

TEST(Constraints, RodsHaveTheirInitialLength) {
  const auto rods = read_constraint<Rods>(R"("kind": "rod", "pairs": [[0,1],[1,2]])");

  EXPECT_EQ(rods.name, "") << "the library makes the default name";
  EXPECT_EQ(rods.pairs, (Pairs{{0, 1}, {1, 2}}));
  EXPECT_TRUE(rods.length.is_initial());
  EXPECT_TRUE(rods.offsets.empty());
}

TEST(Constraints, RodsHaveLengthsAndOffsets) {
  const auto one = read_constraint<Rods>(R"("kind": "rod", "name": "ropes", "pairs": [[0,1],[1,2]], "length": 1.5)");
  const auto each = read_constraint<Rods>(
      R"("kind": "rod", "pairs": [[0,1],[1,2]], "length": [1.5, 2], "offsets": [[0,0,0],[4,0,0]])");

  EXPECT_EQ(one.name, "ropes");
  EXPECT_EQ(one.length.constants, std::vector<double>{1.5});
  EXPECT_EQ(each.length.constants, (std::vector<double>{1.5, 2.0}));
  EXPECT_EQ(each.offsets, (std::vector<Vector3>{{0, 0, 0}, {4, 0, 0}}));
}

TEST(Constraints, LengthsFollowFormulasWithParameters) {
  const auto one = read_constraint<Rods>(
      R"json("kind": "rod", "pairs": [[0,1],[1,2]], "length": {"formula": "1 + 0.1*sin(omega*t)"})json");
  const auto each =
      read_constraint<Rods>(R"("kind": "rod", "pairs": [[0,1],[1,2]], "length": [2, {"formula": "omega + t"}])");

  ASSERT_EQ(one.length.functions.size(), 1u);
  EXPECT_DOUBLE_EQ(one.length.functions[0](0.5).value(), 1 + 0.1 * std::sin(1.5));
  ASSERT_EQ(each.length.functions.size(), 2u);
  EXPECT_EQ(each.length.functions[0](7.0).value(), 2.0);
  EXPECT_EQ(each.length.functions[1](7.0).value(), 10.0);
}

TEST(Constraints, LengthsFollowTables) {
  const auto rods = read_constraint<Rods>(R"("kind": "rod", "pairs": [[0,1]], "length": {"table": "drive.csv"})");

  ASSERT_EQ(rods.length.functions.size(), 1u);
  EXPECT_NEAR(rods.length.functions[0](0.25).value(), 1.1, 1e-12);
}

TEST(Constraints, PlanesHaveOffsetZeroByDefault) {
  const auto planes = read_constraint<Planes>(R"("kind": "plane", "points": "all", "normal": [0, 1, 1])");
  const auto shifted = read_constraint<Planes>(R"("kind": "plane", "points": [0], "normal": [0, 0, 1], "offset": 2)");

  EXPECT_EQ(planes.points, (std::vector<Index>{0, 1, 2}));
  EXPECT_EQ(at(planes.normal, 0.0), (Vector3{0, 1, 1}));
  EXPECT_EQ(planes.offset.constants, std::vector<double>{0.0});
  EXPECT_EQ(shifted.offset.constants, std::vector<double>{2.0});
}

TEST(Constraints, SpheresMayMove) {
  const auto spheres = read_constraint<Spheres>(
      R"("kind": "sphere", "points": [1], "center": {"formula": ["t", "2", "omega"]}, "radius": 2)");

  EXPECT_FALSE(spheres.center.is_constant());
  EXPECT_EQ(at(spheres.center, 5.0), (Vector3{5, 2, 3}));
  EXPECT_EQ(spheres.radius.constants, std::vector<double>{2.0});
}

TEST(Constraints, LinesHaveOriginAndDirection) {
  const auto lines =
      read_constraint<Lines>(R"("kind": "line", "points": [1, 2], "origin": [0, 1, 0], "direction": [1, 0, 0])");

  EXPECT_EQ(lines.points, (std::vector<Index>{1, 2}));
  EXPECT_EQ(at(lines.origin, 0.0), (Vector3{0, 1, 0}));
  EXPECT_EQ(at(lines.direction, 0.0), (Vector3{1, 0, 0}));
}

TEST(Constraints, CirclesHaveCenterNormalAndRadius) {
  const auto circles =
      read_constraint<Circles>(R"("kind": "circle", "points": [1], "center": [0, 0, 0], "normal": [0, 0, 1])");

  EXPECT_EQ(at(circles.center, 0.0), (Vector3{0, 0, 0}));
  EXPECT_EQ(at(circles.normal, 0.0), (Vector3{0, 0, 1}));
  EXPECT_TRUE(circles.radius.is_initial());
}

TEST(Constraints, EllipsoidsHaveRadiiAndAxes) {
  const auto plain =
      read_constraint<Ellipsoids>(R"("kind": "ellipsoid", "points": [0], "center": [0, 0, 1], "radii": [1, 2, 3])");
  const auto turned = read_constraint<Ellipsoids>(
      R"("kind": "ellipsoid", "points": "all", "center": {"formula": ["t", "0", "-1"]}, "radii": [1, 2, 3], )"
      R"("axes": [[1, 1, 0], [0, 0, 1]])");

  EXPECT_EQ(plain.points, std::vector<Index>{0});
  EXPECT_EQ(at(plain.center, 0.0), (Vector3{0, 0, 1}));
  EXPECT_EQ(plain.radii, (Vector3{1, 2, 3}));
  EXPECT_EQ(plain.axes, (std::array{Vector3{1, 0, 0}, Vector3{0, 1, 0}}));
  EXPECT_FALSE(turned.center.is_constant());
  EXPECT_EQ(turned.axes, (std::array{Vector3{1, 1, 0}, Vector3{0, 0, 1}}));
}

TEST(Constraints, HelicesHaveAnAxisARadiusAndAPitch) {
  const auto plain = read_constraint<Helices>(
      R"("kind": "helix", "points": [1, 2], "origin": [0, 0, 0], "axis": [0, 0, 1], "radius": 2, "pitch": -0.5)");
  const auto screw = read_constraint<Helices>(
      R"("kind": "helix", "points": [1], "origin": [0, 0, 0], "axis": [0, 0, 1], "radius": 2, "pitch": 1, )"
      R"("phase": {"formula": "omega*t"})");

  EXPECT_EQ(plain.points, (std::vector<Index>{1, 2}));
  EXPECT_EQ(plain.axis, (Vector3{0, 0, 1}));
  EXPECT_EQ(plain.radius, 2.0);
  EXPECT_EQ(plain.pitch, -0.5);
  EXPECT_TRUE(plain.phase.is_initial());
  EXPECT_EQ(screw.phase.functions.size(), 1u);
}

TEST(Constraints, AnglesHaveTriplesAndCosine) {
  const auto angles = read_constraint<Angles>(R"("kind": "angle", "triples": [[0, 1, 2]], "cosine": -0.5)");

  EXPECT_EQ(angles.triples, (Triples{{0, 1, 2}}));
  EXPECT_EQ(angles.cosine.constants, std::vector<double>{-0.5});
}

TEST(Constraints, PulleysHaveRatioOneByDefault) {
  const auto pulleys =
      read_constraint<Pulleys>(R"("kind": "pulley", "pairs": [[0, 1]], "a": [0, 0, 1], "b": [1, 0, 1])");
  const auto tackle = read_constraint<Pulleys>(
      R"("kind": "pulley", "pairs": [[0, 1]], "a": [0, 0, 1], "b": [1, 0, 1], "length": 3, "ratio": 2)");

  EXPECT_EQ(pulleys.a, (Vector3{0, 0, 1}));
  EXPECT_EQ(pulleys.b, (Vector3{1, 0, 1}));
  EXPECT_EQ(pulleys.ratio, 1.0);
  EXPECT_TRUE(pulleys.length.is_initial());
  EXPECT_EQ(tackle.ratio, 2.0);
  EXPECT_EQ(tackle.length.constants, std::vector<double>{3.0});
}

TEST(Constraints, LinearsHaveACoefficientForEachPoint) {
  const auto linears = read_constraint<Linears>(
      R"("kind": "linear", "tuples": [[0, 1], [1, 2]], "coefficients": [[1, 0, 0], [-1, 0, 0]], "value": [-1, -1])");

  EXPECT_EQ(linears.tuples, (std::vector<std::vector<Index>>{{0, 1}, {1, 2}}));
  EXPECT_EQ(linears.coefficients, (std::vector<Vector3>{{1, 0, 0}, {-1, 0, 0}}));
  EXPECT_EQ(linears.value.constants, (std::vector<double>{-1.0, -1.0}));
}

/// Returns xi, its rate and phi of one member.
std::array<double, 3> evaluate(const ConstraintKernel& kernel, double t, const std::vector<double>& r,
                               const std::vector<double>& v) {
  std::array<double, 3> result{};
  kernel.evaluate(kernel.context.get(), {1, t, r.data(), v.data(), &result[0], &result[1], &result[2], nullptr});
  return result;
}

TEST(Constraints, FormulasHaveTuplesAndParameters) {
  const auto user = read_constraint<UserConstraints>(
      R"("kind": "formula", "name": "gear", "points": [[0, 1], [2, 1]], "equation": "omega*x1^2 - y2*t + z1")");

  EXPECT_EQ(user.name, "gear");
  EXPECT_EQ(user.tuples, (std::vector<std::vector<Index>>{{0, 1}, {2, 1}}));
  EXPECT_EQ(user.kernel.num_points, 2);
  // The function is 3 x^2 - y t along x = 2 + e, y = 5 + e, t = 7 + e.
  EXPECT_EQ(evaluate(user.kernel, 7.0, {2, 0, 0, 0, 5, 0}, {1, 0, 0, 0, 1, 0}),
            (std::array<double, 3>{12.0 - 35.0, 12.0 - 7.0 - 5.0, 6.0 - 2.0}));
}

// ---- supports ----

TEST(Supports, MoveByFormulasAndTables) {
  const Scene scene = parse(three_points(R"json("motion": {"t_end": 2}, "supports": [
    {"points": [0], "motion": {"formula": ["0.1*sin(3*t)", "0", "t^2"]}},
    {"points": [1], "motion": {"table": "path.csv"}},
    {"points": [2]}])json"));

  const std::vector<Support>& supports = scene.system.supports;
  EXPECT_DOUBLE_EQ(at(supports[0].displacement, 2.0)[0], 0.1 * std::sin(6.0));
  EXPECT_EQ(at(supports[0].displacement, 2.0)[2], 4.0);
  EXPECT_NEAR(at(supports[1].displacement, 1.0)[2], -0.1, 1e-12);
  EXPECT_TRUE(supports[2].displacement.is_constant());
  EXPECT_EQ(at(supports[2].displacement, 1.0), Vector3{});
}

// ---- forces ----

TEST(Forces, GravityHasAnAcceleration) {
  const auto gravity = read_force<Gravity>(R"("kind": "gravity", "name": "moon", "acceleration": [0, 0, -1.62])");

  EXPECT_EQ(gravity.name, "moon");
  EXPECT_EQ(gravity.acceleration, (Vector3{0, 0, -1.62}));
}

TEST(Forces, ConstantForceMayDependOnTime) {
  const auto push = read_force<ConstantForce>(R"("kind": "constant", "points": [2], "force": [1, 0, 0])");
  const auto wave = read_force<ConstantForce>(
      R"json("kind": "constant", "points": [2], "force": {"formula": ["cos(t)", "0", "0"]})json");

  EXPECT_EQ(push.points, std::vector<Index>{2});
  EXPECT_EQ(at(push.force, 9.0), (Vector3{1, 0, 0}));
  EXPECT_DOUBLE_EQ(at(wave.force, 9.0)[0], std::cos(9.0));
}

TEST(Forces, SpringsRestAtTheirInitialLength) {
  const auto springs = read_force<Springs>(R"("kind": "spring", "pairs": [[0, 1]], "stiffness": 10)");
  const auto dampers = read_force<Springs>(
      R"("kind": "spring", "pairs": [[0, 1], [1, 2]], "stiffness": 10, "damping": 2, "rest_length": [0, 0.5])");

  EXPECT_EQ(springs.pairs, (Pairs{{0, 1}}));
  EXPECT_EQ(springs.stiffness, 10.0);
  EXPECT_EQ(springs.damping, 0.0);
  EXPECT_TRUE(springs.rest_length.is_initial());
  EXPECT_EQ(dampers.damping, 2.0);
  EXPECT_EQ(dampers.rest_length.constants, (std::vector<double>{0.0, 0.5}));
}

TEST(Forces, FormulasOfAForceSeePositionVelocityAndTime) {
  const auto field =
      read_force<FormulaForce>(R"("kind": "formula", "points": [2, 0], "x": "x + 10*vy", "z": "t*vz - z")");
  const auto magnet = read_force<FormulaForce>(R"json("kind": "formula", "points": [1], "y": "1/(1 + x^2)")json");
  const double r[] = {1, 2, 3}, v[] = {4, 5, 6};
  Vector3 f{};

  field.kernel.evaluate(field.kernel.context.get(), {1, 0.5, r, v, f.data()});

  EXPECT_EQ(field.points, (std::vector<Index>{2, 0}));
  EXPECT_EQ(f, (Vector3{51, 0, 0}));
  EXPECT_TRUE(field.kernel.depends_on_velocity);
  EXPECT_FALSE(magnet.kernel.depends_on_velocity);
}

TEST(Forces, PairsHaveALawAndItsNumbers) {
  const auto wca = read_force<PairForces>(R"("kind": "pair", "law": "wca")");
  const auto lj = read_force<PairForces>(
      R"("kind": "pair", "name": "beads", "law": "lj", "points": [0, 2], "epsilon": 2, "sigma": 0.5, "cutoff": 1.5,
         "box": [3, 0, 4], "exclude": "rods")");
  const auto log = read_force<PairForces>(R"("kind": "pair", "law": "log", "strength": -2)");

  EXPECT_EQ(wca.law, PairLaw::Wca);
  EXPECT_TRUE(wca.points.empty()) << "all of them";
  EXPECT_EQ(wca.epsilon, 1.0);
  EXPECT_EQ(wca.sigma, 1.0);
  EXPECT_EQ(wca.box, Vector3{});
  EXPECT_FALSE(wca.cutoff || wca.exclude_rods);
  EXPECT_EQ(lj.law, PairLaw::Lj);
  EXPECT_EQ(lj.name, "beads");
  EXPECT_EQ(lj.points, (std::vector<Index>{0, 2}));
  EXPECT_EQ(lj.epsilon, 2.0);
  EXPECT_EQ(lj.sigma, 0.5);
  EXPECT_EQ(lj.cutoff, 1.5);
  EXPECT_EQ(lj.box, (Vector3{3, 0, 4}));
  EXPECT_TRUE(lj.exclude_rods);
  EXPECT_EQ(log.law, PairLaw::Log);
  EXPECT_EQ(log.strength, -2.0);
}

TEST(Forces, BoxOfPairsMayBeThatOfTheImportedFile) {
  const Scene scene = parse(R"({"tanor_scene": 1, "import": {"file": "polymer.data", "format": "lammps-data"},
    "forces": [{"kind": "pair", "law": "wca", "epsilon": 1, "sigma": 0.1, "box": "import", "exclude": "rods"}]})");

  EXPECT_EQ(std::get<PairForces>(scene.system.forces[0]).box, (Vector3{10, 10, 10}));
}

TEST(Forces, DragIsZeroByDefault) {
  const auto none = read_force<Drag>(R"("kind": "drag", "points": "all")");
  const auto drag = read_force<Drag>(R"("kind": "drag", "points": [1], "linear": 0.5, "quadratic": 0.25)");

  EXPECT_EQ(none.linear, 0.0);
  EXPECT_EQ(none.quadratic, 0.0);
  EXPECT_EQ(drag.points, std::vector<Index>{1});
  EXPECT_EQ(drag.linear, 0.5);
  EXPECT_EQ(drag.quadratic, 0.25);
}

}  // namespace
}  // namespace tanor::scene
