#pragma once

#include <memory>
#include <span>
#include <vector>

#include <tanor/system.hpp>

#include "base/parallel.hpp"
#include "schur/rod_lanes.hpp"

namespace tanor {

/// Computes the motion as a power series if all constraints are rods of fixed length along paths and all forces are
/// gravity. It does what MotionSeries and a solve an order do in general, but fused and with everything kept in lanes
/// between the orders.
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
  /// Returns null if the system has anything else. `inverse_mass` is [point].
  static std::unique_ptr<PathSeries> make(const System& system, const Numbering& numbering,
                                          std::span<const Incidence> incidences, std::span<const double> inverse_mass);
  ~PathSeries();

  /// Computes r_3 … r_P from r_0, r_1, r_2 of coefficients[0 … P], each [3n], and from lambda_0 [d]. `passes` is the
  /// number of solves at each order; more than one refine.
  void expand(const Parallel& parallel, std::span<double* const> coefficients, const double* lambda, int passes);

 private:
  struct AnyGroup;
  struct Rooms;
  PathSeries(std::vector<RodLanes> lanes, std::span<const Vector3> offsets, std::span<const double> inverse_mass);

  std::vector<AnyGroup> groups_;
  std::vector<Rooms> rooms_;  // [thread]
  std::vector<Index> still_;  // points that no rod holds; their r_3 … r_P are 0
};

}  // namespace tanor
