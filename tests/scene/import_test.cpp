#include <cmath>

#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

using Pairs = std::vector<std::array<Index, 2>>;

std::vector<double> coordinates(const Scene& scene, std::size_t axis) {
  std::vector<double> found;
  for (std::size_t k = axis; k < scene.system.positions.size(); k += 3) found.push_back(scene.system.positions[k]);
  return found;
}

TEST(ImportLammps, PutsAtomsIntoTheOrderOfTheirIds) {
  const Scene scene = import(R"("file": "polymer.data", "format": "lammps-data")");

  EXPECT_EQ(scene.source, "import: polymer.data (lammps-data)");
  EXPECT_EQ(scene.system.masses, (std::vector<double>{2, 2, 3.5, 3.5, 2, 2, 2, 3.5}));
  EXPECT_EQ(coordinates(scene, 1), (std::vector<double>{0.25, 0.25, 0.25, 0.25, 1, 1, 1, 1}));
}

// Chain 1 leaves through the upper x face, which its image flags tell; chain 2 through the upper z face, which they do
// not.
TEST(ImportLammps, UnwrapsByImageFlagsAndAlongBonds) {
  const Scene scene = import(R"("file": "polymer.data")");

  EXPECT_EQ(coordinates(scene, 0), (std::vector<double>{3.5, 4.5, 5.5, 6.5, 0, 0, 0, 0}));
  EXPECT_EQ(coordinates(scene, 2), (std::vector<double>{1, 1, 1, 1, 9.5, 10.5, 11.5, 12.5}));
}

TEST(ImportLammps, MakesRodsOfBonds) {
  const Scene scene = import(R"("file": "polymer.data", "bonds": "rods", "angles": "free")");

  EXPECT_EQ(rods_of(scene).name, "rods");
  EXPECT_EQ(rods_of(scene).pairs, (Pairs{{0, 1}, {2, 1}, {2, 3}, {4, 5}, {6, 5}, {6, 7}}));
  EXPECT_TRUE(rods_of(scene).length.is_initial());
  EXPECT_TRUE(rods_of(scene).offsets.empty());
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(rod_length(scene.system, rods_of(scene), k), 1.0);
}

TEST(ImportLammps, TakesBondsOfTheWantedTypes) {
  const Scene scene = import(R"("file": "polymer.data", "types": [2])");

  EXPECT_EQ(rods_of(scene).pairs, (Pairs{{2, 1}, {6, 7}}));
  EXPECT_EQ(scene.system.num_points(), 8u);
}

TEST(ImportLammps, RefusesTypesThatTheFileLacks) {
  EXPECT_EQ(
      error_of(R"({"tanor_scene": 1, "import": {"file": "polymer.data", "types": [1, 3]}})", TANOR_TEST_DATA "/a.json"),
      "a.json: /import/types/1: found number 3, wanted a whole number from 1 to 2");
}

TEST(ImportLammps, ReadsVelocities) {
  const Scene scene = import(R"("file": "polymer.data")");

  const std::vector<double>& v = scene.system.velocities;
  ASSERT_EQ(v.size(), 24u);
  EXPECT_EQ(v[3 * 3 + 0], 4.0);
  EXPECT_EQ(v[3 * 4 + 1], 8.1);
  EXPECT_EQ(v[3 * 7 + 2], 8.4);
}

// The ring runs once along the tilted edge b = (1, 6, 0), so one of its bonds keeps that shift.
TEST(ImportLammps, KeepsTheShiftOfABondThatClosesThroughAPeriodicFace) {
  const Scene scene = import(R"("file": "ring.data")");

  const Rods& rods = rods_of(scene);
  ASSERT_EQ(rods.offsets.size(), 4u);
  Vector3 sum{};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(rod_length(scene.system, rods, k), std::hypot(0.25, 1.5), 1e-15);
    for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += rods.offsets[k][axis];
  }
  EXPECT_EQ(sum, (Vector3{1, 6, 0}));
}

TEST(ImportLammps, RestsAndWeighsOneWhereTheFileDoesNotSay) {
  const Scene scene = import(R"("file": "ring.data")");

  EXPECT_TRUE(scene.system.velocities.empty());
  EXPECT_EQ(scene.system.masses, std::vector<double>(4, 1.0));
}

// Both molecules have arms (0.8, 0.6) and (-0.8, 0.6) once unwrapped, with rods of length 1 and the cosine -0.28.
TEST(ImportLammps, HoldsTheAnglesOfTheFileWhereTheyAreRigid) {
  const Scene scene = import(R"("file": "water.data", "angles": "rigid")");

  ASSERT_EQ(scene.system.constraints.size(), 2u);
  const Angles& angles = std::get<Angles>(scene.system.constraints[1]);
  EXPECT_EQ(angles.name, "angles");
  EXPECT_EQ(angles.triples, (std::vector<std::array<Index, 3>>{{1, 0, 2}, {4, 3, 5}}));
  EXPECT_TRUE(angles.cosine.is_initial());
  EXPECT_NEAR(coordinates(scene, 0)[4], 10.3, 1e-15);  // beside its molecule, so that the angle is its own
}

TEST(ImportLammps, LeavesAnglesFreeUnlessAsked) {
  EXPECT_EQ(import(R"("file": "water.data")").system.constraints.size(), 1u);
}

TEST(ImportLammps, NamesStraightAnglesThatCannotBeHeld) {
  EXPECT_EQ(
      error_of(R"({"tanor_scene": 1, "import": {"file": "polymer.data", "angles": "rigid"}})",
               TANOR_TEST_DATA "/a.json"),
      "a.json: /import/angles: found straight angles: 1, 2, 3, 4, wanted angles that bend, which their cosines can "
      "hold");
}

TEST(ImportLammps, NamesAnglesThatReachThroughAPeriodicFace) {
  EXPECT_EQ(
      error_of(R"({"tanor_scene": 1, "import": {"file": "ring.data", "angles": "rigid"}})", TANOR_TEST_DATA "/a.json"),
      "a.json: /import/angles: found angles that reach through a periodic face: 5, wanted atoms side by side once the "
      "rods have joined them");
}

/// Returns a data file of one atom type, two atoms and one bond type.
std::string data_file(const std::string& body, const std::string& bonds = "0", const std::string& angles = "0") {
  return "comment\n" + angles + " angles\n2 atoms\n" + bonds +
         " bonds\n1 atom types\n1 bond types\n0 9 xlo xhi\n0 9 ylo yhi\n0 9 zlo zhi\n\n" + body;
}

std::string data_error(const std::string& content) {
  const Folder folder;
  folder.add("a.data", content);
  const std::string error = error_of(R"({"tanor_scene": 1, "import": {"file": "a.data"}})", folder / "scene.json");
  const std::string place = "scene.json: /import/file: ";
  EXPECT_TRUE(error == "no error" || error.starts_with(place)) << error;
  return error.starts_with(place) ? error.substr(place.size()) : error;
}

TEST(ImportLammps, UnderstandsAtomStyles) {
  const Folder folder;
  const auto last_position = [&](const std::string& atoms) {
    folder.add("a.data", data_file(atoms));
    const Scene scene = parse_scene(R"({"tanor_scene": 1, "import": {"file": "a.data"}})", folder / "scene.json");
    return std::vector<double>(scene.system.positions.begin() + 3, scene.system.positions.end());
  };

  const std::vector<double> expected = {1, 2, 3}, unwrapped = {10, 2, -6};
  EXPECT_EQ(last_position("Atoms\n\n1 1 0 0 0\n2 1 1 2 3\n"), expected);
  EXPECT_EQ(last_position("Atoms # atomic\n\n1 1 0 0 0\n2 1 1 2 3 1 0 -1\n"), unwrapped);
  EXPECT_EQ(last_position("Atoms\n\n1 7 1 0 0 0 0 0 0\n2 7 1 1 2 3 1 0 -1\n"), unwrapped);
  EXPECT_EQ(last_position("Atoms  # angle\n\n1 7 1 0 0 0\n2 7 1 1 2 3\n"), expected);
  EXPECT_EQ(last_position("Atoms # charge\n\n1 1 -0.5 0 0 0\n2 1 0.5 1 2 3\n"), expected);
  EXPECT_EQ(last_position("Atoms\n\n1 7 1 -0.5 0 0 0\n2 7 1 0.5 1 2 3\n"), expected);
}

TEST(ImportLammps, NamesTheLineOfAnError) {
  EXPECT_EQ(data_error(data_file("Atoms\n\n1 1 0 0 0\n2 1 0 x 0\n")),
            "a.data, line 14: found \"x\", wanted a finite number");
  EXPECT_EQ(data_error(data_file("Atoms\n\n1 1 0 0 0\n2 2 0 0 0\n")),
            "a.data, line 14: found \"2\", wanted an atom type (style atomic, guessed) from 1 to 1");
  EXPECT_EQ(data_error(data_file("Atoms\n\n1 1 0 0\n")),
            "a.data, line 13: found 4 columns, wanted 5 or 8 (style atomic), 6 or 9 (molecular), 7 or 10 (full)");
  EXPECT_EQ(data_error(data_file("Atoms # full\n\n1 1 0 0 0\n")),
            "a.data, line 13: found 5 columns, wanted 7 or 10 (style full)");
  EXPECT_EQ(data_error(data_file("Atoms # balls\n")).substr(0, 83),
            "a.data, line 11: found \"balls\", wanted one of atomic, molecular, charge, full, bond");
  EXPECT_EQ(data_error(data_file("Masses\n\n1 -2\n")), "a.data, line 13: found \"-2\", wanted a mass > 0");
  EXPECT_EQ(data_error("comment\n1 atoms\n5 5 xlo xhi\n"),
            "a.data, line 3: found \"5\", wanted a higher end above the lower one");
}

TEST(ImportLammps, NamesAtomsAndBondsThatDoNotFit) {
  const std::string atoms = "Atoms\n\n1 1 0 0 0\n2 1 1 0 0\n\n";
  EXPECT_EQ(data_error(data_file("Atoms\n\n1 1 0 0 0\n")), "a.data: found 1 atoms, wanted 2 as its header says");
  EXPECT_EQ(data_error(data_file(atoms, "1")), "a.data: found 0 bonds, wanted 1 as its header says");
  EXPECT_EQ(data_error(data_file("Atoms\n\n1 1 0 0 0\n1 1 1 0 0\n")),
            "a.data: found atom 1 twice, wanted ids that differ");
  EXPECT_EQ(data_error(data_file(atoms + "Bonds\n\n1 1 1 3\n", "1")),
            "a.data, line 18: found atom 3 in a bond, wanted one of the section Atoms");
  EXPECT_EQ(data_error(data_file(atoms + "Bonds\n\n1 1 2 2\n", "1")),
            "a.data, line 18: found \"2\", wanted two atoms that differ");
  EXPECT_EQ(data_error(data_file(atoms + "Bonds\n\n1 2 1 2\n", "1")),
            "a.data, line 18: found \"2\", wanted a bond type from 1 to 1");
  EXPECT_EQ(data_error(data_file(atoms + "Angles\n\n1 1 1 2 3\n")),
            "a.data: found 1 angles, wanted 0 as its header says");
  EXPECT_EQ(data_error(data_file(atoms + "Angles\n\n1 1 1 2 3\n", "0", "1")),
            "a.data, line 18: found atom 3 in an angle, wanted one of the section Atoms");
  EXPECT_EQ(data_error(data_file(atoms + "Angles\n\n1 1 1 2 1\n", "0", "1")),
            "a.data, line 18: found \"1\", wanted three atoms that differ");
  EXPECT_EQ(data_error(data_file(atoms + "Velocities\n\n1 0 0 0\n")),
            "a.data: found 1 velocities, wanted 2 as its header says");
}

TEST(ImportLammps, RefusesAFileWithoutAtoms) {
  EXPECT_EQ(data_error("comment\n"),
            "found string \"a.data\", wanted a file of format lammps-data with at least one atom or vertex");
}

/// A file of each format, or of each style of LAMMPS, and the letters that a scene has from it.
struct Lettered {
  std::string file, text, keys;
  Units wanted;
};

std::vector<Lettered> list_lettered_files() {
  const auto data = [](const std::string& title) {
    return title + "\n\n2 atoms\n1 atom types\n\n0 2 xlo xhi\n0 2 ylo yhi\n0 2 zlo zhi\n\nMasses\n\n1 1\n\n" +
           "Atoms # atomic\n\n1 1 0.5 0.5 0.5\n2 1 1.5 0.5 0.5\n";
  };
  const std::string gro = "an atom\n 1\n    1HYD     O1    1   0.100   0.200   0.300\n   2.0   2.0   2.0\n";
  const std::string pdb = "ATOM      1  O   HOH A   1       1.000   2.000   3.000  1.00  0.00           O\nEND\n";
  const Units lj{"lj", "sigma", "m", "tau", "epsilon/sigma", "epsilon", "epsilon/k", "epsilon/sigma^3", 1.0};
  const Units real{"real",
                   "angstrom",
                   "g/mol",
                   "48.88821 fs",
                   "kcal/mol/angstrom",
                   "kcal/mol",
                   "K",
                   "kcal/mol/angstrom^3",
                   0.0019872042586408316};
  const Units metal{"metal", "angstrom", "g/mol",         "10.18051 fs", "eV/angstrom",
                    "eV",    "K",        "eV/angstrom^3", 8.617333262e-5};
  const Units micro{"micro", "um", "pg", "us", "pg um/us^2", "pg um^2/us^2", "K", "pg/(um us^2)", 1.380649e-8};
  const Units nano{"nano", "nm", "ag", "ns", "ag nm/ns^2", "ag nm^2/ns^2", "K", "ag/(nm ns^2)", 0.01380649};
  return {{"a.data", data("LAMMPS data file"), "", lj},
          {"a.data", data("LAMMPS data file via write_data, units = real"), "", real},
          {"a.data", data("units metal"), "", metal},
          {"a.data", data("units real"), R"(, "units": "metal")", metal},
          {"a.data", data("units si"), "", {"si", "m", "kg", "s", "N", "J", "K", "Pa", 1.380649e-23}},
          {"a.data", data("units cgs"), "", {"cgs", "cm", "g", "s", "dyn", "erg", "K", "Ba", 1.380649e-16}},
          {"a.data", data("units micro"), "", micro},
          {"a.data", data("units nano"), "", nano},
          {"a.gro", gro, "", {"gro", "nm", "u", "ps", "kJ/mol/nm", "kJ/mol", "K", "kJ/mol/nm^3", 0.00831446261815324}},
          {"a.pdb", pdb, "", {.name = "pdb", .length = "angstrom", .mass = "u"}},
          {"a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n", "", {}},
          {"a.ply",
           "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
           "end_header\n0 0 0\n",
           "",
           {}}};
}

TEST(Import, SetsTheLettersOfUnits) {
  for (const auto& [file, text, keys, wanted] : list_lettered_files()) {
    const Units found = import_text(file, text, keys).system.units;
    const auto list = [](const Units& of) {
      return of.name + ": " + of.length + ", " + of.mass + ", " + of.time + ", " + of.force + ", " + of.energy + ", " +
             of.temperature + ", " + of.pressure + ", " + std::to_string(of.boltzmann);
    };
    EXPECT_EQ(list(found), list(wanted)) << file << keys << "\n" << text;
    EXPECT_EQ(found, wanted) << file;
  }
}

TEST(Import, TellsThatUnitsOfTheFirstLineAreNone) {
  const auto left_out = [](const std::string& title, const std::string& keys) {
    const std::string atoms = "\n\n1 atoms\n1 atom types\n\nMasses\n\n1 1\n\nAtoms # atomic\n\n1 1 0 0 0\n";
    return import_text("a.data", title + atoms, keys).left_out;
  };
  EXPECT_EQ(
      left_out("LAMMPS data file, units = foo", ""),
      std::vector<std::string>{
          "import: the first line of a.data says units \"foo\", which LAMMPS has not; nothing is converted, as of lj"});
  EXPECT_TRUE(left_out("Reduced units melt, by hand", "").empty()) << "prose";
  EXPECT_TRUE(left_out("LAMMPS data file, units = foo", R"(, "units": "si")").empty());
  EXPECT_TRUE(left_out("LAMMPS data file, units = lj", "").empty());
}

TEST(Import, ASceneMayNameItsOwnUnits) {
  const Folder folder;
  folder.add("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n");
  const auto read = [&](const std::string& units) {
    return parse_scene(R"({"tanor_scene": 1, "import": {"file": "a.obj"}, "units": )" + units + "}", folder / "s.json");
  };
  EXPECT_EQ(read("\"si\"").system.units, units_from_name("si"));
  EXPECT_EQ(read(R"({"length": "mm"})").system.units, (Units{.name = "own", .length = "mm"}));
  const auto expect = [&](const std::string& units, const Units& wanted, const std::string& moment) {
    const Units found = read(units).system.units;
    for (const auto letters :
         {&Units::length, &Units::mass, &Units::time, &Units::force, &Units::energy, &Units::pressure})
      EXPECT_EQ(found.*letters, wanted.*letters) << units;
    EXPECT_EQ(found.letters(Dimension::Moment), moment) << units;
  };
  expect(R"({"length": "mm", "force": "N"})", {.length = "mm", .force = "N", .energy = "N mm", .pressure = "N/mm^2"},
         "N mm");
  expect(R"({"length": "mm", "force": "N", "time": "s"})",
         {.length = "mm", .mass = "N s^2/mm", .time = "s", .force = "N", .energy = "N mm", .pressure = "N/mm^2"},
         "N mm");
  expect(R"({"length": "mm", "mass": "kg", "time": "ms"})",
         {.length = "mm",
          .mass = "kg",
          .time = "ms",
          .force = "kg mm/ms^2",
          .energy = "kg mm^2/ms^2",
          .pressure = "kg/(mm ms^2)"},
         "kg mm^2/ms^2");
  expect(R"({"length": "A", "energy": "eV"})", {.length = "A", .force = "eV/A", .energy = "eV", .pressure = "eV/A^3"},
         "eV");
  expect(R"({"force": "N"})", {.force = "N"}, "");
  const std::string trouble =
      error_of(R"({"tanor_scene": 1, "import": {"file": "a.obj"}, "units": {"force": "N\nm"}})", folder / "s.json");
  EXPECT_EQ(trouble, "s.json: /units/force: found string \"N\\u000am\", wanted letters on one line, without quotes");
}

/// The cell that a scene names is that of an imported box; a tilted one has LAMMPS' edges.
TEST(Import, AScenesOwnCellHasItsCorner) {
  const auto read = [](const std::string& cell) { return three_points("\"cell\": " + cell); };
  const Scene scene =
      parse_scene(read(R"({"edges": [[2, 0, 0], [0.5, 3, 0], [0.2, 0.3, 4]], "origin": [-1, 2, 0.5]})"), "s.json");
  const Cell wanted{.xx = 2, .yy = 3, .zz = 4, .xy = 0.5, .xz = 0.2, .yz = 0.3, .origin = {-1, 2, 0.5}};
  ASSERT_TRUE(scene.system.cell.has_value());
  EXPECT_EQ(*scene.system.cell, wanted);
  for (const char* const edges : {"[[2, 0, 0], [0.5, 3, 0]]", "[[2, 1, 0], [0.5, 3, 0], [0, 0, 4]]",
                                  "[[2, 0, 0], [0.5, 3, 1], [0, 0, 4]]", "[[2, 0, 0], [0.5, 3, 0], [0, 0, 0]]"}) {
    const std::string trouble = error_of(read(std::string(R"({"edges": )") + edges + "}"), "s.json");
    EXPECT_TRUE(trouble.starts_with("s.json: /cell/edges: found ") &&
                trouble.ends_with("wanted edges [[a, 0, 0], [b, c, 0], [d, e, f]] with a, c and f > 0"))
        << trouble;
  }
}

}  // namespace
}  // namespace tanor::scene
