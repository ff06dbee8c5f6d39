#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "solve/sweep.hpp"

namespace tanor {

/// Islands of several kinds, each kind on its own way.
class MixedSweep final : public Sweep {
 public:
  explicit MixedSweep(std::vector<std::unique_ptr<Sweep>> sweeps);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* scratch, double* lambda,
                    double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  const Summary& summary() const override { return summary_; }

 private:
  /// All of `each`(sweep), one after the other.
  template <class Each>
  Elimination join(const Each& each);

  std::vector<std::unique_ptr<Sweep>> sweeps_;
  Summary summary_;
};

}  // namespace tanor
