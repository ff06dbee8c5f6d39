#pragma once

#include <filesystem>

#include <tanor/equilibrium.hpp>

#include "scene/scene.hpp"

namespace tanor::report {

/// "stable", "not_conservative", …
std::string_view name_of(Stability status);

/// summary.json and equilibrium.xyz, and, where an equilibrium was found, equilibrium.json: the scene at rest there,
/// which `tanor run` accepts.
void write_equilibrium(const std::filesystem::path& directory, const scene::Scene& scene,
                       const EquilibriumResult& found);

}  // namespace tanor::report
