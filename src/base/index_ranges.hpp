#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/parallel.hpp"

namespace tanor {

/// A set of numbers 0, 1, 2, …, stored as index ranges [begin, end) in increasing order. A loop over the set is a loop
/// over a few ranges.
class IndexRanges {
 public:
  IndexRanges() = default;
  /// Makes the set of all numbers below `count`.
  explicit IndexRanges(std::size_t count) {
    if (count > 0) runs_.push_back({0, count, 0});
  }

  /// Adds a number above all others.
  void append(std::size_t number) {
    if (runs_.empty() || runs_.back().end != number) runs_.push_back({number, number, size()});
    ++runs_.back().end;
  }

  /// Returns how many numbers there are.
  std::size_t size() const { return runs_.empty() ? 0 : runs_.back().before + runs_.back().end - runs_.back().begin; }

  /// Returns how many numbers are below `number`.
  std::size_t count_below(std::size_t number) const {
    const auto after =
        std::partition_point(runs_.begin(), runs_.end(), [&](const Run& run) { return run.end <= number; });
    return after == runs_.end() ? size() : after->before + (number > after->begin ? number - after->begin : 0);
  }

  bool contains(std::size_t number) const { return count_below(number + 1) > count_below(number); }

  /// Calls visit(begin, end) for the pieces of ranges that hold the numbers with the ranks [first, last) in the set.
  template <class Visit>
  void for_pieces(std::size_t first, std::size_t last, const Visit& visit) const {
    const auto is_before = [&](const Run& run) { return run.before + (run.end - run.begin) <= first; };
    for (auto run = std::partition_point(runs_.begin(), runs_.end(), is_before); first < last; ++run) {
      const std::size_t begin = run->begin + (first - run->before);
      const std::size_t end = std::min(run->end, run->begin + (last - run->before));
      visit(begin, end);
      first += end - begin;
    }
  }

  /// Calls visit(begin, end) for each range.
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (const Run& run : runs_) visit(run.begin, run.end);
  }

  /// Calls Parallel::for_ranges over the numbers of this set.
  template <class Body>
  void for_ranges(const Parallel& parallel, const Body& body) const {
    parallel.for_ranges(size(), [&](std::size_t first, std::size_t last) { for_pieces(first, last, body); });
  }
  template <class Body>
  double max_over_ranges(const Parallel& parallel, const Body& body) const {
    return max_over_places(parallel, 0, size(), body);
  }
  /// Restricts the maximum to the numbers in [begin, end).
  template <class Body>
  double max_over_ranges(const Parallel& parallel, std::size_t begin, std::size_t end, const Body& body) const {
    return max_over_places(parallel, count_below(begin), count_below(end), body);
  }

 private:
  struct Run {
    std::size_t begin, end, before;  // before: how many numbers are in earlier ranges
  };

  template <class Body>
  double max_over_places(const Parallel& parallel, std::size_t first, std::size_t last, const Body& body) const {
    return parallel.max_over_ranges(last - first, [&](std::size_t from, std::size_t to) {
      double worst = 0.0;
      for_pieces(first + from, first + to,
                 [&](std::size_t begin, std::size_t end) { worst = larger(worst, body(begin, end)); });
      return worst;
    });
  }

  std::vector<Run> runs_;
};

}  // namespace tanor
