#include "report/json_writer.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "report/reading.hpp"

namespace tanor::report {
namespace {

std::string write(const std::function<void(JsonWriter&)>& tell) {
  const Folder folder;
  OutputFile file(folder / "x.json");
  JsonWriter json(&file);
  tell(json);
  json.finish();
  file.close();
  return read_text(folder / "x.json");
}

RC_GTEST_PROP(JsonWriterTest, NumbersReadBackToTheSameBits, (std::uint64_t bits)) {
  const double number = std::bit_cast<double>(bits);
  RC_PRE(std::isfinite(number));

  const std::string text = write([&](JsonWriter& json) { json.value(number); });

  RC_ASSERT(std::bit_cast<std::uint64_t>(nlohmann::json::parse(text).get<double>()) == bits);
}

TEST(JsonWriterTest, WhatIsNotFiniteIsNull) {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> numbers{1.0, std::nan(""), infinity, -infinity};

  EXPECT_EQ(write([&](JsonWriter& json) { json.numbers(numbers); }), "[1, null, null, null]\n");
  EXPECT_EQ(write([&](JsonWriter& json) { json.rows(numbers, 2); }), "[\n  [1, null],\n  [null, null]]\n");
  EXPECT_EQ(write([&](JsonWriter& json) { json.value(std::optional<double>()); }), "null\n");
}

TEST(JsonWriterTest, MembersAndElementsKeepTheirOrder) {
  const std::string text = write([](JsonWriter& json) {
    json.begin_object();
    json.key("name").value("three beads");
    json.key("counts").begin_array().value(3).value(std::size_t{4}).value(true).end_array();
    json.key("nothing").begin_object().end_object();
    json.key("nobody").begin_array().end_array();
    json.key("unknown").null();
    json.end_object();
  });

  EXPECT_EQ(text, R"({
  "name": "three beads",
  "counts": [3, 4, true],
  "nothing": {},
  "nobody": [],
  "unknown": null
}
)");
}

TEST(JsonWriterTest, EveryTextReadsBack) {
  const std::string name = "a \"b\" \\ \n\t\x01 \u00e9 \u20ac \U0001F600";

  const std::string text = write([&](JsonWriter& json) { json.value(name); });

  EXPECT_EQ(nlohmann::json::parse(text).get<std::string>(), name);
}

// Lone and missing continuation bytes, an overlong slash, a surrogate, a code point beyond the last one.
TEST(JsonWriterTest, BytesThatAreNoUtf8AreReplaced) {
  for (const std::string bytes : {"\x80", "\xC3", "\xC0\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xFF"}) {
    const std::string text = write([&](JsonWriter& json) { json.value("a" + bytes); });

    const auto read = nlohmann::json::parse(text).get<std::string>();
    EXPECT_TRUE(read.starts_with("a\uFFFD")) << text;
  }
}

TEST(JsonWriterTest, ArraysMayBeMuchLongerThanTheBuffer) {
  std::vector<double> numbers(300'000);
  std::iota(numbers.begin(), numbers.end(), 0.5);

  const std::string text = write([&](JsonWriter& json) { json.rows(numbers, 3); });

  const auto read = nlohmann::json::parse(text).get<std::vector<std::array<double, 3>>>();
  ASSERT_EQ(read.size(), 100'000u);
  EXPECT_EQ(read.back()[2], numbers.back());
}

}  // namespace
}  // namespace tanor::report
