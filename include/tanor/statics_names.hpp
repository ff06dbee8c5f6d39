#pragma once

#include <tanor/enum_names.hpp>
#include <tanor/equilibrium.hpp>

/// \file
/// The words of the enumerations of statics, as <tanor/enum_names.hpp> has those of motion.
namespace tanor {

template <>
inline constexpr std::array<EnumName<EquilibriumMethod>, 3> enum_names<EquilibriumMethod>{
    {{EquilibriumMethod::Auto, "auto"},
     {EquilibriumMethod::Newton, "newton"},
     {EquilibriumMethod::Descent, "descent"}}};

template <>
inline constexpr std::array<EnumName<Stability>, 5> enum_names<Stability>{
    {{Stability::None, "none"},
     {Stability::Stable, "stable"},
     {Stability::Marginal, "marginal"},
     {Stability::Unstable, "unstable"},
     {Stability::NotConservative, "not_conservative"}}};

template <>
inline constexpr std::array<EnumName<AcceptedEquilibria>, 3> enum_names<AcceptedEquilibria>{
    {{AcceptedEquilibria::Stable, "stable"},
     {AcceptedEquilibria::Marginal, "marginal"},
     {AcceptedEquilibria::Any, "any"}}};

}  // namespace tanor
