#pragma once

#include <chrono>
#include <functional>
#include <string>

#include <tanor/motion.hpp>

namespace tanor::report {

/// Tells on stderr how far a run is: by a bar on a terminal, else by a line for every tenth of the time, at most ten.
class Progress {
 public:
  enum class Style { Quiet, Lines, Bar };
  using Clock = std::chrono::steady_clock;

  /// Returns Bar on a terminal and Lines elsewhere, unless the run is quiet.
  static Style choose_style(bool is_quiet);

  /// `now` is the clock.
  Progress(Style style, double t_start, double t_end, std::function<Clock::time_point()> now = &Clock::now);
  ~Progress() { end(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Call this after every step. It costs a look at the clock (30 ns) while there is nothing new to say.
  void update(const MotionReport& report);
  /// Removes the bar, so that other lines may follow.
  void end();

 private:
  /// Percent, time left, the worst violation so far, and more where there is room for it.
  std::string describe(const MotionReport& report, double part, Clock::time_point now) const;

  Style style_;
  double t_start_, t_end_;
  std::function<Clock::time_point()> now_;
  Clock::time_point begin_, next_;
  int tenths_ = 0;  ///< told so far
  bool shows_bar_ = false;
};

}  // namespace tanor::report
