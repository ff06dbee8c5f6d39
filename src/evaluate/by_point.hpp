#pragma once

#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include <tanor/system.hpp>

namespace tanor {

/// Entries grouped by the point that each belongs to. Those of one point keep the order in which they were given.
template <class Entry>
class ByPoint {
 public:
  ByPoint() = default;
  ByPoint(std::size_t num_points, const std::vector<std::pair<Index, Entry>>& entries) {
    if (entries.empty()) return;
    start_.assign(num_points + 1, 0);
    for (const auto& [point, entry] : entries) ++start_[point + 1];
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    entries_.resize(entries.size());
    std::vector<Index> next(start_.begin(), start_.end() - 1);
    for (const auto& [point, entry] : entries) entries_[next[point]++] = entry;
  }

  bool empty() const { return entries_.empty(); }
  std::span<const Entry> operator[](std::size_t point) const {
    if (empty()) return {};
    return {entries_.begin() + start_[point], entries_.begin() + start_[point + 1]};
  }

 private:
  std::vector<Index> start_;  // [point + 1]
  std::vector<Entry> entries_;
};

}  // namespace tanor
