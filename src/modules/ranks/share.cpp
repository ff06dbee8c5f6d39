#include "ranks/share.hpp"

namespace tanor::detail {

Share::Share(Ranks& ranks, std::size_t own) {
  const auto here = static_cast<std::size_t>(ranks.rank());
  std::vector<double> counts(static_cast<std::size_t>(ranks.size()), 0.0);
  counts[here] = static_cast<double>(own);
  ranks.sum(counts);
  for (const double count : counts) start.push_back(start.back() + static_cast<std::size_t>(count));
  first = start[here];
}

}  // namespace tanor::detail
