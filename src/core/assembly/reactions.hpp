#pragma once

#include <span>

#include "base/groups.hpp"
#include "base/index_ranges.hpp"
#include "base/parallel.hpp"
#include "evaluate/family.hpp"

namespace tanor::detail {

/// Computes eta = K lambda, gathered point by point in a fixed order.
class ReactionGather {
 public:
  ReactionGather(std::span<const Incidence> incidences, std::size_t num_points);

  /// Writes out_i = (K lambda)_i [3n], for points and supports alike.
  void reactions(const Parallel& parallel, const double* blocks, const double* lambda, double* out) const;

  /// Adds scale_i (K lambda)_i to out_i for the points below `count`. With scale = 1/m this adds M^-1 K lambda.
  void add_scaled(const Parallel& parallel, const double* blocks, const double* lambda, const double* scale,
                  std::size_t count, double* out) const;
  /// Adds the same for the given points.
  void add_scaled(const Parallel& parallel, const double* blocks, const double* lambda, const double* scale,
                  const IndexRanges& points, double* out) const;
  /// Writes the same terms over what was there.
  void write_scaled(const Parallel& parallel, const double* blocks, const double* lambda, const double* scale,
                    std::size_t count, double* out) const;
  void write_scaled(const Parallel& parallel, const double* blocks, const double* lambda, const double* scale,
                    const IndexRanges& points, double* out) const;
  /// Writes factor scale_i times the sum of the blocks at each of the given points.
  void write_sums(const Parallel& parallel, const double* blocks, double factor, const double* scale,
                  const IndexRanges& points, double* out) const;

 private:
  struct Entry {
    Index row;
    Index block;  // ~block where the sign is negative
  };
  Vec3 reaction(std::size_t point, const double* blocks, const double* lambda) const {
    Vec3 sum{};
    for (const auto [row, block] : by_point_[point]) {
      const double signed_lambda = block >= 0 ? lambda[row] : -lambda[row];
      sum = sum + signed_lambda * load(blocks, block >= 0 ? block : ~block);
    }
    return sum;
  }

  Groups<Entry> by_point_;
};

}  // namespace tanor::detail
