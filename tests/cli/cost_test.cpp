/// The tests compare the prediction of `info` with the cost of a run.

#include "cli/shell.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// Makes the scene of a generator with its first point held.
json make_scene(const json& generate, const json& motion) {
  return {{"tanor_scene", 1},
          {"name", "scene"},
          {"generate", generate},
          {"supports", {{{"points", {0}}}}},
          {"forces", {{{"kind", "gravity"}, {"acceleration", {0, 0, -9.81}}}}},
          {"motion", motion},
          {"solver", {{"threads", 1}}}};
}

/// Returns the prediction of `info` for the method that it names.
json predict(const Ended& info) {
  const json told = json::parse(info.out);
  return told.at("predicted").at(told.at("method").get<std::string>());
}

struct CostCase {
  const char* name;
  json generate;
};

const CostCase large[] = {{"chain", {{"kind", "chain"}, {"count", 50000}}},
                          {"tree", {{"kind", "tree"}, {"count", 50000}}},
                          {"clusters", {{"kind", "clusters"}, {"clusters", 5000}, {"count", 10}}},
                          {"net", {{"kind", "net"}, {"columns", 100}, {"rows", 100}}},
                          {"lattice", {{"kind", "lattice"}, {"size", {16, 16, 16}}}}};

#if TANOR_LIMITS_OF_MEMORY_WORK
TEST(CostTest, PredictedMemoryIsThatOfTheRun) {
  for (const CostCase& given : large) {
    const Folder folder;
    write_text(folder / "s.json", make_scene(given.generate, {{"t_end", 0.002}}).dump());
    const Ended info = run_program(folder, {"info", "s.json", "--json"});
    ASSERT_EQ(info.code, 0) << info.err;

    rusage usage{};
    const Ended run = Program(folder, {"run", "s.json", "--quiet", "--out", "o"}).wait(&usage);

    ASSERT_EQ(run.code, 0) << run.err;
    const double predicted = 1e-6 * predict(info).at("bytes").get<double>();
    const double taken = 1e-6 * 1024.0 * static_cast<double>(usage.ru_maxrss);
    EXPECT_LT(predicted, 2.0 * taken) << given.name;
    EXPECT_GT(predicted, 0.5 * taken) << given.name;
  }
}
#endif

#if TANOR_LIMITS_OF_MEMORY_WORK
TEST(CostTest, ARunThatSurelyDoesNotFitIsRefusedBeforeItsFolderIsMade) {
  const Folder folder;
  const json motion = {{"t_end", 0.002}, {"method", "radau5"}};
  write_text(folder / "s.json", make_scene({{"kind", "lattice"}, {"size", {20, 20, 20}}}, motion).dump());

  const Ended ended = run_script(folder, "ulimit -v 1000000; tanor run s.json --out o");

  EXPECT_EQ(ended.code, 4) << ended.err;
  EXPECT_TRUE(contains(ended.err, "radau5 needs about")) << ended.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "o"));
}
#endif

TEST(CostTest, PredictedSolvesAreThoseOfTheRun) {
  const json small[] = {{{"kind", "chain"}, {"count", 100}},
                        {{"kind", "net"}, {"columns", 12}, {"rows", 12}},
                        {{"kind", "lattice"}, {"size", {5, 5, 5}}},
                        {{"kind", "clusters"}, {"clusters", 20}, {"count", 10}},
                        {{"kind", "tree"}, {"count", 100}}};
  for (const json& generate : small) {
    for (const char* method : {"taylor", "dop853", "dopri5", "rk4"}) {
      const Folder folder;
      json motion = {{"t_end", 0.1}, {"method", method}};
      if (std::string(method) == "rk4") motion["step"] = 0.002;
      write_text(folder / "s.json", make_scene(generate, motion).dump());
      const double predicted = predict(run_program(folder, {"info", "s.json", "--json"})).at("solves");

      ASSERT_EQ(run_program(folder, {"run", "s.json", "--quiet", "--out", "o"}).code, 0);

      const json summary = read_json(folder / "o/summary.json");
      const double taken =
          summary["solves"].get<double>() / (summary["steps"].get<double>() + summary["rejected"].get<double>());
      EXPECT_LT(predicted, 2.0 * taken) << generate << " " << method;
      EXPECT_GT(predicted, 0.5 * taken) << generate << " " << method;
    }
  }
}

TEST(CostTest, ScenesWithoutRoomAreRefusedBeforeAPointIsMade) {
  const Folder folder;
  for (const json& generate :
       {json{{"kind", "chain"}, {"count", 2000000000}}, json{{"kind", "net"}, {"columns", 40000}, {"rows", 50000}},
        json{{"kind", "clusters"}, {"clusters", 100000000}, {"count", 19}},
        json{{"kind", "melt"}, {"chains", 100000000}, {"count", 19}}}) {
    write_text(folder / "huge.json", make_scene(generate, {{"t_end", 1}}).dump());
    const std::string error = complaint(folder, {"info", "huge.json"}, 4);
    EXPECT_TRUE(contains(error, "points need")) << error;
    EXPECT_TRUE(contains(error, "GB of memory at least")) << error;
  }
}

}  // namespace
}  // namespace tanor::cli
