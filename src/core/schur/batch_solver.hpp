#pragma once

#include <memory>
#include <vector>

#include "schur/equal_islands.hpp"
#include "schur/island_solver.hpp"

namespace tanor::detail {

/// Solves islands of rods of which many have one topology. The elimination is written down once for a topology and runs
/// over eight islands side by side in the lanes of a vector. The system alone decides which islands share a vector.
class BatchSolver final : public IslandSolver {
 public:
  /// Takes islands of rods out of `islands`: those of topologies that many islands share, or all if `eagerly` is true.
  /// Returns null if there are none.
  static std::unique_ptr<BatchSolver> make(const SchurProblem& problem, int threads, bool eagerly,
                                           std::vector<Index>* islands);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks, double* scratch,
                    double* lambda, double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override;
  Elimination linearise(const Parallel& parallel, const double* r, const PointSource* source, double* blocks) override;
  Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                               const PointSource* source, double* sum) override;
  Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                double* v, double* sum) override;
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override;
  void read_offsets(std::span<const Vec3> offsets) override {
    for (EqualIslands& islands : equal_islands_) islands.read_offsets(offsets);
  }

 private:
  using Batch = EqualIslands::Batch;
  /// The arrays of one thread, and its findings.
  struct Workspace {
    std::vector<Pack3<>> r, v, w, dw, u, directions;
    Packs b, x, sum, lengths;
    Pack<> smallest;
    LargestResiduals found;  // in all batches that this thread has solved
    Projection projection;
  };

  BatchSolver() = default;
  template <class Visit>
  void for_each_batch(const Parallel& parallel, const Visit& visit);
  Elimination found() const;
  Projection reached() const;
  static const Pack<>* moving_lengths(const Batch& batch, double MovingScalar::*number, Workspace* work);
  template <class Evaluate, class Move>
  static void iterate(const Batch& batch, double target, Workspace* work, const Evaluate& evaluate, const Move& move);

  std::vector<EqualIslands> equal_islands_;
  std::vector<Workspace> workspaces_;  // [thread]
};

}  // namespace tanor::detail
