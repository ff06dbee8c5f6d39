#include "report/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "report/terminal.hpp"
#include "report/words.hpp"

namespace tanor::report {

namespace {

constexpr std::chrono::milliseconds bar_interval(100);    // looks smooth
constexpr std::chrono::milliseconds line_interval(1000);  // short runs need no lines

/// Prints without checking for errors, because a closed stderr must not stop a run.
void print(const std::string& text) {
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
}

std::string describe_duration(double seconds) {
  if (seconds < 60.0) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<long>(std::min(seconds, 1e9));
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

std::string draw_bar(double part) {
  constexpr int width = 24;
  const int filled = static_cast<int>(part * width);
  return "[" + std::string(filled, '=') + std::string(width - filled, ' ') + "]";
}

/// Returns at most one line of the terminal, because the rest of a wider one would stay when the next one is drawn. The
/// words have priority over the bar.
std::string draw_line(const std::string& words, double part, const Terminal& terminal) {
  const std::size_t room = terminal.width().value_or(200) - 1;
  const std::string bar = draw_bar(part);
  if (bar.size() + 1 + words.size() > room) return std::string(first_columns(words, room));
  return terminal.key(bar) + " " + words;
}

}  // namespace

Progress::Style Progress::choose_style(bool is_quiet) {
  if (is_quiet) return Style::Quiet;
  return isatty(STDERR_FILENO) ? Style::Bar : Style::Lines;
}

Progress::Progress(Style style, double t_start, double t_end, std::string unit, std::function<Clock::time_point()> now)
    : style_(style),
      t_start_(t_start),
      t_end_(t_end),
      unit_(std::move(unit)),
      now_(std::move(now)),
      begin_(now_()),
      next_(begin_ + (style == Style::Bar ? bar_interval : line_interval)) {}

void Progress::update(const MotionReport& report) {
  if (style_ == Style::Quiet) return;
  const Clock::time_point now = now_();
  if (now < next_) return;

  const double part = std::clamp((report.time - t_start_) / (t_end_ - t_start_), 0.0, 1.0);
  if (style_ == Style::Bar) {
    print("\r\x1b[K" + draw_line(describe(report, part, now), part, Terminal::of(stderr)));
    shows_bar_ = true;
    next_ = now + bar_interval;
  } else if (const int tenths = static_cast<int>(10.0 * part); tenths > tenths_) {
    print("tanor: " + describe(report, part, now) + "\n");
    tenths_ = tenths;
    next_ = now + line_interval;
  }
}

void Progress::end() {
  if (!shows_bar_) return;
  print("\r\x1b[K");
  shows_bar_ = false;
}

std::string Progress::describe(const MotionReport& report, double part, Clock::time_point now) const {
  const double elapsed = std::chrono::duration<double>(now - begin_).count();
  const std::string left = part > 0.0 ? describe_duration(elapsed * (1.0 - part) / part) : "?";
  const double violation = std::max(report.violation.position, report.violation.velocity);
  return fmt::format("{:3.0f} %  {} left  violation {}  t = {:.4g} of {}  {}", 100.0 * part, left,
                     in_words(violation, "{:.1e}"), report.time, with_unit(fmt::format("{:.4g}", t_end_), unit_),
                     count_in_words(report.steps, "step"));
}

}  // namespace tanor::report
