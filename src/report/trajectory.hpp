#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <tanor/motion.hpp>

#include "report/growing_file.hpp"
#include "report/shown_parts.hpp"
#include "report/xyz_trajectory.hpp"

namespace tanor::report {

/// How far a trajectory was written. A checkpoint keeps it, so that a resumed run goes on behind it.
struct TrajectoryMark {
  std::size_t frames = 0;
  std::uint64_t xyz_bytes = 0;
  std::uint64_t pvd_bytes = 0;  ///< of the list of frames, without its end
};

/// Removes the trajectory of an earlier run.
void remove_trajectory(const std::filesystem::path& directory);

/// The frames of a run in a folder: `trajectory.xyz`, and `trajectory.pvd` with `trajectory/frame_*.vtp`.
///
/// Everything there is readable whenever the program stops: a frame is complete before the list names it, and a frame
/// that could not be written is in none of the files.
class Trajectory {
 public:
  /// Starts anew in a folder without a trajectory. `chosen` names the points to show; empty: all points.
  Trajectory(const std::filesystem::path& directory, const System& system, std::span<const Index> chosen);
  /// Goes on behind a mark and removes what was written after it. Throws InputError where the files are not those of
  /// the mark.
  Trajectory(const std::filesystem::path& directory, const System& system, std::span<const Index> chosen,
             const TrajectoryMark& mark);

  /// Appends the simulation's present state. Throws WriteError; the files are then what they were before.
  void write_frame(const Simulation& simulation);
  /// Waits until the disk has both lists of frames.
  void synchronize();

  TrajectoryMark mark() const { return {frames_, xyz_.size(), list_.body_size()}; }

 private:
  std::filesystem::path directory_;
  ShownParts shown_;
  std::size_t frames_ = 0;
  GrowingFile list_;  ///< trajectory.pvd
  XyzTrajectory xyz_;
  std::vector<double> positions_, velocities_, accelerations_;  ///< of the shown points, one instant
};

}  // namespace tanor::report
