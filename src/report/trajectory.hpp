#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "report/frame_file.hpp"
#include "report/shown_parts.hpp"
#include "scene/periodic_cell.hpp"
#include "scene/trajectory.hpp"

namespace tanor::report {

/// How far a trajectory was written. A checkpoint keeps it, so that a resumed run goes on behind it.
struct TrajectoryMark {
  std::size_t frames = 0;
  std::map<std::string, std::uint64_t> files;  ///< FrameFile::mark of each, by its name
};

/// What a trajectory shows, and in which files.
struct TrajectoryOptions {
  std::vector<Index> points;  ///< empty: all
  scene::TrajectoryFormats formats;
  std::optional<scene::Cell> cell;  ///< periodic box
  std::string title;                ///< name of the scene
  double t_start = 0.0;             ///< s; of the motion, however often it was resumed
};

/// Throws InputError, naming /motion/trajectory or /motion/compression, where this program cannot write the formats, or
/// where `expected_frames` of a format that is kept in memory do not fit there.
void require_formats(const TrajectoryOptions& options, std::size_t num_points, double expected_frames);

/// What the trajectory of a run may have in its folder, whatever its formats.
std::vector<std::filesystem::path> list_trajectory(const std::filesystem::path& directory);
/// The frames `frame_<k>.vtp` that are in a folder.
std::vector<std::filesystem::path> list_frames(const std::filesystem::path& frames);

/// The frames of a run in a folder, in one or several formats (`trajectory.xyz`, …).
///
/// Everything there is readable whenever the program stops, and a frame that could not be written is in none of the
/// files.
class Trajectory {
 public:
  /// Starts anew in a folder without a trajectory.
  Trajectory(const std::filesystem::path& directory, const System& system, const TrajectoryOptions& options);
  /// Goes on behind a mark and removes what was written after it. Throws InputError where the files are not those of
  /// the mark.
  Trajectory(const std::filesystem::path& directory, const System& system, const TrajectoryOptions& options,
             const TrajectoryMark& mark);

  /// Appends the simulation's present state with its friction (3n, N; empty: there is none). Throws WriteError; the
  /// files are then what they were before.
  void write_frame(const Simulation& simulation, std::span<const double> friction = {});
  /// Makes all frames outlive the program and the machine.
  void synchronize();

  TrajectoryMark mark() const;

 private:
  void open_files(const std::filesystem::path& directory, const TrajectoryOptions& options, const TrajectoryMark& mark);
  void gather(const Simulation& simulation);

  std::unique_ptr<ShownParts> shown_;  ///< stays where it is: the files look at it
  std::vector<double> masses_;         ///< m, of the shown points
  bool has_held_points_ = false;
  double t_start_;
  std::size_t frames_ = 0;
  std::map<std::string, std::unique_ptr<FrameFile>> files_;
  std::vector<double> positions_, velocities_, accelerations_, forces_, reactions_, tensions_, guide_forces_,
      friction_;  ///< of the shown points, one instant
};

}  // namespace tanor::report
