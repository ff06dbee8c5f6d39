#include "base/stopwatch.hpp"

#if defined(__x86_64__)

namespace tanor::detail {

namespace {

double measure_seconds_per_tick() {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::microseconds long_enough(100);
  const Clock::time_point start = Clock::now();
  const std::int64_t first = count_ticks();
  Clock::time_point end;
  do end = Clock::now();
  while (end - start < long_enough);
  return std::chrono::duration<double>(end - start).count() / static_cast<double>(count_ticks() - first);
}

}  // namespace

double seconds_per_tick() {
  static const double seconds = measure_seconds_per_tick();
  return seconds;
}

}  // namespace tanor::detail

#endif
