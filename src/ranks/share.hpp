#pragma once

#include <cstddef>
#include <vector>

#include <tanor/ranks.hpp>

namespace tanor {

/// Things that each rank has some of, numbered one rank behind the other.
struct Share {
  Share() = default;
  /// Of a rank that has `own` of them. Collective.
  Share(Ranks& ranks, std::size_t own);

  std::vector<std::size_t> start{0};  ///< [rank + 1] numbers of the ranks' first ones; how many there are
  std::size_t first = 0;              ///< of this rank

  std::size_t all() const { return start.back(); }
};

}  // namespace tanor
