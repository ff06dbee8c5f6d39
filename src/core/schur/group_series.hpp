#pragma once

#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "evaluate/rod_series.hpp"
#include "schur/lane_groves.hpp"
#include "schur/needed_terms.hpp"

namespace tanor::detail {

/// The motion of groups of islands, or of pieces of trees and paths, of rods of fixed length as a power series, see
/// LaneSeries. With a = r_j - r_i and the force mu a = lambda a/|a_0| on the rod's end j, order k obeys
///
///   (k+1)(k+2) r_{k+2} = M^-1 (sum over j = 0 … k of a_j mu_{k-j}, of the rods that meet)
///   a_0.a_{k+2} = -(1/2) sum over j = 1 … k+1 of a_j.a_{k+2-j}
///
/// The unknown mu_k is found as LaneSolver finds multipliers, with a_0 in the place of a rod's direction, so that
/// lengths drop out: x = mu_k/((k+1)(k+2)). A group that stands alone goes through all orders that it needs while it is
/// in the cache. An order of pieces goes up and down all of them.
class GroupSeries final : public IslandSeries {
 public:
  /// Keeps no reference.
  GroupSeries(LanePlan plan, const RodRows& rods, const Numbering& numbering, std::span<const double> inverse_mass,
              int threads)
      : groups_(std::move(plan), rods, inverse_mass, numbering.num_moving, threads) {}

  std::size_t num_parts() const override { return groups_.plan().num_groves(); }
  double expand(const Parallel& parallel, const LaneExpansion& expansion) override;

 private:
  using Largest = TermCounter::Largest;
  struct Solve;
  /// The arrays of a grove.
  struct Room {
    Packs series, next;  // [group][part of the lanes][rod][order] RodSeries::Coefficient, and Known of the next order
    Packs half_squares;  // [rod] of the current order, for later passes
    std::vector<Pack3<>> known;                 // [place] the known forces there, scaled as r
    std::vector<TermCounter::Weights> weights;  // [place]
    std::vector<Largest> largest;               // [group] of the current order
    std::vector<Largest> of_islands;            // [island / lanes] of the current order
    std::vector<TermCounter> counters;          // [island / lanes]
    std::size_t first_island = 0;
    double longest = any_length;  // see FoundTerms

    void hold(const LaneExpansion& expansion, const GroveVisit& visit);
    /// Notes an order. Returns true if no island needs more.
    bool note(const GroveVisit& visit, int order);
  };
  class Rods;
  static constexpr std::size_t packs_of_rod = sizeof(RodSeries<num_lanes>::Coefficient) / sizeof(Pack<>);

  void expand(const LaneExpansion& expansion, const GroveVisit& visit);

  LaneGroups groups_;
  std::vector<Room> rooms_;  // [thread]
};

}  // namespace tanor::detail
