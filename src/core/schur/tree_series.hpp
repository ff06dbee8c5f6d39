#pragma once

#include <memory>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "evaluate/rod_series.hpp"
#include "schur/tree_branches.hpp"
#include "schur/tree_groves.hpp"
#include "schur/tree_trunks.hpp"

namespace tanor::detail {

/// The motion of trees of rods of fixed length as a power series, see LaneSeries. The recurrences are those of
/// PathSeries; S is eliminated as by TreeSolver. The products of an order know no neighbours, so the rods of trunks
/// have lanes there, too.
///
/// An order goes up along the branches, up and down along the trunks and down along the branches. On its way, a batch
/// of branches ends one order and begins the next one.
class TreeSeries {
 public:
  /// Takes trees that consist of equal branches for the most part out of `islands`, whose rows are `rods` of fixed
  /// lengths. Returns null if there are none. Keeps a reference to `inverse_mass` [point].
  static std::unique_ptr<TreeSeries> make(const RodRows& rods, const Numbering& numbering,
                                          std::span<const double> inverse_mass, int threads,
                                          std::vector<Index>* islands);

  /// Computes r_3 … r_P of the trees from r_0, r_1, r_2 of coefficients[0 … P], each [3n], and from lambda_0 [d]. Those
  /// of supports are 0 from the third on. `passes` is the number of solves at each order; more than one refine.
  void expand(const Parallel& parallel, std::span<double* const> coefficients, const double* lambda, int passes);

 private:
  using Series = RodSeries<num_lanes>;
  struct Extent {
    std::size_t slots = 0, places = 0;
  };
  /// The arrays of a grove. A slot has eight rods: one of each branch of a batch, or eight of a trunk.
  struct Room {
    std::vector<Series::Rod> rods;            // [slot]
    std::vector<Series::Coefficient> series;  // [batch, then trunk][order][slot]
    std::vector<Pack3<>> points;              // [place] r of the current order

    void hold(const Extent& extent, std::size_t orders);
  };
  struct Expansion;
  struct Solve;
  class Branches;
  class Trunk;

  TreeSeries(const TreesInLanes& chosen, const RodRows& rods, const Numbering& numbering,
             std::span<const double> inverse_mass, int threads);
  void lay_out();
  void expand(const Expansion& expansion, const GroveVisit& visit);

  TreeBranches branches_;
  TreeTrunks trunks_;
  TreePoints points_;
  TreeGroves groves_;
  std::span<const double> inverse_mass_;
  std::vector<Extent> before_batch_, before_trunk_;  // where its slots and places begin in the room
  std::vector<Extent> of_grove_;
  std::vector<trees::Mobility<Vec3>> root_mobility_;  // [batch][lane] that of the branch alone
  std::vector<double> rows_;                          // [d] right sides, then x, of the rods of trunks
  std::vector<double> force_;                         // [3n] known forces of these rods, scaled as r of the order
  std::vector<Room> rooms_;                           // [thread]
};

}  // namespace tanor::detail
