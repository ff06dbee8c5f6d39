/// Disks that fill and folders that go away are injected with a file system of 256 kB, permissions, rm and mv.

#include "cli/shell.hpp"

namespace tanor::cli {
namespace {

using report::read_xyz;

const std::string endless = R"("t_end": 1e5, "output_every": 0.1, "step": 1e-3)";

/// Prefix of a command. Root may write everywhere, but without this capability the permissions of files hold for it,
/// too.
const std::string as_everybody =
    "without=; test $(id -u) != 0 || without='setpriv --bounding-set=-dac_override,-dac_read_search'; $without ";

TEST(PermissionTest, AFolderThatMayNotBeWrittenEndsTheRunBeforeItBegins) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(many_frames));

  const Ended ended = run_script(folder, "mkdir o; chmod 555 o; " + as_everybody + "\"$TANOR\" run s.json --out o");

  EXPECT_EQ(ended.code, 4) << ended.err;
  EXPECT_EQ(ended.err, "tanor: cannot write o/.tanor.lock: Permission denied\n");
  EXPECT_TRUE(list_names(folder / "o").empty());
  // The run can make no folder of its own either.
  const Ended inside = run_script(folder, as_everybody + "\"$TANOR\" run s.json --out o/inside");
  EXPECT_EQ(inside.code, 4) << inside.err;
  EXPECT_EQ(inside.err, "tanor: cannot write o/inside: Permission denied\n");
}

TEST(PermissionTest, ASceneThatMayNotBeReadIsBadInput) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(many_frames));

  const Ended ended = run_script(folder, "chmod 0 s.json; " + as_everybody + "\"$TANOR\" run s.json --out o");

  EXPECT_EQ(ended.code, 2) << ended.err;
  EXPECT_EQ(ended.err, "tanor: s.json cannot be read: Permission denied\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "o"));
}

// If a checkpoint cannot be replaced, the one before stays, and the frames that were written stay whole.
TEST(PermissionTest, AFolderThatIsLockedOnTheWayKeepsWholeFrames) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(endless));

  const Ended ended = run_script(folder, as_everybody + R"sh("$TANOR" run s.json --out o --quiet & process=$!
    while ! test -e o/trajectory/frame_000004.vtp; do sleep 0.01; done
    chmod 555 o o/trajectory
    wait $process; code=$?
    chmod 755 o o/trajectory
    exit $code)sh");

  EXPECT_EQ(ended.code, 4) << ended.err;
  EXPECT_TRUE(contains(ended.err, "Permission denied")) << ended.err;
  const std::size_t frames = read_xyz(folder / "o/trajectory.xyz").size();
  EXPECT_GE(frames, 5u);
  const std::string end = std::to_string(0.1 * static_cast<double>(frames + 3));
  EXPECT_EQ(run_script(folder, "tanor run s.json --quiet --resume --out o --t-end " + end).code, 0);
  EXPECT_EQ(run_script(folder, "tanor run s.json --quiet --out whole --t-end " + end).code, 0);
  EXPECT_EQ(read_text(folder / "o/trajectory.xyz"), read_text(folder / "whole/trajectory.xyz"));
}

TEST(VanishingFolderTest, EndsTheRunWithTheReason) {
  for (const auto& [trouble, option] : {std::pair<std::string, std::string>{"rm -r o", ""},
                                        {"mv o elsewhere", ""},
                                        {"mv o elsewhere && mkdir o", ""},
                                        {"mv o elsewhere && mkdir o", "--report"}}) {
    const Folder folder;
    write_text(folder / "s.json", pendulum(endless));

    const Ended ended = run_script(folder, R"sh("$TANOR" run s.json --out o --quiet )sh" + option + R"sh( & process=$!
      while ! test -e o/trajectory/frame_000004.vtp; do sleep 0.01; done
      while ! { )sh" + trouble + R"sh(; } 2>/dev/null; do true; done  # a frame may come while rm is on its way
      wait $process)sh");

    EXPECT_EQ(ended.code, 4) << trouble << ": " << ended.err;
    EXPECT_TRUE(contains(ended.err, "tanor: stopped at t = ")) << trouble << ": " << ended.err;
    EXPECT_TRUE(contains(ended.err, "cannot write o")) << trouble << ": " << ended.err;
    if (trouble.starts_with("rm")) {
      EXPECT_FALSE(std::filesystem::exists(folder / "o")) << "it is not made anew";
    } else {
      EXPECT_GE(read_xyz(folder / "elsewhere/trajectory.xyz").size(), 5u) << "what was written stays whole";
    }
    if (trouble.ends_with("mkdir o")) {
      EXPECT_EQ(list_names(folder / "o"), Words{}) << "a strange folder stays empty";
    }
  }
}

// The disk has 256 kB. Where this process may not mount one, FullDiskTest, which limits the length of files, stands for
// it.
TEST(SmallDiskTest, AFullDiskKeepsWholeFramesAndTheRunGoesOnWhereThereIsRoom) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(many_frames));
  ASSERT_EQ(run_script(folder, "tanor run s.json --quiet --out whole").code, 0);

  const Ended ended = run_script(folder, R"sh(mkdir disk
    unshare --mount true || exit 99
    export TANOR; unshare --mount sh -c 'mount -t tmpfs -o size=256k none disk || exit 99
      "$TANOR" run s.json --quiet --out disk/o; code=$?
      cp -r disk/o o
      exit $code')sh");
  if (ended.code == 99) GTEST_SKIP() << "this process may not mount a disk";

  EXPECT_EQ(ended.code, 4) << ended.err;
  EXPECT_TRUE(contains(ended.err, "No space left on device")) << ended.err;
  const std::size_t frames = read_xyz(folder / "o/trajectory.xyz").size();
  EXPECT_GT(frames, 10u);
  EXPECT_LT(frames, 129u);
  const Ended resumed = run_script(folder, "tanor run s.json --quiet --resume --out o");
  EXPECT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_EQ(read_text(folder / "o/trajectory.xyz"), read_text(folder / "whole/trajectory.xyz"));
  EXPECT_EQ(list_names(folder / "o/trajectory"), list_names(folder / "whole/trajectory"));
}

/// The disk has half of the room that the run takes.
TEST(SmallDiskTest, EveryFormatEndsWithTheReasonAndGoesOnWhereThereIsRoom) {
  for (const std::string format : {"lammps", "csv", "h5md", "npz"}) {
    const Folder folder;
    write_text(folder / "s.json", pendulum(many_frames));
    const Ended whole = run_script(folder, "tanor run s.json --quiet --out whole --trajectory " + format);
    if (contains(whole.err, "was built without")) continue;
    ASSERT_EQ(whole.code, 0) << whole.err;
    std::uintmax_t bytes = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "whole")) bytes += entry.file_size();

    const std::string options = "s.json --quiet --trajectory " + format + " --out ";
    const Ended ended = run_script(folder, R"sh(mkdir disk
      unshare --mount true || exit 99
      export TANOR; unshare --mount sh -c 'mount -t tmpfs -o size=)sh" +
                                               std::to_string(bytes / 2) +
                                               R"sh( none disk || exit 99
        "$TANOR" run )sh" + options + R"sh(disk/o; code=$?
        cp -r disk/o o
        exit $code')sh");
    if (ended.code == 99) GTEST_SKIP() << "this process may not mount a disk";
    EXPECT_EQ(ended.code, 4) << format << ended.err;
    EXPECT_TRUE(contains(ended.err, "cannot write disk/o/")) << format << ended.err;
    EXPECT_EQ(run_script(folder, "tanor run --resume " + options + "o").code, 0) << format;
    for (const std::string& name : list_names(folder / "whole")) {
      if (name.starts_with("trajectory") && format != "h5md") {  // the bytes of h5md depend on the order of writing
        EXPECT_EQ(read_text(folder / "o" / name), read_text(folder / "whole" / name)) << name;
      }
    }
    EXPECT_EQ(read_json(folder / "o/summary.json")["final"], read_json(folder / "whole/summary.json")["final"]);
  }
}

/// The name of a scene may be a sentence; its folder is where one looks for it, beside those of other files.
TEST(FolderTest, IsNamedByTheFileOfTheSceneAndLiesHere) {
  for (const auto& [file, made] :
       {std::pair{"scenes/a b.json", "a b.out"}, {"scenes/.hidden.json", "_hidden.out"}, {"scenes/a.b", "a.out"}}) {
    const Folder folder;
    std::filesystem::create_directory(folder / "scenes");
    write_text(folder / file, R"({"tanor_scene": 1, "name": "a ball / that falls", "points": {"positions": [[0,0,0]]},
      "motion": {"t_end": 1}})");
    ASSERT_EQ(run_program(folder, {"run", file, "--quiet"}).code, 0) << file;
    EXPECT_EQ(list_names(folder.path()), (Words{made, "scenes"}));
  }
}

TEST(FolderTest, OneRunWinsOfManyThatBeginAtOnce) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(endless));
  write_text(folder / "other.json", pendulum(R"("t_end": 1e5, "output_every": 0.25, "step": 1e-3)"));

  const Ended ended = run_script(folder, R"sh(for k in 1 2 3 4 5 6; do
      test $((k % 2)) = 0 && scene=s.json || scene=other.json
      ( "$TANOR" run $scene --out o --quiet 2>err$k; echo $? >code$k ) &
    done
    while ! test -e o/trajectory/frame_000004.vtp; do sleep 0.01; done
    while test $(ls code* 2>/dev/null | wc -l) -lt 5; do sleep 0.01; done
    kill -TERM $(cut -d " " -f 1 o/.tanor.lock)
    wait)sh");

  int winners = 0;
  for (int k = 1; k <= 6; ++k) {
    const std::string code = read_text(folder / ("code" + std::to_string(k)));
    if (code == "143\n") {
      ++winners;
      continue;
    }
    const std::string said = read_text(folder / ("err" + std::to_string(k)));
    EXPECT_EQ(code, "4\n") << said;
    EXPECT_TRUE(contains(said, "o: is in use by process"));
  }
  EXPECT_EQ(winners, 1);
  // All frames are those of one run, at its own times.
  const auto frames = read_xyz(folder / "o/trajectory.xyz");
  ASSERT_GE(frames.size(), 3u);
  for (std::size_t k = 1; k + 1 < frames.size(); ++k)
    EXPECT_NEAR(frames[k].time, static_cast<double>(k) * frames[1].time, 1e-9);
}

}  // namespace
}  // namespace tanor::cli
