#pragma once

#include <memory>
#include <span>
#include <vector>

#include "schur/island_solver.hpp"
#include "schur/path_factor.hpp"

namespace tanor::detail {

/// Solves islands that are paths of rods, point after point and rod after rod in the inner numbering, with or without a
/// support at either end. Also solves rings: paths whose free ends one rod more joins. Both are eliminated from both
/// ends at once (see PathFactor), which gives two chains of dependent operations in place of one, and two halves for
/// two threads.
class PathSolver final : public IslandSolver {
 public:
  /// Takes the islands that are such paths or rings out of `islands`. Returns null if there are none.
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
  void read_offsets(std::span<const Vec3> offsets) override { rows_.read_offsets(offsets); }

 private:
  explicit PathSolver(PathRows rows);
  void summarize();

  template <class Forward, class Middle, class Backward, class Finish>
  paths::Findings run(const Parallel& parallel, const Forward& forward, const Middle& middle, const Backward& backward,
                      const Finish& finish);
  Elimination eliminate(const Parallel& parallel, const PathEquations& equations);
  template <class Backward>
  void substitute(const Parallel& parallel, const double* b, double* x, const Backward& backward);
  const PointSource* source_of_sides(const Parallel& parallel, const FreeMotion& motion) const;
  template <class Begin, class Evaluate>
  Projection project(const Parallel& parallel, double target, const Begin& begin, const Evaluate& evaluate,
                     const double* blocks, double* points, double* sum);
  bool are_few() const;

  PathRows rows_;
  PathFactor factor_;
  std::vector<std::size_t> group_start_;  // first paths of the groups that go to threads
  std::vector<paths::PathWork> work_;     // [group, or path where they are few]
};

}  // namespace tanor::detail
