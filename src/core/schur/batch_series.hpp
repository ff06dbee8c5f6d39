#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "evaluate/rod_series.hpp"
#include "schur/equal_islands.hpp"
#include "schur/needed_terms.hpp"

namespace tanor::detail {

/// The motion of equal islands of rods of fixed length as a power series, eight islands side by side: rings, bodies,
/// small trees and nets. The recurrences are those of PathSeries; S is eliminated by the schedule of the islands.
class BatchSeries {
 public:
  /// Takes the islands that it serves out of `islands`, none of which has lengths that move. `inverse_mass` is [point].
  BatchSeries(const Constraints& constraints, const Numbering& numbering, std::span<const double> inverse_mass,
              std::vector<Index>* islands);

  bool is_empty() const { return batches_.empty(); }
  std::size_t num_groups() const { return batches_.size(); }
  /// See LaneSeries::expand.
  double expand(const Parallel& parallel, std::span<double* const> coefficients, const double* lambda, int passes,
                const NeededTerms& needed, std::span<std::uint8_t> last_term);

 private:
  using Series = RodSeries<num_lanes>;
  using Terms = TermCounter<num_lanes>;
  /// The arrays of a thread, [rod] or [place]. The caches keep them from one batch to the next.
  struct Room {
    std::vector<Series::Rod> rods;
    std::vector<Pack3<>> u;                   // a_0/|a_0|
    std::vector<Series::Coefficient> series;  // [rod][order]
    std::vector<Pack3<>> points;              // r of the current order
    std::vector<Terms::Weights> weights;      // of the moving points
    Packs rows;
  };
  struct Lanes;
  double expand(const EqualIslands::Batch& batch, std::span<double* const> coefficients, const double* lambda,
                int passes, const NeededTerms& needed, std::span<std::uint8_t> last_term, Room* room) const;

  std::vector<EqualIslands> equal_islands_;
  struct BatchNumber {
    std::size_t islands, number;
  };
  std::vector<BatchNumber> batches_;
  std::vector<Room> rooms_;      // [thread]
  std::vector<double> longest_;  // [batch] see FoundTerms
};

}  // namespace tanor::detail
