#pragma once

#include <filesystem>
#include <optional>

#include <tanor/modes.hpp>

#include "scene/scene.hpp"

namespace tanor::report {

inline constexpr const char* places_at_rest_name = "equilibrium.xyz";
inline constexpr const char* scene_at_rest_name = "equilibrium.json";

/// Writes summary.json and equilibrium.xyz and, if an equilibrium was found, equilibrium.json: the scene at rest there,
/// which `tanor run` accepts. `modes` are those about the equilibrium, if they were requested.
void write_equilibrium(const std::filesystem::path& directory, const scene::Scene& scene,
                       const EquilibriumResult& found, std::span<const Observed> observed,
                       const std::optional<Modes>& modes = {});

/// Writes trajectory.pvd with one frame: a scene at rest, for pictures.
void write_frame_at_rest(const std::filesystem::path& directory, const System& system, const tanor::Solution& rest);

}  // namespace tanor::report
