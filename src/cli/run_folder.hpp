#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include <tanor/motion.hpp>

#include "report/checkpoint.hpp"
#include "report/summary.hpp"
#include "report/trajectory.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

/// What a run knows before its folder exists.
struct RunPlan {
  using Clock = std::chrono::steady_clock;

  std::filesystem::path directory;
  std::string fingerprint;                   ///< of the scene
  std::optional<report::Checkpoint> before;  ///< where it goes on; none: it starts anew
  Clock::time_point begin;                   ///< of the program
};

/// The folder of a run: its trajectory, its checkpoint and, at the end, its summary. A run that was resumed is told of
/// as one, over all its parts.
class RunFolder {
 public:
  /// Makes the folder; nothing is written before.
  RunFolder(const RunPlan& plan, const scene::Scene& scene, const Simulation& simulation);

  /// Appends the simulation's state to the trajectory; every file is complete afterwards. The list of frames and the
  /// checkpoint follow at once, or, where frames come fast, so often that they take a twentieth of the time.
  void write_frame(const Simulation& simulation);
  /// Keeps the last certificate, or the first one that failed, for the summary.
  void take_certificate(const Certificate& certificate);
  /// Writes what is due at the end, however the run ended, and returns the page `report.txt`.
  std::string finish(const Simulation& simulation);

 private:
  /// Replaces the list of frames and the checkpoint.
  void publish(const Simulation& simulation);
  report::WallTimes measure_wall() const;

  std::filesystem::path directory_;
  report::WallTimes earlier_;  ///< of the parts before this one
  RunPlan::Clock::time_point begin_;
  report::RunFacts facts_;
  report::Trajectory trajectory_;
  report::Checkpoint checkpoint_;
  RunPlan::Clock::time_point next_publication_;  ///< not before
  double setup_ = 0.0, output_ = 0.0;            ///< s, of this part
};

}  // namespace tanor::cli
