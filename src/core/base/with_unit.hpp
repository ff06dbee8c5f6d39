#pragma once

#include <string>

namespace tanor::detail {

/// Returns "0.5 J", "0.5 x 48.88821 fs" where the unit is itself a number of others, or "0.5" without letters.
inline std::string with_unit(const std::string& number, const std::string& letters) {
  if (letters.empty()) return number;
  return number + (letters[0] >= '0' && letters[0] <= '9' ? " x " : " ") + letters;
}

}  // namespace tanor::detail
