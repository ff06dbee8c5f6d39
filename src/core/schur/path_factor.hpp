#pragma once

#include <vector>

#include "schur/path_equations.hpp"
#include "schur/path_half.hpp"
#include "schur/path_reactions.hpp"

namespace tanor::detail {

/// The factor of S of paths. S is tridiagonal and is eliminated from both ends at once (a twisted factorization) up to
/// the row in the middle. The row that closes a ring is eliminated last of all. Its couplings e with the first and the
/// last row of the path spread to the middle as a spike, L^-1 e.
///
/// Two threads may work on the halves of one path, each with its own side of the work.
class PathFactor {
 public:
  explicit PathFactor(const PathRows& rows);

  // ---- the factor, and y = L^-1 b beside it ----

  void eliminate_from_ends(std::size_t p, const PathEquations& equations, paths::Sides sides, paths::PathWork* work);
  /// Eliminates the middle row, and the row that closes a ring.
  void eliminate_middle(std::size_t p, const PathEquations& equations, paths::PathWork* work);

  // ---- y = L^-1 b of one more right side; y may be b ----

  void substitute_forward(std::size_t p, paths::Sides sides, const double* b, double* y, paths::PathWork* work) const;
  void substitute_middle(std::size_t p, const double* b, double* y, const paths::PathWork& work) const;

  // ---- lambda in y's place ----

  /// Finds lambda of the row that closes a ring and of the middle row.
  void begin_backward(std::size_t p, double* y) const;
  void substitute_backward(std::size_t p, paths::Sides sides, double* y) const;
  /// Does the same, and applies the multipliers to the points.
  void substitute_and_accelerate(std::size_t p, const PathReactions& reactions, double* lambda, paths::Sides sides,
                                 paths::PathWork* work) const;

 private:
  /// Lists what the elimination of rows [first, first + count), or their back substitution, will read and write.
  void list_upcoming(const RodPath& path, const PathEquations& equations, std::size_t first, std::size_t count,
                     paths::Upcoming* upcoming) const;
  void list_upcoming(const RodPath& path, const PathReactions& reactions, std::size_t first, std::size_t count,
                     paths::Upcoming* upcoming) const;
  void spread_spikes(const RodPath& path, const PathEquations& equations, paths::Half* left, paths::Half* right);
  void eliminate_closing_row(std::size_t p, const PathEquations& equations, paths::PathWork* work);
  void substitute_closing_row(const RodPath& path, const double* b, double* y, const paths::PathWork& work) const;

  const PathRows& rows_;
  std::vector<double> inverse_pivot_, factor_;  // [row]; the factor of a middle row is that with its left one
  std::vector<double> right_factor_;            // [path] factor of the middle row with its right one
  std::vector<double> spike_;                   // [row]; empty if no path is a ring
};

}  // namespace tanor::detail
