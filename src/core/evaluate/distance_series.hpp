#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "base/vec3.hpp"
#include "evaluate/family.hpp"
#include "evaluate/rod_series.hpp"
#include "evaluate/series_program.hpp"
#include "evaluate/time_series.hpp"

namespace tanor::detail {

/// Distances |a| - l of rods and spheres as series in time. They are hand-written, since most scenes consist of them.
///
/// With a(t) = r_j - r_i + offset, or r_j - center(t), the constraint is a.a = l^2 and its force on j is mu a, where
/// mu = lambda/|a|. An order takes two Cauchy products.
class DistanceSeries {
 public:
  struct Member {
    Index i = -1, j = 0;  ///< points, inner; i = -1: there is a center
    Index row = 0, block = 0;
  };
  /// Data that most members do not have: an offset, and slots in the table of l(t) and of the first of three components
  /// of the center.
  struct Extra {
    Vec3 offset{};
    std::optional<std::size_t> length{}, center{};

    bool is_there() const { return length || center || dot(offset, offset) > 0.0; }
  };
  void append(const Member& member, const Extra& extra);
  std::size_t size() const { return members_.size(); }
  /// Calls visit(block) for the block of each member.
  template <class Visit>
  void for_each_block(const Visit& visit) const {
    for (const Member& member : members_) visit(member.block);
  }

  void resize(int order);

  /// Prepares for k = 0. Then, for k = 1, 2, … in turn, writes coefficient k of K lambda without K_0 lambda_k as blocks
  /// [3 * num_blocks], and coefficient k + 2 of xi without K_0'r_{k+2} [d]. The points are known up to k + 1, lambda
  /// [d] up to k - 1, which is `last`.
  void advance(const Parallel& parallel, int k, std::span<double* const> coefficients, const TimeSeriesTable& table,
               const double* last, double* blocks, double* rows);
  /// Converts rates of the distances [d] to those of (a.a - l^2)/(2 |a_0|), which the multipliers of the series belong
  /// to. The factor is |a|/|a_0| at the time s behind the beginning, by the first `terms` coefficients of a.
  void scale_rates(double s, int terms, double* rates) const;

 private:
  using Series = RodSeries<series_width>;
  static_assert(sizeof(Series::Coefficient) == 4 * sizeof(Pack<>) && sizeof(Series::Known) == 4 * sizeof(Pack<>));
  // A chunk has the coefficients [order + 1], what is known of the next order, and 1/|a_0|.
  std::size_t lanes_per_chunk() const { return 4 * (static_cast<std::size_t>(order_) + 2) + 1; }
  void advance_chunk(std::size_t chunk, int k, std::span<double* const> coefficients, const TimeSeriesTable& table,
                     const double* last, double* blocks, double* rows);
  void load(Series::Coefficient* c, std::size_t chunk, int k, std::span<double* const> coefficients,
            const TimeSeriesTable& table) const;

  std::vector<Member> members_;
  std::vector<Extra> extras_;  // [member]; empty if no member has one
  Packs lanes_;                // [chunk][lanes_per_chunk()]
  int order_ = 0;
};

}  // namespace tanor::detail
