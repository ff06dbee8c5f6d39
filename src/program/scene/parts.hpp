#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tanor::scene {

/// Returns the keys of a part of the scene: "motion", "solver", "equilibrium", "modes", "import", "points", or "" for
/// the scene itself.
const std::vector<std::string_view>& keys_of(std::string_view part);

/// Returns what an unknown key may mean: " (did you mean pairs?)" if a known one is near, " (a key of /motion)" if it
/// belongs to another part, or nothing.
std::string explain_key(std::string_view key, const std::vector<std::string_view>& known);

}  // namespace tanor::scene
