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

/// The facts about a run that are known before its folder exists.
struct RunPlan {
  using Clock = std::chrono::steady_clock;

  std::filesystem::path directory;
  std::unique_ptr<FolderLock> lock;          ///< lock of a folder that exists; a new run has not made its folder yet
  std::string fingerprint, scene_checksum;   ///< of the scene
  std::optional<report::Checkpoint> before;  ///< where the run goes on; none if it starts anew
  Clock::time_point begin;                   ///< start of the program
  Clock::duration checkpoint_every{};        ///< longest time between checkpoints, where frames are rare
  bool has_html_page = false;                ///< report.html is asked for, and this program can make it
};

/// Returns what a scene wants to be written of its motion.
report::TrajectoryOptions choose_trajectory(const scene::Scene& scene);

/// The folder of a run: its trajectory, its checkpoint and, at the end, its summary. A resumed run is reported as one
/// run, over all its parts.
class RunFolder {
 public:
  /// Makes the folder, or takes its lock and the checkpoint from the plan. Nothing is written before.
  RunFolder(RunPlan* plan, const scene::Scene& scene, Simulation& simulation);

  /// Appends the simulation's state to the trajectory; every file is complete afterwards. The checkpoint follows at
  /// once, or, where frames come fast, as often as a twentieth of the time allows.
  void write_frame(Simulation& simulation);
  /// Writes the state at which a signal stopped the run between two output times, as a last frame. A run that goes on
  /// from here does not keep this frame, so its frames are those of a run that was never stopped.
  void write_stop(Simulation& simulation);
  /// Tells the page where a resumed run goes on. The page begins where the recording of the earlier parts does, or here
  /// if there is none.
  void take_resumed(Simulation& simulation);
  /// Records a step for the page, with a picture for some steps, and writes a checkpoint if the last one is old.
  /// `between_frames` is the simulation between two frames, and null at a frame, which is written right after the step.
  void take_step(const MotionReport& report, Simulation* between_frames);
  /// Keeps the last certificate, or the first one that failed, for the summary.
  void take_certificate(const Certificate& certificate);
  /// Writes what is due at the end, however the run ended, and returns the page `report.txt`. `stopped_by` says why the
  /// run ended early. A last checkpoint is written only if the simulation can go on and stands at the last frame,
  /// because a checkpoint is never ahead of the frames.
  std::string finish(Simulation& simulation, const std::string& stopped_by, bool can_go_on);
  /// Returns the last certificate, if there is one.
  const std::optional<Certificate>& certificate() const { return facts_.certificate; }
  /// Marks the run as ended, since its motion cannot go on; then nothing is lost if the run is begun anew.
  void give_up();

 private:
  void append_frame(Simulation& simulation);
  bool is_in_place() const;
  void remove_from_strange_folder(const char* file) const;
  void require_folder(const std::string& file) const;
  /// Replaces the checkpoint.
  void publish(Simulation& simulation);
  /// Replaces the page, for somebody who watches the run.
  void show(const Simulation& simulation);
  report::WallTimes measure_wall() const;

  std::filesystem::path directory_;
  std::unique_ptr<FolderLock> lock_;
  report::WallTimes earlier_;  ///< times of the parts before this one
  RunPlan::Clock::time_point begin_;
  RunPlan::Clock::duration checkpoint_every_;
  report::RunFacts facts_;
  report::Trajectory trajectory_;
  std::optional<report::Recording> recording_;  ///< for report.html
  report::Checkpoint checkpoint_;
  RunPlan::Clock::time_point next_publication_;  ///< earliest time of the next checkpoint
  RunPlan::Clock::time_point due_;               ///< latest time of the next checkpoint, also between frames
  RunPlan::Clock::time_point next_page_;         ///< earliest time of the next report.html
  std::optional<double> last_frame_;             ///< time of the last frame, s, if no checkpoint has it yet
  double setup_ = 0.0, output_ = 0.0;            ///< s, of this part
};

}  // namespace tanor::cli
