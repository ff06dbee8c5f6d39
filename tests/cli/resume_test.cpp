#include <fmt/format.h>
#include <tanor/motion.hpp>

#include "cli/shell.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;
using report::read_xyz;

/// Returns a scene with all that depends on the initial positions (rods at a moving support, a bead on a moving sphere,
/// a spring at rest) and all that does work. Pair forces have no series in time, which `method` may need.
std::string moving_scene(const std::string& motion, Method method = Method::Auto) {
  const std::string pairs = R"({"kind": "pair", "law": "lj", "epsilon": 0.1, "sigma": 0.3, "exclude": "rods"},)";
  return R"({
    "tanor_scene": 1, "name": "moving",
    "points": {"positions": [[0,0,0], [0.3,0,0], [0.6,0,0.1], [0,1,0.5]],
               "velocities": [[0,0,0], [0.2,0,0], [0.2,0,0], [0,0.1,0]]},
    "supports": [{"points": [0], "motion": {"formula": ["0.2*t", "0", "0.1*t^2"]}}],
    "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0,1], [1,2]]},
                    {"name": "ball", "kind": "sphere", "points": [3], "center": {"formula": ["0", "1+0.1*t", "0"]}}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]},
               {"kind": "spring", "pairs": [[2,3]], "stiffness": 3},
               )" +
         (method == Method::Taylor ? "" : pairs) + R"(
               {"kind": "drag", "points": [1], "linear": 0.1}],
    "motion": {)" +
         motion + "}}";
}

/// Returns the summary without the keys that measure time or the work of resuming.
json without_work(json summary) {
  for (const char* key : {"wall_s", "factorizations", "solves"}) summary.erase(key);
  return summary;
}

/// Returns the members of "motion" that choose a method, with steps of `step` or of a tolerance.
std::string choose(Method method, const std::string& step) {
  return R"("method": ")" + std::string(name_of(method)) + "\", " +
         (has_fixed_steps(method) ? R"("step": )" + step : R"("rtol": 1e-10, "atol": 1e-12)");
}

std::vector<Method> list_methods() {
  std::vector<Method> all;
  for (const MethodTraits& each : methods()) all.push_back(each.method);
  return all;
}

class ResumeTest : public testing::TestWithParam<Method> {};

TEST_P(ResumeTest, ARunInTwoPartsEndsWhereOneRunDoesBitByBit) {
  const Folder folder;
  write_text(folder / "s.json",
             moving_scene(R"("t_end": 1, "output_every": 0.1, )" + choose(GetParam(), "0.0007"), GetParam()));

  EXPECT_EQ(run_program(folder, {"run", "s.json", "--out", "whole"}).code, 0);
  EXPECT_EQ(run_program(folder, {"run", "s.json", "--out", "parts", "--t-end", "0.3"}).code, 0);
  const Ended ended = run_program(folder, {"run", "s.json", "--out", "parts", "--resume"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json whole = read_json(folder / "whole/summary.json"), parts = read_json(folder / "parts/summary.json");
  EXPECT_GT(whole["steps"], 20);
  EXPECT_EQ(without_work(parts), without_work(whole));
  const auto frames = read_xyz(folder / "parts/trajectory.xyz");
  ASSERT_EQ(frames.size(), 11u) << "no frame twice, none missing";
  for (std::size_t k = 0; k < frames.size(); ++k) EXPECT_EQ(frames[k].time, 0.1 * static_cast<double>(k));
  EXPECT_EQ(read_text(folder / "parts/trajectory.xyz"), read_text(folder / "whole/trajectory.xyz"));
  EXPECT_EQ(read_text(folder / "parts/trajectory.pvd"), read_text(folder / "whole/trajectory.pvd"));
  ASSERT_EQ(list_names(folder / "whole/trajectory").size(), frames.size());
  for (const std::string& name : list_names(folder / "whole/trajectory"))  // the ball has the radius of the start
    EXPECT_EQ(read_text(folder / "parts/trajectory" / name), read_text(folder / "whole/trajectory" / name)) << name;
}

TEST(Resume, EventsOfBeforePassOnce) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "s",
    "points": {"positions": [[0,0,0], [1,0,0]], "masses": 1}, "supports": [{"points": [0]}],
    "constraints": [{"kind": "rod", "pairs": [[0,1]]}], "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
    "events": [{"name": "half", "when": "position(1).z < -0.5"},
               {"name": "low", "when": "position(1).z < -0.9", "do": "stop"}],
    "motion": {"t_end": 0.6, "output_every": 0.1}})");
  EXPECT_EQ(run_program(folder, {"run", "s.json", "--out", "o"}).code, 0);
  const json before = read_json(folder / "o/summary.json");
  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o", "--resume"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const json after = read_json(folder / "o/summary.json");
  EXPECT_DOUBLE_EQ(after["t_reached"], 0.6);
  EXPECT_EQ(after["passages"].size(), 2u);
  EXPECT_EQ(after["passages"], before["passages"]);
}

/// A signal comes at any step. The steps left until the next output time are those of the whole run. The end is chosen
/// when the signal has come, so that it comes in time on any machine.
TEST_P(ResumeTest, AnInterruptedRunEndsWhereOneRunDoesBitByBit) {
  const Folder folder;
  const double every = GetParam() == Method::Radau5 || GetParam() == Method::Rattle6 ? 10.0 : 50.0;  // these are slow
  write_text(folder / "s.json",
             pendulum(fmt::format(R"("t_end": 1e7, "output_every": {}, )", every) + choose(GetParam(), "0.0007")));

  Program program(folder, {"run", "s.json", "--out", "parts"});
  ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(folder / "parts/checkpoint"); }));
  kill(program.process(), SIGTERM);
  const Ended interrupted = program.wait();
  ASSERT_EQ(interrupted.code, 143) << interrupted.err;
  const double reached = read_json(folder / "parts/summary.json")["t_reached"];
  const std::string end = std::to_string(every * (std::floor(reached / every) + 2.0));
  const Ended ended = run_program(folder, {"run", "s.json", "--out", "parts", "--resume", "--t-end", end});
  ASSERT_EQ(ended.code, 0) << ended.err;
  ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "whole", "--t-end", end}).code, 0);

  EXPECT_EQ(without_work(read_json(folder / "parts/summary.json")),
            without_work(read_json(folder / "whole/summary.json")));
  for (const std::string name : {"trajectory.xyz", "trajectory.pvd"})
    EXPECT_EQ(read_text(folder / ("parts/" + name)), read_text(folder / ("whole/" + name))) << name;
  EXPECT_EQ(list_names(folder / "parts/trajectory"), list_names(folder / "whole/trajectory"));
}

INSTANTIATE_TEST_SUITE_P(Methods, ResumeTest, testing::ValuesIn(list_methods()),
                         [](const auto& info) { return std::string(name_of(info.param)); });

/// 3 * 0.1 is above 0.3 and 3 * 0.3 is below 0.9. The requested end is meant to be that output time.
TEST(ResumeTest, AnEndThatIsAnOutputTimeUpToRoundingIsAStepOfTheWholeRun) {
  for (const auto& [every, end] : {std::pair{"0.1", "0.3"}, {"0.1", "0.6"}, {"0.1", "0.7"}, {"0.3", "0.9"}}) {
    for (const std::string motion : {R"("method": "rk4", "step": 0.007)", R"("method": "dop853")"}) {
      const Folder folder;
      write_text(folder / "s.json", pendulum(R"("t_end": 1.2, "output_every": )" + std::string(every) + ", " + motion));
      ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "whole"}).code, 0);

      ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "parts", "--t-end", end}).code, 0);
      EXPECT_EQ(read_xyz(folder / "parts/trajectory.xyz").back().time,
                std::round(std::stod(end) / std::stod(every)) * std::stod(every));
      ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "parts", "--resume", "--t-end", end}).code, 0);
      ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "parts", "--resume"}).code, 0);

      EXPECT_EQ(read_text(folder / "parts/trajectory.xyz"), read_text(folder / "whole/trajectory.xyz"))
          << end << motion;
      EXPECT_EQ(without_work(read_json(folder / "parts/summary.json")),
                without_work(read_json(folder / "whole/summary.json")))
          << end << motion;
    }
  }
}

/// Multipliers start the next iteration, sticking contacts remember their place, and charts stand where the motion was.
TEST(ResumeTest, FrictionAndCoordinatesGoOnBitByBit) {
  const std::string points = R"json("tanor_scene": 1,
    "points": {"positions": [[0,0,0], [0.1,0,0], [0.1,0.1,0], [0.1,0.1,0.1]]},
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]},
               {"kind": "constant", "points": [3], "force": {"formula": ["8*sin(9*t)", "5*cos(7*t)", "0"]}}],)json";
  const std::string chain = points + R"json("supports": [{"points": [0]}],
    "coordinates": [{"kind": "chain_angles", "points": [1, 2, 3], "anchor": 0}],)json";
  const std::string floor = points + R"json("constraints": [{"name": "floor", "kind": "plane", "points": "all",
      "normal": {"formula": ["0", "0.1*sin(t)", "1"]}, "offset": 0}],
    "friction": [{"kind": "coulomb", "at": "floor", "coefficient": 0.2, "static_coefficient": 0.3}],)json";
  for (const std::string& scene : {chain, floor}) {
    for (const MethodTraits& method : methods()) {
      if (scene == chain ? !method.steps_in_coordinates : !method.serves_friction) continue;
      const std::string motion = choose(method.method, "0.0078125");
      const Folder folder;
      write_text(folder / "s.json",
                 "{" + scene + R"("motion": {"start": "project", "t_end": 2, "output_every": 0.25, )" + motion + "}}");

      ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "whole"}).code, 0) << scene << motion;
      ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "parts", "--t-end", "0.75"}).code, 0);
      ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "parts", "--resume"}).code, 0);

      EXPECT_EQ(without_work(read_json(folder / "parts/summary.json")),
                without_work(read_json(folder / "whole/summary.json")))
          << scene << motion;
    }
  }
}

TEST(ResumeTest, ARunThatWasInterruptedIsNotBegunAnewByMistake) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 1e5, "output_every": 1)"));
  Program program(folder, {"run", "s.json", "--out", "o"});
  ASSERT_TRUE(wait_for_frames(folder / "o", 4));
  kill(program.process(), SIGTERM);
  ASSERT_EQ(program.wait().code, 143);
  const std::string frames = read_text(folder / "o/trajectory.xyz");

  const Ended refused = run_program(folder, {"run", "s.json", "--out", "o", "--quiet"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_TRUE(contains(refused.err, "tanor: o: has this run, which was interrupted at t = ")) << refused.err;
  EXPECT_TRUE(contains(refused.err, "--resume goes on with it, --overwrite begins anew")) << refused.err;
  EXPECT_EQ(read_text(folder / "o/trajectory.xyz"), frames);
  EXPECT_EQ(run_program(folder, {"run", "s.json", "--out", "o", "--resume", "--overwrite"}).code, 2);

  const Words anew{"run", "s.json", "--out", "o", "--overwrite", "--quiet", "--t-end", "2"};
  EXPECT_EQ(run_program(folder, anew).code, 0);
  EXPECT_EQ(read_xyz(folder / "o/trajectory.xyz").size(), 3u);
  EXPECT_EQ(run_program(folder, {"run", "s.json", "--out", "o", "--quiet", "--t-end", "1"}).code, 0)
      << "what has reached its end is replaced";
}

TEST(ResumeTest, AFileThatIsGoneIsNamed) {
  for (const std::string name : {"trajectory.xyz", "trajectory.pvd", "trajectory/frame_000001.vtp"}) {
    const Folder folder;
    write_text(folder / "s.json", pendulum(R"("t_end": 1, "output_every": 0.25)"));
    ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "o", "--t-end", "0.5"}).code, 0);
    std::filesystem::remove(folder / ("o/" + name));

    const Ended ended = run_program(folder, {"run", "s.json", "--out", "o", "--resume"});

    EXPECT_EQ(ended.code, 2);
    EXPECT_TRUE(contains(ended.err, "tanor: o/" + name + ": is missing")) << ended.err;
  }
}

TEST(ResumeTest, CountsTheWorkOfAllParts) {
  const Folder folder;
  write_text(folder / "s.json", moving_scene(R"("t_end": 1, "method": "rk4", "step": 0.125)"));

  run_program(folder, {"run", "s.json", "--out", "o", "--t-end", "0.5"});
  run_program(folder, {"run", "s.json", "--out", "o", "--resume"});

  EXPECT_EQ(read_json(folder / "o/summary.json")["steps"], 8);
}

TEST(ResumeTest, AKilledRunGoesOn) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 1e5, "output_every": 0.125, "step": 0.0078125)"));
  Program program(folder, {"run", "s.json", "--out", "o", "--quiet"});
  ASSERT_TRUE(wait_for_frames(folder / "o", 4));
  kill(program.process(), SIGKILL);
  EXPECT_EQ(program.wait().code, 128 + SIGKILL);
  const std::size_t written = count_frames(folder / "o");
  // Half a frame at the end stands for what was being written, and must not matter.
  std::ofstream(folder / "o/trajectory.xyz", std::ios::app) << "3\nProperties=spec";

  const double end = 0.125 * static_cast<double>(written + 20);
  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o", "--resume", "--t-end", std::to_string(end)});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const auto frames = read_xyz(folder / "o/trajectory.xyz");
  ASSERT_EQ(frames.size(), written + 21);
  for (std::size_t k = 0; k < frames.size(); ++k) EXPECT_EQ(frames[k].time, 0.125 * static_cast<double>(k));
}

/// Compares the data sets of two H5MD files by h5py, since their bytes depend on when they were written.
Ended compare_h5(const Folder& folder, const std::string& a, const std::string& b) {
  return run_script(folder, "/usr/bin/python3 -c 'import h5py' || exit 77\n/usr/bin/python3 - " + a + " " + b +
                                R"py( <<'END'
import sys, h5py
def read(name):
    sets = {}
    def take(path, each):
        if isinstance(each, h5py.Dataset):
            sets[path] = (each.shape, str(each.dtype), each[()].tobytes())
    with h5py.File(name) as file:
        file.visititems(take)
    return sets
a, b = read(sys.argv[1]), read(sys.argv[2])
sys.exit(f"data sets {sorted(a)} and {sorted(b)}" if a.keys() != b.keys() or not a else
         next((f"{name} differs" for name in a if a[name] != b[name]), 0))
END
)py");
}

TEST(ResumeTest, AKilledRunHasTheFramesOfOneRunInEveryFormat) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 1e5, "output_every": 0.125, "step": 0.0078125,
    "trajectory": ["vtp", "lammps", "h5md", "csv", "npz"])"));
  if (contains(run_program(folder, {"run", "s.json", "--out", "tried", "--t-end", "0.1"}).err, "was built without"))
    GTEST_SKIP() << "without HDF5 or libzip";
  Program program(folder, {"run", "s.json", "--out", "o", "--quiet"});
  ASSERT_TRUE(wait_for_frames(folder / "o", 4));
  kill(program.process(), SIGKILL);
  EXPECT_EQ(program.wait().code, 128 + SIGKILL);
  const std::string end = std::to_string(0.125 * static_cast<double>(count_frames(folder / "o") + 20));

  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o", "--resume", "--t-end", end});
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_FALSE(contains(ended.err, "starts anew")) << ended.err;
  ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "whole", "--t-end", end}).code, 0);

  ASSERT_EQ(list_names(folder / "o"), list_names(folder / "whole"));
  for (const std::string name :
       {"trajectory.pvd", "trajectory.dump", "trajectory_rods.dump", "trajectory.csv", "trajectory.npz"})
    EXPECT_EQ(read_text(folder / "o" / name), read_text(folder / "whole" / name)) << name;
  const Ended compared = compare_h5(folder, "o/trajectory.h5", "whole/trajectory.h5");
  EXPECT_TRUE(compared.code == 0 || compared.code == 77) << compared.err;
}

/// Frames are rare and the run is long. The work since the last frame is not lost.
TEST(ResumeTest, ARunThatIsKilledBetweenFramesGoesOnFromThere) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 1e6, "step": 0.0078125, "method": "rk4")"));
  const auto time_of_checkpoint = [&] {
    const std::string text = read_text(folder / "o/checkpoint");
    const std::size_t begin = text.find('\n') + 1;
    return json::parse(text.substr(begin, text.find('\n', begin) - begin))["time"].get<double>();
  };
  Program program(folder, {"run", "s.json", "--out", "o", "--quiet", "--checkpoint-every", "0"});
  ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(folder / "o/checkpoint") && time_of_checkpoint() > 1; }));
  kill(program.process(), SIGKILL);
  EXPECT_EQ(program.wait().code, 128 + SIGKILL);
  const double reached = time_of_checkpoint();
  const std::string end = std::to_string(std::floor(reached) + 2.0);

  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o", "--resume", "--t-end", end});
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(run_program(folder, {"run", "s.json", "--out", "whole", "--t-end", end}).code, 0);

  EXPECT_EQ(read_text(folder / "o/trajectory.xyz"), read_text(folder / "whole/trajectory.xyz"));
  EXPECT_EQ(without_work(read_json(folder / "o/summary.json")), without_work(read_json(folder / "whole/summary.json")));
}

TEST(ResumeTest, WithoutACheckpointARunStartsAnew) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));

  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o", "--resume"});

  EXPECT_EQ(ended.code, 0);
  EXPECT_TRUE(contains(ended.err, "tanor: no checkpoint in o; starts anew\n")) << ended.err;
  EXPECT_EQ(read_json(folder / "o/summary.json")["t_reached"], 0.1);
}

TEST(ResumeTest, AFinishedRunHasNothingToDo) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.25, "output_every": 0.125)"));
  run_program(folder, {"run", "s.json", "--out", "o"});

  EXPECT_EQ(run_program(folder, {"run", "s.json", "--out", "o", "--resume"}).code, 0);

  EXPECT_EQ(read_xyz(folder / "o/trajectory.xyz").size(), 3u);
  EXPECT_EQ(read_json(folder / "o/summary.json")["t_reached"], 0.25);
}

TEST(ResumeTest, OtherScenesAndEarlierEndsAreRefused) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.2)"));
  run_program(folder, {"run", "s.json", "--out", "o"});
  const std::string summary = read_text(folder / "o/summary.json");

  EXPECT_TRUE(contains(complaint(folder, {"run", "s.json", "--out", "o", "--resume", "--t-end", "0.1"}),
                       "o: the run already reached t = 0.2,"));
  write_text(folder / "s.json", pendulum(R"("t_end": 0.3)"));
  EXPECT_TRUE(contains(complaint(folder, {"run", "s.json", "--out", "o", "--resume"}),
                       "o/checkpoint: is of an earlier version of the scene: s.json was changed; run without"));
  EXPECT_EQ(read_text(folder / "o/summary.json"), summary);
}

/// A run with two methods would be the motion of neither.
TEST(ResumeTest, OtherMethodsAndStepsAreRefusedByName) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.2, "method": "rk4", "step": 0.0125)"));
  write_text(folder / "same.json", read_text(folder / "s.json"));
  run_program(folder, {"run", "s.json", "--out", "o"});
  const auto refuse = [&](const std::string& scene, Words options) {
    options.insert(options.begin(), {"run", scene, "--out", "o", "--resume", "--t-end", "0.3"});
    return complaint(folder, options);
  };

  EXPECT_TRUE(contains(refuse("s.json", {"--method", "dopri5"}),
                       "o/checkpoint: is of a run with /motion/method rk4, not dopri5; run without --resume"));
  EXPECT_TRUE(contains(refuse("s.json", {"--step", "0.025"}),
                       "o/checkpoint: is of a run with /motion/step 0.0125, not 0.025; run without --resume"));
  EXPECT_TRUE(contains(refuse("same.json", {}),
                       "o/checkpoint: belongs to another scene, of s.json, not of same.json; run without --resume"));
  EXPECT_EQ(run_program(folder, {"run", "s.json", "--out", "o", "--resume", "--t-end", "0.3"}).code, 0);
}

TEST(ResumeTest, ATableThatWasChangedIsAnotherScene) {
  const Folder folder;
  write_text(folder / "drive.csv", "0,0,0,0\n1,0,0,0.1\n");
  write_text(folder / "s.json", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0], [0.1,0,0]]},
    "supports": [{"points": [0], "motion": {"table": "drive.csv"}}],
    "constraints": [{"kind": "rod", "pairs": [[0,1]]}], "motion": {"t_end": 0.2}})");
  run_program(folder, {"run", "s.json", "--out", "o"});

  write_text(folder / "drive.csv", "0,0,0,0\n1,0,0,0.2\n");

  EXPECT_TRUE(contains(complaint(folder, {"run", "s.json", "--out", "o", "--resume", "--t-end", "0.3"}),
                       "o/checkpoint: is of an earlier version of the scene: drive.csv was changed; run without"));
}

}  // namespace
}  // namespace tanor::cli
