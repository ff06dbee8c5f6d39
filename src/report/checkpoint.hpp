#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "report/summary.hpp"
#include "report/trajectory.hpp"

namespace tanor::report {

/// Everything that a run needs to go on, except its scene.
struct Checkpoint {
  std::string scene;  ///< fingerprint of the scene file and its points
  TrajectoryMark trajectory;
  MotionReport report;  ///< with the time
  WallTimes wall;
  std::vector<double> positions, velocities;  ///< 3n
};

/// 16 hexadecimal digits of the scene file's bytes and of the start that they led to (FNV-1a, 64 bits).
std::string make_fingerprint(const std::filesystem::path& scene_file, const System& system);

/// Replaces `directory/checkpoint`: a line of JSON and two .npy arrays, positions and velocities.
void write_checkpoint(const std::filesystem::path& directory, const Checkpoint& checkpoint);

/// None where there is no checkpoint. Throws InputError for one that is damaged or belongs to another scene.
std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& directory, const std::string& fingerprint,
                                          std::size_t num_points);

/// Forgets the checkpoint of an earlier run.
void remove_checkpoint(const std::filesystem::path& directory);

}  // namespace tanor::report
