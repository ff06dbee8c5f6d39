/// Bonds, angles and dihedrals of LAMMPS data files as energies, against the energies and forces of LAMMPS itself,
/// which tests/data/lammps/make_forces.py stores.

#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>
#include <tanor/motion.hpp>

#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

using Json = nlohmann::json;

std::string import_of(const std::string& file, const std::string& more = "") {
  return R"({"tanor_scene": 1, "import": {"file": "lammps/)" + file + R"(.data", "bonds": "energies", )" +
         R"("angles": "energies", "dihedrals": "energies")" + more + "}}";
}

class LammpsStyles : public testing::TestWithParam<const char*> {};

TEST_P(LammpsStyles, HaveTheEnergyAndTheForcesThatLammpsComputes) {
  const std::string name = GetParam();
  const Json wanted = Json::parse(std::ifstream(TANOR_TEST_DATA "/lammps/" + name + ".json"));
  const Scene scene = parse(import_of(name));
  Simulation simulation(scene.system);
  const double energy = wanted.at("energies").at("bond").get<double>() +
                        wanted.at("energies").at("angle").get<double>() +
                        wanted.at("energies").at("dihedral").get<double>();
  double largest = 0.0;
  for (const Json& force : wanted.at("forces"))
    for (const Json& x : force) largest = std::max(largest, std::abs(x.get<double>()));

  EXPECT_NEAR(simulation.report().energy.potential, energy, 1e-13 * std::abs(energy));
  for (std::size_t i = 0; i < scene.system.num_points(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(scene.system.masses[i] * simulation.accelerations()[3 * i + axis],
                  wanted.at("forces").at(i).at(axis).get<double>(), 1e-12 * largest)
          << i << " " << axis;
  }
}

INSTANTIATE_TEST_SUITE_P(Files, LammpsStyles,
                         testing::Values("fene_cosine_opls", "harmonic_charmm", "morse_squared_multi",
                                         "dihedral_harmonic"),
                         [](const auto& instance) { return std::string(instance.param); });

TEST(ImportEnergies, MakesAGroupOfEachType) {
  const Scene scene = parse(import_of("harmonic_charmm"));

  ASSERT_EQ(scene.system.forces.size(), 6u);
  EXPECT_TRUE(scene.system.constraints.empty());
  const auto& bonds = std::get<Bonds>(scene.system.forces[1]);
  EXPECT_EQ(bonds.name, "bonds2");
  EXPECT_EQ(bonds.stiffness.constants, std::vector<double>{2 * 268.25});
  EXPECT_EQ(bonds.pairs, (std::vector<std::array<Index, 2>>{{1, 2}, {3, 4}}));
  EXPECT_TRUE(KindOf<Bendings>::is_straight(std::get<Bendings>(scene.system.forces[3])));
}

TEST(ImportEnergies, BondTypesMayStayRods) {
  const Scene scene = parse(import_of("harmonic_charmm", R"(, "types": [2])"));

  EXPECT_EQ(std::get<Rods>(scene.system.constraints.at(0)).pairs.size(), 2u);
  EXPECT_EQ(std::get<Bonds>(scene.system.forces.at(0)).pairs.size(), 4u);
  EXPECT_TRUE(std::holds_alternative<Bendings>(scene.system.forces.at(1)));
}

/// The text of a data file with some words replaced, as a scene of its own.
std::string error_with(const std::string& file, const std::string& from, const std::string& to,
                       const std::string& more = "") {
  const Folder folder;
  std::stringstream text;
  text << std::ifstream(TANOR_TEST_DATA "/lammps/" + file + ".data").rdbuf();
  std::string data = text.str();
  if (!from.empty()) data.replace(data.find(from), from.size(), to);
  std::ofstream(folder / "a.data") << data;
  std::string scene = import_of(file, more);
  const std::string path = "lammps/" + file + ".data";
  scene.replace(scene.find(path), path.size(), "a.data");
  return error_of(scene, folder / "scene.json");
}

TEST(ImportEnergies, ErrorsNameTheStyleAndTheType) {
  const std::string where = "scene.json: /import/";
  EXPECT_EQ(error_with("harmonic_charmm", " # charmm", ""),
            where +
                "dihedral_style: missing, and no comment behind \"Dihedral Coeffs\" names the style; wanted one of "
                "opls, multi/harmonic, charmm, harmonic");
  EXPECT_EQ(error_with("harmonic_charmm", "# charmm", "# helix"),
            where +
                "dihedral_style: found the dihedral style \"helix\", wanted one of opls, multi/harmonic, charmm, "
                "harmonic");
  EXPECT_EQ(error_with("harmonic_charmm", "2 1.2 2 -35 0.0\n", ""),
            where + "dihedral_style: the file has no coefficients of dihedral type 2, wanted K n d weight");
  EXPECT_EQ(error_with("harmonic_charmm", "1 310.5 1.53", "1 310.5"),
            where + "bond_style: the file has 1 coefficients of bond type 1, wanted those of style harmonic: K r0");
  EXPECT_EQ(error_with("harmonic_charmm", "60 0.0", "60 0.5"),
            where +
                "dihedral_style: dihedral type 1 of style charmm: weight 0.5 asks for pair forces of its own, "
                "wanted 0");
  EXPECT_EQ(error_with("fene_cosine_opls", "30 2.5 0 1", "30 2.5 1 0.9"),
            where +
                "bond_style: bond type 1 of style fene: epsilon 1 and sigma 0.9 are a repulsion along the bond, "
                "wanted a pair force that acts there too and \"fene_repulsion\": \"pair\", or epsilon 0");
  EXPECT_EQ(error_with("fene_cosine_opls", "30 2.5 0 1", "30 2.5 1 0.9", R"(, "fene_repulsion": "pair")"), "no error");
  EXPECT_EQ(error_with("dihedral_harmonic", "2.0 1 3", "2.0 2 3"),
            where + "dihedral_style: dihedral type 1 of style harmonic: d = 2, wanted 1 or -1");
  EXPECT_EQ(
      error_of(R"({"tanor_scene": 1, "import": {"file": "lammps/harmonic_charmm.data", "angle_style": "cosine"}})",
               TANOR_TEST_DATA "/scene.json"),
      where + "angle_style: found without \"angles\": \"energies\", which reads it");
}

}  // namespace
}  // namespace tanor::scene
