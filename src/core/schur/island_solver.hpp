#pragma once

#include <optional>
#include <span>
#include <vector>

#include "schur/island_group.hpp"
#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// A solver of some islands, complete but for its factor. Values, rates and gradients come from the families of
/// constraints. Projections are chord iterations with the last factor. Each solver overrides what it does faster.
class IslandSolver : public SchurSolver {
 public:
  Elimination linearise(const Parallel& parallel, const double* r, const PointSource* source, double* blocks) override;
  void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override;
  double evaluate_values(const Parallel& parallel, const double* r, double* xi) override;
  double evaluate_rates(const Parallel& parallel, const double* r, const double* v, double* rates) override;
  Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                               const PointSource* source, double* sum) override;
  Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                double* v, double* sum) override;
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override;
  /// Does nothing: the families have the offsets.
  void read_offsets(std::span<const Vec3>) override {}
  const Summary& summary() const final { return summary_; }

 protected:
  IslandSolver() = default;
  explicit IslandSolver(IslandGroup group) : group_(std::move(group)) {}

  /// Serves the islands of `before` that are no longer in `left`.
  void serve(const SchurProblem& problem, std::span<const Index> before, std::span<const Index> left);
  const IslandGroup& group() const { return *group_; }
  /// Brings all points of its islands at once. Does nothing if `source` is null, since the points are there then.
  void bring_points(const Parallel& parallel, const PointSource* source) const {
    if (source == nullptr) return;
    group_->points.for_ranges(parallel, [&](std::size_t begin, std::size_t end) { source->bring(begin, end - begin); });
  }

  Summary summary_;

 private:
  template <class Evaluate>
  Projection iterate(const Parallel& parallel, const double* blocks, double target, const Evaluate& evaluate,
                     double* points, double* sum);

  std::optional<IslandGroup> group_;
  std::vector<double> rows_;  // [d] scratch; made at the first projection
};

}  // namespace tanor::detail
