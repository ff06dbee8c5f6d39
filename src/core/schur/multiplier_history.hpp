#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/memory.hpp"
#include "base/parallel.hpp"

namespace tanor::detail {

/// Keeps the last three solutions lambda(t). The polynomial through them guesses the next one.
class MultiplierHistory {
 public:
  explicit MultiplierHistory(std::size_t num_rows) {
    for (Solution& solution : solutions_) solution = {0.0, std::vector<double>(num_rows, 0.0)};
  }

  void forget() { size_ = 0; }
  /// Adds a solution, or replaces the one at the same time.
  void add(double t, const std::vector<double>& lambda) {
    const auto first = solutions_.begin();
    auto place = std::find_if(first, first + size_, [&](const Solution& each) { return each.t == t; });
    if (place == first + size_) {
      size_ = std::min(most, size_ + 1);
      place = first + size_ - 1;
    }
    std::rotate(first, place, place + 1);
    first->t = t;
    std::ranges::copy(lambda, first->lambda.begin());
  }
  /// Writes the guess into lambda, which stays as it is if there is no solution yet: lambda(t) = sum_j lambda_j prod_(k
  /// != j) (t - t_k)/(t_j - t_k) of as many solutions as do not magnify their errors too much.
  void extrapolate(const Parallel& parallel, double t, std::vector<double>* lambda) const {
    constexpr double most_magnified = 20.0;
    if (size_ == 0) return;
    std::array<double, most> weights{};
    double magnified = HUGE_VAL;
    for (std::size_t count = size_; magnified > most_magnified; --count) {
      magnified = 0.0;
      weights = {};
      for (std::size_t j = 0; j < count; ++j) {
        weights[j] = 1.0;
        for (std::size_t k = 0; k < count; ++k)
          if (k != j) weights[j] *= (t - solutions_[k].t) / (solutions_[j].t - solutions_[k].t);
        magnified += std::abs(weights[j]);
      }
    }
    const auto& [a, b, c] = solutions_;
    parallel.for_ranges(lambda->size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        (*lambda)[i] = weights[0] * a.lambda[i] + weights[1] * b.lambda[i] + weights[2] * c.lambda[i];
    });
  }

  void exchange_memory(Memory& memory) {
    memory.exchange(size_);
    for (Solution& solution : solutions_) memory.exchange(solution.t, solution.lambda);
    if (size_ > most) memory.refuse();
    // Two solutions at one time would divide by 0.
    for (std::size_t k = 1; k < size_; ++k)
      for (std::size_t j = 0; j < k; ++j)
        if (solutions_[j].t == solutions_[k].t) memory.refuse();
  }

 private:
  static constexpr std::size_t most = 3;
  struct Solution {
    double t;
    std::vector<double> lambda;
  };

  std::array<Solution, most> solutions_;  // the latest first
  std::size_t size_ = 0;
};

}  // namespace tanor::detail
