#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/motion.hpp>

#include "report/output_file.hpp"
#include "report/summary.hpp"
#include "report/trajectory.hpp"

namespace tanor::report {

inline constexpr const char* checkpoint_name = "checkpoint";

/// Everything that a run needs to go on, except its scene.
struct Checkpoint {
  std::string scene;   ///< its fingerprint
  double time = 0.0;   ///< reached, s
  double t_end = 0.0;  ///< to be reached, s
  TrajectoryMark trajectory;
  WallTimes wall;
  std::vector<std::byte> state;  ///< of Simulation::save
};

/// A line for each file of a scene and for the start that they led to: 16 hexadecimal digits of the bytes, the name;
/// and one for each choice that another motion would follow from: its value, the place in a scene.
std::string make_fingerprint(std::span<const std::filesystem::path> files, const System& system,
                             const MotionOptions& motion = {});

/// 16 hexadecimal digits of a fingerprint's files and start, however they are to move.
std::string make_scene_checksum(std::string_view fingerprint);

/// Why two fingerprints differ, by the first thing that both name and that is another one: "is of an earlier version of
/// the scene: net.json was changed", "is of a run with /motion/method rk4, not dop853"; or of which two scenes they
/// are.
std::string name_difference(std::string_view before, std::string_view now);

/// Replaces `directory/checkpoint`: a line with the format's number; a line with a JSON object; the bytes of the
/// simulation; a line with the checksum of everything before.
void write_checkpoint(const std::filesystem::path& directory, const Checkpoint& checkpoint, Wait wait = Wait::ForDisk);

/// None where there is no checkpoint. Throws InputError for one that is damaged, holds an impossible number, or belongs
/// to another scene. (The bytes of the simulation are looked at by Simulation::restore.)
std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& directory, const std::string& fingerprint);

}  // namespace tanor::report
