#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

enum class PairLaw {
  Wca,      ///< Lennard-Jones cut at its minimum: repulsion alone
  Lj,       ///< Lennard-Jones, cut and shifted
  Log,      ///< potential -strength ln r, without a cutoff
  Coulomb,  ///< strength q_i q_j/r, without a cutoff
  Yukawa,   ///< strength exp(-r/length)/r
  Morse,    ///< depth (1 - exp(-width (r - rest_length)))^2
};

/// Between any two of the points at a distance r, along the line that joins them.
///
/// Yukawa and Morse with a cutoff: minus their value there, 0 beyond it; without one each pair counts.
/// Wca, Lj: potential 4 epsilon ((sigma/r)^12 - (sigma/r)^6) - its value at the cutoff, 0 beyond that; with a box the
/// nearest image of the other point counts, wherever in space both are. Log: strength (r_i - r_j)/r^2 on point i.
/// Supports take part; what two of them do to each other is in the load that they carry, but in no energy and no work.
struct PairForces {
  std::string name{};
  std::vector<Index> points{};  ///< empty: all
  PairLaw law = PairLaw::Wca;
  double epsilon = 1.0;            ///< J, > 0 (Wca, Lj)
  double sigma = 1.0;              ///< m, > 0 (Wca, Lj)
  std::optional<double> cutoff{};  ///< m, > 0 (Lj; default 2.5 sigma; Yukawa, Morse: none); of Wca 2^(1/6) sigma
  double strength = 1.0;           ///< N m (Log) or J m (Coulomb, Yukawa); negative: attraction
  Vector3 box{};              ///< m, edges of the periodic box (laws with a cutoff); 0: not periodic along this axis
  bool exclude_rods = false;  ///< points that a rod joins leave each other alone
  std::vector<double> charges{};  ///< one for all points, or one each in their order (Coulomb)
  double length = 1.0;            ///< m, > 0 (Yukawa)
  double depth = 1.0;             ///< J, > 0 (Morse)
  double width = 1.0;             ///< 1/m, > 0 (Morse)
  double rest_length = 0.0;       ///< m, >= 0 (Morse)
};

template <>
struct KindOf<PairForces> {
  static constexpr std::string_view name = "pair";
  static constexpr auto members = &PairForces::points;
  static constexpr std::tuple fields{
      FieldOf("epsilon", &PairForces::epsilon, {.unit = "J", .range = ValueRange::positive}),
      FieldOf("sigma", &PairForces::sigma, {.unit = "m", .range = ValueRange::positive}),
      FieldOf("strength", &PairForces::strength, {.unit = "N m"}),
      FieldOf("cutoff", &PairForces::cutoff, {.unit = "m", .range = ValueRange::positive}),
      FieldOf("length", &PairForces::length, {.unit = "m", .range = ValueRange::positive}),
      FieldOf("depth", &PairForces::depth, {.unit = "J", .range = ValueRange::positive}),
      FieldOf("width", &PairForces::width, {.unit = "1/m", .range = ValueRange::positive}),
      FieldOf("rest_length", &PairForces::rest_length, {.unit = "m", .range = ValueRange::not_negative})};

  /// U of two points at a distance r whose charges have this product, J, over a scalar type: laws that are smooth
  /// wherever points are apart, without a cutoff.
  template <class T>
  static T smooth_energy(const PairForces& pairs, const T& r, const T& charges) {
    using std::exp;
    if (pairs.law == PairLaw::Coulomb) return pairs.strength * charges / r;
    if (pairs.law == PairLaw::Yukawa) return pairs.strength * exp(-r / pairs.length) / r;
    const T part = 1.0 - exp(-pairs.width * (r - pairs.rest_length));
    return pairs.depth * part * part;
  }
};

}  // namespace tanor
