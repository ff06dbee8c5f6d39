#pragma once

#include <memory>
#include <span>
#include <vector>

#include "schur/island_solver.hpp"
#include "schur/path_block.hpp"

namespace tanor::detail {

/// Solves islands that are paths of rods, point after point and rod after rod in the inner numbering, with or without a
/// support at either end. Also solves rings: paths whose free ends one rod more joins. S is tridiagonal. A path is cut
/// into pieces, which are eliminated eight side by side in the lanes of a vector, and then the rods between them (H. H.
/// Wang, ACM TOMS 7, 1981). Rods that fill no lanes are eliminated with those.
class PathSolver final : public IslandSolver {
 public:
  /// Takes the islands that are such paths or rings out of `islands`. Returns null if there are none.
  static std::unique_ptr<PathSolver> make(const SchurProblem& problem, int threads, std::vector<Index>* islands);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks, double* b,
                    double* lambda, double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  Elimination linearise(const Parallel& parallel, const double* r, const PointSource* source, double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override;
  Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                               const PointSource* source, double* sum) override;
  Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                double* v, double* sum) override;
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override;
  void read_offsets(std::span<const Vec3> offsets) override { rows_.read_offsets(offsets); }

 private:
  /// The numbers that were found in one path.
  struct Found {
    double largest_inverse = 1.0, right_side = 0.0, residual = 0.0;
    Projection projection;
  };
  class Visit;

  PathSolver(PathRows rows, int threads);
  void summarize();
  template <class Work>
  void for_each_path(const Parallel& parallel, const Work& work);
  /// Calls take(visit) for each path, which sets u of all rods, and factorizes S.
  template <class Take>
  Elimination eliminate(const Parallel& parallel, const Take& take);
  template <class Evaluate, class EvaluateAlone>
  Projection project(const Visit& visit, const double* blocks, double target, const Evaluate& evaluate,
                     const EvaluateAlone& alone, double* points, double* sum);
  Elimination found() const;
  Projection reached() const;

  PathRows rows_;
  PathFactor factor_;
  std::vector<Found> found_;               // [path]
  std::vector<PathWorkspace> workspaces_;  // [thread]
};

}  // namespace tanor::detail
