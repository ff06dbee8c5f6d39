#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tanor::scene {

/// Returns " (did you mean run?)" if a word is near a known one, else nothing.
std::string suggest(std::string_view word, const std::vector<std::string>& known);

}  // namespace tanor::scene
