#include "plan/partition.hpp"

#include <algorithm>

namespace tanor {

std::vector<Index> partition_islands(std::span<const Index> island_start) {
  constexpr Index most_parts = 16, least_rows = 512;  // below that a part is not worth its overhead
  const Index num_rows = island_start.back();
  const Index wanted = std::clamp<Index>(num_rows / least_rows, 1, most_parts);
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

}  // namespace tanor
