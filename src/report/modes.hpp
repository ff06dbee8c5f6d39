#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include <tanor/modes.hpp>

#include "report/json_text.hpp"

namespace tanor::report {

/// Writes the member "modes" of a summary: numbers in it, the shapes [modes, n, 3] in `directory/shapes.npy`. Modes
/// that were not found are null.
void add_modes(const std::filesystem::path& directory, const std::optional<Modes>& modes, JsonObjectFile* json);

/// What `tanor modes` tells beside the modes.
struct ModesFacts {
  std::string scene, source;  ///< its name; where its points come from
  std::size_t points = 0, supports = 0, equations = 0;
  std::optional<Buckling> buckling;  ///< none: not asked for
};

/// Writes `directory/summary.json` and the shapes beside it.
void write_modes(const std::filesystem::path& directory, const ModesFacts& facts, const Modes& modes);

/// Writes the vibration in each mode for ParaView: `directory/mode_<k>.pvd`, k = 1, 2, …, and the frames that it names
/// in `mode_<k>`. One period, moves enlarged to a twentieth of the scene's size; where omega is no frequency, of 1 s.
void write_mode_pictures(const std::filesystem::path& directory, const System& system,
                         std::span<const double> positions, const Modes& modes);

/// Shapes and pictures of modes that may be in a folder.
std::vector<std::filesystem::path> list_modes(const std::filesystem::path& directory);

}  // namespace tanor::report
