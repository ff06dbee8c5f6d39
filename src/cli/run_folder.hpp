#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <tanor/motion.hpp>

#include "cli/folder_lock.hpp"
#include "report/checkpoint.hpp"
#include "report/recording.hpp"
#include "report/summary.hpp"
#include "report/trajectory.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

/// What a run knows before its folder exists.
struct RunPlan {
  using Clock = std::chrono::steady_clock;

  std::filesystem::path directory;
  std::unique_ptr<FolderLock> lock;          ///< of a folder that was there; a new run has not made it yet
  std::string fingerprint, scene_checksum;   ///< of the scene
  std::optional<report::Checkpoint> before;  ///< where it goes on; none: it starts anew
  Clock::time_point begin;                   ///< of the program
  Clock::duration checkpoint_every{};        ///< at most, where frames are rare
  bool has_html_page = false;                ///< report.html is asked for, and this program can make it
};

/// What a scene wants to be written of its motion.
report::TrajectoryOptions choose_trajectory(const scene::Scene& scene);

/// The folder of a run: its trajectory, its checkpoint and, at the end, its summary. A run that was resumed is told of
/// as one, over all its parts.
class RunFolder {
 public:
  /// Makes the folder, or takes its lock and the checkpoint from the plan; nothing is written before.
  RunFolder(RunPlan* plan, const scene::Scene& scene, const Simulation& simulation);

  /// Appends the simulation's state to the trajectory; every file is complete afterwards. The checkpoint follows at
  /// once, or, where frames come fast, so often that it takes a twentieth of the time.
  void write_frame(Simulation& simulation);
  /// The state at which a signal stopped the run between two output times, as a last frame. A run that goes on from
  /// here does not keep it: its frames are those of a run that was never stopped.
  void write_stop(Simulation& simulation);
  /// Where a run goes on: its page begins where the recording of the parts before does, or here where there is none.
  void take_resumed(Simulation& simulation);
  /// What the page keeps of a step (of some with a picture), and a checkpoint where the last one is old: of a
  /// simulation between two frames (null at a frame, which is to be written before).
  void take_step(const MotionReport& report, Simulation* between_frames);
  /// Keeps the last certificate, or the first one that failed, for the summary.
  void take_certificate(const Certificate& certificate);
  /// Writes what is due at the end, however the run ended (`stopped_by`: why before its time), and returns the page
  /// `report.txt`. A last checkpoint only
  /// where the simulation can go on, and stands where the last frame shows it: a checkpoint is never ahead of the
  /// frames.
  std::string finish(Simulation& simulation, const std::string& stopped_by, bool can_go_on);
  /// The motion has no more to find: nothing is lost where the run is begun anew.
  void give_up();

 private:
  void append_frame(Simulation& simulation);
  bool is_in_place() const;
  void remove_from_strange_folder(const char* file) const;
  void require_folder(const std::string& file) const;
  /// Replaces the checkpoint.
  void publish(Simulation& simulation);
  /// Replaces the page, for somebody who watches.
  void show(const Simulation& simulation);
  report::WallTimes measure_wall() const;

  std::filesystem::path directory_;
  std::unique_ptr<FolderLock> lock_;
  report::WallTimes earlier_;  ///< of the parts before this one
  RunPlan::Clock::time_point begin_;
  RunPlan::Clock::duration checkpoint_every_;
  report::RunFacts facts_;
  report::Trajectory trajectory_;
  std::optional<report::Recording> recording_;  ///< for report.html
  report::Checkpoint checkpoint_;
  RunPlan::Clock::time_point next_publication_;  ///< of the checkpoint, not before
  RunPlan::Clock::time_point due_;               ///< a checkpoint between frames, too
  RunPlan::Clock::time_point next_page_;         ///< of report.html, not before
  std::optional<double> last_frame_;             ///< its time, s, where no checkpoint has it yet
  double setup_ = 0.0, output_ = 0.0;            ///< s, of this part
};

}  // namespace tanor::cli
