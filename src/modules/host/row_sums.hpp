#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "base/block3.hpp"
#include "base/groups.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// A row of K with one block for both of its points: the gradient at j, and its opposite at i.
struct RodRow {
  Index row, block, i, j;
};
std::vector<RodRow> list_rods(const Workspace& work);

/// Sums over the rows, weighted by their multipliers. With F_p = lambda g_p at the points p of a row, g_p being its
/// gradient,
///
///   virial = sum of r_p (x) F_p = sum of (r_p - c) (x) F_p + c (x) sum of F_p,   c: the centroid of the row's points
///
/// A rod of length L along the unit vector u adds lambda L u (x) u, whatever image of its end it joins.
class RowSums {
 public:
  /// The workspace outlives the sums.
  explicit RowSums(const Workspace& work);

  /// Returns the virial xx, yy, zz, xy, xz, yz for multipliers `lambda` [d] times `factor`, with K in blocks at r [3n]
  /// and the present time. The order of the sum does not depend on the number of threads.
  std::array<double, 6> virial(const double* lambda, double factor, const double* blocks, const double* r);
  /// Shares the same out among the points of each row, as `stress` [9n].
  void share_virial(const double* lambda, double factor, const double* blocks, const double* r, double* stress);
  /// Returns the largest angle (rad) between a rod at r and its gradient in `blocks`, taken at r_old, where rods have
  /// their lengths. `changes` are those of the rods' offsets from there on.
  double largest_turn(const double* blocks, const double* r_old, const double* r,
                      std::span<const Constraints::RowOffset> changes);
  const std::vector<RodRow>& rods() const { return rods_; }
  /// Returns the lengths [d] by which violations are measured, at the present time.
  const std::vector<double>& lengths();
  /// Returns the row with the largest |rows|/length; `worst_row` returns that with the largest |rows|.
  std::size_t worst_position_row(const std::vector<double>& rows);
  static std::size_t worst_row(const std::vector<double>& rows);

 private:
  struct End {
    Index point, block;
    double sign;
  };
  Block3 sum_rod_virials(std::span<const RodRow> rods, const double* lambda, double factor, const double* blocks) const;
  template <class Add>
  void split_row(std::size_t row, double lambda, const double* blocks, const double* r, const Add& add) const;

  const Workspace& work_;
  const Model& model_;
  std::vector<RodRow> rods_;
  Groups<End> others_;  // [row] empty for rods
  std::vector<Index> other_rows_;
  std::vector<double> lengths_;  // [d]
  bool knows_lengths_ = false;   // `lengths_` is written and constant
};

}  // namespace tanor::detail
