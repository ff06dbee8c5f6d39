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
  std::vector<std::byte> state;  ///< as Simulation::save writes it
};

/// Makes a fingerprint. It has a line for each file of a scene and for the start that they lead to, with 16 hexadecimal
/// digits for the bytes and the name, and a line for each option that changes the motion, with its value and its place
/// in a scene.
std::string make_fingerprint(std::span<const std::filesystem::path> files, const System& system,
                             const MotionOptions& motion = {});

/// Returns 16 hexadecimal digits for a fingerprint's files and start; the options of the motion do not count.
std::string make_scene_checksum(std::string_view fingerprint);

/// Says how two fingerprints differ, by the first entry of both that differs: "is of an earlier version of the scene:
/// net.json was changed", "is of a run with /motion/method rk4, not dop853". For two different scenes it names both.
std::string name_difference(std::string_view before, std::string_view now);

/// Replaces `directory/checkpoint`. The file has a line with the format's number, a line with a JSON object, the bytes
/// of the simulation, and a line with the checksum of everything before.
void write_checkpoint(const std::filesystem::path& directory, const Checkpoint& checkpoint, Wait wait = Wait::ForDisk);

/// Returns the checkpoint, or nothing if there is none. Throws InputError if it is damaged, holds an impossible number,
/// or belongs to another scene. (Simulation::restore checks the bytes of the simulation.)
std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& directory, const std::string& fingerprint);

}  // namespace tanor::report
