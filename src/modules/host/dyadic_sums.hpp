#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <tanor/system.hpp>

namespace tanor::detail {

/// Sums of the weights of whole numbers over the intervals [k 2^m, (k + 1) 2^m).
class DyadicSums {
 public:
  struct Interval {
    Index begin, end;
  };

  /// Makes room for the numbers below `count`.
  void resize(std::size_t count) {
    if (count <= size_) return;
    const std::size_t old_size = size_;
    const std::vector<std::int64_t> old = std::move(sums_);
    size_ = std::bit_ceil(count);
    sums_.assign(2 * size_, 0);
    for (std::size_t k = 0; k < old_size; ++k) {
      if (old[old_size + k] != 0) add(static_cast<Index>(k), old[old_size + k]);
    }
  }
  void add(Index number, std::int64_t weight) {
    for (std::size_t node = size_ + static_cast<std::size_t>(number); node > 0; node /= 2) sums_[node] += weight;
  }
  /// Returns the largest interval around a number whose sum is at most `most`, or the number alone if there is none.
  Interval around(Index number, std::int64_t most) const {
    std::size_t node = 1, begin = 0, length = size_;
    while (length > 1 && sums_[node] > most) {
      length /= 2;
      const bool is_right = static_cast<std::size_t>(number) >= begin + length;
      node = 2 * node + (is_right ? 1 : 0);
      if (is_right) begin += length;
    }
    return {static_cast<Index>(begin), static_cast<Index>(begin + length)};
  }

 private:
  std::size_t size_ = 0;            // a power of two
  std::vector<std::int64_t> sums_;  // [node] node 1 is the whole; 2k and 2k + 1 are the halves of node k
};

}  // namespace tanor::detail
