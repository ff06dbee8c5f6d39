#pragma once

/// \file Random numbers that are the same in every run.

#include <cstddef>
#include <random>
#include <vector>

namespace tanor {

/// Returns `count` numbers between -2 and 2.
inline std::vector<double> uniform_numbers(std::size_t count, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> number(-2.0, 2.0);
  std::vector<double> result(count);
  for (double& x : result) x = number(generator);
  return result;
}

/// Returns `count` numbers with the mean 0 and the variance 1.
inline std::vector<double> normal_numbers(std::size_t count, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  std::vector<double> result(count);
  for (double& x : result) x = normal(generator);
  return result;
}

}  // namespace tanor
