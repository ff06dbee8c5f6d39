#pragma once

#include <chrono>
#include <ctime>  // also clock_gettime
#include <functional>
#include <string>

#include <tanor/motion.hpp>

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

/// Tells on stderr how far a run is: by a bar on a terminal, else by a line for every tenth of the time, at most ten.
class Progress {
 public:
  enum class Style { Quiet, Lines, Bar };
  using Clock = std::chrono::steady_clock;

  /// Returns Bar on a terminal and Lines elsewhere, unless the run is quiet.
  static Style choose_style(bool is_quiet);

  /// `unit` is that of the simulated time; `now` returns the time of the clock.
  Progress(Style style, double t_start, double t_end, std::string unit,
           std::function<Clock::time_point()> now = &read_rough_clock);
  ~Progress() { end(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Must be called after every step. It only reads the clock (6 ns) while there is nothing new to print.
  void update(const MotionReport& report);
  /// Removes the bar, so that other lines may follow.
  void end();

 private:
  /// Returns percent, time left, the worst violation so far, and more if there is room for it.
  std::string describe(const MotionReport& report, double part, Clock::time_point now) const;

  Style style_;
  double t_start_, t_end_;
  std::string unit_;
  std::function<Clock::time_point()> now_;
  Clock::time_point begin_, next_;
  int tenths_ = 0;  ///< printed so far
  bool shows_bar_ = false;
};

}  // namespace tanor::report
