#include "scene/number_table.hpp"

#include <limits>

#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

std::string table_error(const std::string& name, const std::string& content) {
  const Folder folder;
  try {
    read_number_table(folder.add(name, content));
  } catch (const InputError& error) {
    return error.where().empty() ? error.what() : error.where() + ": " + error.what();
  }
  return "no error";
}

/// Returns a NumPy file of version 1.0; the header is not padded.
std::string npy(const std::string& description, const std::vector<double>& numbers) {
  std::string text =
      std::string("\x93NUMPY\x01", 7) + '\0' + static_cast<char>(description.size()) + '\0' + description;
  return text.append(reinterpret_cast<const char*>(numbers.data()), sizeof(double) * numbers.size());
}

TEST(NumberTable, ReadsCommaSeparatedValues) {
  const Folder folder;

  const NumberTable table = read_number_table(folder.add("a.csv", "t, x\r\n\r\n0,+1.5\r\n 1e0 ,-2e-3\n\n"));

  EXPECT_EQ(table.rows, 2u);
  EXPECT_EQ(table.columns, 2u);
  EXPECT_EQ(table.values, (std::vector<double>{0.0, 1.5, 1.0, -2e-3}));
}

TEST(NumberTable, NeedsNoHeader) {
  const Folder folder;

  EXPECT_EQ(read_number_table(folder.add("a.csv", "1\n2\n3")).values, (std::vector<double>{1, 2, 3}));
}

TEST(NumberTable, NamesLineAndValueOfAWrongNumber) {
  EXPECT_EQ(table_error("a.csv", "t,x\n0,1\n1,two\n"), "a.csv, line 3: found \"two\", wanted a finite number");
  EXPECT_EQ(table_error("a.csv", "0,1\n1,\n"), "a.csv, line 2: found \"\", wanted a finite number");
  EXPECT_EQ(table_error("a.csv", "0,1\n1,nan\n"), "a.csv, line 2: found \"nan\", wanted a finite number");
  EXPECT_EQ(table_error("a.csv", "0,1\n1,1e999\n"), "a.csv, line 2: found \"1e999\", wanted a finite number");
  EXPECT_EQ(table_error("a.csv", "0,1\n1,2;3\n"), "a.csv, line 2: found \"2;3\", wanted a finite number");
}

TEST(NumberTable, NamesTheLineThatHasOtherColumns) {
  EXPECT_EQ(table_error("a.csv", "0,1\n1,2,3\n"), "a.csv, line 2: found 3 columns, wanted 2 as in the first row");
}

TEST(NumberTable, TakesTinyNumbersForZero) {
  const Folder folder;

  EXPECT_EQ(read_number_table(folder.add("a.csv", "1e-999")).values, std::vector<double>{0.0});
}

TEST(NumberTable, ReadsNumPyFiles) {
  const Folder folder;

  const NumberTable matrix = read_number_table(
      folder.add("a.npy", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }", {1, 2, 3, 4, 5, 6})));
  const NumberTable vector =
      read_number_table(folder.add("b.npy", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }", {7, 8})));

  EXPECT_EQ(matrix.rows, 2u);
  EXPECT_EQ(matrix.columns, 3u);
  EXPECT_EQ(matrix(1, 0), 4.0);
  EXPECT_EQ(vector.rows, 2u);
  EXPECT_EQ(vector.columns, 1u);
  EXPECT_EQ(vector.values, (std::vector<double>{7, 8}));
}

TEST(NumberTable, RefusesOtherNumPyFiles) {
  EXPECT_EQ(table_error("a.npy", "1,2,3"), "a.npy: wanted a NumPy file");
  EXPECT_EQ(table_error("a.npy", npy("{'descr': '<i8', 'fortran_order': False, 'shape': (1,), }", {1})),
            "a.npy: wanted numbers of type '<f8' (float64)");
  EXPECT_EQ(table_error("a.npy", npy("{'descr': '<f8', 'fortran_order': True, 'shape': (1,1), }", {1})),
            "a.npy: wanted an array in C order");
  EXPECT_EQ(table_error("a.npy", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (1,1,1), }", {1})),
            "a.npy: wanted an array with one or two dimensions");
  EXPECT_EQ(table_error("a.npy", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }", {1})),
            "a.npy: wanted as many numbers as its shape says");
  EXPECT_EQ(table_error("a.npy", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }",
                                     {1, std::numeric_limits<double>::infinity()})),
            "a.npy, row 1: found inf, wanted a finite number");
  EXPECT_EQ(table_error("a.npy", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (1,), }", {1, 2})),
            "a.npy: wanted as many numbers as its shape says");
}

/// Returns a scene whose first support follows the table.
std::string driven_scene(const std::string& more = "") {
  return three_points(R"("supports": [{"points": [0], "motion": {"table": "a.csv"}}])" + more);
}

std::string driven_error(const std::string& table, const std::string& more = "") {
  const Folder folder;
  folder.add("a.csv", table);
  return error_of(driven_scene(more), folder / "scene.json");
}

TEST(TimeTable, NeedsFourColumnsForAVector) {
  EXPECT_EQ(
      driven_error("0,1\n1,2\n"),
      "scene.json: /supports/0/motion/table: found string \"a.csv\", wanted a table of 4 columns (t and 3 more) and "
      "2 rows or more, this one has 2 and 2");
}

TEST(TimeTable, NeedsTimesThatGrow) {
  EXPECT_EQ(driven_error("0,0,0,0\n1,0,0,0\n1,0,0,0\n"),
            "scene.json: /supports/0/motion/table: found string \"a.csv\", wanted a table whose times grow, here 1 is "
            "followed by 1");
}

TEST(TimeTable, CoversTheMotion) {
  EXPECT_EQ(
      driven_error("0.5,0,0,0\n1,0,0,0\n"),
      "scene.json: /supports/0/motion/table: found string \"a.csv\", wanted a table from t = 0 to t_end = 0, this "
      "one has 0.5 to 1");
  EXPECT_EQ(
      driven_error("0,0,0,0\n1,0,0,0\n", R"(, "motion": {"t_end": 2})"),
      "scene.json: /supports/0/motion/table: found string \"a.csv\", wanted a table from t = 0 to t_end = 2, this "
      "one has 0 to 1");
}

TEST(TimeTable, PassesOnWhatIsWrongInTheFile) {
  EXPECT_EQ(driven_error("0,0,0,0\n1,0,x,0\n"),
            "scene.json: /supports/0/motion/table: a.csv, line 2: found \"x\", wanted a finite number");
}

}  // namespace
}  // namespace tanor::scene
