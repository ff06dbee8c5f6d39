#pragma once

#include "evaluate/tangents.hpp"
#include "friction/laws.hpp"

namespace tanor::detail {

/// Returns the friction of a contact that sticks, N: its reference plus the multipliers of its own rows, lambda [rows].
Vec3 held_friction(const Tangents& tangents, const FrictionLaws& laws, std::size_t contact, const double* lambda);

/// Returns the largest friction that the contact could hold, mu_s |N| at lambda [rows], N.
inline double static_limit(const FrictionLaws& laws, std::size_t contact, const double* lambda) {
  return laws.static_coefficient(contact) * norm(laws.normal_force(contact, lambda));
}

}  // namespace tanor::detail
