/// The tests read bonds, angles and dihedrals of LAMMPS data files as energies and compare them with the energies and
/// forces of LAMMPS itself, which tests/data/lammps/make_forces.py stores.

#include <algorithm>
#include <cmath>
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

/// A data file with some words replaced, and a scene that imports it.
class Replaced {
 public:
  Replaced(const std::string& file, const std::string& from, const std::string& to, const std::string& more) {
    std::stringstream text;
    text << std::ifstream(TANOR_TEST_DATA "/lammps/" + file + ".data").rdbuf();
    std::string data = text.str();
    if (!from.empty()) data.replace(data.find(from), from.size(), to);
    std::ofstream(folder_ / "a.data") << data;
    scene_ = import_of(file, more);
    const std::string path = "lammps/" + file + ".data";
    scene_.replace(scene_.find(path), path.size(), "a.data");
  }
  Scene read() const { return parse_scene(scene_, folder_ / "scene.json"); }
  std::string error() const { return error_of(scene_, folder_ / "scene.json"); }

 private:
  Folder folder_;
  std::string scene_;
};

std::string error_with(const std::string& file, const std::string& from, const std::string& to,
                       const std::string& more = "") {
  return Replaced(file, from, to, more).error();
}

/// Forces of a file that are not read are reported.
TEST(ImportEnergies, SectionsThatAreNotReadAreNamed) {
  EXPECT_TRUE(parse(import_of("harmonic_charmm")).left_out.empty());
  const Scene scene = Replaced("harmonic_charmm", "Atoms #",
                               "Pair Coeffs # lj/cut\n\n1 0.1 3.0\n\nImproper Coeffs\n\n1 2.0 0.0\n\nImpropers\n\n"
                               "1 1 1 2 3 4\n\nAtom Type Labels\n\n1 C\n\nAtoms #",
                               "")
                          .read();
  const std::vector<std::string> wanted{"import: the section Pair Coeffs of a.data is not read",
                                        "import: the section Improper Coeffs of a.data is not read",
                                        "import: the section Impropers of a.data is not read"};
  EXPECT_EQ(scene.left_out, wanted);
}

/// With kcal/mol, angstrom and g/mol the unit of time is sqrt(g/mol angstrom²/(kcal/mol)), which is no femtosecond.
/// The velocities are converted, and the scene says so.
TEST(ImportEnergies, UnitsWithAnotherTimeAreConverted) {
  const std::string velocities =
      "Velocities\n\n1 1 2 3\n2 0 0 0\n3 0 0 0\n4 0 0 0\n5 0 0 0\n6 0 0 0\n7 0 0 0\n\nAtoms #";
  const auto read = [&](const std::string& more) {
    return Replaced("fene_cosine_opls", "Atoms #", velocities, more).read();
  };
  const Scene plain = read(""), lj = read(R"(, "units": "lj")"), real = read(R"(, "units": "real")"),
              metal = read(R"(, "units": "metal")");
  EXPECT_EQ(plain.source, "import: a.data (lammps-data)");
  EXPECT_EQ(lj.source, plain.source);
  EXPECT_EQ(plain.system.units, units_from_name("lj")) << "the file names none";
  EXPECT_EQ(lj.system.velocities, plain.system.velocities);
  EXPECT_EQ(real.source, "import: a.data (lammps-data, units real: the unit of time is 48.88821291 fs)");
  EXPECT_EQ(metal.source, "import: a.data (lammps-data, units metal: the unit of time is 10.18050571 fs)");
  const double avogadro = 6.02214076e23, kilocalorie = 4184.0, electronvolt = 1.602176634e-19, gram = 1e-3;
  const double of_real = std::sqrt(gram * 1e-20 / kilocalorie),
               of_metal = std::sqrt(gram / avogadro * 1e-20 / electronvolt);
  EXPECT_NEAR(real.system.velocities[1], 2.0 * of_real / 1e-15, 1e-7);
  EXPECT_NEAR(metal.system.velocities[1], 2.0 * of_metal / 1e-12, 1e-10);

  // The titles are those of `write_data`.
  const std::string title = "LAMMPS data: fene_cosine_opls";
  const auto titled = [&](const std::string& words) { return Replaced("fene_cosine_opls", title, words, ""); };
  EXPECT_NE(titled("LAMMPS data file via write_data, timestep = 0, units = real").read().source.find("units real"),
            std::string::npos);
  EXPECT_EQ(titled("A melt in units of its beads").read().source, plain.source);
  const std::string wanted = "wanted one of lj, real, metal, si, cgs, micro, nano";
  EXPECT_EQ(titled("units electron").error(), "scene.json: /import/units: found the units \"electron\", " + wanted);
  EXPECT_EQ(error_with("fene_cosine_opls", "", "", R"(, "units": "imperial")"),
            "scene.json: /import/units: found the units \"imperial\", " + wanted);
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
