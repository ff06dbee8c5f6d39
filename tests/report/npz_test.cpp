/// The tests write trajectories for numpy and check how much memory and disk that takes.

#include <cmath>
#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>

#include "formats/npz_trajectory.hpp"
#include "report/output_file.hpp"
#include "report/reading.hpp"

namespace tanor::report {
namespace {

/// Returns a number of /proc/self/status in bytes; the largest resident set counts from `forget_peak` on.
double read_status(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(key + ":")) return 1024.0 * std::atof(line.substr(key.size() + 1).c_str());
  return 0.0;
}
void forget_peak() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

ShownParts show(std::size_t num_points) {
  ShownParts shown;
  shown.num_points = num_points;
  shown.is_support.resize(num_points);
  for (std::size_t k = 0; k < num_points; ++k) shown.points.push_back(static_cast<Index>(k));
  return shown;
}

TEST(NpzTest, WritingTakesNoMoreMemoryThanTheFrames) {
  constexpr std::size_t num_points = 100'000, frames = 12;
  const Folder folder;
  const ShownParts shown = show(num_points);
  std::vector<double> rows(3 * num_points);
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = std::sin(static_cast<double>(k));
  for (const bool is_compressed : {false, true}) {
    NpzTrajectory file(folder / "t.npz", &shown, is_compressed);
    for (std::size_t k = 0; k < (is_compressed ? 2 : frames); ++k)
      file.write({.number = k,
                  .time = 0.1 * static_cast<double>(k),
                  .positions = rows,
                  .velocities = rows,
                  .accelerations = rows});
    forget_peak();
    const double before = read_status("VmRSS");
    file.synchronize();
    // All frames together take 86 MB.
    EXPECT_LT(read_status("VmHWM") - before, 10e6);
  }
}

TEST(NpzTest, AFullDiskLeavesTheFileBefore) {
  const Folder folder;
  const ShownParts shown = show(2);
  const std::vector<double> rows{1, 2, 3, 4, 5, 6};
  NpzTrajectory file(folder / "t.npz", &shown, false);
  file.write({.time = 0.5, .positions = rows, .velocities = rows, .accelerations = rows});
  const std::string first = read_text(folder / "t.npz");
  EXPECT_GT(first.size(), 500u);
  // A folder stands in the place of the replacement.
  std::filesystem::create_directory(folder / "t.npz.part");
  EXPECT_THROW(file.synchronize(), WriteError);
  EXPECT_EQ(read_text(folder / "t.npz"), first);
  std::filesystem::remove(folder / "t.npz.part");
  std::filesystem::create_symlink("/dev/full", folder / "t.npz.part");
  EXPECT_THROW(file.synchronize(), WriteError);
  EXPECT_EQ(read_text(folder / "t.npz"), first);
}

TEST(NpzTest, GoesOnBehindItsFrames) {
  const Folder folder;
  const ShownParts shown = show(2);
  const std::vector<double> a{1, 2, 3, 4, 5, 6}, b{7, 8, 9, 10, 11, 12};
  const auto write = [&](NpzTrajectory* file, double time, const std::vector<double>& rows) {
    file->write({.time = time, .positions = rows, .velocities = rows, .accelerations = rows});
  };
  for (const bool is_compressed : {false, true}) {
    NpzTrajectory whole(folder / "whole.npz", &shown, is_compressed),
        parts(folder / "parts.npz", &shown, is_compressed);
    for (NpzTrajectory* each : {&whole, &parts}) write(each, 0.25, a);
    write(&whole, 0.5, b);
    whole.synchronize();
    parts.synchronize();
    NpzTrajectory again(folder / "parts.npz", &shown, is_compressed, 1);
    write(&again, 0.5, b);
    again.synchronize();
    EXPECT_EQ(read_text(folder / "parts.npz"), read_text(folder / "whole.npz"));
    EXPECT_THROW(NpzTrajectory(folder / "whole.npz", &shown, is_compressed, 3), InputError);
  }
}

}  // namespace
}  // namespace tanor::report
