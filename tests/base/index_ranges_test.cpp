/// The tests compare numbers as runs with a plain list of them.

#include "base/index_ranges.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace tanor {
using namespace detail;
namespace {

std::vector<std::size_t> any_numbers(std::mt19937* generator) {
  std::vector<std::size_t> result;
  const double density = std::uniform_real_distribution<double>(0.0, 1.0)(*generator);
  for (std::size_t k = 0; k < 60; ++k) {
    if (std::bernoulli_distribution(density)(*generator)) result.push_back(k);
  }
  return result;
}

IndexRanges ranges_of(const std::vector<std::size_t>& numbers) {
  IndexRanges runs;
  for (const std::size_t number : numbers) runs.append(number);
  return runs;
}

TEST(IndexRanges, CountAndContainWhatWasAppended) {
  std::mt19937 generator(1);
  for (int k = 0; k < 100; ++k) {
    const std::vector<std::size_t> numbers = any_numbers(&generator);
    const IndexRanges runs = ranges_of(numbers);

    EXPECT_EQ(runs.size(), numbers.size());
    for (std::size_t number = 0; number < 62; ++number) {
      const auto place = std::ranges::lower_bound(numbers, number);
      EXPECT_EQ(runs.count_below(number), static_cast<std::size_t>(place - numbers.begin()));
      EXPECT_EQ(runs.contains(number), place != numbers.end() && *place == number);
    }
  }
}

TEST(IndexRanges, PiecesHoldTheNumbersBetweenTwoPlaces) {
  std::mt19937 generator(2);
  for (int k = 0; k < 100; ++k) {
    const std::vector<std::size_t> numbers = any_numbers(&generator);
    const IndexRanges runs = ranges_of(numbers);
    const auto last = std::uniform_int_distribution<std::size_t>(0, numbers.size())(generator);
    const auto first = std::uniform_int_distribution<std::size_t>(0, last)(generator);

    std::vector<std::size_t> visited;
    runs.for_pieces(first, last, [&](std::size_t begin, std::size_t end) {
      EXPECT_LT(begin, end);
      for (; begin < end; ++begin) visited.push_back(begin);
    });

    EXPECT_EQ(visited, std::vector(numbers.begin() + static_cast<std::ptrdiff_t>(first),
                                   numbers.begin() + static_cast<std::ptrdiff_t>(last)));
  }
}

TEST(IndexRanges, FindTheLargestOfManyOnAnyNumberOfThreads) {
  IndexRanges runs;
  for (std::size_t number = 0; number < 50'000; ++number) {
    if (number % 7 < 3) runs.append(number);
  }
  const auto largest = [](std::size_t begin, std::size_t end) {
    double result = 0.0;
    for (; begin < end; ++begin) result = std::max(result, static_cast<double>(begin * 7919 % 50'021));
    return result;
  };
  double wanted = 0.0, wanted_of_some = 0.0;
  for (std::size_t number = 0; number < 50'000; ++number) {
    if (number % 7 >= 3) continue;
    wanted = std::max(wanted, largest(number, number + 1));
    if (1'000 <= number && number < 30'001) wanted_of_some = std::max(wanted_of_some, largest(number, number + 1));
  }

  for (const int threads : {1, 2, 5}) {
    EXPECT_EQ(runs.max_over_ranges(Parallel(threads), largest), wanted);
    EXPECT_EQ(runs.max_over_ranges(Parallel(threads), 1'000, 30'001, largest), wanted_of_some);
  }
}

}  // namespace
}  // namespace tanor
