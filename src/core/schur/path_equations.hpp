#pragma once

#include "schur/path_half.hpp"
#include "schur/path_rows.hpp"

namespace tanor::detail {

/// The data that an elimination of rows of paths reads and writes: K, b = phi + K'w0 and y = L^-1 b. Without `motion`
/// the blocks of K are given. Without b there is no right side, and only r of the motion is needed.
struct PathEquations {
  const PathRows& rows;
  const FreeMotion* motion;
  const double* given_blocks;
  double *blocks, *b, *y;
  const PointSource* source = nullptr;  ///< source of the points that each half brings

  /// Returns the direction of a row along its path.
  Vec3 direction(const RodPath& path, std::size_t row) const;
  /// Writes the block of a row and its b. Returns its direction along the path.
  Vec3 evaluate_row(const RodPath& path, std::size_t row) const;
  /// Evaluates the directions, b and S of the chunk that a half has reached.
  void take_rows(const RodPath& path, paths::Half* half) const;
  /// Brings those points of the chunk that earlier chunks have not brought.
  void bring_rows(const RodPath& path, const paths::Half& half) const;
  /// Brings the end points of a path beside its middle row if no half has rows that would bring them.
  void bring_middle(const RodPath& path, paths::Sides sides) const;
};

}  // namespace tanor::detail
