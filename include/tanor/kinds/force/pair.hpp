#pragma once

#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

enum class PairLaw {
  Wca,  ///< Lennard-Jones cut at its minimum: repulsion alone
  Lj,   ///< Lennard-Jones, cut and shifted
  Log,  ///< potential -strength ln r, without a cutoff
};

/// Between any two of the points at a distance r, along the line that joins them.
///
/// Wca, Lj: potential 4 epsilon ((sigma/r)^12 - (sigma/r)^6) - its value at the cutoff, 0 beyond that; with a box the
/// nearest image of the other point counts, wherever in space both are. Log: strength (r_i - r_j)/r^2 on point i.
/// Supports take part; what two of them do to each other is in the load that they carry, but in no energy and no work.
struct PairForces {
  std::string name{};
  std::vector<Index> points{};  ///< empty: all
  PairLaw law = PairLaw::Wca;
  double epsilon = 1.0;            ///< J, > 0 (Wca, Lj)
  double sigma = 1.0;              ///< m, > 0 (Wca, Lj)
  std::optional<double> cutoff{};  ///< m, > 0 (Lj; default 2.5 sigma); that of Wca is 2^(1/6) sigma
  double strength = 1.0;           ///< N m; negative: attraction (Log)
  Vector3 box{};                   ///< m, edges of the periodic box (Wca, Lj); 0: not periodic along this axis
  bool exclude_rods = false;       ///< points that a rod joins leave each other alone
};

template <>
struct KindOf<PairForces> {
  static constexpr std::string_view name = "pair";
  static constexpr auto members = &PairForces::points;
  static constexpr std::tuple fields{
      FieldOf("epsilon", &PairForces::epsilon, {.unit = "J", .range = ValueRange::positive}),
      FieldOf("sigma", &PairForces::sigma, {.unit = "m", .range = ValueRange::positive}),
      FieldOf("strength", &PairForces::strength, {.unit = "N m"}),
      FieldOf("cutoff", &PairForces::cutoff, {.unit = "m", .range = ValueRange::positive})};
};

}  // namespace tanor
