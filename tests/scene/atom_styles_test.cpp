/// The columns of a LAMMPS file's atoms are told by the style's name, or by what all lines allow, or refused.

#include "scene/atom_styles.hpp"
#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

using Names = std::vector<std::string>;

/// Returns a file of two atom types in a box of edge 10 with these lines of atoms, and masses unless they are unknown.
std::string file_with(const std::string& title, const std::vector<std::string>& atoms, bool has_masses = true,
                      int num_bonds = 0) {
  std::string text = "a file\n\n" + std::to_string(atoms.size()) + " atoms\n" + std::to_string(num_bonds) +
                     " bonds\n2 atom types\n1 bond types\n0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n\n";
  if (has_masses) text += "Masses\n\n1 12\n2 16\n\n";
  text += "Atoms" + title + "\n\n";
  for (const std::string& atom : atoms) text += atom + "\n";
  if (num_bonds > 0) text += "\nBonds\n\n";
  for (int k = 1; k <= num_bonds; ++k)
    text += std::to_string(k) + " 1 " + std::to_string(k) + " " + std::to_string(k + 1) + "\n";
  return text;
}

Scene read_atoms(const std::string& text, const std::string& style = "") {
  return import_text("a.data", text, style.empty() ? "" : R"(, "atom_style": ")" + style + "\"");
}
std::string atoms_error(const std::string& text, const std::string& style = "") {
  return import_error("a.data", text, style.empty() ? "" : R"(, "atom_style": ")" + style + "\"");
}

void expect_two(const Scene& scene, const std::vector<double>& last, double last_mass, const std::string& what) {
  ASSERT_EQ(scene.system.num_points(), 2u) << what;
  EXPECT_EQ(std::vector<double>(scene.system.positions.begin() + 3, scene.system.positions.end()), last) << what;
  EXPECT_EQ(scene.system.masses, (std::vector<double>{12, last_mass})) << what;
}

TEST(AtomStyles, ChargesAreNotTakenForTypes) {
  const std::string place = "a.json: /import/file: charge_no_comment_int.data, line 17: ";
  EXPECT_EQ(error_of(R"({"tanor_scene": 1, "import": {"file": "import/charge_no_comment_int.data"}})",
                     TANOR_TEST_DATA "/a.json"),
            place +
                "the columns of Atoms are those of several styles (\"molecular\", \"charge\", \"bond\", \"angle\", "
                "\"dpd\", \"mdpd\", \"hybrid molecular\"), wanted a comment behind Atoms or /import/atom_style, which "
                "names the style");
  const std::vector<double> wanted{12, 16, 12, 16};
  for (const std::string keys : {R"("file": "import/charge_no_comment_int.data", "atom_style": "charge")",
                                 R"("file": "import/charge_no_comment_zero.data")",
                                 R"("file": "import/charge_no_comment_zero.data", "atom_style": "charge")"}) {
    const Scene scene = import(keys);
    EXPECT_EQ(scene.system.masses, wanted) << keys;
    EXPECT_EQ(scene.system.positions, (std::vector<double>{1, 1, 1, 2, 1, 1, 3, 1, 1, 4, 1, 1})) << keys;
    EXPECT_EQ(rods_of(scene).pairs.size(), 3u) << keys;
  }
  EXPECT_EQ(import(R"("file": "import/charge_no_comment_int.data", "atom_style": "molecular")").system.masses,
            std::vector<double>(4, 12.0));
}

// Every style of the manual, with image flags and without, named by the comment or by the scene.
TEST(AtomStyles, EveryStyleHasItsColumns) {
  struct Row {
    std::string style, before, type, between, behind;
  };
  const std::vector<Row> rows{{"atomic", "", "2", "", ""},
                              {"molecular", "5", "2", "", ""},
                              {"bond", "5", "2", "", ""},
                              {"angle", "5", "2", "", ""},
                              {"full", "5", "2", "-0.5", ""},
                              {"amoeba", "5", "2", "-0.5", ""},
                              {"charge", "", "2", "-0.5", ""},
                              {"body", "", "2", "1 3.5", ""},
                              {"bpm/sphere", "5", "2", "1.5 2", ""},
                              {"dielectric", "", "2", "0.5", "0 0 1 0.9 8 6 6 0.5"},
                              {"dielectric", "5", "2", "0.5", "0 0 1 0.9 8 6 6 0.5"},
                              {"dipole", "", "2", "0.5", "0 0 1.5"},
                              {"dpd", "", "2", "1.5", ""},
                              {"edpd", "", "2", "1.5 2.5", ""},
                              {"electron", "", "2", "0.5 -1 0.25", ""},
                              {"ellipsoid", "", "2", "1 2.5", ""},
                              {"line", "5", "2", "1 2.5", ""},
                              {"mdpd", "", "2", "2.5", ""},
                              {"mesont", "5", "2", "1 -1 2.5 3.5 4.5 0", ""},
                              {"oxdna", "", "2", "", ""},
                              {"peri", "", "2", "2.5 3.5", ""},
                              {"rheo", "", "2", "0 3.5", ""},
                              {"rheo/thermal", "", "2", "0 3.5 1.5", ""},
                              {"smd", "", "2", "7 1 2 3 4 0.5 0.5 0.5", ""},
                              {"sph", "", "2", "1.5 2.5 3.5", ""},
                              {"sphere", "", "2", "1 2", ""},
                              {"spin", "", "2", "", "0 0 1 1.5"},
                              {"tdpd 2", "", "2", "", "0.5 0.5"},
                              {"template", "5 1 1", "2", "", ""},
                              {"template twomols", "", "2", "5 7 9", ""},
                              {"tri", "5", "2", "1 2.5", ""},
                              {"wavepacket", "", "2", "0.5 1 0.25 3 1 0", ""},
                              {"hybrid full sphere", "", "2", "", "5 -0.5 1 2"},
                              {"hybrid bond ellipsoid oxdna", "", "2", "", "5 1 2.5"},
                              {"hybrid template twomols charge", "", "2", "", "1 1 1 -0.5"}};
  for (const Row& row : rows) {
    const auto line = [&](const std::string& id, const std::string& type, const std::string& place,
                          const std::string& images) {
      return id + " " + row.before + " " + type + " " + row.between + " " + place + " " + row.behind + " " + images;
    };
    const std::vector<std::string> plain{line("1", "1", "0.5 0.5 0.5", ""), line("2", "2", "1.5 2.5 3.5", "")},
        flagged{line("1", "1", "0.5 0.5 0.5", "0 0 0"), line("2", "2", "1.5 2.5 3.5", "1 0 -1")};
    const std::vector<double> place{1.5, 2.5, 3.5}, shifted{11.5, 2.5, -6.5};
    expect_two(read_atoms(file_with("", plain), row.style), place, 16, row.style);
    expect_two(read_atoms(file_with("", flagged), row.style), shifted, 16, row.style);
    expect_two(read_atoms(file_with(" # " + row.style, plain)), place, 16, row.style);
    expect_two(read_atoms(file_with(" # " + row.style, flagged)), shifted, 16, row.style);
    // The scene knows better than the file.
    expect_two(read_atoms(file_with(" # atomic", flagged), row.style), shifted, 16, row.style);
  }
}

TEST(AtomStyles, AreToldByTheirColumnsWhereTheseLeaveOneChoice) {
  struct Row {
    std::string what, first, second;
    std::vector<double> last;
    double mass;
  };
  for (const Row& row : std::vector<Row>{
           {"atomic", "1 1 0 0 0", "2 2 1 2 3", {1, 2, 3}, 16},
           {"atomic with flags", "1 1 0.5 0.5 0.5 0 0 0", "2 2 1.5 2.5 3.5 1 0 -1", {11.5, 2.5, -6.5}, 16},
           {"molecular: the molecule is no type", "1 3 1 0 0 0", "2 3 2 1 2 3", {1, 2, 3}, 16},
           {"molecular with flags", "1 7 1 0 0 0 0 0 0", "2 7 2 1 2 3 1 0 -1", {11, 2, -7}, 16},
           {"charge: 0.0 is no type", "1 1 0.0 0 0 0", "2 2 0.0 1 2 3", {1, 2, 3}, 16},
           {"charge: 0 is no type", "1 1 0 0.5 0.5 0.5", "2 2 1 1 2 3", {1, 2, 3}, 16},
           {"charge: -1 is no type", "1 1 -1 0 0 0", "2 2 1 1 2 3", {1, 2, 3}, 16},
           {"charge with flags", "1 1 -0.5 0.5 0.5 0.5 0 0 0", "2 1 0.5 1.5 2.5 3.5 1 0 -1", {11.5, 2.5, -6.5}, 12},
           {"charge with flags 0, or dipole", "1 1 -0.5 0.5 0.5 0.5 0 0 0", "2 2 0.5 1 2 3 0 0 0", {1, 2, 3}, 16},
           {"atomic in a plane", "1 1 0.5 0.5 0 0 0 0", "2 2 1.5 2.5 0 1 0 0", {11.5, 2.5, 0}, 16},
           {"dipole", "1 1 0.5 1.25 5.5 6.125 0 0.6 0.8", "2 2 0.5 2.25 5.5 6.125 0 0 1", {2.25, 5.5, 6.125}, 16},
           {"dipoles of any length", "1 1 0 5 5 6 0 0.5 0", "2 1 0 2 5 6.5 0 0 2", {2, 5, 6.5}, 12},
           {"spin", "1 1 1.25 5.5 6.125 1 0 0 2", "2 2 2.25 5.5 6.125 0 1 0 2", {2.25, 5.5, 6.125}, 16},
           {"spin that turns", "1 1 1.5 5.5 6.5 0.6 0.8 0 2", "2 1 2.5 5 6 0 1 0 2", {2.5, 5, 6}, 12},
           {"dielectric", "1 1 0.5 1 5 6 0 0 1 1 1 1 1 1", "2 2 0.5 2 5 6 0 0 1 1 1 1 1 1", {2, 5, 6}, 16},
           {"full", "1 7 1 0.5 0 0 0", "2 7 2 0.5 1 2 3", {1, 2, 3}, 16},
           {"full, as few molecules as types", "1 1 1 0.5 0 0 0", "2 1 2 0.5 1 2 3", {1, 2, 3}, 16},
           {"full with flags", "1 1 1 0.5 0 0 0 0 0 0", "2 1 2 -0.5 1 2 3 1 0 -1", {11, 2, -7}, 16},
           {"full, charges that nobody reads", "1 7 1 nan 0 0 0", "2 7 2 -inf 1 2 3", {1, 2, 3}, 16},
           {"electron", "1 1 6.0 0 0.0 0.0 0.0 0.0", "2 2 0.0 1 0.5 1 2 3", {1, 2, 3}, 16}})
    expect_two(read_atoms(file_with("", {row.first, row.second})), row.last, row.mass, row.what);
  // A charged sample in a plane has no molecules, although z is a whole number.
  const Scene plane = read_atoms(file_with("", {"1 1 0.5 1.5 2.5 0", "2 2 -0.5 3.5 4.5 0"}));
  expect_two(plane, {3.5, 4.5, 0}, 16, "plane");
  // Points of one molecule that are bonded, with the molecule behind them.
  const std::vector<std::string> behind{"1 1 1.5 2.5 3.5 1", "2 2 2.5 2.5 3.5 1"};
  expect_two(read_atoms(file_with("", behind, true, 1)), {2.5, 2.5, 3.5}, 16, "hybrid molecular");
}

// Bonded atoms share their molecule, unless the types of the header then do not occur.
TEST(AtomStyles, MoleculesAreWhatBondsShare) {
  const std::string refused = "the columns of Atoms are those of several styles";
  const std::vector<std::string> ones{"1 1 1 0.5 0.5 0.5", "2 1 2 1.5 2.5 3.5"},
      twos{"1 2 1 0.5 0.5 0.5", "2 2 2 1.5 2.5 3.5"}, mixed{"1 1 1 0.5 0.5 0.5", "2 2 2 1.5 2.5 3.5"},
      alike{"1 2 1 0.5 0.5 0.5", "2 2 1 1.5 2.5 3.5"};
  expect_two(read_atoms(file_with("", ones, true, 1)), {1.5, 2.5, 3.5}, 16, "one molecule");
  expect_two(read_atoms(file_with("", twos, true, 1)), {1.5, 2.5, 3.5}, 16, "one molecule");
  EXPECT_NE(atoms_error(file_with("", ones)).find(refused), std::string::npos) << "no bonds";
  EXPECT_NE(atoms_error(file_with("", mixed, true, 1)).find(refused), std::string::npos) << "two molecules";
  EXPECT_NE(atoms_error(file_with("", alike, true, 1)).find(refused), std::string::npos) << "one type of two";
}

TEST(AtomStyles, ThatCannotBeToldApartAreRefusedWithTheKey) {
  const std::string wanted = "wanted a comment behind Atoms or /import/atom_style, which names the style";
  for (const auto& [first, second] :
       std::vector<std::pair<std::string, std::string>>{{"1 1 1 0.5 0.5 0.5", "2 2 1 1.5 2.5 3.5"},
                                                        {"1 1 1 0 0 0", "2 2 2 1 2 3"},
                                                        {"1 1 2 0 0 0 0 0 0", "2 2 1 1 2 3 0 0 0"}}) {
    const std::string text = file_with("", {first, second});
    EXPECT_NE(atoms_error(text).find("a.data, line 16: the columns of Atoms are those of several styles"),
              std::string::npos)
        << first;
    EXPECT_NE(atoms_error(text).find(wanted), std::string::npos) << first;
    EXPECT_EQ(atoms_error(text, "charge"), "no error");
    EXPECT_EQ(atoms_error(text, "bond"), "no error");
  }
  // Flags, or dipoles; flags, or columns of styles whose coordinates are whole numbers, too.
  for (const auto& [first, second, style] : std::vector<std::array<std::string, 3>>{
           {"1 1 0.5 1.25 5.5 6.125 1 0 0", "2 1 0.5 2.25 5.5 6.125 0 1 0", "dipole"},
           {"1 1 0.5 1.25 5.5 6.125 1 0 0", "2 2 0.5 2.25 5.5 6.125 0 -2 0", "charge"},
           {"1 1 1 5 5 1 0 0 1", "2 1 2 6 5 1 0 0 1", "spin"},
           {"1 1 1.5 2.5 3.5 5 8 8", "2 2 2.5 2.5 3.5 6 8 8", "sph"},
           {"1 1 1 1 1 1 5 6", "2 2 1 2 1 2 5 6", "template"}}) {
    const std::string text = file_with("", {first, second});
    EXPECT_NE(atoms_error(text).find(wanted), std::string::npos) << first;
    EXPECT_EQ(atoms_error(text, style), "no error") << first;
  }
  // Coordinates of a hybrid style below 0 are no densities of sph, whose atoms would all be at (1, 1, 3.5).
  const std::string unnamed = file_with("", {"1 1 -0.5 0.5 0.5 1 1 3.5", "2 2 1.5 2.5 3.5 1 1 3.5"});
  EXPECT_NE(atoms_error(unnamed).find("wanted an image flag (style atomic, guessed)"), std::string::npos);
  // Flags of a hybrid style, or columns of its sub-styles.
  const std::string hybrid = file_with(" # hybrid", {"1 1 0.5 0.5 0.5 1 1 1", "2 2 1.5 2.5 3.5 1 1 1"});
  EXPECT_NE(atoms_error(hybrid).find(wanted), std::string::npos);
  expect_two(read_atoms(hybrid, "hybrid bond ellipsoid"), {1.5, 2.5, 3.5}, 16, "no flags");
  expect_two(read_atoms(hybrid, "hybrid atomic"), {11.5, 12.5, 13.5}, 16, "flags");
  const std::string shifted = file_with(" # hybrid", {"1 1 0.5 0.5 0.5 1 0 0", "2 2 1.5 2.5 3.5 1 0 -1"});
  expect_two(read_atoms(shifted), {11.5, 2.5, -6.5}, 16, "one below 0 is no column of its own");
}

TEST(AtomStyles, MayBeUnknownWhereAllOfThemAgree) {
  // The types decide on nothing where the file has no masses.
  const Scene scene = read_atoms(file_with("", {"1 1 1 0.5 0.5 0.5", "2 2 1 1.5 2.5 3.5"}, false));
  EXPECT_EQ(scene.system.positions, (std::vector<double>{0.5, 0.5, 0.5, 1.5, 2.5, 3.5}));
  EXPECT_EQ(read_atoms(file_with("", {"1 1 1 1 0.5 0.5 0", "2 2 1 1 1.5 2.5 0"}, false)).system.positions,
            (std::vector<double>{0.5, 0.5, 0, 1.5, 2.5, 0}));
}

TEST(AtomStyles, ColumnsThatAreNotReadAreNamed) {
  const auto left_out = [](const std::string& first, const std::string& second, const std::string& style) {
    return read_atoms(file_with("", {first, second}), style).left_out;
  };
  EXPECT_EQ(left_out("1 7 1 0.5 0 0 0", "2 7 2 0 1 2 3", "full"),
            (Names{R"(import: what stands in columns "q" of Atoms of a.data is not read)"}));
  EXPECT_EQ(left_out("1 7 1 0 0 0 0", "2 7 2 0.0 1 2 3", "full"), Names{}) << "no charges";
  EXPECT_EQ(left_out("1 1 1 2.5 0 0 0", "2 2 1 2 1 2 3", "sphere"),
            (Names{R"(import: what stands in columns "diameter", "density" of Atoms of a.data is not read)"}));
  const std::string text =
      file_with(" # sphere", {"1 1 1 1 0 0 0", "2 2 1 1 1 2 3"}) + "\nVelocities\n\n1 1 2 3 0 0 0.5\n2 0 0 0 0 0 0\n";
  const Scene scene =
      read_atoms("LAMMPS\n\n3 impropers\n1 extra bond per atom\n0 10 xlo xhii\n" + text.substr(text.find("2 atoms")));
  EXPECT_EQ(scene.left_out,
            (Names{R"(import: what stands in columns "diameter", "density" of Atoms of a.data is not read)",
                   R"(import: what stands in header lines "0 10 xlo xhii" of a.data is not read)",
                   "import: what stands behind vx, vy and vz of Velocities of a.data is not read"}));
  EXPECT_EQ(scene.system.velocities[2], 3.0);
}

TEST(AtomStyles, ThatAreUnknownAreRefused) {
  EXPECT_NE(atoms_error(file_with("", {"1 1 0 0 0", "2 2 1 2 3"}), "molecullar")
                .find("/import/atom_style: found the atom style \"molecullar\" (did you mean molecular?), wanted one "
                      "of atomic"),
            std::string::npos);
  EXPECT_NE(atoms_error(file_with(" # banana", {"1 1 0 0 0", "2 2 1 2 3"}))
                .find("line 16: found \"banana\", wanted one of atomic"),
            std::string::npos);
  expect_two(read_atoms(file_with(" # banana", {"1 1 0 0 0", "2 2 1 2 3"}), "atomic"), {1, 2, 3}, 16, "named");
  EXPECT_EQ(error_of(R"({"tanor_scene": 1, "import": {"file": "cube.ply", "atom_style": "full"}})",
                     TANOR_TEST_DATA "/a.json"),
            "a.json: /import/atom_style: found without lammps-data, which reads it");
}

TEST(AtomStyles, TypesMayHaveLabels) {
  const std::string text =
      "a file\n\n3 atoms\n2 bonds\n2 atom types\n2 bond types\n1 angles\n1 angle types\n0 10 xlo xhi\n0 10 ylo yhi\n0 "
      "10 zlo zhi\n\n"
      "Atom Type Labels\n\n1 C\n2 O[h]\n\nBond Type Labels\n\n1 C-C\n2 C-O\n\nAngle Type Labels\n\n1 C-C-O\n\n"
      "Masses\n\nC 12\nO[h] 16\n\nPair Coeffs\n\nC 1 2\n\nBond Coeffs # harmonic\n\nC-C 100 1.5\nC-O 200 1.25\n\n"
      "Atoms # full\n\n1 1 C 0 0 0 0\n2 1 C 0 1 0 0\n3 1 O[h] 0 2 1 0\n\nBonds\n\n1 C-C 1 2\n2 C-O 2 3\n\nAngles\n\n1 "
      "C-C-O 1 2 3\n";
  const Scene scene = read_atoms(text);
  EXPECT_EQ(scene.system.masses, (std::vector<double>{12, 12, 16}));
  EXPECT_EQ(rods_of(scene).pairs.size(), 2u);
  EXPECT_EQ(scene.left_out, (Names{"import: the section Pair Coeffs of a.data is not read",
                                   "import: the section Bond Coeffs of a.data is not read",
                                   "import: the section Angles of a.data is not read"}));
  const Folder folder;
  folder.add("a.data", text);
  const Scene energies =
      parse_scene(R"({"tanor_scene": 1, "import": {"file": "a.data", "bonds": "energies"}})", folder / "s.json");
  EXPECT_EQ(std::get<Bonds>(energies.system.forces.at(1)).stiffness.constants, (std::vector<double>{400.0}));
  std::string unknown = text;
  unknown.replace(unknown.find("1 C-C 1 2"), 9, "1 N-N 1 2");
  EXPECT_NE(atoms_error(unknown).find("found \"N-N\", wanted a bond type from 1 to 2"), std::string::npos);
}

TEST(AtomStyles, LabelsMayStandBehindTheLinesThatUseThem) {
  const std::string head = "a file\n\n2 atoms\n2 atom types\n0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n\n",
                    masses = "Masses\n\nC 12.0\nO 16.0\n\nPair Coeffs\n\nC 0.1 3.4\nO 0.2 3.0\n\n",
                    labels = "Atom Type Labels\n\n1 C\n2 O\n\n", atoms = "Atoms # atomic\n\n1 C 0 0 0\n2 O 1 2 3\n";
  for (const std::string& text : {masses + labels + atoms, masses + atoms + "\n" + labels, labels + masses + atoms}) {
    const Scene scene = read_atoms(head + text);
    EXPECT_EQ(scene.system.masses, (std::vector<double>{12, 16})) << text;
    EXPECT_EQ(scene.left_out, (Names{"import: the section Pair Coeffs of a.data is not read"})) << text;
  }
  EXPECT_NE(atoms_error(head + masses + "Atoms # atomic\n\n1 1 0 0 0\n2 2 1 2 3\n")
                .find("line 11: found \"C\", wanted an atom type from 1 to 2"),
            std::string::npos);
}

TEST(AtomStyles, ALineBehindATitleMayNameTheColumns) {
  std::string text = file_with("", {"1 1 1 1 0.5 0.5 0.5", "2 2 1 1 1.5 2.5 3.5"}, false);
  text.replace(text.find("Atoms\n\n"), 7, "Atoms\natom-ID atom-type ellipsoidflag density x y z\n");
  const Scene scene = read_atoms(text + "\nVelocities\natom-ID vx vy vz\n1 1 0 0\n2 0 0 2\n", "ellipsoid");

  EXPECT_EQ(scene.system.positions, (std::vector<double>{0.5, 0.5, 0.5, 1.5, 2.5, 3.5}));
  EXPECT_EQ(scene.system.velocities, (std::vector<double>{1, 0, 0, 0, 0, 2}));
}

TEST(AtomStyles, TooFewColumnsAreToldWithTheStyleThatIsNamed) {
  const std::vector<std::string> lines{"1 1 0.5 0.5", "2 2 1.5 2.5"};
  EXPECT_NE(atoms_error(file_with(" # hybrid bond", lines)).find("found 4 columns, wanted 6 or 9 (style hybrid bond)"),
            std::string::npos);
  EXPECT_NE(atoms_error(file_with("", lines), "hybrid").find("found 4 columns, wanted 5 or more (style hybrid)"),
            std::string::npos);
  EXPECT_NE(atoms_error(file_with("", lines), "template").find("found 4 columns, wanted 8 or 11 (style template)"),
            std::string::npos);
  EXPECT_NE(atoms_error(file_with("", lines), "full").find("found 4 columns, wanted 7 or 10 (style full)"),
            std::string::npos);
}

TEST(AtomStyles, BondsOfLengthZeroAreLeftOutByName) {
  const Scene scene = read_atoms(file_with(" # molecular", {"1 1 1 0 0 0", "2 1 2 0 0 0", "3 1 2 1 0 0"}, true, 2));

  EXPECT_EQ(rods_of(scene).pairs, (decltype(Rods::pairs){{1, 2}}));
  EXPECT_EQ(scene.left_out, (Names{"import: what joins atoms at one place (bonds: 1) of a.data is not read"}));
}

TEST(AtomStyles, CoefficientsOfHybridStylesMatterForEnergiesAlone) {
  const Scene scene = import(R"("file": "import/hybrid_bond_coeffs.data")");
  EXPECT_EQ(scene.system.masses, (std::vector<double>{12, 16, 12, 16}));
  EXPECT_EQ(rods_of(scene).pairs.size(), 3u);
  EXPECT_EQ(error_of(R"({"tanor_scene": 1, "import": {"file": "import/hybrid_bond_coeffs.data", "bonds": "energies"}})",
                     TANOR_TEST_DATA "/a.json"),
            "a.json: /import/bond_style: hybrid_bond_coeffs.data, line 21: found \"harmonic\", wanted a finite number "
            "(hybrid styles are not read)");
}

}  // namespace
}  // namespace tanor::scene
