#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include <tanor/motion.hpp>

#include "report/output_file.hpp"
#include "report/summary.hpp"
#include "report/trajectory.hpp"

namespace tanor::report {

/// Everything that a run needs to go on, except its scene.
struct Checkpoint {
  std::string scene;  ///< its fingerprint
  TrajectoryMark trajectory;
  WallTimes wall;
  Snapshot snapshot;
};

/// 16 hexadecimal digits of the bytes of a scene's files and of the start that they led to (FNV-1a, 64 bits).
std::string make_fingerprint(std::span<const std::filesystem::path> files, const System& system);

/// Replaces `directory/checkpoint`. The file has a line with the format's number, a JSON object with all numbers, the
/// positions, velocities and memories as .npy arrays, and a line with the checksum (FNV-1a, 64 bits) of everything
/// before.
void write_checkpoint(const std::filesystem::path& directory, const Checkpoint& checkpoint, Wait wait = Wait::ForDisk);

/// Reads `directory/checkpoint`, if there is one. Throws InputError where it is damaged, holds an impossible number, or
/// belongs to another scene.
std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& directory, const std::string& fingerprint,
                                          std::size_t num_points);

/// Forgets the checkpoint of an earlier run.
void remove_checkpoint(const std::filesystem::path& directory);

}  // namespace tanor::report
