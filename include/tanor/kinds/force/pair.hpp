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

/// A force between any two of the points at a distance r, along the line that joins them.
///
/// Wca and Lj have the potential 4 epsilon ((sigma/r)^12 - (sigma/r)^6) minus its value at the cutoff, and 0 beyond it.
/// Yukawa and Morse with a cutoff are shifted and cut likewise; without one, each pair counts. Log exerts the force
/// strength (r_i - r_j)/r^2 on point i. With a box, the nearest image of the other point counts, wherever in space both
/// are. Supports take part. The force between two of them is in the load that they carry, but in no energy and no work.
struct PairForces {
  std::string name{};
  std::vector<Index> points{};  ///< all points if empty
  PairLaw law = PairLaw::Wca;
  double epsilon = 1.0;  ///< J, > 0 (Wca, Lj)
  double sigma = 1.0;    ///< m, > 0 (Wca, Lj)
  /// m, > 0 (Lj, default 2.5 sigma; Yukawa and Morse, default none); for Wca it is 2^(1/6) sigma.
  std::optional<double> cutoff{};
  double strength = 1.0;  ///< N m (Log) or J m (Coulomb, Yukawa); a negative one attracts
  Vector3 box{};          ///< m, edges of the periodic box (laws with a cutoff); 0 along an axis that is not periodic
  bool exclude_rods = false;      ///< if true, there is no force between points that a rod joins
  std::vector<double> charges{};  ///< one for all points, or one for each in their order (Coulomb)
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

  /// Returns the energy of two points at a distance r, J, over a scalar type; `charges` is the product of their
  /// charges. It serves the laws that are smooth wherever points are apart, without a cutoff.
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
