#include "base/parallel.hpp"

#include <chrono>
#include <ctime>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace tanor;
using namespace tanor::detail;

TEST(Parallel, SumsHaveTheSameBitsForAnyNumberOfThreads) {
  const auto term = [](std::size_t k) { return 1.0 / (3.0 + static_cast<double>(k)); };
  const double alone = Parallel(1).sum(100'003, term);
  for (const int threads : {2, 3, 7}) EXPECT_EQ(Parallel(threads).sum(100'003, term), alone);
}

TEST(Parallel, SumsArePartsInTheirOrder) {
  const auto term = [](std::size_t k) { return 1.0 / (3.0 + static_cast<double>(k)); };
  for (const std::size_t count : {65, 127, 128, 1000, 100'003}) {
    double all = 0.0;
    for (std::size_t p = 0; p < 64; ++p) {
      double part = 0.0;
      for (std::size_t k = count * p / 64; k < count * (p + 1) / 64; ++k) part += term(k);
      all += part;
    }
    for (const int threads : {1, 2, 3, 7}) EXPECT_EQ(Parallel(threads).sum(count, term, 1), all) << count;
  }
}

TEST(Parallel, ExceptionsOfTasksReachTheCaller) {
  const Parallel parallel(2);
  EXPECT_THROW(parallel.for_ranges(10'000,
                                   [](std::size_t begin, std::size_t) {
                                     if (begin > 0) throw std::runtime_error("second half");
                                   }),
               std::runtime_error);
  EXPECT_THROW(parallel.for_tasks(5,
                                  [](std::size_t k) {
                                    if (k == 3) throw std::runtime_error("fourth task");
                                  }),
               std::runtime_error);
}

// A host program that computes something else now and then must not find its processors taken.
TEST(Parallel, ThreadsWithoutWorkSleep) {
  constexpr int threads = 2;
  std::vector<double> x(100'000, 1.0);
  Parallel(threads).for_ranges(x.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) x[k] += 1.0;
  });
  // The threads may spin for a while first, and so may a BLAS whose threads have just been made.
  constexpr double idle = 0.3;  // s
  double used = idle;           // by all threads of this process
  for (int k = 0; k < 10 && used > 0.1 * idle; ++k) {
    const std::clock_t before = std::clock();
    std::this_thread::sleep_for(std::chrono::duration<double>(idle));
    used = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
  }
  EXPECT_LE(used, 0.1 * idle);
}

}  // namespace
