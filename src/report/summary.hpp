#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

namespace tanor::report {

/// Wall clock of a run, s, over all its parts when it was resumed.
struct WallTimes {
  double total = 0.0, setup = 0.0, output = 0.0;
};

/// What is told about a run that a Simulation does not know itself.
struct RunFacts {
  std::string scene;                       ///< its name
  std::string source;                      ///< where its points come from
  std::string scene_checksum;              ///< as `make_scene_checksum` makes it
  std::vector<std::string> left_out;       ///< what acts in an imported file and not in the scene
  int threads = 1;                         ///< used
  double t_start = 0.0;                    ///< s, of the scene
  double t_end = 0.0;                      ///< asked for, s
  std::optional<double> t_resumed;         ///< s, where this part of the run began; none: at t_start
  bool has_started = true;                 ///< a start was found; else no state is known
  std::string stopped_by;                  ///< why it ended before t_end; empty: it did not, or goes on
  bool wants_certificate = true;           ///< at the end at least
  std::optional<Certificate> certificate;  ///< of the end, or the first one that failed
  std::size_t certificates = 0;            ///< made since the run began or was resumed
  WallTimes wall;
};

inline constexpr const char* summary_name = "summary.json";
/// What a run ended with, of all its points and equations in the order of the scene.
struct RunEnd {
  const System& system;
  const PlanSummary& plan;
  const MotionReport& report;
  std::optional<RankReport> rank;  ///< where a start was found
  double time;                     ///< s
  std::span<const double> positions, velocities, accelerations, multipliers, reactions, support_forces;
};

/// Writes `directory/summary.json` as docs/scene-format.md has it, and arrays above `largest_inline` points beside it.
void write_summary(const std::filesystem::path& directory, const RunFacts& facts, const RunEnd& end);
void write_summary(const std::filesystem::path& directory, const RunFacts& facts, Simulation& simulation);

/// The summary of a run or equilibrium, and the arrays that may lie beside it.
std::vector<std::filesystem::path> list_summary(const std::filesystem::path& directory);

}  // namespace tanor::report
