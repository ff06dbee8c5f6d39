#pragma once

#include <memory>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "evaluate/rod_series.hpp"
#include "schur/tree_groves.hpp"
#include "schur/tree_lanes.hpp"

namespace tanor::detail {

/// The motion of trees of rods of fixed length as a power series, see LaneSeries. The recurrences are those of
/// PathSeries, with a_0 in the place of its direction, so that lengths drop out: x = lambda_k/((k+1)(k+2)|a_0|). S is
/// eliminated as by TreeSolver. An order goes down along the pieces of trees and ends; the next one begins on the way
/// up.
class TreeSeries {
 public:
  /// Takes trees out of `islands`, whose rows are `rods` of fixed lengths. Returns null if there are none. Keeps no
  /// reference.
  static std::unique_ptr<TreeSeries> make(const RodRows& rods, const Numbering& numbering,
                                          std::span<const double> inverse_mass, int threads,
                                          std::vector<Index>* islands);

  /// Computes r_3 … r_P of the trees from r_0, r_1, r_2 of coefficients[0 … P], each [3n], and from lambda_0 [d]. Those
  /// of supports are 0 from the third on. `passes` is the number of solves at each order; more than one refine.
  void expand(const Parallel& parallel, std::span<double* const> coefficients, const double* lambda, int passes);

 private:
  using Series = RodSeries<num_lanes>;
  /// The arrays of a grove.
  struct Room {
    std::vector<Series::Known> next;          // [rod] that of the next order
    Packs half_squares;                       // [rod] of the current order, for later passes
    std::vector<Series::Coefficient> series;  // [rod][order]
    std::vector<Pack3<>> points, known;       // [place] r of the current order; the known forces there, scaled as r

    void hold(std::size_t num_rods, std::size_t num_places, std::size_t stride);
  };
  struct Expansion;
  struct Solve;
  class Pieces;

  TreeSeries(TreePieces pieces, const RodRows& rods, std::span<const double> inverse_mass, std::size_t num_moving,
             int threads);
  void expand(const Expansion& expansion, const GroveVisit& visit);

  TreeLanes lanes_;
  std::vector<Room> rooms_;  // [thread]
};

}  // namespace tanor::detail
