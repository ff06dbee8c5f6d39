#include "report/progress.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

namespace tanor::report {
namespace {

using namespace std::chrono_literals;

/// What a run of 100 steps, that begins after a pause, tells.
std::string tell(Progress::Style style, std::chrono::milliseconds pause) {
  testing::internal::CaptureStderr();
  Progress progress(style, 0.0, 1.0);
  std::this_thread::sleep_for(pause);
  MotionReport report;
  for (std::size_t step = 1; step <= 100; ++step) {
    report.time = 0.01 * static_cast<double>(step);
    report.steps = step;
    progress.update(report);
  }
  progress.end();
  return testing::internal::GetCapturedStderr();
}

TEST(ProgressTest, ShortRunsAndQuietOnesAreSilent) {
  EXPECT_EQ(tell(Progress::Style::Lines, 0ms), "");
  EXPECT_EQ(tell(Progress::Style::Quiet, 200ms), "");
}

TEST(ProgressTest, LinesComeByTenthsAndNotMoreThanOneASecond) {
  const std::string text = tell(Progress::Style::Lines, 1050ms);

  EXPECT_TRUE(text.starts_with("tanor:  10 %  t = 0.1 of 1 s  10 steps  ")) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
}

TEST(ProgressTest, TheBarIsTakenAwayAtTheEnd) {
  const std::string text = tell(Progress::Style::Bar, 120ms);

  EXPECT_TRUE(text.starts_with("\r\x1b[K[                        ]   1 %  t = 0.01 of 1 s  1 steps  ")) << text;
  EXPECT_TRUE(text.ends_with(" left\r\x1b[K")) << text;
}

}  // namespace
}  // namespace tanor::report
