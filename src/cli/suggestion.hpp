#pragma once

#include <string>
#include <vector>

namespace tanor::cli {

/// Returns " (did you mean run?)" if a word is near a known one, else nothing.
std::string suggest(const std::string& word, const std::vector<std::string>& known);

}  // namespace tanor::cli
