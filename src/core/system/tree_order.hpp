#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <tanor/system.hpp>

#include "base/groups.hpp"

namespace tanor::detail {

/// Breadth-first searches over points that members join.
class BreadthFirstSearch {
 public:
  /// Returns the points in the order of their distance from `root`.
  const std::vector<Index>& visit(const Groups<Index>& points_of_member, const Groups<Index>& members_of_point,
                                  Index root) {
    parent_.assign(members_of_point.size(), unseen);
    member_seen_.assign(points_of_member.size(), 0);
    order_.reserve(parent_.size());
    order_.assign(1, root);
    parent_[static_cast<std::size_t>(root)] = -1;
    for (std::size_t head = 0; head < order_.size(); ++head) {
      for (const Index member : members_of_point[static_cast<std::size_t>(order_[head])]) {
        if (std::exchange(member_seen_[static_cast<std::size_t>(member)], 1) != 0) continue;
        for (const Index point : points_of_member[static_cast<std::size_t>(member)]) {
          Index& parent = parent_[static_cast<std::size_t>(point)];
          if (parent != unseen) continue;
          parent = order_[head];
          order_.push_back(point);
        }
      }
    }
    return order_;
  }
  const std::vector<Index>& order() const { return order_; }
  /// Returns the point from which the last search saw a point; -1 for the root.
  Index parent(Index point) const { return parent_[static_cast<std::size_t>(point)]; }

 private:
  static constexpr Index unseen = -2;
  std::vector<Index> order_, parent_;
  std::vector<char> member_seen_;
};

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

  void visit(Index root) { search_.visit(points_of_member_, members_of_point_, root); }

  /// Returns the middle of a longest path, from one far end to another.
  Index find_center() {
    visit(0);
    visit(search_.order().back());
    std::vector<Index> path{search_.order().back()};
    while (search_.parent(path.back()) >= 0) path.push_back(search_.parent(path.back()));
    return path[path.size() / 2];
  }

  /// Measures branches by a size and a hash of their shape. Equal branches agree in both; others seldom do, which costs
  /// only time.
  void measure_branches() {
    size_.assign(num_points(), 1);
    hash_.assign(num_points(), 0);
    for (auto point = search_.order().rbegin(); point != search_.order().rend(); ++point) {
      const auto k = static_cast<std::size_t>(*point);
      std::uint64_t alone = 0;
      for (const Index member : members_of_point_[k])
        alone += points_of_member_[static_cast<std::size_t>(member)].size() == 1 ? 1 : 0;
      hash_[k] = mix(hash_[k] + alone);
      if (search_.parent(*point) < 0) continue;
      const auto parent = static_cast<std::size_t>(search_.parent(*point));
      size_[parent] += size_[k];
      hash_[parent] += mix(hash_[k] + 1);
    }
  }

  /// Lists the points with the branches of each point sorted by size, then shape.
  std::vector<Index> list_branch_by_branch() const {
    // In the reverse of the result, a point comes before its branches, the last one first.
    const Groups<Index> branches(num_points(), [&](const auto& add) {
      for (const Index point : search_.order()) {
        if (search_.parent(point) >= 0) add(search_.parent(point), point);
      }
    });
    std::vector<Index> open{search_.order().front()}, result, own;
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
  BreadthFirstSearch search_;
  std::vector<Index> size_;          // [point]
  std::vector<std::uint64_t> hash_;  // [point]
};

}  // namespace tanor::detail
