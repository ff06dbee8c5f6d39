#pragma once

#include <string>
#include <vector>

namespace tanor::cli {

/// " (did you mean run?)" where a word is near a known one, else nothing.
std::string suggest(const std::string& word, const std::vector<std::string>& known);

}  // namespace tanor::cli
