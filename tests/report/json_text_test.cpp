#include "report/json_text.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "report/page.hpp"
#include "report/reading.hpp"

namespace tanor::report {
namespace {

/// Returns the file of an object with one member.
std::string write(const Json& value) {
  const Folder folder;
  OutputFile file(folder / "x.json");
  JsonObjectFile json(&file);
  json.add("x", value);
  json.finish();
  file.close();
  return read_text(folder / "x.json");
}

nlohmann::json read_back(const Json& value) {
  return nlohmann::json::parse(write(value)).at("x");
}

RC_GTEST_PROP(JsonText, NumbersReadBackToTheSameBits, (std::uint64_t bits)) {
  const double number = std::bit_cast<double>(bits);
  RC_PRE(std::isfinite(number));

  RC_ASSERT(std::bit_cast<std::uint64_t>(read_back(number).get<double>()) == bits);
}

TEST(JsonText, NumbersHaveTheFewestDigitsThatReadBack) {
  EXPECT_EQ(write({0.1, 1e-10, 1.0 / 3.0, -0.0, 5e-324, std::size_t{1} << 60}),
            "{\n  \"x\": [0.1,1e-10,0.3333333333333333,-0.0,5e-324,1152921504606846976]\n}\n");
}

TEST(JsonText, WhatIsNotFiniteIsNull) {
  const double infinity = std::numeric_limits<double>::infinity();

  EXPECT_EQ(write({1.5, std::nan(""), infinity, -infinity}), "{\n  \"x\": [1.5,null,null,null]\n}\n");
  EXPECT_EQ(write(json_or_null(std::optional<double>())), "{\n  \"x\": null\n}\n");
  EXPECT_EQ(write(json_or_null("")), "{\n  \"x\": null\n}\n");
}

TEST(JsonText, MembersKeepTheirOrderAndHaveLinesOfTheirOwnAsRowsOfTablesHave) {
  const Json object = {{"name", "three beads"},
                       {"counts", {3, 4, true}},
                       {"table", {{1, 2}, {3, 4}}},
                       {"nothing", Json::object()},
                       {"nobody", Json::array()},
                       {"unknown", nullptr},
                       {"list", {{{"b", 1}, {"a", 2}}, {{"b", 3}, {"a", 4}}}}};

  EXPECT_EQ(write(object), R"({
  "x": {
    "name": "three beads",
    "counts": [3,4,true],
    "table": [
      [1,2],
      [3,4]
    ],
    "nothing": {},
    "nobody": [],
    "unknown": null,
    "list": [
      {"b":1,"a":2},
      {"b":3,"a":4}
    ]
  }
}
)");
}

TEST(JsonText, AnObjectWithoutMembersIsWritten) {
  const Folder folder;
  OutputFile file(folder / "x.json");
  JsonObjectFile(&file).finish();
  file.close();

  EXPECT_EQ(read_text(folder / "x.json"), "{}\n");
}

TEST(JsonText, EveryTextReadsBack) {
  const std::string name = "a \"b\" \\ \n\t\x01 \u00e9 \u20ac \U0001F600";

  EXPECT_EQ(read_back(name).get<std::string>(), name);
}

// The texts have lone and missing continuation bytes, an overlong slash, a surrogate, a code point beyond the last one.
TEST(JsonText, BytesThatAreNoUtf8AreReplaced) {
  for (const std::string bytes : {"\x80", "\xC3", "\xC0\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xFF"}) {
    EXPECT_TRUE(read_back("a" + bytes).get<std::string>().starts_with("a\uFFFD")) << write("a" + bytes);
  }
}

TEST(PageText, WhatIsRoundingBesideTheLargestNumberOfItsUnitIsZero) {
  const auto observed = [](const char* name, const char* unit, double value, Dimension dimension = Dimension::None) {
    Observed one;
    one.name = name;
    one.unit = unit;
    one.dimension = dimension;
    one.values = {value};
    one.least = one.largest = {{value, 0.0, ""}};
    return one;
  };
  const std::vector<Observed> all{observed("a", "N", 2e-15), observed("b", "N", -40.0), observed("c", "J", 2e-15),
                                  observed("d", "N", 2e-9)};
  EXPECT_EQ(format_observables(all, {}, nullptr), "  a  0 N\n  b  -40 N\n  c  2e-15 J\n  d  2e-09 N\n");
  using enum Dimension;
  const std::vector<Observed> without_letters{observed("a", "", 2e-15, Forces), observed("b", "", -40.0, Forces),
                                              observed("c", "", 2e-15, Moment), observed("d", "", 2e-15),
                                              observed("e", "", 3e-13, Length), observed("f", "", 5.0)};
  EXPECT_EQ(format_observables(without_letters, {}, nullptr),
            "  a  0\n  b  -40\n  c  2e-15\n  d  2e-15\n  e  3e-13\n  f  5\n");
  EXPECT_EQ(format_observables({&without_letters[4], 1}, {.positions = {0, 0, 0, 3, 4, 0}}, nullptr), "  e  0\n")
      << "beside the size of the scene";
}

}  // namespace
}  // namespace tanor::report
