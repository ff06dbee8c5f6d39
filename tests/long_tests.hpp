#pragma once

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace tanor {

/// Whether tests take more of the same: TANOR_LONG_TESTS=1, as scripts/check.sh sets it, and a quarter of an hour more.
inline bool tests_are_long() {
  const char* const asked = std::getenv("TANOR_LONG_TESTS");
  return asked != nullptr && std::string_view(asked) == "1";
}

/// How many random systems a test draws: all of them, or a fifth; at most TANOR_DRAWS, at least one.
inline int num_draws(int all) {
  const char* const most = std::getenv("TANOR_DRAWS");
  const int usual = tests_are_long() ? all : all / 5;
  return std::max(1, most != nullptr ? std::min(std::atoi(most), usual) : usual);
}

}  // namespace tanor
