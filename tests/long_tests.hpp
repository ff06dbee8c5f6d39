#pragma once

#include <cstdlib>

namespace tanor {

/// Whether tests take more of the same: TANOR_LONG_TESTS=1, as scripts/check.sh sets it, and a quarter of an hour more.
inline bool tests_are_long() {
  return std::getenv("TANOR_LONG_TESTS") != nullptr;
}

/// How many random systems a test draws: all of them, or a fifth; at most TANOR_DRAWS.
inline int num_draws(int all) {
  const char* const most = std::getenv("TANOR_DRAWS");
  const int usual = tests_are_long() ? all : all / 5;
  return most != nullptr && std::atoi(most) < usual ? std::atoi(most) : usual;
}

}  // namespace tanor
