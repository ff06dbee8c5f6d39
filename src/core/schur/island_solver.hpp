#pragma once

#include <span>
#include <vector>

#include "base/index_ranges.hpp"
#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// Some islands of a system. Each function reads and writes only their rows and moving points.
struct IslandGroup {
  IslandGroup(const SchurProblem& problem, std::span<const Index> islands);

  const Constraints& constraints;
  const ReactionGather& gather;
  std::span<const double> inverse_mass;  ///< [point]
  IndexRanges rows, points;
  std::vector<Index> island_start;  ///< first row of each island, counted in `rows`, then their number
  Constraints::Selection members;

  std::size_t num_islands() const { return island_start.size() - 1; }

  /// Computes y += x [d].
  void add_rows(const Parallel& parallel, const double* x, double* y) const {
    rows.for_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      for (std::size_t a = begin; a < end; ++a) y[a] += x[a];
    });
  }
};

/// A solver of some islands, complete but for its factor. Values, rates and gradients come from the families of
/// constraints. Projections are chord iterations with the last factor. Each solver overrides what it does faster.
class IslandSolver : public SchurSolver {
 public:
  Elimination linearise(const Parallel& parallel, const double* r, const PointSource* source, double* blocks) override;
  void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override;
  Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                               const PointSource* source, double* sum) override;
  Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                double* v, double* sum) override;
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override {
    group_.gather.add_scaled(parallel, blocks, rows, group_.inverse_mass.data(), group_.points, points);
  }
  /// Does nothing: the families have the offsets.
  void read_offsets(std::span<const Vec3>) override {}

 protected:
  /// Factorizes S of given blocks of K.
  virtual Elimination factorize(const Parallel& parallel, const double* blocks) = 0;
  explicit IslandSolver(IslandGroup group) : group_(std::move(group)) {}

  /// Brings all points of its islands at once. Does nothing if `source` is null, since the points are there then.
  void bring_points(const Parallel& parallel, const PointSource* source) const {
    if (source == nullptr) return;
    group_.points.for_ranges(parallel, [&](std::size_t begin, std::size_t end) { source->bring(begin, end - begin); });
  }

  const IslandGroup group_;

 private:
  template <class Evaluate>
  Projection iterate(const Parallel& parallel, const double* blocks, double target, const Evaluate& evaluate,
                     double* points, double* sum);

  std::vector<double> rows_;  // [d] scratch; made at the first projection
};

}  // namespace tanor::detail
