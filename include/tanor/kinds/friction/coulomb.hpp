#pragma once

#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// -mu |N| v_rel/|v_rel|, N the force of the guides on the point (17), (41).
struct Coulomb {
  enum class Reaction {
    Guide,  ///< of the named guides alone: a rod that pulls at the bead takes no part
    Full    ///< eta_i of the point, whatever makes it: the paper's literal law
  };
  std::string name{};
  std::vector<std::string> at{};
  double coefficient = 0.0;                    ///< mu, >= 0
  std::optional<double> static_coefficient{};  ///< mu_s >= mu; default: mu
  /// m/s, > 0: v_rel/sqrt(v_rel^2 + v0^2) in place of v_rel/|v_rel|, which creeps. Default: exact, with stick.
  std::optional<double> regularisation{};
  VectorFunction velocity{};  ///< m/s
  Reaction reaction = Reaction::Guide;
};

template <>
struct KindOf<Coulomb> {
  static constexpr std::string_view name = "coulomb";
  static constexpr std::tuple fields{
      FieldOf("coefficient", &Coulomb::coefficient, {.range = ValueRange::not_negative, .is_required = true}),
      FieldOf("static_coefficient", &Coulomb::static_coefficient, {.range = ValueRange::not_negative}),
      FieldOf("velocity", &Coulomb::velocity, {.unit = "m/s"})};

  static bool is_without_effect(const Coulomb& law) {
    return law.coefficient == 0.0 && law.static_coefficient.value_or(0.0) == 0.0;
  }
  static bool sticks(const Coulomb& law) { return !law.regularisation; }
};

}  // namespace tanor
