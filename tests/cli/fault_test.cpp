#include <sys/file.h>

#include <algorithm>

#include <tanor/build_info.hpp>

#include "cli/shell.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;
using report::read_xyz;

/// Expects one line of the program on stderr and nothing else.
void expect_one_line(const Ended& ended, const std::string& what) {
  EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << what << ": " << ended.err;
  EXPECT_TRUE(ended.err.starts_with("tanor: ")) << what << ": " << ended.err;
}

// With descriptor 2 closed the trajectory would be opened as 2, and printed text would land in it.
TEST(DescriptorTest, ClosedDescriptorsAreNotGivenToTheResults) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(many_frames));
  ASSERT_EQ(run_script(folder, "tanor run s.json --out open").code, 0);

  for (const std::string closed : {"2>&-", "<&- 2>&-", "<&- >&- 2>&-", ">&- 2>&-", "<&-"}) {
    const bool has_output = !contains(closed, ">&- 2") && !contains(closed, "<&- >&-");
    EXPECT_EQ(run_script(folder, "tanor run s.json --out o " + closed).code, has_output ? 0 : 4) << closed;
    EXPECT_EQ(read_text(folder / "o/trajectory.xyz"), read_text(folder / "open/trajectory.xyz")) << closed;
    EXPECT_EQ(read_text(folder / "o/trajectory.pvd"), read_text(folder / "open/trajectory.pvd")) << closed;
    EXPECT_EQ(read_json(folder / "o/summary.json")["t_reached"], 1) << closed;
  }
}

TEST(OutputTest, AFullOrClosedOutputIsAFailureOfTheMachine) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
  write_text(folder / "m.csv", "0,0,0,0,0.1,0,0,0.2,0,0\n0.5,0,0,0,0.1,0,0,0.2,0,0\n1,0,0,0,0.1,0,0,0.2,0,0\n");

  for (const std::string command :
       {"--help", "--version", "run --help", "info s.json", "check s.json", "solve s.json", "run s.json",
        "forces s.json --motion m.csv", "error-time s.json --methods rk4 --quiet", "selftest"}) {
    for (const std::string output : {">/dev/full", ">&-"}) {
      if (command == "selftest" && output == ">&-") continue;  // selftest takes a second
      const Ended ended = run_script(folder, "tanor " + command + " " + output);
      EXPECT_EQ(ended.code, 4) << command << output << ended.err;
      EXPECT_TRUE(contains(ended.err, "tanor: cannot write standard output: ")) << command << output << ended.err;
    }
  }
}

// As `| head` goes when it has its lines: the exit code is that of SIGPIPE, and files are written to their ends.
TEST(OutputTest, AReaderWhoIsGoneIsNoFailureThatIsTold) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
  const auto run = [&](const std::string& command) {
    return run_script(folder,
                      "rm -f pipe; mkfifo pipe; true <pipe & exec 4>pipe; wait; tanor " + command + "; echo $?");
  };

  for (const std::string command :
       {"--help", "--version", "--methods --json", "help --json", "manual run", "info s.json", "check s.json",
        "solve s.json", "completion zsh", "run s.json --out o", "run s.json --json --out o"}) {
    const Ended ended = run(command + " >&4");
    EXPECT_EQ(ended.out, "141\n") << command;
    EXPECT_FALSE(contains(ended.err, "cannot write")) << command << ended.err;
    EXPECT_FALSE(contains(ended.err, "roken")) << command << ended.err;
  }
  EXPECT_TRUE(read_json(folder / "o/summary.json")["t_reached"] == 0.1);
  EXPECT_EQ(run_script(folder, "tanor run s.json --out whole").code, 0);
  for (const char* const file : {"trajectory.xyz", "trajectory.pvd"})
    EXPECT_EQ(read_text(folder / "o" / file), read_text(folder / "whole" / file)) << file;
  // A run whose messages nobody reads goes on.
  EXPECT_EQ(run("run s.json --out o 2>&4 >/dev/null").out, "0\n");
  // A pipe whose reader stops after a line, whatever the program has still to print.
  EXPECT_EQ(run_script(folder, "tanor --help | head -n 1 >line").err, "");
}

TEST(ProgramTest, IsLinkedLikeAnyOther) {
  const Folder folder;
  const std::string libraries = run_script(folder, "LD_TRACE_LOADED_OBJECTS=1 \"$TANOR\"").out;
  EXPECT_TRUE(contains(libraries, "libtanor.so")) << libraries;
  const Ended defined = run_script(folder, "nm -D --defined-only \"$TANOR\"");
  EXPECT_EQ(defined.code, 0) << defined.err;
  EXPECT_FALSE(contains(defined.out, " mmap")) << "mmap is that of the C library";
}

#if TANOR_LIMITS_OF_MEMORY_WORK
// Every command is tried with less memory than the libraries take, which the loader reports, up to enough memory for
// each.
TEST(MemoryTest, TooLittleMemoryEndsEveryCommandAtOnce) {
  const Folder folder;
  // On a machine with many processors the stacks of all threads would take more memory than the test gives.
  std::string scene = pendulum(R"("t_end": 0.1)");
  scene.insert(scene.rfind('}'), R"(, "solver": {"threads": 2})");
  write_text(folder / "s.json", scene);
  int answered = 0, refused = 0;

  for (int megabytes = 25; megabytes <= 400; megabytes += 25) {
    for (const std::string command : {"--version", "--help", "info s.json", "check s.json", "run s.json --quiet"}) {
      const std::string script = "ulimit -v " + std::to_string(1000 * megabytes) + "; tanor " + command;
      const Ended ended = run_script(folder, script);
      const bool is_loaded = ended.code != 127;
      EXPECT_TRUE(is_loaded || contains(ended.err, "error while loading shared libraries")) << ended.err;
      ASSERT_TRUE(ended.code == 0 || ended.code == 4 || !is_loaded) << script << ": " << ended.code << ended.err;
      if (ended.code == 4) expect_one_line(ended, script);
      ++(ended.code == 0 ? answered : refused);
    }
  }
  EXPECT_GE(refused, 5) << "the libraries take more than 25 MB";
  EXPECT_GE(answered, 5 * 8) << "200 MB are enough for two beads";
}
#endif

#if TANOR_LIMITS_OF_MEMORY_WORK
// BLAS, which SuiteSparseQR calls here, would ask for its work space forever. Without SuiteSparseQR nobody calls BLAS.
TEST(MemoryTest, BlasWithoutWorkSpaceEndsTheProgram) {
  const Folder folder;
  write_text(folder / "net.json", R"({"tanor_scene": 1,
    "generate": {"kind": "net", "columns": 40, "rows": 40}, "supports": [{"points": [0, 1599]}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
    "motion": {"t_end": 0.002, "output_every": 0.001}, "solver": {"threads": 2}})");
  int met = 0;

  for (int megabytes = 100; megabytes <= 400; megabytes += 50) {
    for (const std::string command : {"check net.json", "run net.json --quiet"}) {
      const std::string script = "ulimit -v " + std::to_string(1000 * megabytes) + "; tanor " + command;
      const Ended ended = run_script(folder, script);
      ASSERT_TRUE(ended.code == 0 || ended.code == 4) << script << ": " << ended.code << ended.err;
      EXPECT_EQ(contains(ended.err, "tanor: "), ended.code == 4) << script << ": " << ended.err;
      met += contains(ended.err, "work space of BLAS");
    }
  }
  EXPECT_EQ(met > 0, build_info().has_suitesparse_qr) << "the test is to meet what it is about";
}
#endif

/// Expects that the lists of frames and the frames have the same number and that no frame is half written. Returns the
/// number.
std::size_t count_whole_frames(const Folder& folder, const std::string& out) {
  const std::size_t frames = read_xyz(folder / (out + "/trajectory.xyz")).size();  // throws at half a frame
  const std::string list = read_text(folder / (out + "/trajectory.pvd"));
  EXPECT_TRUE(list.ends_with("</Collection>\n</VTKFile>\n")) << list;
  EXPECT_EQ(count(list, "<DataSet "), frames);
  EXPECT_EQ(list_names(folder / (out + "/trajectory")).size(), frames);
  return frames;
}

void expect_same_results(const Folder& folder, const std::string& out, const std::string& whole) {
  for (const std::string name : {"/trajectory.xyz", "/trajectory.pvd"})
    EXPECT_EQ(read_text(folder / (out + name)), read_text(folder / (whole + name))) << name;
  const Words frames = list_names(folder / (whole + "/trajectory"));
  ASSERT_EQ(list_names(folder / (out + "/trajectory")), frames);
  for (const std::string& frame : frames) {
    EXPECT_EQ(read_text(folder / (out + "/trajectory/" + frame)), read_text(folder / (whole + "/trajectory/" + frame)));
  }
  EXPECT_EQ(read_json(folder / (out + "/summary.json"))["final"],
            read_json(folder / (whole + "/summary.json"))["final"]);
}

// A file that may not grow beyond some blocks of 512 bytes stands for a full disk. The trajectory reaches the limit in
// the middle of a frame, and the small files do not reach it.
TEST(FullDiskTest, LeavesWholeFramesAndResumeGoesOnWithoutALostOne) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(many_frames));
  ASSERT_EQ(run_script(folder, "tanor run s.json --out whole").code, 0);
  const std::size_t bytes = read_text(folder / "whole/trajectory.xyz").size();

  for (const std::string ignored : {"", "trap '' XFSZ; "}) {
    for (const std::size_t blocks : {bytes / 1024, bytes / 768}) {
      const std::string out = "o" + std::to_string(blocks) + (ignored.empty() ? "" : "i");
      const Ended ended = run_script(
          folder, ignored + "ulimit -f " + std::to_string(blocks) + "; tanor run s.json --quiet --out " + out);
      EXPECT_EQ(ended.code, 4) << ended.err;
      EXPECT_TRUE(contains(ended.err, "cannot write " + out + "/trajectory.xyz: File too large")) << ended.err;
      const std::size_t frames = count_whole_frames(folder, out);
      EXPECT_GT(frames, 20u);
      EXPECT_LT(frames, 129u);

      const Ended resumed = run_script(folder, "tanor run s.json --quiet --resume --out " + out);
      EXPECT_EQ(resumed.code, 0) << resumed.err;
      EXPECT_EQ(count_whole_frames(folder, out), 129u);
      expect_same_results(folder, out, "whole");
    }
  }
}

// A folder has the name of a frame's file, so that this file cannot be written.
TEST(FullDiskTest, AFrameThatCannotBeWrittenIsInNoList) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(many_frames));
  ASSERT_EQ(run_script(folder, "tanor run s.json --out whole").code, 0);
  ASSERT_EQ(run_script(folder, "tanor run s.json --out o --t-end 0.5").code, 0);
  ASSERT_EQ(count_whole_frames(folder, "o"), 65u);
  std::filesystem::create_directories(folder / "o/trajectory/frame_000070.vtp/in_the_way");

  const Ended ended = run_script(folder, "tanor run s.json --quiet --resume --out o");

  EXPECT_EQ(ended.code, 4) << ended.err;
  EXPECT_EQ(read_xyz(folder / "o/trajectory.xyz").size(), 70u);
  EXPECT_EQ(count(read_text(folder / "o/trajectory.pvd"), "<DataSet "), 70u);
  std::filesystem::remove_all(folder / "o/trajectory/frame_000070.vtp");
  EXPECT_EQ(run_script(folder, "tanor run s.json --quiet --resume --out o").code, 0);
  expect_same_results(folder, "o", "whole");
}

TEST(CheckpointFileTest, AFlippedBitIsRefused) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(many_frames));
  ASSERT_EQ(run_script(folder, "tanor run s.json --out o --t-end 0.5").code, 0);
  const std::string good = read_text(folder / "o/checkpoint");

  for (std::size_t k = 0; k < 40; ++k) {
    const std::size_t place = k * (good.size() - 1) / 39;
    std::string bad = good;
    bad[place] = static_cast<char>(bad[place] ^ (1 << (k % 8)));
    write_text(folder / "o/checkpoint", bad);
    const std::string line = complaint(folder, {"run", "s.json", "--out", "o", "--resume"});
    EXPECT_TRUE(line.starts_with("tanor: o/checkpoint: ")) << line;
  }
  write_text(folder / "o/checkpoint", good);
  EXPECT_EQ(run_program(folder, {"run", "s.json", "--out", "o", "--resume"}).code, 0);
}

TEST(FolderTest, BelongsToOneRunAtATime) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 1e5, "output_every": 0.1, "step": 1e-3)"));
  Program first(folder, {"run", "s.json", "--out", "o", "--quiet"});
  ASSERT_TRUE(wait_for_frames(folder / "o", 4));

  for (const Words& words : {Words{"run", "s.json", "--out", "o"}, Words{"run", "s.json", "--out", "o", "--resume"}}) {
    const std::string line = complaint(folder, words, 4);
    EXPECT_TRUE(contains(line, "o: is in use by process " + std::to_string(first.process()) + " ")) << line;
  }
  EXPECT_EQ(kill(first.process(), 0), 0) << "the first one does not mind";
  // The lock goes with its process, however that ends.
  kill(first.process(), SIGKILL);
  first.wait();
  const std::string end = std::to_string(count_frames(folder / "o") + 20);  // later than any of them
  EXPECT_EQ(run_program(folder, {"run", "s.json", "--out", "o", "--resume", "--t-end", end}).code, 0);
  EXPECT_EQ(read_json(folder / "o/summary.json")["t_reached"], std::stod(end));
  for (const std::string& name : list_names(folder / "o")) EXPECT_FALSE(contains(name, "lock")) << name;
}

/// Every command that writes results holds its folder, or asks which process holds it.
TEST(FolderTest, BelongsToOneCommandAtATime) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 1e5, "output_every": 0.1, "step": 1e-3)"));
  write_text(folder / "m.csv", "0,0,0,0,0.1,0,0,0.2,0,0\n1,0,0,0,0.1,0,0,0.2,0,0\n");
  Program run(folder, {"run", "s.json", "--out", "o", "--quiet"});
  ASSERT_TRUE(wait_for_frames(folder / "o", 4));

  for (const Words& words :
       {Words{"equilibrium", "s.json", "--out", "o"}, Words{"modes", "s.json", "--out", "o"},
        Words{"forces", "s.json", "--motion", "m.csv", "--out", "o"},
        Words{"error-time", "s.json", "--methods", "rk4", "--t-end", "0.1", "--quiet", "--out", "o"},
        Words{"solve", "s.json", "--out", "o/summary.json"}}) {
    const std::string line = complaint(folder, words, 4);
    EXPECT_TRUE(contains(line, "o: is in use by process " + std::to_string(run.process()) + " (tanor run);")) << line;
  }
  for (const std::string& name : list_names(folder / "o"))
    EXPECT_FALSE(contains(name, "summary") || contains(name, "forces") || contains(name, "error")) << name;
  kill(run.process(), SIGKILL);
  run.wait();

  // This is what src/program/cli/folder_lock.cpp does in another command.
  write_text(folder / "o/.tanor.lock", "77 error-time\n");
  const int lock = open((folder / "o/.tanor.lock").c_str(), O_RDWR);
  ASSERT_EQ(flock(lock, LOCK_EX | LOCK_NB), 0);
  for (const Words& words : {Words{"run", "s.json", "--out", "o"}, Words{"run", "s.json", "--out", "o", "--resume"}})
    EXPECT_TRUE(contains(complaint(folder, words, 4), "o: is in use by process 77 (tanor error-time);"));
  close(lock);
}

TEST(FolderTest, CommandsOfOneSceneHaveFoldersOfTheirOwn) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
  ASSERT_EQ(run_program(folder, {"run", "s.json"}).code, 0);
  const Words written = list_names(folder / "s.out");

  ASSERT_EQ(run_program(folder, {"equilibrium", "s.json"}).code, 0);
  ASSERT_EQ(run_program(folder, {"modes", "s.equilibrium.out/equilibrium.json"}).code, 0);

  EXPECT_EQ(list_names(folder / "s.out"), written);
  EXPECT_EQ(list_names(folder.path()), (Words{"s.at_rest.modes.out", "s.equilibrium.out", "s.json", "s.out"}));
}

/// A run may be the work of hours, so that other commands do not replace its results.
TEST(FolderTest, FolderOfARunIsRefusedByOtherCommandsThatHaveASummary) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
  ASSERT_EQ(run_program(folder, {"equilibrium", "s.json", "--out", "rest"}).code, 0);
  ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "o"}).code, 0);
  const std::string summary = read_text(folder / "o/summary.json");
  const Words written = list_names(folder / "o");

  for (const Words& words :
       {Words{"equilibrium", "s.json", "--out", "o"}, Words{"modes", "rest/equilibrium.json", "--out", "o"}}) {
    const std::string line = complaint(folder, words);
    EXPECT_TRUE(contains(line, "o: has the results of a run, which tanor " + words[0] + " would replace")) << line;
  }
  EXPECT_EQ(read_text(folder / "o/summary.json"), summary);
  EXPECT_EQ(list_names(folder / "o"), written);
  EXPECT_EQ(run_program(folder, {"error-time", "s.json", "--methods", "rk4", "--out", "o", "--quiet"}).code, 0)
      << "files of their own names come beside";
}

TEST(FolderTest, NothingOfAnEquilibriumOrOfModesIsMixedIntoOtherResults) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
  const auto names_after = [&](const Words& words) {
    const Ended ended = run_program(folder, words);
    EXPECT_EQ(ended.code, 0) << words[0] << ended.err;
    Words names = list_names(folder / "o");
    std::erase(names, "report.html");  // which a tanor without node does not make
    return names;
  };
  const std::string at_rest = "o/equilibrium.json";

  EXPECT_EQ(names_after({"equilibrium", "s.json", "--modes", "2", "--out", "o"}),
            (Words{"equilibrium.json", "equilibrium.xyz", "observables.csv", "report.txt", "shapes.npy", "summary.json",
                   "trajectory", "trajectory.pvd"}));
  EXPECT_EQ(names_after({"modes", at_rest, "--count", "1", "--pictures", "--out", "o"}),
            (Words{"equilibrium.json", "mode_1", "mode_1.pvd", "observables.csv", "report.txt", "shapes.npy",
                   "summary.json", "trajectory", "trajectory.pvd"}));
  write_text(folder / "o/mode_7.pvd.txt", "of a user");
  EXPECT_EQ(names_after({"run", at_rest, "--trajectory", "csv", "--out", "o"}),
            (Words{"checkpoint", "equilibrium.json", "mode_7.pvd.txt", "observables.csv", "report.txt", "summary.json",
                   "trajectory.csv"}));
}

/// Otherwise the scene at rest of an earlier search would pass for that of a search that found none.
TEST(FolderTest, NoSceneAtRestIsLeftWhereNoneIsFound) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
  write_text(folder / "falls.json", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0]]},
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}]})");
  ASSERT_EQ(run_program(folder, {"equilibrium", "s.json", "--out", "o"}).code, 0);
  ASSERT_TRUE(std::filesystem::exists(folder / "o/equilibrium.json"));

  EXPECT_EQ(run_program(folder, {"equilibrium", "falls.json", "--out", "o"}).code, 3);

  EXPECT_FALSE(std::filesystem::exists(folder / "o/equilibrium.json"));
}

/// A file that the scene reads has the name of a result in the folder that the command would fill.
TEST(FolderTest, FilesThatACommandReadsAreNotReplaced) {
  const Folder folder;
  const std::string scene = pendulum(R"("t_end": 0.1)");
  const std::string table = "0,0,0,0\n1,0,0,0\n2,0,0,0\n";
  std::filesystem::create_directories(folder / "o");
  write_text(folder / "o/trajectory.csv", table);
  write_text(folder / "o/moved.json", R"({"tanor_scene": 1, "points": {"positions": [[0, 0, 0], [1, 0, 0]]},
    "supports": [{"points": [0], "motion": {"table": "trajectory.csv"}}],
    "constraints": [{"kind": "rod", "pairs": [[0, 1]]}], "motion": {"t_end": 1}})");
  write_text(folder / "o/equilibrium.json", scene);
  write_text(folder / "o/summary.json", scene);

  const auto expect_kept = [&](const Words& words, const std::string& name, const std::string& text) {
    const Ended ended = run_program(folder, words);
    EXPECT_EQ(ended.code, 2) << words[0];
    expect_one_line(ended, words[0]);
    EXPECT_TRUE(contains(ended.err, name + ": is read by this command, which would replace it")) << ended.err;
    EXPECT_EQ(read_text(folder / name), text);
  };
  expect_kept({"run", "o/moved.json", "--out", "o"}, "o/trajectory.csv", table);
  expect_kept({"run", "o/moved.json", "--out", "o", "--resume"}, "o/trajectory.csv", table);
  expect_kept({"run", "o/summary.json", "--out", "o"}, "o/summary.json", scene);
  expect_kept({"equilibrium", "o/equilibrium.json", "--out", "o"}, "o/equilibrium.json", scene);
  expect_kept({"modes", "o/summary.json", "--out", "o"}, "o/summary.json", scene);
  std::filesystem::create_hard_link(folder / "o/summary.json", folder / "linked.json");
  expect_kept({"run", "linked.json", "--out", "o"}, "linked.json", scene);
  write_text(folder / "scene.json", scene);
  std::filesystem::create_symlink("../scene.json", folder / "o/report.txt");
  expect_kept({"run", "o/report.txt", "--out", "o"}, "o/report.txt", scene);
  expect_kept({"solve", "o/moved.json", "--out", "o/moved.json"}, "o/moved.json", read_text(folder / "o/moved.json"));
  expect_kept({"solve", "o/moved.json", "--out", "./o/../o/trajectory.csv"}, "o/trajectory.csv", table);
}

TEST(FolderTest, ANewRunRemovesWhatAnOldOneLeftAndNothingElse) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 1e5, "output_every": 0.1, "step": 1e-3)"));
  ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "o", "--t-end", "0.5"}).code, 0);
  for (const std::string name : {"final_positions.npy", "final_support_forces.npy", "checkpoint.part",
                                 "summary.json.part", "trajectory/frame_000009.vtp.part"})
    write_text(folder / ("o/" + name), "of an old run");
  for (const std::string name : {"final_report.npy", "notes.txt", "trajectory/notes.txt", "picture.svg"})
    write_text(folder / ("o/" + name), "of a user");

  Program killed(folder, {"run", "s.json", "--out", "o", "--quiet"});
  ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(folder / "o/trajectory/frame_000007.vtp"); }));
  kill(killed.process(), SIGKILL);
  killed.wait();

  const Words names = list_names(folder / "o");
  for (const std::string name :
       {"report.txt", "summary.json", "final_positions.npy", "final_support_forces.npy", "summary.json.part"})
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 0) << name;
  // The new run may have been killed while it wrote a file of its own.
  if (std::filesystem::exists(folder / "o/checkpoint.part")) {
    EXPECT_NE(read_text(folder / "o/checkpoint.part"), "of an old run");
  }
  for (const std::string name : {"final_report.npy", "notes.txt", "trajectory/notes.txt", "picture.svg"})
    EXPECT_EQ(read_text(folder / ("o/" + name)), "of a user") << name;
}

TEST(FolderTest, ARunWithoutFramesForParaViewLeavesNoFolderOfThem) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
  ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "o"}).code, 0);
  ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "o", "--trajectory", "csv"}).code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "o/trajectory"));
}

TEST(SignalTest, EndsARunThatCanBeResumed) {
  for (const auto& [signal, name] : {std::pair{SIGINT, "SIGINT"}, {SIGTERM, "SIGTERM"}, {SIGHUP, "SIGHUP"}}) {
    const Folder folder;
    write_text(folder / "s.json", pendulum(R"("t_end": 1e5, "output_every": 0.1, "step": 1e-3)"));
    Program program(folder, {"run", "s.json", "--out", "o", "--quiet"});
    ASSERT_TRUE(wait_for_frames(folder / "o", 4));

    kill(program.process(), signal);
    const Ended ended = program.wait();

    EXPECT_EQ(ended.code, 128 + signal) << name;
    EXPECT_TRUE(contains(ended.err, std::string(name) + " came")) << ended.err;
    const double reached = read_json(folder / "o/summary.json")["t_reached"];
    EXPECT_EQ(read_xyz(folder / "o/trajectory.xyz").back().time, reached);
    const Ended resumed =
        run_program(folder, {"run", "s.json", "--out", "o", "--resume", "--t-end", std::to_string(reached + 1.0)});
    EXPECT_EQ(resumed.code, 0) << resumed.err;
  }
}

TEST(SignalTest, NohupIsRespected) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 1e5, "output_every": 0.1, "step": 1e-3)"));

  // Frames that come after the signal show that the run goes on. Another signal ends it.
  const Ended ended = run_script(folder, R"sh(trap '' HUP
    "$TANOR" run s.json --out o --quiet & process=$!
    wait_for_frame() { while ! test -e "o/trajectory/frame_$1.vtp"; do sleep 0.01; done; }
    wait_for_frame 000002
    kill -HUP $process
    set -- o/trajectory/*.vtp
    wait_for_frame "$(printf %06d $(($# + 2)))"
    kill -TERM $process
    wait $process)sh");

  EXPECT_EQ(ended.code, 128 + SIGTERM) << ended.err;
}

TEST(ReferenceFileTest, WrongContentsAreNamedByTheirPlace) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "s", "points": {"positions": [[0,0,0]]},
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"t_end": 1}})");
  const auto trouble = [&](const std::string& file, const std::string& text) {
    write_text(folder / file, text);
    return complaint(folder, {"error-time", "s.json", "--methods", "rk4", "--reference", file, "--quiet"});
  };
  const auto instant = [](const std::string& t, const std::string& r) {
    return R"({"dim": 2, "trajectory": [{"t": )" + t + R"(, "r": )" + r + "}]}";
  };

  for (const std::string dim : {"0", "-1", "1", "4", "2.5", "1e9", "null", "\"3\"", "[3]"}) {
    const std::string line = trouble("x.json", R"({"dim": )" + dim + R"(, "trajectory": [{"t": 1, "r": [0, 0, 0]}]})");
    EXPECT_TRUE(line.starts_with("tanor: x.json: /dim: found ")) << line;
  }
  for (const std::string number : {"\"1x\"", "\"nan\"", "\"inf\"", "\"\"", "\"1e999\"", "\"0x1p3\"", "null", "true"}) {
    EXPECT_TRUE(trouble("x.json", instant(number, "[0, 0]")).starts_with("tanor: x.json: /trajectory/0/t: found "))
        << number;
    EXPECT_TRUE(
        trouble("x.json", instant("1", "[0, " + number + "]")).starts_with("tanor: x.json: /trajectory/0/r/1: found "))
        << number;
  }
  EXPECT_EQ(trouble("x.json", instant("1", "[0, 0, 0]")),
            "tanor: x.json: /trajectory/0/r: found 3 numbers, wanted 2 for each point\n");
  EXPECT_EQ(trouble("x.json", instant("1", "[0]")),
            "tanor: x.json: /trajectory/0/r: found 1 number, wanted 2 for each point\n");
  EXPECT_TRUE(contains(trouble("x.json", instant("1", "[]")), "x.json: has 0 points at t = 1;"));
  EXPECT_TRUE(
      contains(trouble("x.json", R"({"trajectory": 3})"), "x.json: /trajectory: found number 3, wanted a list"));
  EXPECT_TRUE(
      contains(trouble("x.json", R"({"trajectory": [1]})"), "x.json: /trajectory/0: found number 1, wanted an"));
  EXPECT_TRUE(contains(trouble("x.json", "{}"), "x.json: /trajectory: missing"));
  EXPECT_TRUE(contains(trouble("x.json", "[]"), "x.json: found a list of 0, wanted an object"));
  EXPECT_TRUE(contains(trouble("x.json", R"({"trajectory": []})"), "has no state at t_end = 1; its times are none"));
  EXPECT_TRUE(contains(trouble("x.json", "{\"trajectory\": ["), "x.json"));
  for (const std::string word : {"1x", "nan", "inf", "1e999", "0x1"}) {
    EXPECT_TRUE(contains(trouble("x.txt", "1\n0 0 " + word + "\n"), "x.txt, line 2: found \"" + word + "\"")) << word;
  }
  EXPECT_TRUE(contains(trouble("x.txt", "1\n0 0 0\n0 0 0 0 0 0\n"), "x.txt, line 3: found 6 numbers, wanted 3"));
  std::string times;
  for (int k = 2; k < 100000; ++k) times += std::to_string(k) + "\n";
  EXPECT_TRUE(contains(trouble("x.txt", times), "its times are 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, … (99998 in all)"));
}

}  // namespace
}  // namespace tanor::cli
