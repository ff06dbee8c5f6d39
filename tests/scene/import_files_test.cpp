/// The tests read points and rods of .obj, .ply, .gro and .pdb files; those in tests/data come from Debian packages
/// (README.md there).

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "scene/imported.hpp"
#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

using Pairs = std::vector<std::array<Index, 2>>;

/// Returns the lengths of all rods in millionths, each once.
std::set<long> lengths_of(const Scene& scene) {
  std::set<long> lengths;
  for (std::size_t k = 0; k < rods_of(scene).pairs.size(); ++k)
    lengths.insert(std::lround(1e6 * rod_length(scene.system, rods_of(scene), k)));
  return lengths;
}

/// Returns the message about a file of this content.
std::string file_error(const std::string& name, const std::string& content, const std::string& keys = "") {
  const Folder folder;
  folder.add(name, content);
  const std::string format = name.substr(name.find('.') + 1);
  const std::string error =
      error_of(R"({"tanor_scene": 1, "import": {"file": ")" + name + R"(", "format": ")" + format + "\"" + keys + "}}",
               folder / "scene.json");
  const std::string place = "scene.json: /import/file: ";
  return error.starts_with(place) ? error.substr(place.size()) : error;
}

// The cube has eight vertices and six squares: each of the twelve edges is in two faces.
TEST(ImportPly, ReadsACubeWithEachEdgeOnce) {
  const Scene scene = import(R"("file": "cube.ply", "format": "ply")");

  EXPECT_EQ(scene.source, "import: cube.ply (ply)");
  EXPECT_EQ(scene.system.num_points(), 8u);
  EXPECT_EQ(scene.system.masses, std::vector<double>(8, 1.0));
  EXPECT_EQ(rods_of(scene).name, "rods");
  EXPECT_EQ(rods_of(scene).pairs.size(), 12u);
  EXPECT_EQ(lengths_of(scene), (std::set<long>{1000000}));
}

// This is the same cube as twelve triangles, whose diagonals are edges too.
TEST(ImportPly, ReadsABinaryCube) {
  const Scene scene = import(R"("file": "cube_binary.ply", "format": "ply", "mass": 0.25)");

  EXPECT_EQ(scene.system.masses, std::vector<double>(8, 0.25));
  EXPECT_EQ(rods_of(scene).pairs.size(), 18u);
  const std::set<long> lengths = lengths_of(scene);
  ASSERT_EQ(lengths.size(), 2u);
  EXPECT_NEAR(static_cast<double>(*lengths.rbegin()) / static_cast<double>(*lengths.begin()), std::sqrt(2.0), 1e-6);
}

TEST(ImportPly, ReadsEdgesAndBigEndianNumbers) {
  const std::string header =
      "ply\nformat binary_big_endian 1.0\nelement edge 1\nproperty ushort vertex1\nproperty char vertex2\n"
      "element vertex 2\nproperty list uchar short tags\nproperty double x\nproperty float y\nproperty int z\n"
      "end_header\n";
  const auto bytes = [](std::initializer_list<int> values) { return std::string(values.begin(), values.end()); };
  const std::string edge = bytes({0, 1, 0});
  const std::string first = bytes({2, 0, 7, 0, 8, 0x3F, 0xF8, 0, 0, 0, 0, 0, 0, 0xC0, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFD});
  const std::string second = bytes({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0});

  const Imported data = read_ply("a.ply", header + edge + first + second);

  EXPECT_EQ(data.positions, (std::vector<Vector3>{{1.5, -2, -3}, {0, 0, 256}}));
  ASSERT_EQ(data.bonds.size(), 1u);
  EXPECT_EQ(data.bonds[0].atoms, (std::array<std::int32_t, 2>{1, 0}));
}

TEST(ImportPly, ReadsEveryTypeInEitherByteOrder) {
  struct Row {
    std::vector<std::string> names;
    std::string little;  // the bytes of the number
    double number;
  };
  const std::vector<Row> rows{{{"char", "int8"}, "\x80", -128.0},
                              {{"uchar", "uint8"}, "\x80", 128.0},
                              {{"short", "int16"}, "\xFE\xFF", -2.0},
                              {{"ushort", "uint16"}, "\xFE\xFF", 65534.0},
                              {{"int", "int32"}, "\x01\x02\x03\x84", -2080177663.0},
                              {{"uint", "uint32"}, "\x01\x02\x03\x84", 2214789633.0},
                              {{"float", "float32"}, std::string("\0\0\xC8\xC2", 4), -100.0},
                              {{"double", "float64"}, std::string("\0\0\0\0\0\0\x59\x40", 8), 100.0}};
  for (const Row& row : rows) {
    for (const std::string& name : row.names) {
      const auto read = [&](const std::string& format, const std::string& number, const std::string& rest) {
        return read_ply("a.ply", "ply\nformat " + format + " 1.0\nelement vertex 1\nproperty " + name +
                                     " x\nproperty uchar y\nproperty uchar z\nend_header\n" + number + rest)
            .positions;
      };
      const std::vector<Vector3> wanted{{row.number, 1, 2}};

      EXPECT_EQ(read("binary_little_endian", row.little, "\x01\x02"), wanted) << name;
      EXPECT_EQ(read("binary_big_endian", {row.little.rbegin(), row.little.rend()}, "\x01\x02"), wanted) << name;
      EXPECT_EQ(read("ascii", std::to_string(row.number), " 1\t2\r\n"), wanted) << name;
    }
  }
}

TEST(ImportPly, FacesAreClosedAndOtherElementsAreSkipped) {
  const Imported data = read_ply("a.ply",
                                 "ply\ncomment element vertex 9\nformat ascii 1.0\nobj_info none\n"
                                 "element material 2\nproperty uchar red\nproperty list uchar int vertex_index\n"
                                 "element vertex 4\nproperty double z\nproperty double quality\nproperty double x\n"
                                 "property double y\n"
                                 "element face 3\nproperty list uchar int tags\n"
                                 "property list uchar int vertex_indices\n"
                                 "element edge 1\nproperty int vertex2\nproperty int vertex1\nproperty int age\n"
                                 "end_header\n255 2 7 8\n0 0\n3 -9 1 2\n6 -9 4 5\n9 -9 7 8\n12 -9 10 11\n"
                                 "2 3 1 4 0 1 2 3\n0 1 2\n0 0\n0 2 5\n");

  EXPECT_EQ(data.positions, (std::vector<Vector3>{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}}));
  std::vector<std::array<std::int32_t, 2>> edges;
  for (const auto& bond : data.bonds) edges.push_back(bond.atoms);
  EXPECT_EQ(edges, (std::vector<std::array<std::int32_t, 2>>{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {2, 0}}));
}

TEST(ImportPly, NamesWhatIsWrong) {
  const std::string vertex = "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n";
  const auto error = [&](const std::string& rest) { return file_error("a.ply", "ply\nformat ascii 1.0\n" + rest); };

  EXPECT_EQ(file_error("a.ply", "solid\n"), "a.ply, line 1: wanted \"ply\", the first line of such a file");
  EXPECT_EQ(file_error("a.ply", "ply\nend_header\n"), "a.ply, line 2: missing the line \"format …\" above");
  EXPECT_EQ(error(vertex), "a.ply, line 6: missing end_header");
  EXPECT_EQ(error("element vertex 2\nproperty quad x\n"),
            "a.ply, line 4: found \"quad\", wanted a type: char, uchar, short, ushort, int, uint, float, double");
  EXPECT_EQ(error(vertex + "end_header\n0 0 0\n1 x 0\n"), "a.ply, line 9: found no finite number for y of vertex 1");
  EXPECT_EQ(error("element vertex 2000000000\nproperty float x\nend_header\n1\n"),
            "a.ply, line 6: found 2000000000 elements vertex, wanted no more than the rest of the file holds");
  EXPECT_EQ(error("element vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n"),
            "a.ply, line 7: found vertices without x, y and z, wanted these properties once each");
  const std::string face = vertex + "element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n";
  EXPECT_EQ(error(face + "3 0 1 2\n"), "a.ply: found vertex 2 in an edge or face, wanted one from 0 to 1");
  EXPECT_EQ(error(face + "2 1 1\n"),
            "a.ply, line 12: found vertex 1 twice in sequence in face 0, wanted vertices that differ");
  EXPECT_EQ(error(face + "200 1 1\n"),
            "a.ply, line 12: found a list of 200 entries in face 0, wanted no more than the rest of the file holds");
  // The number is larger than an integer holds.
  EXPECT_EQ(error("element face 1\nproperty list double int vertex_index\nend_header\n1e46 1 1\n"),
            "a.ply, line 6: found a list of 1e+46 entries in face 0, wanted no more than the rest of the file holds");
  const std::string list = "found a list of ";
  EXPECT_EQ(error("element face 1\nproperty list double int vertex_index\nend_header\n1.5 1 1\n"),
            "a.ply, line 6: " + list + "1.5 entries in face 0, wanted a count");
  EXPECT_EQ(error("element face 1\nproperty list double int vertex_index\nend_header\n-1\n"),
            "a.ply, line 6: " + list + "-1 entries in face 0, wanted a count");
  const std::string edge = "element edge 1\nproperty double vertex1\nproperty double vertex2\nend_header\n";
  for (const std::string wrong : {"-1", "0.5", "2147483647"})
    EXPECT_EQ(error(edge + wrong + " 1\n"),
              "a.ply, line 7: found vertex " + wrong + " in edge 0, wanted one from 0 on");
  EXPECT_EQ(error("element edge 1\nproperty double vertex1\nend_header\n1\n"),
            "a.ply, line 6: found vertex -1 in edge 0, wanted one from 0 on");
  EXPECT_EQ(error(vertex +
                  "element edge 2\nproperty int vertex1\nproperty int vertex2\nend_header\n0 0 0\n1 0 0\n0 5\n0 1\n"),
            "a.ply: found vertex 5 in an edge or face, wanted one from 0 to 1");
  // A number takes at least a digit and a blank.
  EXPECT_EQ(error("element face 4\nproperty uchar a\nend_header\n1 1\n"),
            "a.ply, line 6: found 4 elements face, wanted no more than the rest of the file holds");
  EXPECT_EQ(error("element vertex 1\nend_header\n"),
            "a.ply, line 5: found 1 elements vertex, wanted no more than the rest of the file holds");
}

TEST(ImportPly, NamesTheLineOfItsHeaderThatIsWrong) {
  const auto error = [](const std::string& rest) { return file_error("a.ply", "ply\n" + rest); };
  const std::string line = "format, element, property, comment or end_header";

  EXPECT_EQ(error("format text 1.0\n"),
            "a.ply, line 2: found \"text\", wanted ascii, binary_little_endian or binary_big_endian");
  EXPECT_EQ(error("\nformat ascii\n"), "a.ply, line 3: found \"format ascii\", wanted " + line);
  EXPECT_EQ(error("property float x\n"), "a.ply, line 2: found \"property float x\", wanted " + line);
  EXPECT_EQ(error("element vertex\n"), "a.ply, line 2: found \"element vertex\", wanted " + line);
  for (const std::string wrong : {"-1", "1.5", "2147483648", "many"})
    EXPECT_EQ(error("element vertex " + wrong + "\n"),
              "a.ply, line 2: found \"" + wrong + "\", wanted a count from 0 to 2147483647");
  for (const std::string wrong : {"property float x y", "property list uchar int", "property list x"})
    EXPECT_EQ(error("element vertex 1\n" + wrong + "\n"),
              "a.ply, line 3: found \"" + wrong + "\", wanted property TYPE NAME or property list TYPE TYPE NAME");
}

/// Behind the header of a binary file there are no lines.
TEST(ImportPly, SaysWhereBinaryNumbersEnd) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n";
  const std::string zeros(16, '\0');

  EXPECT_EQ(file_error("a.ply", header + zeros),
            "a.ply: found 2 elements vertex, wanted no more than the rest of the file holds");
  EXPECT_EQ(file_error("a.ply", header + zeros + std::string("\0\0\x80\x7F", 4) + std::string(4, '\0')),
            "a.ply: found no finite number for y of vertex 1");
  const std::string face =
      "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list uchar int a\n"
      "property list uchar int b\nend_header\n";
  EXPECT_EQ(file_error("a.ply", face + std::string("\0\x02", 2) + std::string(7, '\0')),
            "a.ply: found a list of 2 entries in face 0, wanted no more than the rest of the file holds");
  EXPECT_EQ(file_error("a.ply", face + std::string("\x01\0\0\0\0", 5)),
            "a.ply: found no finite number for b of face 0");
}

// The part has sixteen triangles over ten vertices.
TEST(ImportObj, ReadsAPartOfAMechanism) {
  const Scene scene = import(R"("file": "bricard_part.obj", "format": "obj")");

  EXPECT_EQ(scene.system.num_points(), 10u);
  EXPECT_EQ(scene.system.positions[3 * 6 + 1], -1.0);
  EXPECT_EQ(rods_of(scene).pairs.size(), 23u) << "two plates of 16 triangles share one edge";
  EXPECT_EQ(rods_of(scene).pairs[0], (std::array<Index, 2>{2, 0}));
}

TEST(ImportObj, TakesLinesAndFacesAndSkipsPoints) {
  const Scene scene = import(R"("file": "lines_and_faces.obj", "format": "obj")");

  EXPECT_EQ(scene.system.num_points(), 8u);
  EXPECT_EQ(rods_of(scene).pairs.size(), 12u);
  EXPECT_EQ(lengths_of(scene), (std::set<long>{1000000}));
}

TEST(ImportObj, UnderstandsRelativeIndicesTexturesAndContinuedLines) {
  const Imported data = read_obj("a.obj", "v 0 0 0\r\nv 1 0 0 1\nl -2 -1\nf 1/4 2//7 \\\n 3/1/2\nv 0 \\\n1 0\n");

  EXPECT_EQ(data.positions, (std::vector<Vector3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  ASSERT_EQ(data.bonds.size(), 3u);
  EXPECT_EQ(data.bonds[0].atoms, (std::array<std::int32_t, 2>{0, 1}));
  EXPECT_EQ(data.bonds[1].atoms, (std::array<std::int32_t, 2>{2, 0}));
  EXPECT_EQ(data.bonds[2].atoms, (std::array<std::int32_t, 2>{1, 2}));
}

TEST(ImportObj, NamesTheLineOfAnError) {
  EXPECT_EQ(file_error("a.obj", "v 0 0\n"), "a.obj, line 1: found a vertex of 2 numbers, wanted x, y and z");
  EXPECT_EQ(file_error("a.obj", "v 0 0 1e999\n"), "a.obj, line 1: found \"1e999\", wanted a finite number");
  EXPECT_EQ(file_error("a.obj", "v 0 0 0\nl 1 0\n"),
            "a.obj, line 2: found \"0\", wanted a vertex: from 1 on, or from -1 to -1");
  EXPECT_EQ(file_error("a.obj", "v 0 0 0\nl 1 -2\n"),
            "a.obj, line 2: found \"-2\", wanted a vertex: from 1 on, or from -1 to -1");
  EXPECT_EQ(file_error("a.obj", "v 0 0 0\nl 1 1\n"),
            "a.obj, line 2: found \"1\", wanted vertices in sequence that differ");
  EXPECT_EQ(file_error("a.obj", "v 0 0 0\nv 1 0 0\nl 1 3\nv nothing\n"),
            "a.obj, line 4: found a vertex of 1 number, wanted x, y and z");
  EXPECT_EQ(file_error("a.obj", "v 0 0 0\nv 1 0 0\n\nl 1 3\n"),
            "a.obj, line 4: found vertex 3, wanted one from 1 to 2");
  EXPECT_EQ(file_error("a.obj", "f 1 2\n"), "a.obj, line 1: found 2 vertices, wanted 3 or more");
  EXPECT_EQ(file_error("a.obj", "o nothing\n"),
            "found string \"a.obj\", wanted a file of format obj with at least one atom or vertex");
}

// The file has 216 molecules of SPC: O-H 0.1 nm, H-O-H 109.47 degrees, in a box of 1.86206 nm.
TEST(ImportGro, ReadsWaterWithBondsByDistance) {
  const Scene scene = import(R"("file": "water216.gro", "format": "gro", "bonds": "distance", "angles": "rigid")");

  EXPECT_EQ(scene.source, "import: water216.gro (gro, bonds by distance)");
  ASSERT_EQ(scene.system.num_points(), 648u);
  EXPECT_EQ(scene.system.masses[0], 15.999);
  EXPECT_EQ(scene.system.masses[1], 1.008);
  ASSERT_EQ(rods_of(scene).pairs.size(), 432u);
  for (std::size_t k = 0; k < 432; ++k) {
    const auto [i, j] = rods_of(scene).pairs[k];
    EXPECT_EQ(i, static_cast<Index>(3 * (k / 2)));
    EXPECT_EQ(j, static_cast<Index>(3 * (k / 2) + 1 + k % 2));
    EXPECT_NEAR(rod_length(scene.system, rods_of(scene), k), 0.1, 2e-3) << "three digits in the file";
  }
  const Angles& angles = std::get<Angles>(scene.system.constraints.at(1));
  ASSERT_EQ(angles.triples.size(), 216u);
  EXPECT_EQ(angles.triples[5], (std::array<Index, 3>{16, 15, 17}));
}

TEST(ImportGro, MakesNoRodsByItself) {
  const Scene scene = import(R"("file": "water216.gro", "format": "gro")");

  EXPECT_TRUE(rods_of(scene).pairs.empty());
}

// The file has more digits and a slanted box: molecule 2 reaches through its slanted face.
TEST(ImportGro, ReadsVelocitiesDigitsAndTiltedBoxes) {
  const std::string text =
      "two hydroxyls\n 4\n"
      "    1HYD     O1    1   0.10000   0.20000   0.30000  0.400000 -0.500000  0.600000\n"
      "    1HYD     H1    2   0.20000   0.20000   0.30000  0.000000  0.000000  0.000000\n"
      "    2HYD     O1    3   0.65000   1.95000   1.00000  0.000000  0.000000  0.000000\n"
      "    2HYD     H1    4   0.15000   0.05000   1.00000  0.000000  0.000000  0.000000\n"
      "   2.00000   2.00000   2.00000   0.00000   0.00000   0.50000   0.00000   0.00000   0.00000\n";
  const Folder folder;
  folder.add("a.gro", text);
  const Scene scene = parse_scene(
      R"({"tanor_scene": 1, "import": {"file": "a.gro", "format": "gro", "bonds": "distance"}})", folder / "s.json");

  EXPECT_EQ(std::vector<double>(scene.system.velocities.begin(), scene.system.velocities.begin() + 3),
            (std::vector<double>{0.4, -0.5, 0.6}));
  EXPECT_EQ(rods_of(scene).pairs, (Pairs{{0, 1}, {2, 3}}));
  EXPECT_NEAR(rod_length(scene.system, rods_of(scene), 1), 0.1, 1e-12) << "(0.5, 2) is an edge of the box";
}

TEST(ImportGro, NamesTheLineOfAnError) {
  const std::string atom = "    1SOL     OW    1   0.000   0.000   0.000\n", box = "   1.0 1.0 1.0\n";
  EXPECT_EQ(file_error("a.gro", "t\nmany\n"), "a.gro, line 2: found \"many\", wanted the number of atoms");
  EXPECT_EQ(file_error("a.gro", "t\n2\n" + atom), "a.gro, line 3: found 1 atom, wanted 2 as line 2 says");
  EXPECT_EQ(file_error("a.gro", "t\n1\n" + atom), "a.gro, line 3: missing the line of the box behind the atoms");
  EXPECT_EQ(file_error("a.gro", "t\n1\n" + atom + "1 2\n"),
            "a.gro, line 4: found 2 numbers, wanted 3 or 9 for the box");
  EXPECT_EQ(file_error("a.gro", "t\n1\n" + atom + "1\n"), "a.gro, line 4: found 1 number, wanted 3 or 9 for the box");
  EXPECT_EQ(file_error("a.gro", "t\n1\n    1SOL     OW    1   0.000   x.000   0.000\n" + box),
            "a.gro, line 3: found \"x.000\", wanted a finite number");
  EXPECT_EQ(file_error("a.gro", "t\n1\n    1SOL     MW    1   0.000   0.000   0.000\n" + box),
            "a.gro, line 3: atom \"MW\" is of no element that its name tells; give one mass for all by /import/mass");
  EXPECT_EQ(file_error("a.gro", "t\n1\n    1SOL     MW    1   0.000   0.000   0.000\n" + box, R"(, "mass": 2)"),
            "no error");
}

// The ligand has 36 atoms: the CONECT records name 40 bonds, double ones twice, each from both ends.
TEST(ImportPdb, MakesRodsOfConect) {
  const Scene scene = import(R"("file": "ligand.pdb", "format": "pdb")");

  EXPECT_EQ(scene.system.num_points(), 36u);
  EXPECT_EQ(scene.system.masses[0], 35.45) << "Cl";
  EXPECT_EQ(scene.system.masses[34], 79.904) << "Br";
  EXPECT_EQ(scene.system.positions[4], 131.704);
  EXPECT_EQ(rods_of(scene).pairs.size(), 40u);
  EXPECT_EQ(rods_of(scene).pairs[0], (std::array<Index, 2>{0, 8}));
  EXPECT_GT(*lengths_of(scene).begin(), 1200000);
  EXPECT_LT(*lengths_of(scene).rbegin(), 1920000) << "C-Br is the longest";
}

// Two independent sources agree: the bonds that the file's author wrote, and those that the radii of the elements give.
TEST(ImportPdb, FindsTheBondsOfConectByDistance) {
  const auto sorted = [](Pairs pairs) {
    for (auto& [i, j] : pairs)
      if (i > j) std::swap(i, j);
    std::ranges::sort(pairs);
    return pairs;
  };

  const Scene named = import(R"("file": "ligand.pdb", "format": "pdb")");
  const Scene found = import(R"("file": "ligand.pdb", "format": "pdb", "bonds": "distance")");

  EXPECT_EQ(sorted(rods_of(found).pairs), sorted(rods_of(named).pairs));
}

TEST(ImportPdb, TakesTheFirstModelTheFirstPlaceAndTheCell) {
  const std::string text =
      "CRYST1   10.000   20.000   30.000  90.00  90.00 120.00 P 1           1\n"
      "MODEL        1\n"
      "ATOM      1  CA AALA A   1       1.000   2.000   3.000  0.50  0.00\n"
      "ATOM      2  CA BALA A   1       1.100   2.000   3.000  0.50  0.00\n"
      "HETATM    3 CA    CA A   2       5.000   2.000   3.000  1.00  0.00\n"
      "HETATM    4 HG11 VAL A   3       6.000   2.000   3.000  1.00  0.00\n"
      "ENDMDL\nMODEL        2\n"
      "ATOM      1  CA AALA A   1       9.000   2.000   3.000  0.50  0.00\n"
      "ENDMDL\n"
      "CONECT    1    3    2\n";

  const Imported data = read_pdb("a.pdb", text);

  EXPECT_EQ(data.positions, (std::vector<Vector3>{{1, 2, 3}, {5, 2, 3}, {6, 2, 3}}));
  EXPECT_EQ(data.elements[0]->symbol, "C") << "alpha carbon";
  EXPECT_EQ(data.elements[1]->symbol, "Ca") << "calcium";
  EXPECT_EQ(data.elements[2]->symbol, "H") << "not mercury";
  ASSERT_EQ(data.bonds.size(), 1u);
  EXPECT_NEAR(data.cell.xy, -10.0, 1e-12);
  EXPECT_NEAR(data.cell.yy, 20.0 * std::sin(M_PI / 1.5), 1e-12);
  EXPECT_EQ(data.cell.zz, 30.0);
}

TEST(ImportPdb, NamesTheLineOfAnError) {
  const std::string atom = "ATOM      1  CA  ALA A   1       1.000   2.000   3.000  1.00  0.00           C\n";
  EXPECT_EQ(file_error("a.pdb", "ATOM      1  CA  ALA A   1       1.000   2.o00   3.000\n"),
            "a.pdb, line 1: found \"2.o00\", wanted a finite number in columns 39 to 46");
  EXPECT_EQ(file_error("a.pdb", atom + "CONECT    1    7\n"),
            "a.pdb, line 2: found \"7\", wanted the number of an atom above");
  EXPECT_EQ(file_error("a.pdb", atom + atom + "CONECT    1    1\n"),
            "a.pdb, line 3: found \"1\", wanted the number of one atom, which several atoms have");
  EXPECT_EQ(file_error("a.pdb", atom + "CONECT    1    1\n"), "a.pdb, line 2: found an atom bonded to itself");
  EXPECT_EQ(file_error("a.pdb", "CRYST1   10.000   20.000   30.000  90.00  90.00 180.00\n" + atom),
            "a.pdb, line 1: found angles between which no cell has room");
  EXPECT_EQ(file_error("a.pdb", "END\n"),
            "found string \"a.pdb\", wanted a file of format pdb with at least one atom or vertex");
}

TEST(Import, DistancesNeedElementsAndMolecules) {
  EXPECT_EQ(error_of(R"({"tanor_scene": 1, "import": {"file": "cube.ply", "format": "ply", "bonds": "distance"}})",
                     TANOR_TEST_DATA "/a.json"),
            "a.json: /import/bonds: found string \"distance\", wanted rods or none: the file knows no elements, whose "
            "radii tell bonds");
  std::string heap;
  for (int k = 0; k < 40; ++k)
    heap += "ATOM     " + std::to_string(k + 10) + "  C   ALA A   1       1.000   2.000 " +
            std::to_string(3.0 + 0.03 * k).substr(0, 5) + "  1.00  0.00\n";
  EXPECT_EQ(file_error("a.pdb", heap, R"(, "bonds": "distance")").substr(0, 60),
            "scene.json: /import/bonds: found point 0 within bonding dist");
}

TEST(Import, BondsMayBeLeftOutAndAreNamedThen) {
  const Scene scene = import(R"("file": "cube.ply", "format": "ply", "bonds": "none")");
  EXPECT_TRUE(rods_of(scene).pairs.empty());
  ASSERT_EQ(scene.left_out.size(), 1u);
  EXPECT_EQ(scene.left_out[0].substr(0, 48), "import: what joins atoms by bonds (bonds: 12) of");
  EXPECT_TRUE(import(R"("file": "import/UPPER.GRO", "bonds": "none")").left_out.empty()) << "it has no bonds";
}

/// Returns carbon atoms at these places, angstrom.
Imported carbon_at(std::vector<Vector3> positions) {
  Imported data;
  data.angstrom = 1.0;
  data.elements.assign(positions.size(), find_element("C"));
  data.positions = std::move(positions);
  return data;
}

// Trying all pairs of so many atoms would take hours.
TEST(Import, AtomsThatAreAllInOnePlaceAreToldByTheFirst) {
  try {
    (void)find_bonds_by_distance(carbon_at(std::vector<Vector3>(400000, Vector3{1.0, 2.0, 3.0})));
    FAIL() << "nothing was said";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "found point 0 within bonding distance of more than 24 others, wanted at most 24");
  }
}

TEST(Import, AnAtomFarAwayKeepsNoOtherFromItsNeighbours) {
  constexpr int edge = 40;
  std::vector<Vector3> grid{{9000.0, -9000.0, 9000.0}};
  for (int k = 0; k < edge * edge * edge; ++k)
    grid.push_back({1.5 * (k % edge), 1.5 * (k / edge % edge), 1.5 * (k / edge / edge)});

  EXPECT_EQ(find_bonds_by_distance(carbon_at(grid)).size(), 3u * edge * edge * (edge - 1));
}

// Every bond of random atoms in a random box is also found by trying all pairs.
RC_GTEST_PROP(Import, BondsByDistanceAreThoseOfAllPairs, ()) {
  const bool is_periodic = *rc::gen::arbitrary<bool>();
  const auto edge = [] { return 3.0 + 0.01 * *rc::gen::inRange(0, 900); };
  const auto tilt = [] { return 0.01 * *rc::gen::inRange(-100, 100); };
  Imported data;
  data.angstrom = 1.0;
  if (is_periodic) data.cell = {.xx = edge(), .yy = edge(), .zz = edge(), .xy = tilt(), .xz = tilt(), .yz = tilt()};
  const int num_atoms = *rc::gen::inRange(1, 26);  // more in one place are no molecule
  for (int k = 0; k < num_atoms; ++k) {
    Vector3 r;
    for (double& x : r) x = 0.001 * *rc::gen::inRange(-15000, 15000);
    data.positions.push_back(r);
    data.elements.push_back(find_element(*rc::gen::element("H", "C", "O", "Br")));
  }

  const auto found = find_bonds_by_distance(data);

  std::vector<std::array<std::int32_t, 2>> expected;
  for (int i = 0; i < num_atoms; ++i) {
    for (int j = i + 1; j < num_atoms; ++j) {
      const Vector3 &a = data.positions[i], &b = data.positions[j];
      Vector3 d{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
      const Vector3 shift = shift_of(data.cell, nearest_images(data.cell, d));
      const double distance = std::hypot(d[0] - shift[0], d[1] - shift[1], d[2] - shift[2]);
      const double most = data.elements[i]->covalent_radius + data.elements[j]->covalent_radius + 0.45;
      if (distance > 0.4 && distance < most) expected.push_back({i, j});
    }
  }
  RC_ASSERT(found.size() == expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) RC_ASSERT(found[k].atoms == expected[k]);
}

}  // namespace
}  // namespace tanor::scene
