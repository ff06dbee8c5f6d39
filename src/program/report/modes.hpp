#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/modes.hpp>
#include <tanor/observables.hpp>

#include "report/json_text.hpp"
#include "scene/scene.hpp"

namespace tanor::report {

/// Writes the member "modes" of a summary: its numbers, and the shapes [modes, n, 3] in `directory/shapes.npy`. The
/// member is null if modes were not found.
void add_modes(const std::filesystem::path& directory, const Units& units, const std::optional<Modes>& modes,
               JsonObjectFile* json);
/// Returns the letters of the moves q, of which q'Mq is 1.
std::string unit_of_shapes(const Units& units);

/// Writes `directory/summary.json` and the shapes beside it. `observed` is that at rest; there is no buckling where
/// none was asked for.
void write_modes(const std::filesystem::path& directory, const scene::Scene& scene, const Modes& modes,
                 std::span<const Observed> observed, const std::optional<Buckling>& buckling);

inline constexpr std::string_view mode_prefix = "mode_";
/// Returns "mode_<k>", k = 1, 2, …
inline std::string name_mode(std::size_t number) {
  return std::string(mode_prefix) + std::to_string(number);
}

/// Writes the vibration of each mode for pictures and ParaView: `directory/mode_<k>.pvd` and the frames that it names
/// in `mode_<k>`. They show one period, with moves enlarged to a tenth of the scene's size; the period is 1 s if omega
/// is not a frequency.
void write_mode_pictures(const std::filesystem::path& directory, const System& system, const Solution& rest,
                         const Modes& modes);

/// Returns the names that shapes and pictures of modes may have in a folder.
std::vector<std::filesystem::path> list_modes(const std::filesystem::path& directory);

}  // namespace tanor::report
