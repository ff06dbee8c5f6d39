#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "cli/program.hpp"

namespace tanor::cli {
namespace {

constexpr const char* beads =
    R"({"tanor_scene": 1, "points": {"positions": [[0,0,0], [1,0,0], [5,5,0]], "masses": [0, 1, 1]},
  "supports": [{"name": "hook", "points": [0]}], "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
  "constraints": [{"name": "rod", "kind": "rod", "pairs": [[0,1]]},
                  {"name": "floor", "kind": "plane", "points": [2], "normal": [0,0,1]}], "motion": {"t_end": 0.1}, )";

/// A key of a scene, and a part of the error that it gives.
struct Asked {
  const char *observe, *error;
};
const Asked asked[] = {
    {R"json("observe": ["moment(hook)"])json",
     R"json(/observe/0: formula "moment(hook)": column 1: a moment needs an axis)json"},
    {R"json("observe": ["pressure()"])json",
     R"json(column 1: pressure needs a periodic cell, and the system has none)json"},
    {R"json("observe": ["tension(rdo)"])json", "no constraints or forces are named 'rdo' (did you mean rod?)"},
    {R"json("events": [{"when": "t > 0.1", "do": "break", "of": "floor[0]"}])json",
     "/events/0/do: 'floor[0]' is a plane and does not break"},
    {R"json("events": [{"when": "t > 0.1", "do": "release", "of": "flor[0]"}])json",
     "/events/0/of: no constraints or supports or forces are named 'flor' (did you mean floor?)"},
    {R"json("events": [{"when": "t > 0.1", "do": "stop", "of": "rod[0]"}])json",
     "/events/0/of: belongs to events that break or release something"},
    {R"json("events": [{"when": "t > 0.1", "do": "release", "of": "hook"}])json",
     "point 0 is a support without mass and cannot be let go"},
    {R"json("events": [{"when": "any tension(rdo) > 20", "do": "stop"}])json",
     R"json(/events/0/when: formula "any tension(rdo) > 20": column 13: no)json"},
    {R"json("events": [{"when": "any force(floor).z > 20", "do": "break"}])json",
     "/events/0/do: 'floor[0]' is a plane and does not break"},
    {R"json("events": [{"when": "moment(hook, z) > 20", "do": "break"}])json",
     "/events/0/do: 'hook[0]' is a support and does not break"},
    {R"json("observe": [{"name": "t", "what": "kinetic()"}])json",
     R"json(/observe/0/name: "t" is the name of the time)json"},
    {R"json("observe": [{"name": "a\nb", "what": "kinetic()"}])json",
     R"(/observe/0/name: the name "a\x0ab" holds a line break or another control character)"},
    {R"json("observe": ["sum reaction([1, 2, 1])"])json",
     R"json(/observe/0: formula "sum reaction([1, 2, 1])": column 14: it names point 1 twice)json"},
    {R"json("observe": ["distance(1, 1)"])json", "column 13: a distance is that of two different points"},
    {R"json("observe": ["angle(1, 0, 1)"])json", "column 13: an angle is that of three different points"},
    {R"json("events": [{"name": "e", "when": "t > 0.1"}, {"name": "e", "when": "t > 0.2"}])json",
     R"json(/events/1/name: two events have the name "e")json"},
    {R"json("events": [{"name": "t > 0.2", "when": "t > 0.1"}, {"when": "t > 0.2"}])json",
     R"json(/events/1: two events have the name "t > 0.2")json"},
};

/// Names that no scene has, and quantities that lack what they are measured about, are refused before the run.
TEST(ObserveErrors, NameWhatAndWhereInOneLineAndEndWithTwo) {
  for (const Asked& each : asked) {
    const Folder folder;
    write_text(folder / "s.json", std::string(beads) + each.observe + "}");
    const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});
    EXPECT_EQ(ended.code, 2) << each.observe;
    EXPECT_NE(ended.err.find(each.error), std::string::npos) << ended.err;
    EXPECT_EQ(std::ranges::count(ended.err, '\n'), 1) << ended.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "o"));
  }
}

}  // namespace
}  // namespace tanor::cli
