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
#include "scene/trajectory.hpp"

namespace tanor::report {

/// The position up to which a trajectory was written. A checkpoint stores it, and a resumed run continues there.
struct TrajectoryMark {
  std::size_t frames = 0;
  std::map<std::string, std::uint64_t> files;  ///< FrameFile::mark of each file, by its name
};

/// The content and the files of a trajectory.
struct TrajectoryOptions {
  std::vector<Index> points;  ///< empty: all points
  scene::TrajectoryFormats formats;
  std::optional<Cell> cell;             ///< periodic box
  std::vector<Observed> observables{};  ///< what is observed, without numbers
  Units units{};
  std::string title;     ///< name of the scene
  double t_start = 0.0;  ///< s; start of the motion, however often it was resumed
};

/// Throws InputError, naming /motion/trajectory or /motion/compression, if this program cannot write the formats, or if
/// `expected_frames` of a format that is kept in memory do not fit there.
void require_formats(const TrajectoryOptions& options, std::size_t num_points, double expected_frames);

/// Returns the names that files of a trajectory may have in a run's folder, for all formats.
std::vector<std::filesystem::path> list_trajectory(const std::filesystem::path& directory);
/// Returns the frames `frame_<k>.vtp` in a folder.
std::vector<std::filesystem::path> list_frames(const std::filesystem::path& frames);

/// Writes the frames of a run into a folder, in one or several formats (`trajectory.xyz`, …).
///
/// All files are readable whenever the program stops, and a frame that could not be written is in none of them.
class Trajectory {
 public:
  /// Starts a new trajectory in a folder that has none, or continues after a mark and removes what was written after
  /// it. Throws InputError if the files are not those of the mark.
  Trajectory(const std::filesystem::path& directory, const System& system, const TrajectoryOptions& options,
             const TrajectoryMark& mark = {});

  /// Appends the simulation's present state with its friction (3n, N; empty if there is none). Throws WriteError; the
  /// files are then what they were before.
  void write_frame(Simulation& simulation, std::span<const double> friction = {});
  /// Ensures that all frames outlive the program and the machine.
  void synchronize();

  TrajectoryMark mark() const;

 private:
  void open_files(const std::filesystem::path& directory, const TrajectoryOptions& options, const TrajectoryMark& mark);
  void gather(const Simulation& simulation);

  std::unique_ptr<ShownParts> shown_;  ///< has a fixed address, because the files point to it
  std::vector<double> masses_;         ///< m, of the shown points
  bool has_held_points_ = false;
  double t_start_;
  std::vector<Guide> without_picture_;
  std::size_t frames_ = 0;
  std::map<std::string, std::unique_ptr<FrameFile>> files_;
  std::vector<double> positions_, velocities_, accelerations_, forces_, reactions_, tensions_, guide_forces_,
      friction_;  ///< of the shown points, one instant
};

}  // namespace tanor::report
