#pragma once

#include "schur/path_half.hpp"
#include "schur/path_rows.hpp"

namespace tanor::detail {

/// The effect of multipliers on the points of paths: dw = M^-1 K lambda, w := w0 + dw, and the residual K'dw + b.
/// Without `uniform`, w holds w0. Without b, no residual is computed.
struct PathReactions {
  const PathRows& rows;
  const Vec3* uniform;
  const double *blocks, *b;
  const double* lambda;
  double* w;

  /// Accelerates the points between `count` + 1 rows from `first` on.
  paths::Ends accelerate(const RodPath& path, std::size_t first, std::size_t count, double* residual) const;
  /// Accelerates a free end: dw = K lambda/m of its only rod, or of that and the rod that closes the ring.
  Vec3 accelerate_end(const RodPath& path, std::size_t row, std::size_t point, double sense) const;
  /// Accelerates the outermost point of one of the halves; `dw_next` is that of the point beside it.
  paths::Accelerated accelerate_outermost(const RodPath& path, paths::Sides half, std::size_t row, Vec3 dw_next,
                                          paths::Accelerated found) const;
  /// Accelerates all points of a path; threads share a long one.
  void accelerate_all(const Parallel& parallel, const RodPath& path) const;
  /// Returns |K'dw + b| of one row.
  double residual_of(std::size_t row, Vec3 dw_left, Vec3 dw_right) const;
  /// Includes the residual of a whole path, given that of its halves.
  void include_residual(const RodPath& path, paths::PathWork* work) const;
};

}  // namespace tanor::detail
