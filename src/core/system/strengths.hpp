#pragma once

#include <span>
#include <string>
#include <variant>

#include <tanor/error.hpp>
#include <tanor/system.hpp>

#include "base/text.hpp"

namespace tanor::detail {

/// Returns the tensions at which members break, N, one for all or one for each; none if they do not.
inline std::span<const double> strengths_of(const Constraint& group) {
  return std::visit(
      [](const auto& of) -> std::span<const double> {
        if constexpr (requires { of.breaks_at; }) return of.breaks_at;
        return {};
      },
      group);
}

/// Throws InputError if members have a tension at which they break; `why` is the reason why they cannot.
inline void refuse_breaks(const System& system, const std::string& why) {
  for (std::size_t g = 0; g < system.constraints.size(); ++g)
    if (!strengths_of(system.constraints[g]).empty()) throw InputError("/constraints/" + text(g) + "/breaks_at", why);
}

}  // namespace tanor::detail
