#pragma once

#include <metis.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

#include <tanor/error.hpp>

namespace tanor {

/// Throws InputError if the points to be cut have more neighbours, counted for each point, than METIS and our lists of
/// neighbours can count.
inline void require_metis_counts(std::size_t neighbours) {
  constexpr std::int64_t most_of_metis = std::numeric_limits<idx_t>::max(),
                         most_of_ours = std::numeric_limits<std::int32_t>::max();
  constexpr auto most = static_cast<std::size_t>(std::min(most_of_metis, most_of_ours));
  if (neighbours <= most) return;
  throw InputError("", "an island is to be cut whose points have " + std::to_string(neighbours) +
                           " neighbours together; METIS counts to " + std::to_string(most));
}

}  // namespace tanor
