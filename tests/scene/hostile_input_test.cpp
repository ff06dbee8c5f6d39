/// Small files that ask for much: those that tests/fuzz found, and those that it cannot reach.

#include <stdexcept>

#include "scene/context.hpp"
#include "scene/reading.hpp"

namespace tanor::scene {
namespace {

constexpr std::size_t megabyte = 1 << 20;

std::string repeat(const std::string& text, std::size_t count) {
  std::string repeated;
  for (std::size_t k = 0; k < count; ++k) repeated += text;
  return repeated;
}

/// Expects one line that a terminal can hold.
void expect_short(const std::string& error) {
  EXPECT_EQ(error.find('\n'), std::string::npos);
  EXPECT_LT(error.size(), 1000u);
}

TEST(HostileInput, ListsMayBeNestedAHundredDeep) {
  EXPECT_EQ(error_of(repeat("[", megabyte)),
            "scene.json: found more than 100 lists and objects inside one another, wanted a scene");
  expect_short(error_of(repeat(R"({"a":)", megabyte / 5)));
  // A hundred nested lists are read and then found to be no scene.
  EXPECT_EQ(error_of(repeat("[", 100) + repeat("]", 100)), "scene.json: found a list of 1, wanted an object");
}

// The bytes continue a character that never began, so that a long word cannot be cut between two characters.
TEST(HostileInput, LongWordsOfBrokenCharactersAreCut) {
  const std::string word(300, '\x80');
  const Folder folder;
  folder.add("a.data", "a file of LAMMPS\n\n1 atoms\n1 atom types\n\nAtoms # atomic\n\n1 1 0 " + word + " 0\n");

  const std::string error =
      error_of(R"({"tanor_scene": 1, "import": {"file": "a.data"}})", folder.path() / "scene.json");

  EXPECT_NE(error.find("a.data, line 8: found \""), std::string::npos) << error;
  expect_short(error);
  expect_short(error_of("{" + word));
  expect_short(error_of(R"({"tanor_scene": )" + word));
}

// The scene is complete, so that a text behind its end has no place in it.
TEST(HostileInput, NumbersBehindTheEndOfTheSceneAreRefused) {
  for (const char* rest : {"nan", "1e999", "\"a b nan", "[nan]"}) {
    const std::string error = error_of(std::string("{\"tanor_scene\": 1} ") + rest);
    EXPECT_EQ(error.find("scene.json: line 1, column "), 0u) << error;
    EXPECT_NE(error.find("not JSON: "), std::string::npos) << error;
    expect_short(error);
  }
}

/// Messages of the parser quote the text, which may read like words of its own.
TEST(HostileInput, TextLikeAMessageOfTheParserIsNoMessage) {
  const std::string error = error_of("{ \"while parsing value}nan");
  EXPECT_NE(error.find("not JSON: syntax error while parsing object key"), std::string::npos) << error;
}

// scripts/fuzz found a name with a line break that the library quoted unchanged.
TEST(HostileInput, NamesOfTwoLinesAreToldOnOne) {
  EXPECT_EQ(error_of(three_points(R"("motion": {"t_end": 1, "method": "radau5\\\nva"})")).find('\n'),
            std::string::npos);
}

TEST(HostileInput, FormulasAreQuotedInPart) {
  for (const std::string& formula :
       {repeat("x+", megabyte / 2), repeat("(", megabyte), repeat("1", megabyte) + "e999", std::string(megabyte, 'a'),
        repeat("2^", megabyte / 2) + "2", repeat("-", megabyte)})
    expect_short(
        error_of(three_points(R"("forces": [{"kind": "formula", "points": "all", "x": ")" + formula + "\"}]")));
}

TEST(HostileInput, ParametersAreAThousandAtMost) {
  std::string parameters;
  for (int k = 0; k < 1001; ++k) parameters += (k > 0 ? ", \"a" : "\"a") + std::to_string(k) + "\": 1";

  EXPECT_EQ(error_of(three_points(R"("parameters": {)" + parameters + "}")),
            "scene.json: /parameters: found 1001 of them, wanted at most 1000");
}

// A group of "all" points takes thirty bytes of a file.
TEST(HostileInput, GroupsThatHaveNoRoomAreRefusedBeforeTheyTakeIt) {
  std::size_t num_named = 0;
  const Context context{.directory = {}, .files = nullptr, .parameters = {}, .num_named = &num_named};

  context.take_room(1000);
  EXPECT_EQ(num_named, 1000u);
  for (int k = 0; k < 10; ++k) context.take_room(100);
  EXPECT_EQ(num_named, 2000u);
  EXPECT_THROW(context.take_room(std::size_t{1} << 50), std::length_error);
}

}  // namespace
}  // namespace tanor::scene
