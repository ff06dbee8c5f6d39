#pragma once

#include <string>

namespace tanor::detail {

/// Returns "0.5 J", or "0.5" without letters.
inline std::string with_unit(const std::string& number, const std::string& letters) {
  return letters.empty() ? number : number + " " + letters;
}

}  // namespace tanor::detail
