#pragma once

#include <span>
#include <vector>

#include <tanor/system.hpp>

namespace tanor::detail {

/// Cuts the islands into at most 16 parts of similar size, of whole islands each. Parts are factorized and solved side
/// by side. The cut does not depend on the number of threads, so neither do the results. `island_start` holds the first
/// row of each island, then d. Returns the first row of each part, then d.
std::vector<Index> partition_islands(std::span<const Index> island_start);

/// Returns true if a part should be worked on by all threads, before the others are shared among them: it would keep
/// the others waiting, and threads of its own make it faster. `cost` is in the unit of `all`, that of all parts.
inline bool runs_alone(double cost, double all, int threads, bool gains_by_threads) {
  return gains_by_threads && threads * cost > all;
}

}  // namespace tanor::detail
