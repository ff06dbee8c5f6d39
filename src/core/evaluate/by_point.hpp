#pragma once

#include <span>
#include <utility>
#include <vector>

#include <tanor/system.hpp>

#include "base/groups.hpp"

namespace tanor::detail {

/// Entries grouped by the point that each belongs to. Those of one point keep the order in which they were given.
template <class Entry>
class ByPoint {
 public:
  ByPoint() = default;
  ByPoint(std::size_t num_points, const std::vector<std::pair<Index, Entry>>& entries) {
    if (entries.empty()) return;
    groups_ = {num_points, [&](const auto& add) {
                 for (const auto& [point, entry] : entries) add(point, entry);
               }};
  }

  bool empty() const { return groups_.empty(); }
  std::span<const Entry> operator[](std::size_t point) const {
    if (empty()) return {};
    return groups_[point];
  }

 private:
  Groups<Entry> groups_;  // [point]; without groups if there are no entries
};

}  // namespace tanor::detail
