/// The tests read files of other systems: byte-order marks, ends of lines, endings in capitals, packed files.

#include <algorithm>

#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

constexpr const char* square_obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
constexpr const char* square_ply =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
constexpr const char* chain_data =
    "a chain\n\n3 atoms\n2 bonds\n1 atom types\n1 bond types\n0 9 xlo xhi\n0 9 ylo yhi\n0 9 zlo zhi\n\nMasses\n\n1 "
    "2.5\n\n"
    "Atoms # molecular\n\n1 1 1 0 0 0\n2 1 1 1 0 0\n3 1 1 2 0 0\n\nBonds\n\n1 1 1 2\n2 1 2 3\n";
constexpr const char* water_gro =
    "water\n3\n    1SOL     OW    1   0.000   0.000   0.000\n    1SOL    HW1    2   0.100   0.000   0.000\n"
    "    1SOL    HW2    3  -0.033   0.094   0.000\n   2.0 2.0 2.0\n";
constexpr const char* water_pdb =
    "ATOM      1  O   HOH A   1       0.000   0.000   0.000  1.00  0.00           O\n"
    "ATOM      2  H1  HOH A   1       0.960   0.000   0.000  1.00  0.00           H\n"
    "CONECT    1    2\nEND\n";

struct Sample {
  const char* name;
  std::string text;
  std::size_t num_points, num_rods;
};
const std::vector<Sample> samples{{"a.obj", square_obj, 4, 4},
                                  {"a.ply", square_ply, 4, 4},
                                  {"a.data", chain_data, 3, 2},
                                  {"a.gro", water_gro, 3, 2},
                                  {"a.pdb", water_pdb, 2, 1}};

/// A .gro file has no bonds of its own.
std::string keys_for(const std::string& name) {
  return name.ends_with("gro") ? R"(, "bonds": "distance")" : "";
}
std::string with_ends(const std::string& text, const std::string& end) {
  std::string result;
  for (const char c : text) result += c == '\n' ? end : std::string(1, c);
  return result;
}

void expect_counts(const Scene& scene, std::size_t num_points, std::size_t num_rods, const std::string& what) {
  EXPECT_EQ(scene.system.num_points(), num_points) << what;
  EXPECT_EQ(rods_of(scene).pairs.size(), num_rods) << what;
  EXPECT_TRUE(scene.left_out.empty()) << what << ": " << scene.left_out[0];
}

TEST(ImportEncodings, EveryFormatHasAnyEndsOfLines) {
  for (const Sample& sample : samples) {
    for (const std::string end : {"\n", "\r\n", "\r", "\r\r\n"})
      expect_counts(import_text(sample.name, with_ends(sample.text, end), keys_for(sample.name)), sample.num_points,
                    sample.num_rods, sample.name);
    std::string last_open = with_ends(sample.text, "\r");
    last_open.pop_back();
    expect_counts(import_text(sample.name, last_open, keys_for(sample.name)), sample.num_points, sample.num_rods,
                  sample.name);
  }
}

TEST(ImportEncodings, AMarkOfUtf8IsNoPartOfTheFirstLine) {
  for (const Sample& sample : samples)
    for (const std::string end : {"\n", "\r"})
      expect_counts(import_text(sample.name, "\xEF\xBB\xBF" + with_ends(sample.text, end), keys_for(sample.name)),
                    sample.num_points, sample.num_rods, sample.name);
}

TEST(ImportEncodings, OtherEncodingsAndPackedFilesAreRefusedByName) {
  const auto widen = [](const std::string& text, std::size_t before, std::size_t behind) {
    std::string wide;
    for (const char c : text) wide += std::string(before, '\0') + c + std::string(behind, '\0');
    return wide;
  };
  for (const Sample& sample : samples) {
    const std::string place = std::string("s.json: /import/file: ") + sample.name + ": found a ",
                      wanted = ", wanted plain text in ASCII or UTF-8", &text = sample.text;
    EXPECT_EQ(import_error(sample.name, "\xFF\xFE" + widen(text, 0, 1)), place + "text in UTF-16" + wanted);
    EXPECT_EQ(import_error(sample.name, "\xFE\xFF" + widen(text, 1, 0)), place + "text in UTF-16" + wanted);
    EXPECT_EQ(import_error(sample.name, std::string("\xFF\xFE\0\0", 4) + widen(text, 0, 3)),
              place + "text in UTF-32" + wanted);
    EXPECT_EQ(import_error(sample.name, std::string("\0\0\xFE\xFF", 4) + widen(text, 3, 0)),
              place + "text in UTF-32" + wanted);
    EXPECT_EQ(import_error(sample.name, widen(text, 0, 1)),
              "s.json: /import/file: " + std::string(sample.name) + ", line 1: found a zero byte" + wanted);
    EXPECT_EQ(import_error(sample.name, "\x1F\x8B\x08" + text), place + "file packed by gzip" + wanted);
    EXPECT_EQ(import_error(sample.name, "BZh91AY&SY" + text), place + "file packed by bzip2" + wanted);
    EXPECT_EQ(import_error(sample.name,
                           "\xFD"
                           "7zXZ" +
                               text),
              place + "file packed by xz" + wanted);
    EXPECT_EQ(import_error(sample.name, "\x28\xB5\x2F\xFD" + text), place + "file packed by zstd" + wanted);
    EXPECT_EQ(import_error(sample.name, "PK\x03\x04" + text), place + "file packed by zip" + wanted);
  }
  EXPECT_EQ(import_error("data.chain.gz", "\x1F\x8B\x08 1"),
            "s.json: /import/file: data.chain.gz: found a file packed by gzip, wanted plain text in ASCII or UTF-8");
}

/// Numbers may begin with a byte that ends lines elsewhere: the first vertex is (2.6e-44, 0, 0), and its first byte is
/// LF or CR.
TEST(ImportEncodings, BinaryNumbersFollowTheHeaderAtOnce) {
  const auto file = [](const std::string& end, char first) {
    const std::string header = with_ends(
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty int x\nproperty int y\nproperty int z\n"
        "end_header\n",
        end);
    return header + first + std::string(11, '\0');
  };
  const auto x_of = [&](const std::string& end, char first) {
    return import_text("a.ply", file(end, first)).system.positions.at(0);
  };
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    EXPECT_EQ(x_of(end, '\n'), 10.0) << end.size();
    if (end == "\r\n") continue;  // LF behind it would end the line
    EXPECT_EQ(x_of(end, '\r'), 13.0) << end.size();
  }
}

TEST(ImportEncodings, FilesWithThemHaveTheirCounts) {
  expect_counts(import(R"("file": "import/bom_first_vertex.obj")"), 5, 4, "a mark");
  expect_counts(import(R"("file": "import/cr_line_ends2.obj")"), 4, 4, "old Mac");
}

TEST(ImportEncodings, TablesHaveThemToo) {
  const Folder folder;
  const auto masses = [&](const std::string& name, const std::string& text) {
    folder.add(name, text);
    return parse_scene(
               R"({"tanor_scene": 1, "points": {"positions": [[0,0,0],[1,0,0]], "masses": {"file": ")" + name + "\"}}}",
               folder / "s.json")
        .system.masses;
  };
  const std::vector<double> wanted{2.0, 3.5};
  EXPECT_EQ(masses("a.csv",
                   "\xEF\xBB\xBF"
                   "2\r3.5\r"),
            wanted);
  EXPECT_EQ(masses("b.csv", "2\r\n3.5"), wanted);
}

TEST(ImportFormats, EndingsInCapitalsAndOtherEndings) {
  EXPECT_EQ(import(R"("file": "import/SQUARE.OBJ")").source, "import: import/SQUARE.OBJ (obj)");
  EXPECT_EQ(import(R"("file": "import/UPPER.GRO", "bonds": "none")").system.num_points(), 3u);
  expect_counts(import(R"("file": "import/pdb1eth.ent")"), 3, 2, "ent");
  EXPECT_EQ(import_text("A.PLY", square_ply).system.num_points(), 4u);
  EXPECT_EQ(import_text("A.Ent", water_pdb).source, "import: A.Ent (pdb)");
  // Files of LAMMPS end in anything; their header tells them.
  for (const std::string name : {"data.chain", "chain.lammps", "chain", "CHAIN.DATA", "a.b.c"})
    expect_counts(import_text(name, chain_data), 3, 2, name);
}

TEST(ImportFormats, AnEndingThatTellsNothingIsRefused) {
  const std::string xyz = "3\nwater\nO 0 0 0\nH 1 0 0\nH 0 1 0\n", stl = "solid a\nfacet normal 0 0 1\n",
                    cif = "data_1ABC\nloop_\n_atom_site.id\n";
  for (const auto& [name, text] : {std::pair<std::string, std::string>{"a.xyz", xyz},
                                   {"a.stl", stl},
                                   {"a.cif", cif},
                                   {"b.stl", std::string(99, '\0')},
                                   {"a", ""}})
    EXPECT_EQ(import_error(name, text), "s.json: /import/format: missing, and neither the ending of \"" + name +
                                            "\" nor a line \"… atoms\" of lammps-data tells it, wanted one of "
                                            "lammps-data, obj, ply, gro, pdb");
}

}  // namespace
}  // namespace tanor::scene
