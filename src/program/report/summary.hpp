#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "report/json_text.hpp"
#include "report/motion_extent.hpp"
#include "scene/scene.hpp"

namespace tanor::report {

/// Wall clock of a run, s, over all its parts when it was resumed.
struct WallTimes {
  double total = 0.0, setup = 0.0, output = 0.0;
};

/// Facts of a run that a Simulation does not know itself.
struct RunFacts {
  std::string scene;                       ///< name of the scene
  std::string source;                      ///< origin of its points
  std::string scene_checksum;              ///< as `make_scene_checksum` makes it
  std::vector<std::string> left_out;       ///< what acts in an imported file but not in the scene
  int threads = 1;                         ///< used
  double t_start = 0.0;                    ///< s, start of the scene
  double t_end = 0.0;                      ///< requested end, s
  std::optional<double> t_resumed;         ///< s, where this part of the run began; none if at t_start
  bool has_started = true;                 ///< false: no start was found, and no state is known
  std::string stopped_by;                  ///< why it ended before t_end; empty if it did not or goes on
  bool wants_certificate = true;           ///< at the end at least
  std::optional<Certificate> certificate;  ///< certificate at the end, or the first one that failed
  std::size_t certificates = 0;            ///< made since the run began or was resumed
  std::optional<TensionScale> tensions;    ///< colours of report.html; none without it
  std::optional<Cell> cell;                ///< periodic box
  Json arrays{};                           ///< in files beside, which have no names: `axes` and `unit` of each
  WallTimes wall;
};

/// Returns what a scene tells of its run.
RunFacts facts_of(const scene::Scene& scene, int threads, bool has_started);

inline constexpr const char* summary_name = "summary.json";

/// All points and equations at the end of a run, in the order of the scene.
struct EndArrays {
  std::span<const double> positions, velocities, accelerations, multipliers, self_stress, reactions, support_forces;
};

/// The end of a run.
struct RunEnd {
  std::size_t contacts;  ///< with friction
  const PlanSummary& plan;
  const MotionReport& report;
  std::optional<RankReport> rank;   ///< none if no start was found
  double time;                      ///< s
  std::optional<EndArrays> arrays;  ///< none if no process holds those of all points
  std::span<const Observed> observables{};
  std::span<const Passage> passages{};
  Units units{};
  Json groups{};  ///< of constraints, `list_groups`; null if no process knows those of all ranks
};

/// Writes `directory/summary.json` as docs/scene-format.md describes it, and arrays above `largest_inline` points
/// beside it.
void write_summary(const std::filesystem::path& directory, const RunFacts& facts, const RunEnd& end);
void write_summary(const std::filesystem::path& directory, const RunFacts& facts, Simulation& simulation);

/// Returns the names that the summary of a run or equilibrium, and the arrays beside it, may have.
std::vector<std::filesystem::path> list_summary(const std::filesystem::path& directory);

}  // namespace tanor::report
