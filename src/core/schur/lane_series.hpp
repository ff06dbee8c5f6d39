#pragma once

#include <memory>
#include <span>
#include <vector>

#include <tanor/system.hpp>

#include "base/index_ranges.hpp"
#include "evaluate/constraints.hpp"
#include "schur/needed_terms.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// The motion as a power series of the islands of rods that share SIMD lanes, if all forces are gravity, supports rest
/// and lengths are fixed: equal islands, paths, rings and trees. It does what MotionSeries and a solve an order do in
/// general, but fused and with everything kept in lanes between the orders.
class LaneSeries {
 public:
  /// Keeps a reference to `inverse_mass` [point].
  LaneSeries(const System& system, const Constraints& constraints, const Numbering& numbering,
             std::span<const double> inverse_mass, int threads);

  bool serves_some() const { return !series_.empty(); }
  bool serves_all() const { return serves_all_; }
  /// Returns in how many parts the islands are expanded, each of which has as many terms as it needs.
  std::size_t num_parts() const;
  /// Returns the part of all rows that is left to others.
  double share_left() const { return share_left_; }
  /// Returns what is left to others: a flag for each row [d], and the moving points.
  std::span<const char> left_rows() const { return left_rows_; }
  const IndexRanges& left_points() const { return left_points_; }

  /// Returns the longest step that the islands serve whose terms end earlier than others', s.
  double expand(const Parallel& parallel, const LaneExpansion& expansion);

 private:
  std::vector<std::unique_ptr<IslandSeries>> series_;
  bool serves_all_ = false;
  double share_left_ = 1.0;
  std::vector<char> left_rows_;
  IndexRanges left_points_;
};

}  // namespace tanor::detail
