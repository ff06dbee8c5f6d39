#pragma once

#include <ctime>

namespace tanor::embed {

/// Adds the processor time of this thread to `sum`, s, as long as it lives. Waiting for others does not count.
class CpuClock {
 public:
  explicit CpuClock(double* sum) : sum_(sum) { *sum_ -= now(); }
  CpuClock(const CpuClock&) = delete;
  CpuClock& operator=(const CpuClock&) = delete;
  ~CpuClock() { *sum_ += now(); }

 private:
  static double now() {
    std::timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  double* sum_;
};

}  // namespace tanor::embed
