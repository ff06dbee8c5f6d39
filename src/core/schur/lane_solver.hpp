#pragma once

#include <memory>
#include <span>
#include <vector>

#include "schur/lane_groups.hpp"
#include "schur/lane_groves.hpp"
#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// Solves islands of rods in groups of eight islands or pieces, side by side in the lanes of a vector. Batches are
/// islands of which many have one topology, with an elimination that is written down once for it. Trees are cut into
/// pieces; S has no fill and is eliminated from the leaves to the root point by point (the articulated-body method of
/// R. Featherstone 1983, with mobilities in place of inertias, so that supports may stand at any leaf).
class LaneSolver final : public SchurSolver {
 public:
  /// Takes batches, paths or trees out of `islands`, see lane_plan.hpp. Returns null if there are none.
  static std::unique_ptr<LaneSolver> make(const SchurProblem& problem, LinearSolver kind, int threads, bool eagerly,
                                          std::vector<Index>* islands);

  bool finds_multipliers_alone() const override;
  Elimination solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks, double* b,
                    double* lambda, double* w) override;
  Elimination linearise(const Parallel& parallel, const double* r, const PointSource* source, double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override {
    solve(parallel, b, x, nullptr, nullptr);
  }
  void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override {
    solve(parallel, rows, rows, blocks, points);
  }
  Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                               const PointSource* source, double* sum) override;
  Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                double* v, double* sum) override;
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override;
  void read_offsets(std::span<const Vec3> offsets) override { groups_.read_offsets(offsets); }

 private:
  using Group = LaneGroups::Group;
  LaneSolver(const SchurProblem& problem, const RodRows& rods, LanePlan plan, int threads)
      : groups_(std::move(plan), rods, problem.inverse_mass, problem.numbering.num_moving, threads),
        of_island_(groups_.plan().islands.size()) {}

  struct Found {
    Elimination elimination;
    Projection projection;
  };
  template <class Work>
  Found visit(const Parallel& parallel, const Work& work, Pass pass = Pass::Single);
  void solve(const Parallel& parallel, const double* b, double* x, const double* blocks, double* points);
  void note_findings(const GroveVisit& visit);
  void project(const GroveVisit& visit, double target, bool was_moved, void (Group::*evaluate)(), double* points,
               double* sum);

  LaneGroups groups_;
  std::vector<Elimination> of_island_;  // [island] largest |b| and residual
};

}  // namespace tanor::detail
