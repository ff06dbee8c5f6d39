#include "report/progress.hpp"

#include <algorithm>
#include <chrono>

#include <gtest/gtest.h>

namespace tanor::report {
namespace {

using namespace std::chrono_literals;

/// Returns the output of a run of 100 steps, each of which takes so long; the clock is the test's own.
std::string tell(Progress::Style style, std::chrono::milliseconds step_takes) {
  testing::internal::CaptureStderr();
  Progress::Clock::time_point now{};
  Progress progress(style, 0.0, 1.0, "tau", [&] { return now; });
  MotionReport report;
  for (std::size_t step = 1; step <= 100; ++step) {
    now += step_takes;
    report.time = 0.01 * static_cast<double>(step);
    report.steps = step;
    report.violation.position = 1e-13 * static_cast<double>(step);  // the worst so far
    progress.update(report);
  }
  progress.end();
  return testing::internal::GetCapturedStderr();
}

TEST(ProgressTest, ShortRunsAndQuietOnesAreSilent) {
  EXPECT_EQ(tell(Progress::Style::Lines, 9ms), "");
  EXPECT_EQ(tell(Progress::Style::Bar, 0ms), "");
  EXPECT_EQ(tell(Progress::Style::Quiet, 10s), "");
}

TEST(ProgressTest, LinesComeAtEachTenthAndAtMostOnceASecond) {
  EXPECT_EQ(tell(Progress::Style::Lines, 45ms),
            "tanor:  23 %  3.5 s left  violation 2.3e-12  t = 0.23 of 1 tau  23 steps\n"
            "tanor:  46 %  2.4 s left  violation 4.6e-12  t = 0.46 of 1 tau  46 steps\n"
            "tanor:  69 %  1.4 s left  violation 6.9e-12  t = 0.69 of 1 tau  69 steps\n"
            "tanor:  92 %  0.4 s left  violation 9.2e-12  t = 0.92 of 1 tau  92 steps\n");
}

TEST(ProgressTest, LongRunsTellEveryTenth) {
  const std::string text = tell(Progress::Style::Lines, 60s);

  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 10);
  EXPECT_TRUE(text.starts_with("tanor:  10 %  1 h 30 min left  violation 1.0e-12  t = 0.1 of 1 tau  10 steps\n"))
      << text;
}

TEST(ProgressTest, TheBarComesTenTimesASecondAndIsTakenAwayAtTheEnd) {
  const std::string text = tell(Progress::Style::Bar, 60ms);

  EXPECT_TRUE(text.starts_with(
      "\r\x1b[K[                        ]   2 %  5.9 s left  violation 2.0e-13  t = 0.02 of 1 tau  2 steps"
      "\r\x1b[K[                        ]   4 %  5.8 s left  violation 4.0e-13  t = 0.04 of 1 tau  4 steps\r"))
      << text;
  EXPECT_TRUE(text.ends_with(
      "[========================] 100 %  0.0 s left  violation 1.0e-11  t = 1 of 1 tau  100 steps\r\x1b[K"))
      << text;
}

}  // namespace
}  // namespace tanor::report
