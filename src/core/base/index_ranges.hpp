#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/parallel.hpp"

namespace tanor::detail {

/// A set of numbers 0, 1, 2, …, stored as index ranges [begin, end) in increasing order. A loop over the set is a loop
/// over a few ranges.
class IndexRanges {
 public:
  IndexRanges() = default;
  /// Makes the set of all numbers below `count`.
  explicit IndexRanges(std::size_t count) {
    if (count > 0) ranges_.push_back({0, count, 0});
  }

  /// Adds a number above all others.
  void append(std::size_t number) {
    if (ranges_.empty() || ranges_.back().end != number) ranges_.push_back({number, number, size()});
    ++ranges_.back().end;
  }

  /// Returns how many numbers there are.
  std::size_t size() const {
    return ranges_.empty() ? 0 : ranges_.back().before + ranges_.back().end - ranges_.back().begin;
  }

  /// Returns how many numbers are below `number`.
  std::size_t count_below(std::size_t number) const {
    const auto after =
        std::partition_point(ranges_.begin(), ranges_.end(), [&](const Range& range) { return range.end <= number; });
    return after == ranges_.end() ? size() : after->before + (number > after->begin ? number - after->begin : 0);
  }

  bool contains(std::size_t number) const { return count_below(number + 1) > count_below(number); }

  /// Calls visit(begin, end) for the pieces of ranges that hold the numbers with the ranks [first, last) in the set.
  template <class Visit>
  void for_pieces(std::size_t first, std::size_t last, const Visit& visit) const {
    const auto is_before = [&](const Range& range) { return range.before + (range.end - range.begin) <= first; };
    for (auto range = std::partition_point(ranges_.begin(), ranges_.end(), is_before); first < last; ++range) {
      const std::size_t begin = range->begin + (first - range->before);
      const std::size_t end = std::min(range->end, range->begin + (last - range->before));
      visit(begin, end);
      first += end - begin;
    }
  }

  /// Calls visit(begin, end) for each range.
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (const Range& range : ranges_) visit(range.begin, range.end);
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
  struct Range {
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

  std::vector<Range> ranges_;
};

}  // namespace tanor::detail
