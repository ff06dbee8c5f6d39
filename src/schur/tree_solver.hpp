#pragma once

#include <memory>
#include <span>
#include <vector>

#include "schur/island_solver.hpp"
#include "schur/rod_rows.hpp"
#include "schur/tree_kernels.hpp"

namespace tanor {

/// Islands of rods that are trees, or trees and a few rods more that close rings: S without fill, eliminated from the
/// leaves to the root point by point (the articulated-body method of R. Featherstone 1983, for mobilities in place of
/// inertias, so that supports may stand at any leaf); rods that close rings are a border of a few rows.
class TreeSolver final : public IslandSolver {
 public:
  /// Takes such islands out of `islands`; null where there are none.
  static std::unique_ptr<TreeSolver> make(const SchurProblem& problem, std::vector<Index>* islands);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks, double* b,
                    double* lambda, double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override;

 private:
  using Range = trees::PivotRange;
  /// Rods [first_rod, end_rod) of the tree in the order of elimination, those that close rings from there on until the
  /// next island, and its points.
  struct Island {
    std::size_t first_rod, end_rod, end, first_point, end_point;
    std::size_t first_spike, first_entry;  ///< where its numbers of spikes_ and border_ begin
    std::size_t num_rings() const { return end - end_rod; }
  };
  /// Of one task.
  struct Found {
    Range range;
    double right_side = 0.0, residual = 0.0, own_residual = 0.0;
    void include(const Found& other);
  };

  TreeSolver() = default;
  bool add_island(const Numbering& numbering, Index island, const RodRows& rods);
  void finish(const RodRows& rods);

  template <class Work>
  Found for_each_island(const Parallel& parallel, const Work& work);

  trees::Tree tree(const Island& island) { return rods(island.first_rod, island.end_rod); }
  trees::Tree rods(std::size_t first, std::size_t end);
  trees::Motion motion_from(std::size_t rod, const FreeMotion& motion, double* blocks, double* b) const;
  void accelerate(const Island& island, const Vec3* uniform, const double* b, double* w, Found* found) const;
  void prepare(const Island& island);
  void read_directions(const Island& island, const double* blocks);
  void eliminate(const Island& island, Range* range);
  void eliminate_border(const Island& island, Range* range);
  void substitute(const Island& island, const double* b, double* x);
  void finish_substitution(const Island& island, const double* b, double* x);
  void substitute_border(const Island& island, const double* b, double* x);
  void clear(const Island& island, std::vector<double>* points) const;
  void add_forces(std::size_t rod, double lambda, double* forces) const;
  Vec3 response(Index point) const;
  double gap(std::size_t rod) const;

  std::vector<std::pair<std::size_t, const MovingScalar*>> lengths_;  // that depend on time, by rod
  std::span<const double> inverse_mass_;
  Index num_moving_ = 0;
  std::vector<Island> islands_;
  std::vector<trees::Rod> order_;         // [rod]
  std::vector<signed char> sign_;         // [rod] of its block, from the child to the parent
  std::vector<std::size_t> block_;        // [rod]
  std::vector<Vec3> offset_;              // [rod] from the child to the parent; empty: none
  std::vector<double> length_second_;     // [rod] l''; empty: all 0
  std::vector<std::size_t> group_start_;  // islands that one thread takes

  std::vector<trees::Mobility> mobility_;  // [point]
  std::vector<double> s_;                  // [3n] dw that eliminated branches make
  std::vector<double> force_;              // [3n] K lambda
  std::vector<double> rows_;               // [d] scratch
  std::vector<Vec3> u_, h_;                // [rod]
  std::vector<double> inverse_pivot_;      // [rod]
  std::vector<double> spikes_;             // of an island: [ring][rod] lambda of the tree for a unit one of the ring
  std::vector<double> border_;             // of an island: [ring][ring] of LDL' of their rows, with 1/D
  std::vector<Found> found_;               // [group]
};

}  // namespace tanor
