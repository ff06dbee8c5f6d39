#include <cmath>
#include <cstdlib>
#include <sstream>

#include <gtest/gtest.h>

#include "cli/program.hpp"

// An instruction set is chosen once in a process by TANOR_ISA or --isa, so that each of these tests runs its own
// processes.

namespace tanor::cli {
namespace {

/// Sets TANOR_ISA for the processes of this test.
class Pinned {
 public:
  explicit Pinned(const std::string& set) { setenv("TANOR_ISA", set.c_str(), 1); }
  ~Pinned() { unsetenv("TANOR_ISA"); }
};

constexpr const char* scene = R"({"tanor_scene": 1,
  "generate": {"kind": "chain", "count": 400, "spacing": 0.1, "mass": 0.1, "direction": [1, 0.2, 0.1], "anchored": true},
  "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
  "motion": {"method": "dop853", "t_end": 0.05, "output_every": 0.05}})";

/// Returns the instruction sets of this processor.
Words list_sets() {
  Words result;
  for (const std::string set : {"baseline", "avx2", "avx512"}) {
    const Pinned pinned(set);
    const Ended ended = run_program(Folder(), {"--version"});
    if (ended.code == 0) {
      EXPECT_TRUE(contains(ended.out, "instruction set: " + set + "\n")) << ended.out;
      result.push_back(set);
    } else {
      EXPECT_EQ(ended.code, 2);
      EXPECT_TRUE(contains(ended.err, "TANOR_ISA asks for " + set)) << ended.err;
    }
  }
  return result;
}

/// Runs a motion and returns all its digits.
std::string move(const std::string& set, const std::string& threads) {
  const Folder folder;
  folder.add("chain.json", scene);
  const Ended ended = run_program(folder, {"run", "chain.json", "--isa", set, "--threads", threads, "--trajectory",
                                           "csv", "--out", "out", "--quiet"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  return read_text(folder / "out/trajectory.csv");
}

/// Returns the numbers of the last row alone, since the first rows hold the given numbers.
std::vector<double> last_numbers(const std::string& table) {
  std::istringstream row(table.substr(table.rfind('\n', table.size() - 2) + 1));
  std::vector<double> result;
  for (std::string number; std::getline(row, number, ',');) result.push_back(std::stod(number));
  return result;
}

TEST(InstructionSetTest, EachSetGivesTheSameBitsOnAnyNumberOfThreadsAndAllAgreeToRounding) {
  const Words sets = list_sets();
  ASSERT_FALSE(sets.empty());
  const std::string first = move(sets[0], "1");
  for (const std::string& set : sets) {
    const std::string alone = move(set, "1");
    EXPECT_TRUE(alone == move(set, "2")) << set;
    if (set == sets[0]) continue;
    EXPECT_TRUE(alone != first) << set << " is not taken";
    const std::vector<double> a = last_numbers(first), b = last_numbers(alone);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k)
      EXPECT_NEAR(a[k], b[k], 1e-8 * (1.0 + std::abs(a[k]))) << set << ' ' << k;
  }
}

TEST(InstructionSetTest, AnUnknownSetIsNamed) {
  const Folder folder;
  folder.add("chain.json", scene);
  EXPECT_TRUE(
      contains(complaint(folder, {"solve", "chain.json", "--isa", "mmx"}), "avx512, avx2 or baseline, not 'mmx'"));
  const Pinned pinned("sse9");
  EXPECT_TRUE(
      contains(complaint(folder, {"solve", "chain.json"}), "TANOR_ISA must be avx512, avx2 or baseline, not 'sse9'"));
}

}  // namespace
}  // namespace tanor::cli
