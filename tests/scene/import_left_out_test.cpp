/// A file is read, or what is left out is named, or it is refused: nothing is lost or mixed without a word.

#include <algorithm>

#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

using Names = std::vector<std::string>;
using Pairs = std::vector<std::array<Index, 2>>;

// ---- obj ----

TEST(ImportLeftOut, CommentsOfObjBeginAnywhere) {
  EXPECT_EQ(rods_of(import(R"("file": "import/comment_behind.obj")")).pairs, (Pairs{{3, 0}, {0, 1}, {1, 2}, {2, 3}}));
  EXPECT_EQ(rods_of(import(R"("file": "import/comment_behind_line.obj")")).pairs, (Pairs{{0, 1}, {1, 2}}));
  const Scene scene =
      import_text("a.obj", "# C:\\models\\\nv 0 0 0#first\nv 1 0 \\ # goes on\n0 # \\\nl 1 2#\n #l 2 1\n");
  EXPECT_EQ(scene.system.positions, (std::vector<double>{0, 0, 0, 1, 0, 0}));
  EXPECT_EQ(rods_of(scene).pairs, (Pairs{{0, 1}}));
  EXPECT_TRUE(scene.left_out.empty());
}

TEST(ImportLeftOut, LinesOfObjThatAreNotReadAreNamed) {
  const Scene scene =
      import_text("a.obj", "mtllib a.mtl\nv 0 0 0 1\nvn 0 0 1\nV 5 5 5\nv 1 0 0\nvn 0 0 1\ncurv 0 1 1 2\nl 1 2\n");
  EXPECT_EQ(scene.left_out, (Names{R"(import: what stands in lines "mtllib", "vn", "V", "curv" of a.obj is not read)",
                                   R"(import: what stands behind x, y and z in lines "v" of a.obj is not read)"}));
}

// ---- ply ----

TEST(ImportLeftOut, NumbersOfPlyThatNobodyReadsMayBeAnything) {
  for (const std::string file : {"nan_normal.ply", "nan_normal_binary.ply"}) {
    const Scene scene = import(R"("file": "import/)" + file + "\"");
    EXPECT_EQ(scene.system.num_points(), 4u) << file;
    EXPECT_EQ(rods_of(scene).pairs.size(), 4u) << file;
    EXPECT_EQ(scene.left_out,
              (Names{R"(import: what stands in properties "nx", "ny", "nz" of element "vertex" of import/)" + file +
                     " is not read"}));
  }
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property float q\nproperty list uchar float w\nelement material 1\nproperty float k\nend_header\n";
  const Scene scene = import_text("a.ply", header + "0 0 0 -1.#IND 2 inf -nan\n1 0 0 nan 0\nnan\n8 8\n");
  EXPECT_EQ(scene.system.positions, (std::vector<double>{0, 0, 0, 1, 0, 0}));
  EXPECT_EQ(scene.left_out,
            (Names{R"(import: what stands in properties "q", "w" of element "vertex" of a.ply is not read)",
                   R"(import: what stands in properties "k" of element "material" of a.ply is not read)",
                   "import: what stands behind the last element of a.ply is not read"}));
  EXPECT_EQ(import_error("a.ply", header + "0 0 nan 0 0\n1 0 0 0 0\n1\n"),
            "s.json: /import/file: a.ply, line 12: found no finite number for z of vertex 0");
  EXPECT_EQ(import_error("a.ply", header + "0 0 0 0 0\n1 0 0 0 0\n"),
            "s.json: /import/file: a.ply, line 14: found no number for k of material 0");
}

TEST(ImportLeftOut, StripsOfTrianglesAreRods) {
  const Pairs wanted{{0, 1}, {1, 3}, {3, 0}, {3, 2}, {2, 1}};
  for (const std::string file : {"tristrips.ply", "tristrips_ascii.ply"}) {
    const Scene scene = import(R"("file": "import/)" + file + "\"");
    EXPECT_EQ(rods_of(scene).pairs, wanted) << file;
    EXPECT_TRUE(scene.left_out.empty()) << file;
  }
}

/// Returns a file of seven vertices and strips, in any encoding.
std::string strip_file(const std::string& format, const std::vector<int>& strips) {
  std::string text = "ply\nformat " + format +
                     " 1.0\nelement vertex 7\nproperty int x\nproperty int y\nproperty int z\n"
                     "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
  std::vector<int> numbers;
  for (int k = 0; k < 7; ++k) numbers.insert(numbers.end(), {k, k * k, 0});
  numbers.push_back(static_cast<int>(strips.size()));
  numbers.insert(numbers.end(), strips.begin(), strips.end());
  for (const int number : numbers) {
    if (format == "ascii") {
      text += std::to_string(number) + " ";
      continue;
    }
    for (int byte = 0; byte < 4; ++byte) {
      const int shift = 8 * (format == "binary_big_endian" ? 3 - byte : byte);
      text += static_cast<char>(static_cast<unsigned>(number) >> shift);
    }
  }
  return text;
}

TEST(ImportLeftOut, StripsArePartedAndMayTurn) {
  for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const auto rods = [&](const std::vector<int>& strips) {
      Pairs pairs = rods_of(import_text("a.ply", strip_file(format, strips))).pairs;
      for (auto& [i, j] : pairs)
        if (i > j) std::swap(i, j);
      std::ranges::sort(pairs);
      return pairs;
    };
    EXPECT_EQ(rods({0, 1, 2, -1, 4, 5, 6}), (Pairs{{0, 1}, {0, 2}, {1, 2}, {4, 5}, {4, 6}, {5, 6}})) << format;
    EXPECT_EQ(rods({-1, -1, 0, 1, 2, -1, -1}), (Pairs{{0, 1}, {0, 2}, {1, 2}})) << format;
    EXPECT_EQ(rods({0, 1, 2, 2, 4, 4, 5, 6}), (Pairs{{0, 1}, {0, 2}, {1, 2}, {4, 5}, {4, 6}, {5, 6}})) << format;
    EXPECT_EQ(rods({}), Pairs{}) << format;
    EXPECT_NE(import_error("a.ply", strip_file(format, {0, 1, -1, 2, 3, 4}))
                  .find("found a strip of 2 vertices in tristrips 0"),
              std::string::npos);
    EXPECT_NE(import_error("a.ply", strip_file(format, {0, 1, 7})).find("found vertex 7 in an edge or face"),
              std::string::npos);
    EXPECT_NE(import_error("a.ply", strip_file(format, {0, 1, -2})).find("found vertex -2"), std::string::npos);
  }
}

// ---- gro ----

TEST(ImportLeftOut, LaterFramesOfGroAreNamed) {
  const std::string frame = "t\n1\n    1SOL     OW    1   0.000   0.000   0.000\n   1.0 1.0 1.0\n";
  EXPECT_TRUE(import_text("a.gro", frame + "\n\n").left_out.empty());
  const Scene scene = import_text("a.gro", frame + frame);
  EXPECT_EQ(scene.system.num_points(), 1u);
  EXPECT_EQ(scene.left_out, (Names{"import: what stands behind the first frame of a.gro is not read"}));
}

// ---- pdb ----

/// Returns a line of an atom; `name` is its number, as it stands in columns 7 to 11.
std::string atom(const std::string& serial, int place, const std::string& chain = "A") {
  const std::string x = std::to_string(place) + ".000";
  return "ATOM  " + serial + "  C   ALA " + chain + "   1    " + std::string(8 - x.size(), ' ') + x +
         "   0.000   0.000  1.00  0.00           C\n";
}

std::vector<double> first_coordinates(const Scene& scene) {
  std::vector<double> x;
  for (std::size_t k = 0; k < scene.system.num_points(); ++k) x.push_back(scene.system.positions[3 * k]);
  return x;
}

TEST(ImportLeftOut, FramesOfPdbThatEndPartsAreNotMixed) {
  const Scene scene = import(R"("file": "import/frames_by_END.pdb", "bonds": "distance")");
  EXPECT_EQ(scene.system.num_points(), 3u);
  EXPECT_EQ(rods_of(scene).pairs.size(), 2u);
  EXPECT_EQ(scene.left_out,
            (Names{"import: what stands behind the first frame (2 more) of import/frames_by_END.pdb is not read"}));
}

TEST(ImportLeftOut, FramesOfPdbEndInAnyOfItsWays) {
  const std::string first = atom("    1", 0) + atom("    2", 1), second = atom("    1", 5) + atom("    2", 7),
                    bond = "CONECT    1    2\n", cell = "CRYST1   10.000   10.000   10.000  90.00  90.00  90.00\n",
                    other_cell = "CRYST1   20.000   20.000   20.000  90.00  90.00  90.00\n";
  const std::vector<std::string> texts{
      "MODEL        1\n" + first + "ENDMDL\nMODEL        2\n" + second + "ENDMDL\n" + bond + "END\n",
      "MODEL        1\n" + first + "MODEL        2\n" + second + "ENDMDL\n" + bond + "END\n",
      first + "ENDMDL\n" + second + "ENDMDL\n" + bond,
      first + bond + "END\n" + second + bond + "END\n",
      "MODEL        1\n" + first + "ENDMDL\n" + bond + "END\nMODEL        2\n" + second + "ENDMDL\n" + bond + "END\n",
      "END\n" + first + "TER\n" + bond + "END\n" + second,
      cell + first + bond + "END\n" + other_cell + second + "CONECT    1    9\nEND\n"};
  for (const std::string& text : texts) {
    const Scene scene = import_text("a.pdb", text);
    EXPECT_EQ(first_coordinates(scene), (std::vector<double>{0, 1})) << text;
    EXPECT_EQ(rods_of(scene).pairs, (Pairs{{0, 1}})) << text;
    EXPECT_EQ(scene.left_out, (Names{"import: what stands behind the first frame (1 more) of a.pdb is not read"}))
        << text;
    EXPECT_EQ(scene.system.cell->xx, text.starts_with(cell) ? 10.0 : 0.0) << text;
  }
}

TEST(ImportLeftOut, AtomsOfPdbWithLongNumbersAreRead) {
  EXPECT_EQ(import(R"("file": "import/serial_six_digits.pdb")").system.num_points(), 4u);
  // The number reaches to the left, or pushes the rest of the line to the right.
  for (const std::string& six :
       {std::string("ATOM 100000"), std::string("ATOM  100000"), std::string("HETATM100000")}) {
    const std::string text = atom("99999", 0) + six + atom("", 123).substr(6) + "CONECT99999 9999\n";
    EXPECT_EQ(first_coordinates(import_text("a.pdb", text.substr(0, text.find("CONECT")))),
              (std::vector<double>{0, 123}))
        << six;
  }
  const std::string seven = "ATOM  1000000" + atom("", 123).substr(6);
  EXPECT_EQ(first_coordinates(import_text("a.pdb", seven)), (std::vector<double>{123}));
  EXPECT_EQ(first_coordinates(import_text("a.pdb", "ATOM1000000" + atom("", 123).substr(6))),
            (std::vector<double>{123}));
  EXPECT_EQ(first_coordinates(import_text("a.pdb", atom("186a0", 1) + atom("A0000", 2) + atom("*****", 3))),
            (std::vector<double>{1, 2, 3}));
}

// A number of six digits that ends in the blank column 12 moves nothing: residues are no second places.
TEST(ImportLeftOut, LongNumbersOfPdbMayTakeABlankColumn) {
  std::string text;
  for (const std::string serial : {"99998 ", "99999 ", "100000", "100001", "100002"})
    text += "ATOM  " + serial + " C1  HOH A   1    -123.456-100.125-999.500  1.00  0.00           C\n";
  const Scene scene = import_text("a.pdb", text + "CONECT99999100002\n");
  ASSERT_EQ(scene.system.num_points(), 5u);
  EXPECT_EQ(scene.left_out, Names{"import: what joins atoms at one place (bonds: 1) of a.pdb is not read"});
  for (std::size_t k = 0; k < 15; k += 3) EXPECT_EQ(scene.system.positions[k], -123.456);
  EXPECT_EQ(import_error("a.pdb", "ATOM  100000 C1  HOH A   1        1      2      3\n"),
            "s.json: /import/file: a.pdb, line 1: found no three decimal points in columns 35, 43 and 51, nor up to 1 "
            "columns behind these, where the number of the atom is long");
}

TEST(ImportLeftOut, BondsOfPdbWithLongNumbersAreToldApartOrRefused) {
  const auto six = [&](const std::string& number, int place) { return "ATOM " + number + atom("", place).substr(6); };
  const std::string atoms = atom("99999", 0) + six("100000", 1) + six("100001", 2);
  const auto rods = [&](const std::string& line) { return rods_of(import_text("a.pdb", atoms + line)).pairs; };
  EXPECT_EQ(rods("CONECT100000100001\n"), (Pairs{{1, 2}}));
  EXPECT_EQ(rods("CONECT 99999100000\n"), (Pairs{{0, 1}}));
  EXPECT_EQ(rods("CONECT 99999 100000 100001\n"), (Pairs{{0, 1}, {0, 2}}));
  EXPECT_EQ(rods("CONECT99999100000\n"), (Pairs{{0, 1}}));
  EXPECT_EQ(rods("CONECT99999100000100001   \n"), (Pairs{{0, 1}, {0, 2}}));
  EXPECT_EQ(import_error("a.pdb", atoms + "CONECT99999100007\n"),
            "s.json: /import/file: a.pdb, line 4: found \"10000\", wanted the number of an atom above");
  // 1 stands at the left of its columns: it is the end of 100001.
  const std::string more = atom("10000", 3) + atom("    1", 4);
  EXPECT_EQ(rods_of(import_text("a.pdb", atoms + more + "CONECT99999100001\nCONECT    110000\n")).pairs,
            (Pairs{{0, 2}, {4, 3}}));
  // 11234 and 512345, or 112345 and 12345.
  const std::string many = six("112345", 0) + six("512345", 1) + atom("11234", 2) + atom("12345", 3);
  EXPECT_EQ(import_error("a.pdb", many + "CONECT11234512345\n"),
            "s.json: /import/file: a.pdb, line 5: found numbers of atoms that may be parted in several ways");
  EXPECT_EQ(rods_of(import_text("a.pdb", atom("186a0", 0) + atom("A0000", 1) + "CONECT186a0A0000\n")).pairs,
            (Pairs{{0, 1}}));
}

TEST(ImportLeftOut, RecordsAndSecondPlacesOfPdbAreNamed) {
  std::string second = atom("    2", 1);
  second[16] = 'B';
  std::string first = atom("    1", 0);
  first[16] = 'A';
  const Scene scene = import_text(
      "a.pdb", "HEADER    X\nREMARK   1\n" + first + second + "ANISOU    1\nANISOU    2\nTER\nSSBOND   1\nEND\n");
  EXPECT_EQ(scene.left_out,
            (Names{R"(import: what stands in records "HEADER", "ANISOU", "SSBOND" of a.pdb is not read)",
                   "import: what stands in second places of atoms (1) of a.pdb is not read"}));
}

TEST(ImportLeftOut, SectionsOfLammpsOfWhichNothingIsAskedAreNamed) {
  const std::string text =
      "a file\n\n4 atoms\n3 bonds\n1 angles\n1 dihedrals\n1 atom types\n2 bond types\n1 angle types\n1 dihedral types\n"
      "0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n\nBond Coeffs # harmonic\n\n1 1 1\n2 1 1\n\nAngle Coeffs # "
      "cosine\n\n1 "
      "2\n\nDihedral Coeffs # opls\n\n1 1 1 1 1\n\nAtoms # bond\n\n1 1 1 0 0 0\n2 1 1 1 0 0\n3 1 1 1 1 0\n4 1 1 1 1 "
      "1\n\nBonds\n\n1 1 1 2\n2 1 2 3\n3 2 3 4\n\nAngles\n\n1 1 1 2 3\n\nDihedrals\n\n1 1 1 2 3 4\n";
  const auto left_out = [&](const std::string& keys) {
    std::string all;
    for (std::string each : import_text("a.data", text, keys).left_out)
      all += each.substr(8, each.size() - 8 - std::string(" of a.data is not read").size()) + "; ";
    return all;
  };
  EXPECT_EQ(left_out(""),
            "the section Bond Coeffs; the section Angles; the section Angle Coeffs; the section Dihedrals; "
            "the section Dihedral Coeffs; ");
  EXPECT_EQ(left_out(R"(, "bonds": "energies", "angles": "energies", "dihedrals": "energies")"), "");
  EXPECT_EQ(left_out(R"(, "bonds": "energies", "types": [2], "angles": "energies", "dihedrals": "energies")"), "");
  EXPECT_EQ(left_out(R"(, "types": [2], "angles": "rigid", "dihedrals": "energies")"),
            "what joins atoms by bonds of other types (bonds: 2); the section Bond Coeffs; the section Angle Coeffs; ");
}

TEST(ImportLeftOut, ABoxThatIsNotFiniteIsNone) {
  const Scene pdb = import_text("a.pdb", "CRYST1      nan      nan      NaN    nan    nan    nan\n" + atom("    1", 0));
  EXPECT_FALSE(pdb.system.cell);
  EXPECT_EQ(pdb.left_out, Names{"import: the cell, which is not finite, of a.pdb is not read"});
  const Scene gro = import_text("a.gro", "t\n1\n    1SOL     OW    1   0.000   0.000   0.000\n nan nan nan\n");
  EXPECT_FALSE(gro.system.cell);
  EXPECT_EQ(gro.left_out, Names{"import: the box, which is not finite, of a.gro is not read"});
  EXPECT_NE(import_error("a.gro", "t\n1\n    1SOL     OW    1   0.000   0.000   0.000\n 1 nan 1\n").find("nan"),
            std::string::npos);
}

TEST(ImportLeftOut, ACellOfZerosOrBlanksIsNone) {
  const Scene scene = import(R"("file": "import/cryst1_zero.pdb")");
  EXPECT_EQ(scene.system.num_points(), 4u);
  EXPECT_EQ(rods_of(scene).pairs.size(), 2u);
  EXPECT_FALSE(scene.system.cell);
  for (const std::string cell : {"CRYST1\n", "CRYST1                                                P 1           1\n",
                                 "CRYST1    0.000    0.000    0.000  90.00  90.00  90.00 P 1           1\n",
                                 "CRYST1    1.000    1.000    1.000  90.00  90.00  90.00 P 1           1\n"})
    EXPECT_FALSE(import_text("a.pdb", cell + atom("    1", 0)).system.cell) << cell;
  EXPECT_EQ(
      import_text("a.pdb", "CRYST1   10.000    9.000    0.000  90.00  90.00  90.00\n" + atom("    1", 0)).system.cell->yy,
      9.0);
  EXPECT_EQ(import_error("a.pdb", "CRYST1   10.000    9.000    8.000                     \n" + atom("    1", 0)),
            "s.json: /import/file: a.pdb, line 1: found \"\", wanted a finite number in columns 34 to 40");
}

}  // namespace
}  // namespace tanor::scene
