#pragma once

#include <variant>

#include <tanor/forward.hpp>
#include <tanor/kinds.hpp>

#include "system/friction_magnitude.hpp"

/// \file Evaluates what the files of the laws of friction define, for any list of laws.
namespace tanor::detail {

enum class LawForm {
  Given,         ///< a magnitude that depends on the speed alone
  Proportional,  ///< mu(speed) |N|
  Magnitude,     ///< any other magnitude that depends on |N|
  ThreeParts     ///< a force in any direction
};

template <class Law>
constexpr LawForm form_of() {
  if (HasForceOfFriction<Law>) return LawForm::ThreeParts;
  if (IsProportionalFriction<Law>) return LawForm::Proportional;
  return ReadsNormalForce<Law> ? LawForm::Magnitude : LawForm::Given;
}

template <class T, class... Laws>
T magnitude(const std::variant<Laws...>& friction, double speed, const T& normal) {
  return std::visit([&](const auto& law) { return magnitude_of(law, speed, normal); }, friction);
}

/// Returns the derivative of `magnitude` in |N|.
template <class... Laws>
double slope_in_normal_force(const std::variant<Laws...>& friction, double speed, double normal) {
  return magnitude(friction, speed, Forward<1>::variable(normal, 0)).d[0];
}

}  // namespace tanor::detail
