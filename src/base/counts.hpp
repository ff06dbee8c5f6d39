#pragma once

#include <limits>
#include <stdexcept>
#include <string>

namespace tanor {

/// Entries of matrices are counted by int, as CHOLMOD counts them. Throws std::length_error where a system needs more:
/// "S of 70000 rows: 2450035000 nonzeros of L, above 2^31 - 1 = 2147483647". `what` says what is counted, `of` where.
inline void check_count(double count, const std::string& of, const std::string& what) {
  constexpr double most = std::numeric_limits<int>::max();
  if (count <= most) return;
  throw std::length_error(of + ": " + std::to_string(static_cast<unsigned long long>(count)) + ' ' + what +
                          ", above 2^31 - 1 = 2147483647");
}

}  // namespace tanor
