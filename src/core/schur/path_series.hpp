#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <tanor/system.hpp>

#include "base/parallel.hpp"
#include "schur/needed_terms.hpp"
#include "schur/rod_lanes.hpp"

namespace tanor::detail {

/// The motion of paths of rods of fixed length as a power series, see LaneSeries.
///
/// With a = r_{i+1} - r_i, u = a_0/|a_0| and the force mu a = lambda a/|a_0| on the rod's end, order k obeys
///
///   (k+1)(k+2) r_{k+2} = M^-1 (sum over j = 0 … k of a_j mu_{k-j}, of the rods that meet)
///   |a_0| u.a_{k+2} = -(1/2) sum over j = 1 … k+1 of a_j.a_{k+2-j}
///
/// The unknown mu_k is found by elimination along the path. A path that is cut into lanes is eliminated piece by piece,
/// the separators last. L then has one more row a piece, which joins it to the separator before it.
class PathSeries {
 public:
  /// Takes the islands that are paths out of `islands`, whose rows are `rods`. `inverse_mass` is [point].
  PathSeries(const RodRows& rods, const Numbering& numbering, std::span<const double> inverse_mass,
             std::vector<Index>* islands);
  ~PathSeries();

  bool is_empty() const { return num_groups() == 0; }
  std::size_t num_groups() const;
  /// See LaneSeries::expand.
  double expand(const Parallel& parallel, std::span<double* const> coefficients, const double* lambda, int passes,
                const NeededTerms& needed, std::span<std::uint8_t> last_term);

 private:
  struct AnyGroup;
  struct Rooms;

  std::vector<AnyGroup> groups_;
  std::vector<Rooms> rooms_;     // [thread]
  std::vector<double> longest_;  // [group] see FoundTerms
};

}  // namespace tanor::detail
