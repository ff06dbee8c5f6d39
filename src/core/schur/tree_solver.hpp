#pragma once

#include <memory>
#include <span>
#include <vector>

#include "schur/island_solver.hpp"
#include "schur/tree_branches.hpp"
#include "schur/tree_groves.hpp"
#include "schur/tree_trunks.hpp"

namespace tanor::detail {

/// Solves islands of rods that are trees. S has no fill and is eliminated from the leaves to the root point by point
/// (the articulated-body method of R. Featherstone 1983, with mobilities in place of inertias, so that supports may
/// stand at any leaf). Branches of one shape are eliminated eight side by side in the lanes of a vector, then the
/// trunks that they hang on rod by rod. Multipliers come back the other way.
class TreeSolver final : public IslandSolver {
 public:
  /// Takes trees out of `islands`: those that consist of equal branches for the most part, or all if `eagerly` is true.
  /// Returns null if there are none.
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
  void read_offsets(std::span<const Vec3> offsets) override {
    branches_.read_offsets(offsets);
    trunks_.read_offsets(offsets);
  }

 private:
  TreeSolver(const SchurProblem& problem, const RodRows& rods, std::span<const RodTree> trees, EqualBranches branches,
             int threads);
  void summarize();

  class Visit;
  template <class Work>
  void for_each_grove(const Parallel& parallel, const Work& work);
  template <class Begin, class OfBranches, class OfTrunk>
  Elimination eliminate(const Parallel& parallel, const Begin& begin, const OfBranches& take_branches,
                        const OfTrunk& take_trunk);
  void forget_findings();
  Elimination found() const;
  template <class Finish>
  void substitute(const Visit& visit, const double* b, double* x, const Finish& finish);
  void add_reactions(const Visit& visit, const double* rows, double* points);
  template <class OfBranches, class OfTrunk>
  Projection project(const Visit& visit, double target, const OfBranches& evaluate_branches,
                     const OfTrunk& evaluate_trunk, double* points, double* sum);
  Projection reached() const;
  bool has_moving_lengths() const { return trunks_.has_moving_lengths() || branches_.has_moving_lengths(); }

  TreeBranches branches_;
  TreeTrunks trunks_;
  TreePoints points_;
  TreeGroves groves_;
  std::vector<TreeFindings> found_;  // [tree]
  std::vector<Projection> reached_;  // [grove]
};

}  // namespace tanor::detail
