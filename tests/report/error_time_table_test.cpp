#include "report/error_time.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "report/reading.hpp"

namespace tanor::report {
namespace {

/// The table has two methods of two rows each; the last one did not arrive.
ErrorTimeTable make_table() {
  ErrorTimeTable table{"s, \"t\"", "inline", 1.0, 1, {}, {}, {}, {}, "0123456789abcdef"};
  table.units.length = "mm";
  table.references = {{Method::Rk4, "taylor with rtol 1e-13", 0.0}, {Method::Taylor, "end.txt", {}}};
  for (const Method method : {Method::Rk4, Method::Taylor}) {
    for (const double error : {1e-3, 1e-6}) {
      table.rows.push_back(
          {.method = method, .step = 0.1, .steps = 10, .wall_s = 1.0 - error, .error = error, .trouble = {}});
    }
  }
  table.rows.back().error = NAN;
  table.rows.back().trouble = "event \"vertical\", at t = 1";
  return table;
}

TEST(ErrorTimeTableTest, CsvHoldsNoErrorOfARunThatDidNotArriveAndQuotesItsTrouble) {
  const Folder folder;
  write_error_time(folder.path(), make_table());

  const std::string csv = read_text(folder / "error_time.csv");

  EXPECT_TRUE(
      csv.ends_with("\ntaylor,0.1,0,10,0,0.999999,,0,0,0,0,\"event \"\"vertical\"\", at t = 1\",\"s, "
                    "\"\"t\"\"\",0123456789abcdef,\"mm\",\"\"\n"))
      << csv;
}

/// The page of a run of another scene says whose errors it shows.
TEST(ErrorTimeTableTest, PageNamesTheSceneOfErrorsThatAreNotItsOwn) {
  const Folder folder;
  const Json nothing = Json::array();
  EXPECT_EQ(read_error_time(folder.path(), "0123456789abcdef"), nothing);
  write_error_time(folder.path(), make_table());

  const Json rows = read_error_time(folder.path(), "0123456789abcdef");
  EXPECT_EQ(rows.at(0), Json({{"method", "rk4"}, {"wall_s", 0.999}, {"error", 0.001}}));
  EXPECT_EQ(rows.back(), Json({{"method", "taylor"}, {"wall_s", 0.999999}, {"error", nullptr}}));
  const Json of_another = read_error_time(folder.path(), "0123456789abcdee");
  EXPECT_EQ(of_another.size(), rows.size());
  EXPECT_EQ(of_another.at(0).at("method"), "rk4 (s, \"t\")");

  write_text(folder / "error_time.csv", "method,wall_s,error_m,scene,scene_checksum\nrk4,1,0.5,s,0123456789abcdef\n");
  EXPECT_EQ(read_error_time(folder.path(), "0123456789abcdef").at(0).at("error"), 0.5) << "a table of 0.2";
  write_text(folder / "error_time.csv", "method,wall_s,error_m\nrk4,1,1\n");
  EXPECT_EQ(read_error_time(folder.path(), "0123456789abcdef"), nothing) << "it may be of any scene";
}

TEST(ErrorTimeTableTest, AReferenceTellsItsErrorEvenWhereItIsZero) {
  const std::string text = format_error_time(make_table());

  EXPECT_NE(text.find("rk4 is compared with taylor with rtol 1e-13, whose own error is <= 0.0e+00 mm\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("taylor is compared with end.txt\n"), std::string::npos) << text;
}

/// rsvg-convert is a package of the program.
TEST(ErrorTimeTableTest, ThePictureIsAPngFile) {
  const Folder folder;
  const std::string no_picture = write_error_time(folder.path(), make_table());

  EXPECT_EQ(no_picture, "");
  EXPECT_EQ(read_text(folder / "error_time.png").substr(0, 8), "\x89PNG\r\n\x1a\n");
}

}  // namespace
}  // namespace tanor::report
