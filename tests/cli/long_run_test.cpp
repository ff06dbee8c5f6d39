/// A long run takes no more memory than a short one, with its frames, its page and its checkpoints.

#include "cli/shell.hpp"

namespace tanor::cli {
namespace {

#if TANOR_LIMITS_OF_MEMORY_WORK
TEST(LongRun, TakesNoMoreMemoryThanAShortOne) {
  const Folder folder;
  write_text(
      folder / "s.json",
      R"({"tanor_scene": 1, "points": {"positions": [[0, 0, 0], [1, 0, 0], [2, 0, 0]]}, "supports": [{"points": [0]}],
                 "constraints": [{"kind": "rod", "pairs": [[0, 1], [1, 2]]}],
                 "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
                 "motion": {"method": "rk4", "step": 1e-3, "t_end": 1, "output_every": 0.01}})");
  const auto megabytes_of = [&](const char* t_end) {
    rusage usage{};
    const Ended run = Program(folder, {"run", "s.json", "--quiet", "--report", "--t-end", t_end, "--checkpoint-every",
                                       "0.1", "--out", std::string("until_") + t_end})
                          .wait(&usage);
    EXPECT_EQ(run.code, 0) << run.err;
    return 1e-6 * 1024.0 * static_cast<double>(usage.ru_maxrss);
  };

  // The recording of a page is full after some thousand frames.
  const double of_short = megabytes_of("30"), of_long = megabytes_of("300");

  EXPECT_LT(of_long, of_short + 2.0);
}
#endif

}  // namespace
}  // namespace tanor::cli
