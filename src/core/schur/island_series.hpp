#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "schur/needed_terms.hpp"

namespace tanor::detail {

/// The motion of some islands as a power series.
class IslandSeries {
 public:
  virtual ~IslandSeries() = default;

  /// Returns in how many parts the islands are expanded, each of which has as many terms as it needs.
  virtual std::size_t num_parts() const = 0;
  /// See LaneSeries::expand.
  virtual double expand(const Parallel& parallel, std::span<double* const> coefficients, const double* lambda,
                        int passes, const NeededTerms& needed, std::span<std::uint8_t> last_term) = 0;
};

}  // namespace tanor::detail
