#pragma once

#include <memory>
#include <span>
#include <vector>

#include "solve/sweep.hpp"

namespace tanor {

/// Islands that are paths of rods: point after point and rod after rod in the inner numbering, a support at either end
/// or none. S is tridiagonal and is eliminated from both ends at once (a twisted factorization), up to the row in the
/// middle: two chains of dependent operations in place of one, and two halves for two threads.
class PathSweep final : public Sweep {
 public:
  /// Null where some island is no such path.
  static std::unique_ptr<PathSweep> make(const Constraints& constraints, const Numbering& numbering,
                                         std::span<const double> inverse_mass);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* b, double* lambda,
                    double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  const Summary& summary() const override { return summary_; }

 private:
  /// Row first_row + k joins point left(k) = first_point + k (- 1 behind a support) and the next one.
  struct Path {
    Index first_row, num_rows, first_point, num_points;
    Index left_support = -1, right_support = -1;

    Index left_point(Index k) const {
      return left_support < 0 ? first_point + k : k == 0 ? left_support : first_point + k - 1;
    }
    Index right_point(Index k) const {
      if (k + 1 == num_rows && right_support >= 0) return right_support;
      return left_support < 0 ? first_point + k + 1 : first_point + k;
    }
    Index middle() const { return num_rows / 2; }
  };
  /// A length that moves, or an offset.
  struct Extra {
    Vec3 offset{};
    const MovingScalar* length = nullptr;
  };

  PathSweep() = default;
  Elimination eliminate(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* b, double* lambda);
  double substitute(const Parallel& parallel, const Vec3* uniform, const double* blocks, const double* b,
                    double* lambda, double* w);
  double inverse_mass(Index point) const { return inverse_mass_[static_cast<std::size_t>(point)]; }
  Vec3 gradient(const double* blocks, Index row) const;
  Elimination factorize(const Path& path, const double* blocks);
  void eliminate_right_side(const Path& path, const double* b, double* y) const;
  void substitute(const Path& path, double* y) const;

  std::span<const double> inverse_mass_;
  std::vector<Path> paths_;
  std::vector<Index> block_;                                   // [row]
  std::vector<double> sign_;                                   // [row] of the block against the path's direction
  std::vector<Extra> extra_;                                   // [row]; empty: none
  std::vector<double> inverse_pivot_, factor_, other_factor_;  // [row]
  Summary summary_;
};

}  // namespace tanor
