#pragma once

#include <memory>
#include <span>
#include <vector>

#include "schur/island_solver.hpp"
#include "schur/tree_groves.hpp"
#include "schur/tree_lanes.hpp"

namespace tanor::detail {

/// Solves islands of rods that are trees. S has no fill and is eliminated from the leaves to the root point by point
/// (the articulated-body method of R. Featherstone 1983, with mobilities in place of inertias, so that supports may
/// stand at any leaf). Trees are cut into pieces, which are eliminated eight side by side in the lanes of a vector.
/// Multipliers come back the other way.
class TreeSolver final : public IslandSolver {
 public:
  /// Takes trees out of `islands`, see TreePieces::take. Returns null if there are none.
  static std::unique_ptr<TreeSolver> make(const SchurProblem& problem, int threads, bool eagerly,
                                          std::vector<Index>* islands);

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
  void read_offsets(std::span<const Vec3> offsets) override { lanes_.read_offsets(offsets); }

 private:
  TreeSolver(const SchurProblem& problem, const RodRows& rods, TreePieces pieces, int threads);
  void summarize();

  template <class Begin, class TakeDirections>
  Elimination eliminate(const Parallel& parallel, const Begin& begin, const TakeDirections& take);
  Elimination found(bool with_residual);
  double largest_right_side(const Grove& grove) const;
  template <class Evaluate>
  Projection project(const GroveVisit& visit, double target, const Evaluate& evaluate, double* points, double* sum);
  Projection reached() const;

  TreeLanes lanes_;
  std::vector<Elimination> found_;   // [tree] largest |b| and residual
  std::vector<Projection> reached_;  // [grove]
};

}  // namespace tanor::detail
