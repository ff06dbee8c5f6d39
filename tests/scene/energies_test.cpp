/// Energies of several points in scene files: what is read, and every rule with its place.

#include <ostream>

#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

using Triples = std::vector<std::array<Index, 3>>;
using Quadruples = std::vector<std::array<Index, 4>>;

/// Five points in a zigzag, rods "chain" along them, then `forces`; point 5 stands apart as a support.
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

TEST(Energies, SinglePointsAreAListToo) {
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

TEST(Energies, AlongRodsEveryTwoAndEveryThreeInSequence) {
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

TEST_P(EnergyRules, AreOneErrorWithItsPlace) {
  EXPECT_EQ(error_of(zigzag(GetParam().force, GetParam().more_rods)), "scene.json: " + GetParam().error);
}

// clang-format off
const Rule rules[] = {
    {"UnknownName", R"({"kind": "potential", "points": [[0,1]], "energy": "q*x1"})", ""},
    {"VelocityInAnEnergy", R"({"kind": "potential", "points": [[0]], "energy": "vx1^2"})", ""},
    {"TupleOfSupports", R"({"kind": "potential", "points": [[0,1],[5,6]], "energy": "(x1-x2)^2"})", ""},
    {"PointTwice", R"({"kind": "potential", "points": [[1,1]], "energy": "(x1-x2)^2"})", ""},
    {"TupleTooLong", R"({"kind": "potential", "points": [[0,1,2,3,4,5,6,0,1]], "energy": "x1"})", ""},
    {"TuplesOfTwoSizes", R"({"kind": "potential", "points": [[0,1],[0,1,2]], "energy": "x1"})", ""},
    {"EnergyIsNoNumber", R"json({"kind": "potential", "points": [[0,1],[1,3]], "energy": "1/(y1 - y2)"})json", ""},
    {"GradientIsNoNumber", R"json({"kind": "potential", "points": [[0,1]], "energy": "sqrt(x1)"})json", ""},
    {"ConstantsForOtherTuples", R"({"kind": "potential", "points": [[0,1]], "energy": "c*x1", "constants": {"c": [1, 2]}})", ""},
    {"FeneAtItsLimit", R"({"kind": "bond", "law": "fene", "pairs": [[0,2]], "stiffness": 1, "limit": 2})", ""},
    {"StiffnessNotPositive", R"({"kind": "bond", "law": "harmonic", "pairs": [[0,2]], "stiffness": 0})", ""},
    {"NumberOfAnotherLaw", R"({"kind": "bond", "law": "harmonic", "pairs": [[0,2]], "stiffness": 1, "depth": 2})", ""},
    {"NumberMissing", R"({"kind": "bond", "law": "morse", "pairs": [[0,2]], "depth": 1})", ""},
    {"UnknownLaw", R"({"kind": "bond", "law": "spring", "pairs": [[0,2]], "stiffness": 1})", ""},
    {"DegreesForRadians", R"({"kind": "bending", "law": "harmonic", "triples": [[0,1,2]], "stiffness": 1, "rest": 109.5})", ""},
    {"StraightAngle", R"({"kind": "bending", "law": "harmonic", "triples": [[0,2,4]], "stiffness": 1, "rest": 2})", ""},
    {"AngleOfZero", R"({"kind": "bending", "law": "harmonic", "triples": [[4,0,2]], "stiffness": 1, "rest": 3.141592653589793})", ""},
    {"TorsionInLine", R"({"kind": "torsion", "law": "opls", "quadruples": [[0,2,4,1]], "coefficients": [1,0,0,0]})", ""},
    {"ThreeCoefficients", R"({"kind": "torsion", "law": "opls", "quadruples": [[0,1,2,3]], "coefficients": [1,0,0]})", ""},
    {"NegativeMultiplicity", R"({"kind": "torsion", "law": "periodic", "quadruples": [[0,1,2,3]], "stiffness": 1, "phase": 0, "multiplicity": -1})", ""},
    {"AlongNothing", R"({"kind": "bending", "law": "cosine", "along": "rope", "stiffness": 1})", ""},
    {"AlongAndTriples", R"({"kind": "bending", "law": "cosine", "along": "chain", "triples": [[0,1,2]], "stiffness": 1})", ""},
    {"AlongABranch", R"({"kind": "bending", "law": "cosine", "along": "chain", "stiffness": 1})", "", ",[2,5]"},
    {"NeitherAlongNorTriples", R"({"kind": "bending", "law": "cosine", "stiffness": 1})", ""},
};
// clang-format on

INSTANTIATE_TEST_SUITE_P(Scene, EnergyRules, testing::ValuesIn(rules),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace tanor::scene
