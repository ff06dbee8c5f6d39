#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "solve/sweep.hpp"

namespace tanor {

/// Islands of several kinds, each kind on its own way: sweeps that project and correct.
class MixedSweep final : public Sweep {
 public:
  explicit MixedSweep(std::vector<std::unique_ptr<Sweep>> sweeps);

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
  /// All of `each`(sweep), one after the other.
  template <class Each>
  Elimination join(const Each& each);
  template <class Each>
  Projection join_projections(const Each& each);

  std::vector<std::unique_ptr<Sweep>> sweeps_;
  Summary summary_;
};

}  // namespace tanor
