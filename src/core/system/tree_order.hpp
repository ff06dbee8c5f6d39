#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <tanor/system.hpp>

#include "base/groups.hpp"

namespace tanor::detail {

/// Lists the points of a tree from its leaves to its center. Each branch (a point with all that hangs on it) is in one
/// piece, and equal branches of a point are side by side and numbered alike, so that they can be eliminated in the
/// lanes of a vector (schur/tree_pieces.cpp).
class TreeOrder {
 public:
  /// Members join two points or belong to one alone. Those with two points join all points to a tree.
  TreeOrder(const Groups<Index>& points_of_member, const Groups<Index>& members_of_point)
      : points_of_member_(points_of_member), members_of_point_(members_of_point) {}

  std::vector<Index> list() {
    visit(find_center());
    measure_branches();
    return list_branch_by_branch();
  }

 private:
  std::size_t num_points() const { return members_of_point_.size(); }

  /// Searches breadth first: sets `order_`, and for each point the one from which it was seen, -1 for the root.
  void visit(Index root) {
    order_.assign(1, root);
    parent_.assign(num_points(), -1);
    for (std::size_t head = 0; head < order_.size(); ++head) {
      const Index point = order_[head];
      for (const Index member : members_of_point_[static_cast<std::size_t>(point)]) {
        for (const Index other : points_of_member_[static_cast<std::size_t>(member)]) {
          if (other == point || other == parent_[static_cast<std::size_t>(point)]) continue;
          parent_[static_cast<std::size_t>(other)] = point;
          order_.push_back(other);
        }
      }
    }
  }

  /// Returns the middle of a longest path, from one far end to another.
  Index find_center() {
    visit(0);
    visit(order_.back());
    std::vector<Index> path{order_.back()};
    while (parent_[static_cast<std::size_t>(path.back())] >= 0)
      path.push_back(parent_[static_cast<std::size_t>(path.back())]);
    return path[path.size() / 2];
  }

  /// Measures branches by a size and a hash of their shape. Equal branches agree in both; others seldom do, which costs
  /// only time.
  void measure_branches() {
    size_.assign(num_points(), 1);
    hash_.assign(num_points(), 0);
    for (auto point = order_.rbegin(); point != order_.rend(); ++point) {
      const auto k = static_cast<std::size_t>(*point);
      std::uint64_t alone = 0;
      for (const Index member : members_of_point_[k])
        alone += points_of_member_[static_cast<std::size_t>(member)].size() == 1 ? 1 : 0;
      hash_[k] = mix(hash_[k] + alone);
      if (parent_[k] < 0) continue;
      size_[static_cast<std::size_t>(parent_[k])] += size_[k];
      hash_[static_cast<std::size_t>(parent_[k])] += mix(hash_[k] + 1);
    }
  }

  /// Lists the points with the branches of each point sorted by size, then shape.
  std::vector<Index> list_branch_by_branch() const {
    // In the reverse of the result, a point comes before its branches, the last one first.
    const Groups<Index> branches(num_points(), [&](const auto& add) {
      for (const Index point : order_) {
        if (parent_[static_cast<std::size_t>(point)] >= 0) add(parent_[static_cast<std::size_t>(point)], point);
      }
    });
    std::vector<Index> open{order_.front()}, result, own;
    result.reserve(num_points());
    while (!open.empty()) {
      const Index point = open.back();
      open.pop_back();
      result.push_back(point);
      own.assign(branches[static_cast<std::size_t>(point)].begin(), branches[static_cast<std::size_t>(point)].end());
      std::ranges::sort(own, [&](Index a, Index b) { return key(a) < key(b); });
      open.insert(open.end(), own.begin(), own.end());
    }
    std::ranges::reverse(result);
    return result;
  }

  struct Key {
    Index size;
    std::uint64_t hash;
    Index point;
    auto operator<=>(const Key&) const = default;
  };
  Key key(Index point) const {
    return {size_[static_cast<std::size_t>(point)], hash_[static_cast<std::size_t>(point)], point};
  }

  /// Computes the finalizer of SplitMix64 (S. Vigna).
  static std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15U;
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
    return x ^ (x >> 31U);
  }

  const Groups<Index>&points_of_member_, &members_of_point_;
  std::vector<Index> order_, parent_, size_;  // [point]
  std::vector<std::uint64_t> hash_;           // [point]
};

}  // namespace tanor::detail
