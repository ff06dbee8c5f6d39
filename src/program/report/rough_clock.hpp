#pragma once

#include <chrono>
#include <ctime>  // also clock_gettime

namespace tanor::report {

/// Returns what std::chrono::steady_clock showed at the last tick of the system, at most some milliseconds ago, in a
/// fifth of the time that the clock itself takes. It is for what is asked after every step.
inline std::chrono::steady_clock::time_point read_rough_clock() {
#if defined(CLOCK_MONOTONIC_COARSE) && defined(__GLIBCXX__)
  timespec now{};  // of CLOCK_MONOTONIC, which is the steady clock of libstdc++
  if (clock_gettime(CLOCK_MONOTONIC_COARSE, &now) == 0) {
    return std::chrono::steady_clock::time_point(std::chrono::seconds(now.tv_sec) +
                                                 std::chrono::nanoseconds(now.tv_nsec));
  }
#endif
  return std::chrono::steady_clock::now();
}

}  // namespace tanor::report
