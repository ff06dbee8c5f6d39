#pragma once

#include <filesystem>
#include <vector>

#include "mpi/tanor_mpi.hpp"

namespace tanor::mpi {

/// Frames of positions that all ranks write together: `trajectory.npy`, [frame][point][3], m, and
/// `trajectory_times.npy`, [frame], s. The disk has both files completely after each frame.
class Trajectory {
 public:
  /// Starts anew. `keep_until` goes on behind the frames that stand there up to `time`.
  Trajectory(const MpiRanks& ranks, const std::filesystem::path& folder, const RankSystem& part,
             std::size_t num_points);
  void keep_until(double time);
  void write_frame(const Simulation& simulation);

 private:
  const MpiRanks& ranks_;
  std::filesystem::path folder_;
  std::vector<Index> points_;  // points that this rank writes, the first ones of its part
  std::size_t num_points_;
  std::vector<double> times_;
};

}  // namespace tanor::mpi
