#pragma once

#include <array>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "solve/path_kernels.hpp"
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
  /// Rows [first, end): row a joins the points a + shift and a + shift + 1, but a support at an end that has one.
  struct Path {
    std::size_t first, end;
    std::ptrdiff_t shift;
    Index left_support = -1, right_support = -1;

    /// The row that is eliminated last; the left half is [first, middle), the right one [middle + 1, end).
    std::size_t middle() const { return first + (end - first) / 2; }
    bool begins_at_support(std::size_t row) const { return row == first && left_support >= 0; }
    bool ends_at_support(std::size_t row) const { return row + 1 == end && right_support >= 0; }
    std::size_t left_point(std::size_t row) const {
      return begins_at_support(row) ? static_cast<std::size_t>(left_support) : row + static_cast<std::size_t>(shift);
    }
    std::size_t right_point(std::size_t row) const {
      return ends_at_support(row) ? static_cast<std::size_t>(right_support) : row + static_cast<std::size_t>(shift) + 1;
    }
  };
  enum class Halves { Both, Left, Right };
  static bool includes(Halves halves, Halves one) { return halves == Halves::Both || halves == one; }

  /// What an elimination reads and writes; without `motion` the blocks are given, without b there is no right side.
  struct Numbers {
    const FreeMotion* motion;
    const double* given_blocks;
    double *blocks, *b, *y;
  };
  struct Range {
    double smallest_ratio = 1.0, largest_ratio = 1.0;  // S_aa/pivot
    double largest = 0.0;                              // |b|, or |K'dw + b|
    void include(const Range& other);
  };
  /// What a half hands to the row in the middle. An empty half: nothing.
  struct Eliminated {
    Vec3 g{};
    double inverse_pivot = 0.0, y = 0.0;
    Range range;
  };
  struct Accelerated {
    Vec3 dw{};  // of the point beside the middle row
    double residual = 0.0;
  };
  struct Half;

  PathSweep() = default;
  Elimination eliminate(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* b, double* lambda);
  double substitute(const Parallel& parallel, const Vec3* uniform, const double* blocks, const double* b,
                    double* lambda, double* w);
  void read_rods(const Constraints& constraints, std::vector<std::array<Index, 2>>* ends);
  bool add_path(const Numbering& numbering, std::size_t island, std::span<const std::array<Index, 2>> ends);
  void finish();

  bool splits(const Parallel& parallel) const;
  template <class Whole>
  void for_groups(const Parallel& parallel, const Whole& whole);
  template <class OfHalf>
  void for_halves(const Parallel& parallel, const OfHalf& of_half) const;

  Elimination eliminate(const Parallel& parallel, const Numbers& numbers);
  void eliminate_halves(const Path& path, const Numbers& numbers, Halves halves, Eliminated* left, Eliminated* right);
  void take_rows(const Path& path, const Numbers& numbers, Half* half) const;
  Range eliminate_middle(std::size_t path, const Numbers& numbers, const Eliminated& left, const Eliminated& right);
  Vec3 evaluate_row(const Path& path, std::size_t row, const Numbers& numbers) const;

  struct Substituted {
    const Vec3* uniform;
    const double *blocks, *b;
    double *lambda, *w;
  };
  void substitute_halves(std::size_t path, const Substituted& numbers, Halves halves, Accelerated* left,
                         Accelerated* right) const;
  paths::Ends accelerate(const Path& path, const Substituted& numbers, std::size_t first, std::size_t count,
                         double* residual) const;
  Vec3 accelerate_end(const Substituted& numbers, std::size_t row, std::size_t point, double sense) const;
  double rest_of(const Substituted& numbers, std::size_t row, Vec3 dw_left, Vec3 dw_right) const;

  std::size_t block(std::size_t row) const { return block_.empty() ? first_block_ + row : block_[row]; }
  Vec3 direction(const double* blocks, std::size_t row) const { return sign_[row] * load(blocks, block(row)); }

  std::span<const double> inverse_mass_;
  std::vector<Path> paths_;
  std::size_t first_block_ = 0;
  std::vector<std::size_t> block_;                                    // [row]; empty: they follow the rows
  std::vector<signed char> sign_;                                     // [row] of its block, along the path
  std::vector<Vec3> offset_;                                          // [row] along the path; empty: none
  std::vector<std::pair<std::size_t, const MovingScalar*>> lengths_;  // that depend on time, by row
  std::vector<std::size_t> group_start_;                              // paths that one thread takes
  std::vector<double> inverse_pivot_, factor_;                        // [row]; of a middle row: with its left one …
  std::vector<double> right_factor_;                                  // … and with its right one [path]
  std::vector<Range> range_;                                          // [group]
  std::vector<std::array<Eliminated, 2>> eliminated_;                 // [path] where they are few
  std::vector<std::array<Accelerated, 2>> accelerated_;
  Summary summary_;
};

}  // namespace tanor
