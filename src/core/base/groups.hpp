#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace tanor::detail {

/// Entries stored group by group (compressed rows). The entries of group k are [start[k], start[k + 1]).
template <class Entry>
struct Groups {
  std::vector<std::int32_t> start{0};
  std::vector<Entry> entries;

  Groups() = default;
  /// Sorts entries into groups by counting. `list(add)` calls add(group, entry) for each entry; it is called twice and
  /// must list the same entries both times. Entries of one group keep their order.
  template <class List>
  Groups(std::size_t num_groups, const List& list) : start(num_groups + 1, 0) {
    list([&](auto group, const Entry&) { ++start[static_cast<std::size_t>(group) + 1]; });
    std::partial_sum(start.begin(), start.end(), start.begin());
    entries.resize(static_cast<std::size_t>(start.back()));
    std::vector<std::int32_t> next(start.begin(), start.end() - 1);
    list([&](auto group, const Entry& entry) {
      entries[static_cast<std::size_t>(next[static_cast<std::size_t>(group)]++)] = entry;
    });
  }

  /// Sorts pairs of a group and an entry.
  Groups(std::size_t num_groups, const std::vector<std::pair<std::int32_t, Entry>>& pairs)
      : Groups(num_groups, [&](const auto& add) {
          for (const auto& [group, entry] : pairs) add(group, entry);
        }) {}

  std::size_t size() const { return start.size() - 1; }
  bool empty() const { return entries.empty(); }
  /// Returns the entries of a group; none if there are no groups.
  std::span<const Entry> operator[](std::size_t group) const {
    if (empty()) return {};
    return std::span(entries).subspan(first(group), first(group + 1) - first(group));
  }
  std::span<Entry> operator[](std::size_t group) {
    return std::span(entries).subspan(first(group), first(group + 1) - first(group));
  }

  /// Closes the group at the end of `entries`.
  void end_group() { start.push_back(static_cast<std::int32_t>(entries.size())); }
  void clear() {
    start.assign(1, 0);
    entries.clear();
  }

 private:
  std::size_t first(std::size_t group) const { return static_cast<std::size_t>(start[group]); }
};

/// Writes pairs (group, entry) as compressed rows: each pair once, entries of a group in increasing order.
template <class Pair, class Number, class Entry>
void compress_pairs(std::size_t num_groups, std::vector<Pair> pairs, std::vector<Number>* start,
                    std::vector<Entry>* entries) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  start->assign(num_groups + 1, 0);
  entries->clear();
  for (const auto& [group, entry] : pairs) {
    ++(*start)[static_cast<std::size_t>(group) + 1];
    entries->push_back(entry);
  }
  std::partial_sum(start->begin(), start->end(), start->begin());
}

}  // namespace tanor::detail
