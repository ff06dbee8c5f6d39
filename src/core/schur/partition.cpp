#include "schur/partition.hpp"

#include <algorithm>

#include "plan/thresholds.hpp"

namespace tanor::detail {

std::vector<Index> partition_islands(std::span<const Index> island_start) {
  const Index num_rows = island_start.back();
  const Index wanted = std::clamp<Index>(num_rows / plan::least_rows_of_part, 1, plan::most_parts);
  std::vector<Index> result{0};
  for (const Index start : island_start) {
    const auto next = static_cast<Index>(result.size());
    if (start < num_rows && next < wanted && start >= static_cast<long long>(num_rows) * next / wanted) {
      result.push_back(start);
    }
  }
  if (num_rows > 0) result.push_back(num_rows);
  return result;
}

}  // namespace tanor::detail
