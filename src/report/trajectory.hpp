#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "report/shown_parts.hpp"
#include "report/xyz_trajectory.hpp"

namespace tanor::report {

/// How far a trajectory was written: what a checkpoint has to know to go on behind it.
struct TrajectoryMark {
  std::size_t frames = 0;
  std::uint64_t xyz_bytes = 0;
};

/// The frames of a run in a folder: `trajectory.xyz`, and `trajectory.pvd` with `trajectory/frame_*.vtp`.
///
/// Whenever the program stops, everything there is readable: frames are complete before a list names them.
class Trajectory {
 public:
  /// Starts anew; frames of an earlier run go. `chosen`: points to show, empty: all.
  Trajectory(const std::filesystem::path& directory, const System& system, std::span<const Index> chosen);
  /// Goes on behind a mark; what was written after it goes. Throws InputError where the files are not those of the
  /// mark.
  Trajectory(const std::filesystem::path& directory, const System& system, std::span<const Index> chosen,
             const TrajectoryMark& mark);

  /// Appends the simulation's present state.
  void write_frame(const Simulation& simulation);
  /// Rewrites the list of frames, `trajectory.pvd`.
  void write_collection();

  TrajectoryMark mark() const { return {entries_.size(), xyz_.size()}; }

 private:
  std::filesystem::path directory_;
  ShownParts shown_;
  std::vector<std::string> entries_;  ///< of the list of frames
  XyzTrajectory xyz_;
  std::vector<double> positions_, velocities_, accelerations_;  ///< of the shown points, one instant
};

}  // namespace tanor::report
