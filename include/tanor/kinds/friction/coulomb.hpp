#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// tau = -mu |N| v_rel/|v_rel|, where N is the force of the guides on the point (17), (41).
struct Coulomb {
  enum class Reaction {
    Guide,  ///< the force of the named guides alone; a rod that pulls at the bead takes no part
    Full    ///< eta_i of the point, whatever its origin, which is the paper's literal law
  };
  std::string name{};
  std::vector<std::string> at{};
  double coefficient = 0.0;                    ///< mu, >= 0
  std::optional<double> static_coefficient{};  ///< mu_s >= mu; mu by default
  /// m/s, > 0: v0 of v_rel/sqrt(v_rel^2 + v0^2), which replaces v_rel/|v_rel| and creeps. By default the law is exact,
  /// with stick.
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

  /// Returns mu |N|, or the regularised mu |N| |v|/sqrt(v^2 + v0^2).
  template <class T>
  static T magnitude(const Coulomb& law, double speed, const T& normal) {
    if (!law.regularisation) return law.coefficient * normal;
    return law.coefficient * speed / std::hypot(speed, *law.regularisation) * normal;
  }
  static constexpr bool is_proportional = true;
  static bool reads_full_reaction(const Coulomb& law) { return law.reaction == Coulomb::Reaction::Full; }

  static bool sticks(const Coulomb& law) { return !law.regularisation; }
  static double static_coefficient(const Coulomb& law) { return law.static_coefficient.value_or(law.coefficient); }
  static bool is_without_effect(const Coulomb& law) {
    return law.coefficient == 0.0 && law.static_coefficient.value_or(0.0) == 0.0;
  }

  template <class Check>
  static void check(const Coulomb& law, const Check& check) {
    constexpr const char* limit = "/static_coefficient";
    check.choice("/reaction", law.reaction, Coulomb::Reaction::Full);
    if (law.static_coefficient && *law.static_coefficient < law.coefficient) {
      check.fail(limit, "static_coefficient ", *law.static_coefficient, " is less than the coefficient ",
                 law.coefficient, "; it is at least as large");
    }
    if (!law.regularisation) return;
    check.number("/law/regularised", "regularised", *law.regularisation, ValueRange::positive);
    if (law.static_coefficient)
      check.fail(limit, "stands beside a regularised law, which has no stick; leave it out, or take the exact law");
  }
  static std::string variant(const Coulomb& law) {
    return std::string(law.regularisation ? "regularised" : "exact") +
           (law.reaction == Coulomb::Reaction::Full ? ", full reaction" : "");
  }
};

}  // namespace tanor
