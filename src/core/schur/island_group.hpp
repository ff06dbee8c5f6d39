#pragma once

#include <span>
#include <vector>

#include "base/index_ranges.hpp"
#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// Some islands of a system with all that belongs to them. Each function reads and writes only the rows and the moving
/// points of these islands.
struct IslandGroup {
  IslandGroup(const SchurProblem& problem, std::span<const Index> islands);

  const Constraints& constraints;
  const ReactionGather& gather;
  std::span<const double> inverse_mass;  ///< [point]
  IndexRanges rows, points;
  std::vector<Index> island_start;  ///< first row of each island, counted in `rows`, then their number
  Constraints::Selection members;

  std::size_t num_islands() const { return island_start.size() - 1; }

  /// Computes points += M^-1 K lambda [3n].
  void add_reactions(const Parallel& parallel, const double* blocks, const double* lambda, double* to) const {
    gather.add_scaled(parallel, blocks, lambda, inverse_mass.data(), points, to);
  }
  /// Computes y += x [d].
  void add_rows(const Parallel& parallel, const double* x, double* y) const {
    rows.for_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      for (std::size_t a = begin; a < end; ++a) y[a] += x[a];
    });
  }
};

}  // namespace tanor::detail
