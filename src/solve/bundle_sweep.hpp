#pragma once

#include <memory>
#include <span>
#include <vector>

#include "solve/bundles.hpp"
#include "solve/sweep.hpp"

namespace tanor {

/// Islands of rods, many of equal topology: one elimination, written down once, runs over eight islands side by side
/// in the lanes of a vector. Which islands share a vector follows from the system alone.
class BundleSweep final : public Sweep {
 public:
  /// Takes islands of rods out of `islands`: those of topologies that many share, or, `eagerly`, all; null where there
  /// are none.
  static std::unique_ptr<BundleSweep> make(const Constraints& constraints, const Numbering& numbering,
                                           std::span<const double> inverse_mass, int threads, bool eagerly,
                                           std::vector<Index>* islands);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* scratch, double* lambda,
                    double* w) override;
  Elimination solve_again(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* scratch,
                          double* lambda, double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  bool correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override;
  const Summary& summary() const override { return summary_; }

  bool projects() const override { return true; }
  Elimination linearise(const Parallel& parallel, const double* r, double* blocks) override;
  Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                               double* sum) override;
  Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                double* v) override;
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override;

 private:
  using Batch = Bundle::Batch;
  /// What one thread works on, and what it found.
  struct Desk {
    std::vector<Eight3> r, v, w, dw, u, directions;
    Eights b, x, sum, lengths;
    Eight smallest;
    Largest right_side, residual;  // of the batch at hand
    Elimination found;
    Projection projection;
  };

  BundleSweep() = default;
  template <class Work>
  void for_each_batch(const Parallel& parallel, const Work& work);
  Elimination solve(const Parallel& parallel, const FreeMotion& motion, bool keeps, double* blocks, double* lambda,
                    double* w);
  Elimination found() const;
  Projection reached() const;
  static const Eight* moving_lengths(const Batch& batch, double MovingScalar::*number, Desk* desk);
  template <class Evaluate, class Move>
  static void iterate(const Batch& batch, double target, Desk* desk, const Evaluate& evaluate, const Move& move);

  std::vector<Bundle> bundles_;
  std::vector<Desk> desks_;  // [thread]
  Summary summary_;
};

}  // namespace tanor
