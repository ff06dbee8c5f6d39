#pragma once

#include <vector>

#include <tanor/constrainer.hpp>

#include "dynamics/linearization.hpp"
#include "host/point_transfer.hpp"
#include "host/row_sums.hpp"

namespace tanor::detail {

/// Writes what a call wants of the constraints' forces into the host's arrays: multipliers, K lambda, stress.
class ReactionWriter {
 public:
  /// All arguments outlive it. `host_row` [inner row] is the host's number of the row.
  ReactionWriter(const Workspace& work, const Linearization& linearization, const PointTransfer& transfer,
                 RowSums& sums, const std::vector<Index>& host_row)
      : model_(work.model()),
        linearization_(linearization),
        transfer_(transfer),
        sums_(sums),
        host_row_(host_row),
        eta_(3 * work.model().num_points()) {}

  /// Writes what is wanted, except at supports, for `multipliers` [d] times `factor`, which belong to the K evaluated
  /// at r.
  void write(const double* multipliers, double factor, const double* r, const ConstraintForces& wanted);
  /// Adds to what the host's arrays hold at supports, which several parts may share.
  void add_to_supports(const ConstraintForces& wanted) const;

 private:
  const Model& model_;
  const Linearization& linearization_;
  const PointTransfer& transfer_;
  RowSums& sums_;
  const std::vector<Index>& host_row_;
  std::vector<double> eta_;     // [3n]
  std::vector<double> stress_;  // [9n], made on first use
};

}  // namespace tanor::detail
