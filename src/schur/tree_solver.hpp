#pragma once

#include <memory>
#include <span>
#include <vector>

#include "schur/equal_branches.hpp"
#include "schur/island_solver.hpp"
#include "schur/rod_rows.hpp"
#include "schur/tree_kernels.hpp"

namespace tanor {

/// Islands of rods that are trees: S without fill, eliminated from the leaves to the root point by point (the
/// articulated-body method of R. Featherstone 1983, for mobilities in place of inertias, so that supports may stand at
/// any leaf). Branches of one shape are eliminated eight side by side in the lanes of a vector, then what they hang on
/// rod by rod; multipliers come back the other way.
class TreeSolver final : public IslandSolver {
 public:
  /// Takes trees out of `islands` that consist of equal branches for the most part, or, `eagerly`, all; null where
  /// there are none.
  static std::unique_ptr<TreeSolver> make(const SchurProblem& problem, int threads, bool eagerly,
                                          std::vector<Index>* islands);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks, double* b,
                    double* lambda, double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override;
  Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                               const PointSource* source, double* sum) override;
  Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                double* v, double* sum) override;
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override;

 private:
  /// Of a tree: its rods and points outside of branches, and the roots of these, [first, end) of the lists below.
  struct Island {
    std::size_t first_rod, end_rod, first_point, end_point, first_root, end_root;
  };
  struct Branch {
    std::size_t batch, lane;
    Index root;
  };
  /// What a task found.
  struct Found {
    trees::LargestInverse largest_inverse;
    double right_side = 0.0, residual = 0.0, own_residual = 0.0;
    void include(const Found& other);
  };
  /// Of one thread, [point of a branch] or [rod of a branch].
  struct Workspace {
    std::vector<Eight3> r, v, w, s, dw, u;
    std::vector<trees::Mobility<Eight3>> mobility;
    Eights rows, length_second;
    trees::LargestInverse largest_inverse;
  };
  class Lanes;

  explicit TreeSolver(std::vector<RodTree> all);
  void list_islands(std::span<const RodTree> all);
  void read_rods(const RodRows& given);
  void read_branches(const RodRows& given, std::span<const double> inverse_mass);
  void prepare_workspaces(int threads);
  void summarize();

  template <class Work>
  void for_each_batch(const Parallel& parallel, const Work& work);
  template <class Work>
  void for_each_island(const Parallel& parallel, const Work& work);
  void forget_findings();
  Elimination found() const;

  trees::Tree tree(const Island& island);
  trees::Motion motion_of(const Island& island, const FreeMotion& motion, double* blocks, double* b) const;
  void prepare(const Island& island);
  void clear(const Island& island, std::vector<double>* points) const;
  template <class Finish>
  void substitute(const Parallel& parallel, const double* b, double* x, const Finish& finish);
  void finish_substitution(const Island& island, double* x);
  void find_residual(const Island& island, const double* b, Found* found) const;

  template <class Branches, class Row>
  Projection project(const Parallel& parallel, double target, const Branches& evaluate_branches,
                     const Row& evaluate_rod, double* points, double* sum);
  Vec3 distance(std::size_t rod, const double* r) const;
  void move(const Island& island, double* points) const;
  void add_own_reactions(const Island& island, const double* rows, double* points) const;

  EqualBranches branches_;
  std::vector<Island> islands_;
  std::span<const double> inverse_mass_;
  Index num_moving_ = 0;

  // Outside of branches:
  std::vector<trees::Rod> rods_;
  std::vector<signed char> sign_;      // [rod] of its block, from the child to the parent
  std::vector<std::size_t> block_;     // [rod]
  std::vector<Vec3> offset_;           // [rod] from the child to the parent; empty: none
  std::vector<double> length_;         // [rod]
  std::vector<double> length_second_;  // [rod] l''; empty: all 0
  std::vector<std::pair<std::size_t, const MovingScalar*>> lengths_;  // that depend on time, by rod
  std::vector<Index> points_;                                         // but the roots of branches
  std::vector<Branch> roots_;                                         // branches by island
  std::vector<Vec3> u_, h_;                                           // [rod]
  std::vector<double> inverse_pivot_;                                 // [rod]
  std::vector<std::size_t> group_start_;                              // islands that one thread takes
  std::vector<Found> found_;                                          // [group]

  // Of branches, in lanes:
  std::vector<Index> branch_blocks_;                         // [rod][lane]; ~block where the rod is given the other way
  std::vector<Eight3> branch_offsets_;                       // [rod]; empty: none
  Eights branch_length_;                                     // [rod]
  std::vector<const MovingScalar*> branch_lengths_;          // [rod][lane]; null: constant; empty: all are
  Eights branch_masses_;                                     // [point] inverse ones
  std::vector<trees::BranchRod> branch_rods_;                // [rod]
  std::vector<trees::BranchRow> branch_rows_;                // [rod]
  std::vector<double> branch_right_side_, branch_residual_;  // [batch][lane] the largest
  std::vector<Workspace> workspaces_;                        // [share of the batches]

  // [inner point], of points outside of branches and their roots alone:
  std::vector<trees::Mobility<Vec3>> mobility_;
  std::vector<double> s_;   // [3n] dw that eliminated branches make
  std::vector<double> dw_;  // [3n] first K lambda, then M^-1 K lambda
};

}  // namespace tanor
