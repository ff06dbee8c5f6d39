#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "base/memory.hpp"
#include "base/parallel.hpp"

namespace tanor::detail {

/// Keeps the last three solutions lambda(t). The polynomial through them guesses the next one.
class MultiplierHistory {
 public:
  explicit MultiplierHistory(std::size_t num_rows);

  void forget() { size_ = 0; }
  void add(double t, const std::vector<double>& lambda);
  /// Writes the guess into lambda, which stays as it is if there is no solution yet.
  void extrapolate(const Parallel& parallel, double t, std::vector<double>* lambda) const;

  void exchange_memory(Memory& memory);

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
