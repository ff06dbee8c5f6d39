#pragma once

#include <chrono>
#include <cstdint>

namespace tanor::detail {

#if defined(__x86_64__)
/// Reads the time stamp counter of the processor. A call of the operating system's clock would take as long as one
/// order of a small system's series.
inline std::int64_t count_ticks() {
  return static_cast<std::int64_t>(__builtin_ia32_rdtsc());
}
/// Returns the seconds of one tick, measured once against the system's clock to about 1e-3.
double seconds_per_tick();
#else
inline std::int64_t count_ticks() {
  return std::chrono::steady_clock::now().time_since_epoch().count();
}
inline double seconds_per_tick() {
  using Period = std::chrono::steady_clock::period;
  return static_cast<double>(Period::num) / static_cast<double>(Period::den);
}
#endif

/// Adds the seconds of its lifetime to a sum.
class Stopwatch {
 public:
  explicit Stopwatch(double* seconds) : seconds_(seconds) {}
  ~Stopwatch() { *seconds_ += detail::seconds_per_tick() * static_cast<double>(detail::count_ticks() - start_); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double* seconds_;
  std::int64_t start_ = detail::count_ticks();
};

}  // namespace tanor::detail
