#pragma once

#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// tau = -c v_rel
struct Viscous {
  std::string name{};
  std::vector<std::string> at{};
  double coefficient = 0.0;  ///< c, N s/m, >= 0
  VectorFunction velocity{};
};

template <>
struct KindOf<Viscous> {
  static constexpr std::string_view name = "viscous";
  static constexpr std::tuple fields{FieldOf("coefficient", &Viscous::coefficient,
                                             {.unit = "N s/m", .range = ValueRange::not_negative, .is_required = true}),
                                     FieldOf("velocity", &Viscous::velocity, {.unit = "m/s"})};

  static double magnitude(const Viscous& law, double speed) { return law.coefficient * speed; }
  static bool is_without_effect(const Viscous& law) { return law.coefficient == 0.0; }
};

}  // namespace tanor
