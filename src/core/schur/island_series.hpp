#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "schur/needed_terms.hpp"

namespace tanor::detail {

/// Computes r_3 … r_P of islands from r_0, r_1, r_2 of coefficients[0 … P], each [3n], and from lambda_0 [d]. Those of
/// other points stay as they are; of supports, they are 0 from the third on. Terms that are not needed are 0.
struct LaneExpansion {
  std::span<double* const> coefficients;
  const double* lambda;
  int passes;  ///< the number of solves at each order; more than one refine
  NeededTerms needed;
  std::span<std::uint8_t> last_term;  ///< [n] gets the number of each point's last term that is not 0

  bool is_counting() const { return !needed.are_all(); }
  int order() const { return static_cast<int>(coefficients.size()) - 1; }
  /// Returns how far apart the series of rods stand. The number is odd: with a power of 2, they would meet in the same
  /// few lines of the caches.
  std::size_t stride() const { return coefficients.size() | 1; }
};

/// The motion of some islands as a power series.
class IslandSeries {
 public:
  virtual ~IslandSeries() = default;

  /// Returns in how many parts the islands are expanded, each of which has as many terms as it needs.
  virtual std::size_t num_parts() const = 0;
  /// Returns the longest step that the islands serve whose terms end earlier than others', s.
  virtual double expand(const Parallel& parallel, const LaneExpansion& expansion) = 0;
};

}  // namespace tanor::detail
