#pragma once

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace tanor {

/// Returns true if tests do more of the same, which takes a quarter of an hour longer. TANOR_LONG_TESTS=1 asks for it,
/// as scripts/check.sh does.
inline bool tests_are_long() {
  const char* const asked = std::getenv("TANOR_LONG_TESTS");
  return asked != nullptr && std::string_view(asked) == "1";
}

/// Returns how many random systems a test draws, which is all of them or a fifth, at most TANOR_DRAWS and at least one.
inline int num_draws(int all) {
  const char* const most = std::getenv("TANOR_DRAWS");
  const int usual = tests_are_long() ? all : all / 5;
  return std::max(1, most != nullptr ? std::min(std::atoi(most), usual) : usual);
}

}  // namespace tanor
