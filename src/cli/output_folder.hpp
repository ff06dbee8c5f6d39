#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>

#include "scene/scene.hpp"

namespace tanor::cli {

/// Where a command writes: --out, else `<name>.out`; a name may hold what a folder's name must not.
inline std::filesystem::path choose_folder(const std::optional<std::filesystem::path>& out, const scene::Scene& scene) {
  if (out) return *out;
  std::string name = scene.name;
  std::replace(name.begin(), name.end(), '/', '_');
  return name + ".out";
}

/// What tanor-mpi writes beside a summary.
inline constexpr const char *mpi_checkpoint_name = "checkpoint.mpi", *mpi_trajectory_name = "trajectory.npy",
                            *mpi_times_name = "trajectory_times.npy";

/// Removes what an earlier run of tanor or tanor-mpi has left, and nothing else: none of it could be told from the new
/// run's own.
void remove_results(const std::filesystem::path& folder);

}  // namespace tanor::cli
