#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <string_view>

namespace tanor::report {

/// A number for people, in a format such as "{:.1e}"; where it is none, a word that says so.
inline std::string in_words(double number, std::string_view format = "{}") {
  if (std::isfinite(number)) return fmt::format(fmt::runtime(format), number);
  if (std::isnan(number)) return "undefined";
  return number > 0.0 ? "infinite" : "-infinite";
}

}  // namespace tanor::report
