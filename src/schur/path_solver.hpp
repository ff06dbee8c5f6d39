#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "schur/island_solver.hpp"
#include "schur/path_kernels.hpp"
#include "schur/rod_rows.hpp"

namespace tanor {

/// Islands that are paths of rods: point after point and rod after rod in the inner numbering, a support at either end
/// or none. S is tridiagonal and is eliminated from both ends at once (a twisted factorization), up to the row in the
/// middle: two chains of dependent operations in place of one, and two halves for two threads.
///
/// Or rings: paths whose free ends one rod more joins. Its row is eliminated last of all; its couplings e with the
/// first and the last row of the path spread inwards to a spike, L^-1 e.
class PathSolver final : public IslandSolver {
 public:
  /// Takes the islands that are such paths out of `islands`; null where none is.
  static std::unique_ptr<PathSolver> make(const SchurProblem& problem, std::vector<Index>* islands);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks, double* b,
                    double* lambda, double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override;
  Elimination linearise(const Parallel& parallel, const double* r, const PointSource* source, double* blocks) override;
  double evaluate_values(const Parallel& parallel, const double* r, double* xi) override;
  double evaluate_rates(const Parallel& parallel, const double* r, const double* v, double* rates) override;
  Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                               const PointSource* source, double* sum) override;
  Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                double* v, double* sum) override;
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override;

 private:
  using Path = RodPath;
  enum class Halves { Both, Left, Right };
  static bool includes(Halves halves, Halves one) { return halves == Halves::Both || halves == one; }

  /// What an elimination reads and writes; without `motion` the blocks are given, without b there is no right side, and
  /// of the motion r is enough.
  struct Numbers {
    const FreeMotion* motion;
    const double* given_blocks;
    double *blocks, *b, *y;
    const PointSource* source = nullptr;  // of the points that each half brings
  };
  struct Substituted {
    const Vec3* uniform;
    const double *blocks, *b;  // without b nothing is said about what is left over
    const double* lambda;
    double* w;
  };
  struct Range {
    double smallest_ratio = 1.0, largest_ratio = 1.0;  // S_aa/pivot
    double right_side = 0.0, residual = 0.0;           // largest |b| and |K'dw + b|
    double own_residual = 0.0;                         // the largest of any path over its own |b|
    void include(const Range& other);
    double reciprocal_condition() const;
  };
  /// What a half hands to the row in the middle; an empty one nothing.
  struct Eliminated {
    Vec3 g{};
    double inverse_pivot = 0.0, y = 0.0, spike = 0.0;
    double closing_pivot = 0.0, closing_y = 0.0;  // what its rows take from those of the closing row
    Range range;
  };
  /// What it leaves beside the middle row and the closing one: dw of the points, and the residual of its own rows.
  struct Accelerated {
    Vec3 dw{}, end_dw{};
    double residual = 0.0;
  };
  /// Of the path at hand.
  struct Work {
    Eliminated left_end, right_end;
    Accelerated left, right;
    Range range;
    Projection projection;  // of all paths of a group
  };
  struct Half;

  PathSolver() = default;
  void finish();

  template <class Inwards, class Middle, class Outwards, class Finish>
  Range run(const Parallel& parallel, const Inwards& inwards, const Middle& middle, const Outwards& outwards,
            const Finish& finish);
  Elimination eliminate(const Parallel& parallel, const Numbers& numbers);
  void include_residual(std::size_t path, const Substituted& numbers, Work* work) const;

  void announce(const Path& path, const Numbers& numbers, std::size_t first, std::size_t count,
                paths::Upcoming* upcoming) const;
  void announce(const Path& path, const Substituted& numbers, std::size_t first, std::size_t count,
                paths::Upcoming* upcoming) const;
  void eliminate_halves(const Path& path, const Numbers& numbers, Halves halves, Work* work);
  const PointSource* source_of_halves(const Parallel& parallel, const FreeMotion& motion) const;
  void take_rows(const Path& path, const Numbers& numbers, Half* half) const;
  static void bring_rows(const Path& path, const PointSource& source, const Half& half);
  static void bring_middle(const Path& path, const PointSource& source, Halves halves);
  void eliminate_middle(std::size_t path, const Numbers& numbers, Work* work);
  Vec3 direction(const Path& path, std::size_t row, const Numbers& numbers) const;
  Vec3 evaluate_row(const Path& path, std::size_t row, const Numbers& numbers) const;
  Vec3 distance(const Path& path, std::size_t row, const double* r) const;
  double right_side(const Path& path, std::size_t row, const FreeMotion& motion) const;
  paths::Rods rods_between(const Path& path, std::size_t begin, std::size_t end, const FreeMotion& motion) const;
  void subtract_moving(std::size_t begin, std::size_t end, double MovingScalar::*part, double* rows) const;
  template <class Find>
  double largest_of_ranges(const Parallel& parallel, const Find& find) const;
  template <class Between, class Alone>
  double largest_of_rows(std::size_t begin, std::size_t end, const Between& between, const Alone& alone) const;
  void take_lengths();
  double find_values(std::size_t begin, std::size_t end, const double* r, double* xi) const;
  double find_rates(std::size_t begin, std::size_t end, const double* r, const double* v, double* rates) const;
  double evaluate_right_side(const Parallel& parallel, const FreeMotion& motion, double* b) const;

  bool are_few() const;
  template <class Begin, class Evaluate>
  Projection project(const Parallel& parallel, double target, const Begin& begin, const Evaluate& evaluate,
                     const double* blocks, double* points, double* sum);
  void correct_path(std::size_t path, const double* blocks, double* rows, double* points, Work* work) const;
  void add_reactions_of(const Path& path, const Substituted& numbers) const;

  void substitute_halves(std::size_t path, const Substituted& numbers, double* lambda, Halves halves, Work* work) const;
  paths::Ends accelerate(const Path& path, const Substituted& numbers, std::size_t first, std::size_t count,
                         double* residual) const;
  Vec3 accelerate_end(const Path& path, const Substituted& numbers, std::size_t row, std::size_t point,
                      double sense) const;
  Accelerated accelerate_outermost(const Path& path, const Substituted& numbers, Halves half, std::size_t row,
                                   Vec3 dw_next, Accelerated found) const;
  double rest_of(const Substituted& numbers, std::size_t row, Vec3 dw_left, Vec3 dw_right) const;

  void spread_spikes(const Path& path, const Numbers& numbers, Half* left, Half* right);
  void eliminate_closing_row(std::size_t path, const Numbers& numbers, Work* work);
  void eliminate_closing_row_of(const Path& path, const double* b, double* y, const Work& work) const;

  void eliminate_right_side(const Path& path, Halves halves, const double* b, double* y, Work* work) const;
  void eliminate_middle_of(std::size_t path, const double* b, double* y, const Work& work) const;
  void start_outwards(std::size_t path, double* y) const;
  void substitute_right_side(std::size_t path, Halves halves, double* y) const;

  std::size_t block(std::size_t row) const { return block_.empty() ? first_block_ + row : block_[row]; }
  Vec3 direction(const double* blocks, std::size_t row) const { return sign_[row] * load(blocks, block(row)); }

  std::span<const double> inverse_mass_;
  std::vector<Path> paths_;
  std::size_t first_block_ = 0;
  std::vector<std::size_t> block_;                                    // [row]; empty: they follow the rows
  std::vector<signed char> sign_;                                     // [row] of its block, along the path
  std::vector<Vec3> offset_;                                          // [row] along the path; empty: none
  std::vector<double> length_;                                        // [row]
  std::vector<std::pair<std::size_t, const MovingScalar*>> lengths_;  // that depend on time, by row
  std::vector<std::size_t> group_start_;                              // paths that one thread takes
  std::vector<double> inverse_pivot_, factor_;                        // [row]; of a middle row: with its left one …
  std::vector<double> right_factor_;                                  // … and with its right one [path]
  std::vector<double> spike_;                                         // [row]; empty: no path is a ring
  std::vector<Work> work_;                                            // [group, or path where they are few]
};

}  // namespace tanor
