/// The tests read energies of several points from scene files, and check every rule with its place.

#include <ostream>

#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

using Triples = std::vector<std::array<Index, 3>>;
using Quadruples = std::vector<std::array<Index, 4>>;

/// Returns a scene of five points in a zigzag with rods "chain" along them, then `forces`; point 5 is a separate
/// support.
std::string zigzag(const std::string& forces, const std::string& more_rods = "") {
  return R"({"tanor_scene": 1, "parameters": {"k": 2},
    "points": {"positions": [[0,0,0],[1,1,0],[2,0,0],[3,1,0.5],[4,0,0],[0,5,0],[1,5,0]], "masses": 1},
    "supports": [{"points": [5, 6]}],
    "constraints": [{"kind": "rod", "name": "chain", "pairs": [[0,1],[1,2],[2,3],[3,4])" +
         more_rods + R"(]}],
    "forces": [)" +
         forces + "]}";
}

template <class Group>
Group read_energy(const std::string& force) {
  return std::get<Group>(parse(zigzag(force)).system.forces.at(0));
}

TEST(Energies, TextsHaveParametersAndConstantsOfTheirOwn) {
  const auto potential = read_energy<Potential>(
      R"json({"kind": "potential", "points": [[0,1],[2,4]], "energy": "k*c*(x1 - x2)^2", "constants": {"c": [1, 3]}})json");

  ASSERT_EQ(potential.points, (std::vector<std::vector<Index>>{{0, 1}, {2, 4}}));
  ASSERT_EQ(potential.constants, (std::vector<std::vector<double>>{{1, 3}}));
  const std::vector<double> r{0, 0, 0, 1, 1, 0, 2, 0, 0, 4, 0, 0}, constants{1, 3};
  std::vector<double> energy(2), gradient(12);
  potential.kernel.evaluate(potential.kernel.context.get(),
                            {2, 0.0, r.data(), constants.data(), energy.data(), gradient.data()});
  EXPECT_EQ(energy, (std::vector<double>{2.0, 24.0}));
  EXPECT_EQ(gradient[0], -4.0);
  EXPECT_EQ(gradient[9], 24.0);
}

TEST(Energies, PotentialsTakeAListOfSinglePoints) {
  const auto potential =
      read_energy<Potential>(R"({"kind": "potential", "points": {"first": 0, "count": 3}, "energy": "z1"})");

  EXPECT_EQ(potential.points, (std::vector<std::vector<Index>>{{0}, {1}, {2}}));
}

TEST(Energies, LawsHaveTheirNumbers) {
  const auto bonds =
      read_energy<Bonds>(R"({"kind": "bond", "law": "harmonic", "pairs": [[0,2],[1,3]], "stiffness": [3, 4]})");
  const auto bendings =
      read_energy<Bendings>(R"({"kind": "bending", "law": "cosine", "triples": [[0,1,2]], "stiffness": 2})");
  const auto torsions = read_energy<Torsions>(
      R"({"kind": "torsion", "law": "periodic", "quadruples": [[0,1,2,3]], "stiffness": 2, "multiplicity": 3, "phase": 0.5})");

  EXPECT_TRUE(bonds.rest_length.is_initial());
  EXPECT_EQ(bonds.stiffness.constants, (std::vector<double>{3, 4}));
  EXPECT_EQ(bendings.law, BendingLaw::Cosine);
  EXPECT_EQ(torsions.multiplicity, 3);
  EXPECT_EQ(torsions.phase.constants, std::vector<double>{0.5});
}

TEST(Energies, ForcesOnTuplesHaveAComponentForEachPoint) {
  const auto force = read_energy<FormulaForce>(
      R"json({"kind": "formula", "tuples": [[0,1],[2,4]], "x1": "k*(x2 - x1)", "y2": "vx1 + t"})json");

  ASSERT_EQ(force.tuples, (std::vector<std::vector<Index>>{{0, 1}, {2, 4}}));
  EXPECT_TRUE(force.points.empty());
  const std::vector<double> r{0, 0, 0, 1, 1, 0, 2, 0, 0, 5, 0, 0}, v{3, 0, 0, 0, 0, 0, 4, 0, 0, 0, 0, 0};
  std::vector<double> f(12);
  force.kernel.evaluate(force.kernel.context.get(), {2, 0.5, r.data(), v.data(), f.data()});
  EXPECT_EQ(f, (std::vector<double>{2, 0, 0, 0, 3.5, 0, 6, 0, 0, 0, 4.5, 0}));
}

TEST(Energies, PairsHaveTheirLaws) {
  const auto coulomb = read_energy<PairForces>(
      R"({"kind": "pair", "law": "coulomb", "strength": 2, "points": [0, 2, 4], "charges": [1, -1, 2]})");
  const auto morse = read_energy<PairForces>(
      R"({"kind": "pair", "law": "morse", "depth": 2, "width": 3, "rest_length": 0.5, "cutoff": 4})");

  EXPECT_EQ(coulomb.charges, (std::vector<double>{1, -1, 2}));
  EXPECT_EQ(coulomb.strength, 2.0);
  EXPECT_EQ(morse.cutoff, 4.0);
  EXPECT_EQ(morse.rest_length, 0.5);
}

TEST(Energies, TuplesAlongRodsAreEveryTwoAndEveryThreeInSequence) {
  const auto bendings =
      read_energy<Bendings>(R"({"kind": "bending", "law": "cosine", "along": "chain", "stiffness": [1, 2, 3]})");
  const auto torsions =
      read_energy<Torsions>(R"({"kind": "torsion", "law": "opls", "along": "chain", "coefficients": [1, 0, 0, 0]})");

  EXPECT_EQ(bendings.triples, (Triples{{0, 1, 2}, {1, 2, 3}, {2, 3, 4}}));
  EXPECT_EQ(bendings.stiffness.constants, (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(torsions.quadruples, (Quadruples{{0, 1, 2, 3}, {1, 2, 3, 4}}));
}

struct Rule {
  const char* name;
  std::string force, error;
  std::string more_rods = "";

  friend std::ostream& operator<<(std::ostream& out, const Rule& rule) { return out << rule.force; }
};

class EnergyRules : public testing::TestWithParam<Rule> {};

TEST_P(EnergyRules, GiveOneErrorWithItsPlace) {
  EXPECT_EQ(error_of(zigzag(GetParam().force, GetParam().more_rods)), "scene.json: " + GetParam().error);
}

// clang-format off
const Rule rules[] = {
    {"UnknownName", R"({"kind": "potential", "points": [[0,1]], "energy": "q*x1"})",
     R"json(/forces/0/energy: formula "q*x1": column 1: 'q' is not known; known names: x1, y1, z1, x2, y2, z2, t, pi, k and the functions sqrt, exp, log, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, abs, min, max)json"},
    {"VelocityInAnEnergy", R"({"kind": "potential", "points": [[0]], "energy": "vx1^2"})",
     R"json(/forces/0/energy: 'vx1': a potential depends on positions and time; use kind formula)json"},
    {"TupleOfSupports", R"({"kind": "potential", "points": [[0,1],[5,6]], "energy": "(x1-x2)^2"})",
     R"json(/forces/0/points/1: [5, 6]: all of its points are supports: its energy moves nothing)json"},
    {"PointTwice", R"({"kind": "potential", "points": [[1,1]], "energy": "(x1-x2)^2"})",
     R"json(/forces/0/points/0: [1, 1] names point 1 twice; the points of a tuple differ)json"},
    {"TupleTooLong", R"({"kind": "potential", "points": [[0,1,2,3,4,5,6,0,1]], "energy": "x1"})",
     R"json(/forces/0/points/0: found a list of 9, wanted a list of 1 to 8 points)json"},
    {"TuplesOfTwoSizes", R"({"kind": "potential", "points": [[0,1],[0,1,2]], "energy": "x1"})",
     R"json(/forces/0/points/1: found a list of 3, wanted 2 points, as in the first tuple)json"},
    {"EnergyIsNoNumber", R"json({"kind": "potential", "points": [[0,1],[1,3]], "energy": "1/(y1 - y2)"})json",
     R"json(/forces/0: [1, 3]: the energy is inf at the start; finite, at most 1e100, is right)json"},
    {"GradientIsNoNumber", R"json({"kind": "potential", "points": [[0,1]], "energy": "sqrt(x1)"})json",
     R"json(/forces/0: [0, 1]: the gradient of the energy has the component inf at the start; finite, at most 1e100, is right)json"},
    {"ConstantsForOtherTuples", R"({"kind": "potential", "points": [[0,1]], "energy": "c*x1", "constants": {"c": [1, 2]}})",
     R"json(/forces/0/constants/c: found a list of 2, wanted one number, or a list of 1)json"},
    {"EnergyMissing", R"({"kind": "potential", "points": [[0,1]]})",
     R"json(/forces/0/energy: missing, wanted a string)json"},
    {"PointOutOfRange", R"({"kind": "potential", "points": [[0,1],[0,9]], "energy": "x1"})",
     R"json(/forces/0/points/1/1: found number 9, wanted a whole number from 0 to 6)json"},
    {"TupleOfNothing", R"({"kind": "potential", "points": [[]], "energy": "1"})",
     R"json(/forces/0/points/0: found a list of 0, wanted a list of 1 to 8 points)json"},
    {"SinglePointThatIsASupport", R"({"kind": "potential", "points": [[0],[5]], "energy": "x1"})",
     R"json(/forces/0/points/1: point 5: all of its points are supports: its energy moves nothing)json"},
    {"ConstantWithATakenName", R"({"kind": "potential", "points": [[0,1]], "energy": "x1", "constants": {"y2": 1}})",
     R"json(/forces/0/constants/y2: the constant 'y2' has a name that is taken or is none)json"},
    {"ConstantThatIsAParameter", R"({"kind": "potential", "points": [[0,1]], "energy": "k*x1", "constants": {"k": 1}})",
     R"json(/forces/0/constants/k: the constant 'k' has a name that is taken or is none)json"},
    {"ConstantThatIsNoNumber", R"({"kind": "potential", "points": [[0,1]], "energy": "c*x1", "constants": {"c": 1e999}})",
     R"json(/forces/0/constants/c: found 1e999, wanted a finite number)json"},
    {"UnknownKeyOfAPotential", R"({"kind": "potential", "points": [[0,1]], "energy": "x1", "law": "fene"})",
     R"json(/forces/0/law: found the unknown key "law", wanted one of kind, name, points, energy, constants)json"},
    {"DepthNotPositive", R"({"kind": "bond", "law": "morse", "pairs": [[0,2]], "depth": 0, "width": 1})",
     R"json(/forces/0/depth: depth 0 is not positive)json"},
    {"WidthNotPositive", R"({"kind": "bond", "law": "morse", "pairs": [[0,2]], "depth": 1, "width": 0})",
     R"json(/forces/0/width: width 0 is not positive)json"},
    {"LimitNotPositive", R"({"kind": "bond", "law": "fene", "pairs": [[0,2]], "stiffness": 1, "limit": -2})",
     R"json(/forces/0/limit: limit -2 is not positive)json"},
    {"RestLengthNegative", R"({"kind": "bond", "law": "harmonic", "pairs": [[0,2]], "stiffness": 1, "rest_length": -1})",
     R"json(/forces/0/rest_length: rest_length -1 is negative)json"},
    {"FeneBeyondItsLimit", R"({"kind": "bond", "law": "fene", "pairs": [[0,1],[0,4]], "stiffness": 1, "limit": [2, 3]})",
     R"json(/forces/0/pairs/1: [0, 4]: the distance 4 is not below the limit 3)json"},
    {"BendingStiffnessNegative", R"({"kind": "bending", "law": "cosine", "triples": [[0,1,2]], "stiffness": -1})",
     R"json(/forces/0/stiffness: stiffness -1 is negative)json"},
    {"RestAbovePi", R"({"kind": "bending", "law": "cosine_harmonic", "triples": [[0,1,2]], "stiffness": 1, "rest": 4})",
     R"json(/forces/0/rest: rest 4 is not between 0 and pi)json"},
    {"RestNegative", R"({"kind": "bending", "law": "harmonic", "triples": [[0,1,2]], "stiffness": 1, "rest": -0.1})",
     R"json(/forces/0/rest: rest -0.1 is not between 0 and pi)json"},
    {"StraightAngleOfOneThatDoesNotRestStraight", R"({"kind": "bending", "law": "harmonic", "triples": [[0,1,2],[0,2,4]], "stiffness": 1, "rest": [3.141592653589793, 2]})",
     R"json(/forces/0/triples/1: [0, 2, 4]: its angle is straight, where the force of law harmonic has no direction unless all rest at pi)json"},
    {"BendingThatNamesAPointTwice", R"({"kind": "bending", "law": "cosine", "triples": [[0,1,0]], "stiffness": 1})",
     R"json(/forces/0/triples/0: [0, 1, 0] names point 0 twice; a bending needs three different points)json"},
    {"NoCoefficients", R"({"kind": "torsion", "law": "multi", "quadruples": [[0,1,2,3]], "coefficients": []})",
     R"json(/forces/0/coefficients: there are none; law multi has at least c0)json"},
    {"BrokenMultiplicity", R"({"kind": "torsion", "law": "periodic", "quadruples": [[0,1,2,3]], "stiffness": 1, "phase": 0, "multiplicity": 1.5})",
     R"json(/forces/0/multiplicity: found number 1.5, wanted a whole number from 0 to 1000)json"},
    {"TorsionStiffnessNegative", R"({"kind": "torsion", "law": "harmonic", "quadruples": [[0,1,2,3]], "stiffness": -1, "rest": 0})",
     R"json(/forces/0/stiffness: stiffness -1 is negative)json"},
    {"TorsionThatNamesAPointTwice", R"({"kind": "torsion", "law": "opls", "quadruples": [[0,1,2,0]], "coefficients": [1,0,0,0]})",
     R"json(/forces/0/quadruples/0: [0, 1, 2, 0] names point 0 twice; a torsion needs four different points)json"},
    {"TorsionAlongABranch", R"({"kind": "torsion", "law": "opls", "along": "chain", "coefficients": [1,0,0,0]})",
     R"json(/forces/0/along: three or more of these rods meet at point 1: which of them are in sequence is not clear there)json", ",[1,5]"},
    {"YukawaWithoutALength", R"({"kind": "pair", "law": "yukawa", "strength": 1})",
     R"json(/forces/0/length: missing, wanted a number)json"},
    {"PairDepthNotPositive", R"({"kind": "pair", "law": "morse", "depth": 0, "width": 1, "rest_length": 1})",
     R"json(/forces/0/depth: found number 0, wanted a number > 0)json"},
    {"FeneAtItsLimit", R"({"kind": "bond", "law": "fene", "pairs": [[0,2]], "stiffness": 1, "limit": 2})",
     R"json(/forces/0/pairs/0: [0, 2]: the distance 2 is not below the limit 2)json"},
    {"StiffnessNotPositive", R"({"kind": "bond", "law": "harmonic", "pairs": [[0,2]], "stiffness": 0})",
     R"json(/forces/0/stiffness: stiffness 0 is not positive)json"},
    {"NumberOfAnotherLaw", R"({"kind": "bond", "law": "harmonic", "pairs": [[0,2]], "stiffness": 1, "depth": 2})",
     R"json(/forces/0/depth: found beside the law "harmonic", which does not read it)json"},
    {"NumberMissing", R"({"kind": "bond", "law": "morse", "pairs": [[0,2]], "depth": 1})",
     R"json(/forces/0/width: is missing, and the law reads it)json"},
    {"LimitMissing", R"({"kind": "bond", "law": "fene", "pairs": [[0,2]], "stiffness": 1})",
     R"json(/forces/0/limit: is missing, and the law reads it)json"},
    {"UnknownLaw", R"({"kind": "bond", "law": "spring", "pairs": [[0,2]], "stiffness": 1})",
     R"json(/forces/0/law: found string "spring", wanted one of harmonic, fene, morse)json"},
    {"DegreesForRadians", R"({"kind": "bending", "law": "harmonic", "triples": [[0,1,2]], "stiffness": 1, "rest": 109.5})",
     R"json(/forces/0/rest: rest 109.5 is not between 0 and pi: rad, not degrees?)json"},
    {"StraightAngle", R"({"kind": "bending", "law": "harmonic", "triples": [[0,2,4]], "stiffness": 1, "rest": 2})",
     R"json(/forces/0/triples/0: [0, 2, 4]: its angle is straight, where the force of law harmonic has no direction unless all rest at pi)json"},
    {"AngleOfZero", R"({"kind": "bending", "law": "harmonic", "triples": [[4,0,2]], "stiffness": 1, "rest": 3.141592653589793})",
     R"json(/forces/0/triples/0: [4, 0, 2]: its angle is 0, where the force of law harmonic has no direction)json"},
    {"TorsionInLine", R"({"kind": "torsion", "law": "opls", "quadruples": [[0,2,4,1]], "coefficients": [1,0,0,0]})",
     R"json(/forces/0/quadruples/0: [0, 2, 4, 1]: its first three points are on a straight line: there is no dihedral)json"},
    {"TorsionWhoseEndIsInLine", R"({"kind": "torsion", "law": "opls", "quadruples": [[1,0,2,4]], "coefficients": [1,0,0,0]})",
     R"json(/forces/0/quadruples/0: [1, 0, 2, 4]: its last three points are on a straight line: there is no dihedral)json"},
    {"RestThatIsInitial", R"({"kind": "bending", "law": "harmonic", "triples": [[0,1,2]], "stiffness": 1, "rest": "initial"})",
     R"json(/forces/0/rest: found string "initial", wanted a number or a list of numbers)json"},
    {"StiffnessThatIsAWord", R"({"kind": "bending", "law": "cosine", "triples": [[0,1,2]], "stiffness": "a"})",
     R"json(/forces/0/stiffness: found string "a", wanted a number or a list of numbers)json"},
    {"StiffnessesOfOtherMembers", R"({"kind": "bond", "law": "harmonic", "pairs": [[0,2]], "stiffness": [1, 2]})",
     R"json(/forces/0/stiffness: found a list of 2, wanted one number, or a list of 1)json"},
    {"RestLengthThatIsAWord", R"({"kind": "bond", "law": "harmonic", "pairs": [[0,2]], "stiffness": 1, "rest_length": "a"})",
     R"json(/forces/0/rest_length: found string "a", wanted "initial", a number or a list of numbers)json"},
    {"ChargesThatAreAWord", R"({"kind": "pair", "law": "coulomb", "strength": 1, "charges": "a"})",
     R"json(/forces/0/charges: found string "a", wanted a number or a list of numbers)json"},
    {"ConstantThatIsAWord", R"({"kind": "potential", "points": [[0]], "energy": "c*x1", "constants": {"c": "a"}})",
     R"json(/forces/0/constants/c: found string "a", wanted a number or a list of numbers)json"},
    {"NoTuple", R"({"kind": "potential", "points": [], "energy": "x1"})",
     R"json(/forces/0/points: found a list of 0, wanted one list of points or more)json"},
    {"NoPointOfARange", R"({"kind": "potential", "points": {"first": 0, "count": 0}, "energy": "x1"})",
     R"json(/forces/0/points: found no point, wanted one or more)json"},
    {"ForceOnNoTuple", R"({"kind": "formula", "tuples": [], "x1": "1"})",
     R"json(/forces/0/tuples: found a list of 0, wanted one list of points or more)json"},
    {"ForceWithoutAComponent", R"({"kind": "formula", "tuples": [[0,1]]})",
     R"json(/forces/0: found no component of the force, wanted one of x1 to z2 or more)json"},
    {"PhaseInDegrees", R"({"kind": "torsion", "law": "periodic", "quadruples": [[0,1,2,3]], "stiffness": 1, "phase": 180})",
     R"json(/forces/0/phase: phase 180 is more than a whole turn: rad, not degrees?)json"},
    {"TorsionAtRestInDegrees", R"({"kind": "torsion", "law": "harmonic", "quadruples": [[0,1,2,3]], "stiffness": 1, "rest": -60})",
     R"json(/forces/0/rest: rest -60 is more than a whole turn: rad, not degrees?)json"},
    {"CoefficientsOfAnotherLaw", R"({"kind": "torsion", "law": "periodic", "quadruples": [[0,1,2,3]], "stiffness": 1, "phase": 0, "coefficients": [9, 9]})",
     R"json(/forces/0/coefficients: found beside the law "periodic", which does not read it)json"},
    {"CoefficientsBesideHarmonic", R"({"kind": "torsion", "law": "harmonic", "quadruples": [[0,1,2,3]], "stiffness": 1, "rest": 0, "coefficients": []})",
     R"json(/forces/0/coefficients: found beside the law "harmonic", which does not read it)json"},
    {"MultiplicityOfAnotherLaw", R"({"kind": "torsion", "law": "opls", "quadruples": [[0,1,2,3]], "coefficients": [1,0,0,0], "multiplicity": 2})",
     R"json(/forces/0/multiplicity: found beside the law "opls", which does not read it)json"},
    {"MultiplicityBesideHarmonic", R"({"kind": "torsion", "law": "harmonic", "quadruples": [[0,1,2,3]], "stiffness": 1, "rest": 0, "multiplicity": 2})",
     R"json(/forces/0/multiplicity: found beside the law "harmonic", which does not read it)json"},
    {"ThreeCoefficients", R"({"kind": "torsion", "law": "opls", "quadruples": [[0,1,2,3]], "coefficients": [1,0,0]})",
     R"json(/forces/0/coefficients: 3 coefficients; law opls has four)json"},
    {"NegativeMultiplicity", R"({"kind": "torsion", "law": "periodic", "quadruples": [[0,1,2,3]], "stiffness": 1, "phase": 0, "multiplicity": -1})",
     R"json(/forces/0/multiplicity: found number -1, wanted a whole number from 0 to 1000)json"},
    {"AlongNothing", R"({"kind": "bending", "law": "cosine", "along": "rope", "stiffness": 1})",
     R"json(/forces/0/along: found string "rope", wanted the name of rods: "chain")json"},
    {"AlongAndTriples", R"({"kind": "bending", "law": "cosine", "along": "chain", "triples": [[0,1,2]], "stiffness": 1})",
     R"json(/forces/0/along: found beside "triples"; one of both is right)json"},
    {"AlongABranch", R"({"kind": "bending", "law": "cosine", "along": "chain", "stiffness": 1})",
     R"json(/forces/0/along: three or more of these rods meet at point 2: which of them are in sequence is not clear there)json", ",[2,5]"},
    {"CoulombInABox", R"({"kind": "pair", "law": "coulomb", "strength": 1, "charges": 1, "box": [9, 9, 9]})",
     R"json(/forces/0/box: found beside the law "coulomb", wanted without a box: there is no periodic sum)json"},
    {"CoulombWithoutCharges", R"({"kind": "pair", "law": "coulomb", "strength": 1})",
     R"json(/forces/0/charges: missing, wanted a number, or one a point)json"},
    {"ChargesOfOtherPoints", R"({"kind": "pair", "law": "coulomb", "strength": 1, "points": [0, 1], "charges": [1, 2, 3]})",
     R"json(/forces/0/charges: found a list of 3, wanted one number, or a list of 2)json"},
    {"YukawaInABoxWithoutACutoff", R"({"kind": "pair", "law": "yukawa", "strength": 1, "length": 1, "box": [9, 9, 9]})",
     R"json(/forces/0/box: box [9, 9, 9] is given to a law without a cutoff; give one, or leave the box out)json"},
    {"PairNumberOfAnotherLaw", R"({"kind": "pair", "law": "yukawa", "strength": 1, "length": 1, "depth": 2})",
     R"json(/forces/0/depth: found beside the law "yukawa", wanted with morse only)json"},
    {"ComponentOfNoPoint", R"({"kind": "formula", "tuples": [[0,1]], "x3": "1"})",
     R"json(/forces/0/x3: found in a force on tuples of 2 points, wanted x1 to z2)json"},
    {"ComponentOfTuples", R"({"kind": "formula", "points": [0], "x1": "1"})",
     R"json(/forces/0/x1: found beside "points", wanted x, y or z; with "tuples" x1, y1, …)json"},
    {"PointsAndTuples", R"({"kind": "formula", "points": [0], "tuples": [[0,1]], "x1": "1"})",
     R"json(/forces/0/points: found beside "tuples"; one of both is right)json"},
    {"TupleNamesAPointTwice", R"({"kind": "formula", "tuples": [[1,1]], "x1": "1"})",
     R"json(/forces/0/tuples/0: [1, 1]: names point 1 twice; the points of a tuple differ)json"},
    {"ForceIsNoNumber", R"json({"kind": "formula", "tuples": [[0,1]], "x2": "1/x1"})json",
     R"json(/forces/0/tuples/0: [0, 1]: the force is [0, 0, 0, inf, 0, 0] at the start)json"},
    {"UnknownNameInAComponent", R"({"kind": "formula", "tuples": [[0,1]], "z2": "x3"})",
     R"json(/forces/0/z2: formula "x3": column 1: 'x3' is not known (did you mean x1?); known names: x1, y1, z1, x2, y2, z2, vx1, vy1, vz1, vx2, vy2, vz2, t, pi, k and the functions sqrt, exp, log, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, abs, min, max)json"},
    {"NeitherAlongNorTriples", R"({"kind": "bending", "law": "cosine", "stiffness": 1})",
     R"json(/forces/0/triples: missing, wanted a list of triples of points)json"},
};
// clang-format on

/// However many digits of pi a file has, angles that rest there are smooth through the straight line.
TEST(Energies, AnAngleOfRoundedPiRestsStraight) {
  for (const char* pi : {"3.14159265", "3.14159265359", "3.1415926535897936", "3.141592654"}) {
    const auto bendings = read_energy<Bendings>(
        std::string(R"({"kind": "bending", "law": "harmonic", "triples": [[0,2,4]], "stiffness": 1, "rest": )") + pi +
        "}");
    EXPECT_TRUE(KindOf<Bendings>::is_straight(bendings)) << pi;
  }
  EXPECT_FALSE(KindOf<Bendings>::is_straight({.law = BendingLaw::Harmonic, .rest = 3.1415926}));
}

/// The message names both points that coincide, whatever joins them.
TEST(EnergyRulesAtOnePlace, CoincidentPointsAreNamed) {
  const std::string points = R"({"positions": [[0,0,0],[0,0,0],[1,0,0],[2,1,0]]})";
  const auto told = [&](const std::string& force) {
    return error_of(R"({"tanor_scene": 1, "points": )" + points + R"(, "forces": [)" + force + "]}");
  };
  const std::string pair = "scene.json: /forces/0: points 0 and 1 are at the same place; their force has no direction";
  EXPECT_EQ(told(R"({"kind": "pair", "law": "coulomb", "strength": 1, "charges": 1})"), pair);
  EXPECT_EQ(told(R"({"kind": "pair", "law": "yukawa", "strength": 1, "length": 1})"), pair);
  EXPECT_EQ(told(R"({"kind": "pair", "law": "morse", "depth": 1, "width": 1, "rest_length": 1})"), pair);
  const std::string bond =
      "scene.json: /forces/0/pairs/1: [0, 1]: its points are at one place, where the force has no direction";
  for (const char* law :
       {R"("harmonic", "stiffness": 1, "rest_length": 1)", R"("morse", "depth": 1, "width": 1, "rest_length": 1)",
        R"("fene", "stiffness": 1, "limit": 2)"})
    EXPECT_EQ(told(std::string(R"({"kind": "bond", "pairs": [[0,2],[0,1]], "law": )") + law + "}"), bond);
  EXPECT_EQ(told(R"({"kind": "bending", "law": "cosine", "triples": [[0,1,2]], "stiffness": 1})"),
            "scene.json: /forces/0/triples/0: [0, 1, 2]: two of its points are at one place: there is no angle");
  EXPECT_EQ(told(R"({"kind": "torsion", "law": "opls", "quadruples": [[0,1,2,3]], "coefficients": [1,0,0,0]})"),
            "scene.json: /forces/0/quadruples/0: [0, 1, 2, 3]: its first three points are on a straight line: there is "
            "no dihedral");
}

/// Three rods in sequence come back to where they began.
TEST(Energies, ATorsionAlongATriangleNamesIt) {
  EXPECT_EQ(error_of(three_points(
                R"("constraints": [{"kind": "rod", "name": "ring", "pairs": [[0,1],[1,2],[2,0]]}],
                   "forces": [{"kind": "torsion", "law": "opls", "along": "ring", "coefficients": [1,0,0,0]}])")),
            "scene.json: /forces/0/along: three of these rods close a triangle of points 2, 0 and 1, where there is no "
            "dihedral");
}

INSTANTIATE_TEST_SUITE_P(Scene, EnergyRules, testing::ValuesIn(rules),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace tanor::scene
