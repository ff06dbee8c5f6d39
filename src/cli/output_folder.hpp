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

}  // namespace tanor::cli
