#pragma once

#include <vector>

#include <tanor/constrainer.hpp>

#include "dynamics/linearization.hpp"
#include "host/point_transfer.hpp"
#include "host/row_sums.hpp"

namespace tanor {

/// What a call may write of the constraints' forces, on the way into the host's arrays: multipliers, K lambda, stress.
class ReactionWriter {
 public:
  /// All outlive it; `host_row` [inner row] is the host's number of it.
  ReactionWriter(const Workspace& work, const Linearization& linearization, const PointTransfer& transfer,
                 RowSums& sums, const std::vector<Index>& host_row)
      : model_(work.model()),
        linearization_(linearization),
        transfer_(transfer),
        sums_(sums),
        host_row_(host_row),
        eta_(3 * work.model().num_points()) {}

  /// Writes what is wanted, but at supports, of `multipliers` [d] times `factor`, which belong to the K that stands at
  /// r.
  void write(const double* multipliers, double factor, const double* r, const ConstraintForces& wanted);
  /// At supports, which several parts may share: adds to what the host's arrays hold.
  void add_to_supports(const ConstraintForces& wanted) const;

 private:
  const Model& model_;
  const Linearization& linearization_;
  const PointTransfer& transfer_;
  RowSums& sums_;
  const std::vector<Index>& host_row_;
  std::vector<double> eta_;     // [3n]
  std::vector<double> stress_;  // [9n], made where it is first wanted
};

}  // namespace tanor
