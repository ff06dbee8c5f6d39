#pragma once

#include <cstddef>
#include <vector>

#include <tanor/ranks.hpp>

namespace tanor::detail {

/// Things that each rank has some of, numbered one rank behind the other.
struct Share {
  Share() = default;
  /// Makes the share of a rank that has `own` of them. Collective.
  Share(Ranks& ranks, std::size_t own);

  std::vector<std::size_t> start{0};  ///< [rank + 1] number of each rank's first one, then the number of all
  std::size_t first = 0;              ///< number of this rank's first one

  std::size_t all() const { return start.back(); }
};

}  // namespace tanor::detail
