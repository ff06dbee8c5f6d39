#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "evaluate/rod_series.hpp"
#include "schur/lane_groves.hpp"
#include "schur/needed_terms.hpp"

namespace tanor::detail {

/// The motion of groups of islands, or of trees, of rods of fixed length as a power series, see LaneSeries. The
/// recurrences are those of PathSeries, with a_0 in the place of a rod's direction, so that lengths drop out:
/// x = lambda_k/((k+1)(k+2)|a_0|). S is eliminated as by LaneSolver. A group that stands alone goes through all orders
/// that it needs while it is in the cache. An order of pieces of trees goes down along them and ends; the next one
/// begins on the way up.
class GroupSeries {
 public:
  /// Keeps no reference.
  GroupSeries(LanePlan plan, const RodRows& rods, const Numbering& numbering, std::span<const double> inverse_mass,
              int threads)
      : groups_(std::move(plan), rods, inverse_mass, numbering.num_moving, threads) {}

  /// Returns how many groups have as many terms as they need.
  std::size_t num_groups() const;
  /// See LaneSeries::expand.
  double expand(const Parallel& parallel, std::span<double* const> coefficients, const double* lambda, int passes,
                const NeededTerms& needed, std::span<std::uint8_t> last_term);

 private:
  using Series = RodSeries<num_lanes>;
  using Terms = TermCounter<num_lanes>;
  /// The arrays of a grove.
  struct Room {
    std::vector<Series::Known> next;          // [rod] that of the next order
    Packs half_squares;                       // [rod] of the current order, for later passes
    std::vector<Series::Coefficient> series;  // [rod][order]
    std::vector<Pack3<>> known;               // [place] the known forces there, scaled as r
    std::vector<Terms::Weights> weights;      // [place]
    double longest = any_length;              // see FoundTerms

    void hold(const LanePlan::Extent& extent, std::size_t stride);
  };
  struct Expansion;
  struct Solve;
  class Rods;

  void expand(const Expansion& expansion, const GroveVisit& visit);

  LaneGroups groups_;
  std::vector<Room> rooms_;  // [thread]
};

}  // namespace tanor::detail
