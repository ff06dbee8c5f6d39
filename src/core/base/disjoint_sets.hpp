#pragma once

#include <algorithm>
#include <cstddef>

/// \file
/// Disjoint sets of numbers, kept in an array (Tarjan 1975). parent[i] is another member of the set of i, nearer to its
/// root, or i itself if i is the root. Initially each number is its own parent.
namespace tanor::detail {

/// Returns the root of the set of i, and shortens the path to it for later calls.
template <class Integer>
Integer find_root(Integer* parent, Integer i) {
  const auto up = [parent](Integer k) -> Integer& { return parent[static_cast<std::size_t>(k)]; };
  while (up(i) != i) i = up(i) = up(up(i));
  return i;
}

/// Joins the sets of i and j and returns the root of the union, the smaller one of both roots. If sets are joined by
/// this function alone, every root is the least member of its set.
template <class Integer>
Integer join_sets(Integer* parent, Integer i, Integer j) {
  const Integer a = find_root(parent, i), b = find_root(parent, j);
  return parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
}

}  // namespace tanor::detail
