#pragma once

#include <limits>
#include <stdexcept>
#include <string>

namespace tanor::detail {

/// Checks that a count fits into an int, by which entries of matrices are counted, as in CHOLMOD. Throws
/// std::length_error if it does not: "S of 70000 rows: 2450035000 nonzeros of L, above 2^31 - 1 = 2147483647". `what`
/// says what is counted, `of` where.
inline void check_count(double count, const std::string& of, const std::string& what) {
  constexpr double most = std::numeric_limits<int>::max();
  if (count <= most) return;
  throw std::length_error(of + ": " + std::to_string(static_cast<unsigned long long>(count)) + ' ' + what +
                          ", above 2^31 - 1 = 2147483647");
}

}  // namespace tanor::detail
