#include "solve/mixed_sweep.hpp"

#include <algorithm>

namespace tanor {

MixedSweep::MixedSweep(std::vector<std::unique_ptr<Sweep>> sweeps) : sweeps_(std::move(sweeps)) {
  for (const auto& sweep : sweeps_) {
    const Summary& each = sweep->summary();
    summary_.name += (summary_.name.empty() ? "" : "+") + each.name;
    summary_.reason += (summary_.reason.empty() ? "" : "; ") + each.reason;
    summary_.parts += each.parts;
    summary_.pattern_nonzeros += each.pattern_nonzeros;
    summary_.factor_nonzeros += each.factor_nonzeros;
    summary_.flops += each.flops;
  }
}

template <class Each>
Elimination MixedSweep::join(const Each& each) {
  Elimination result;
  for (const auto& sweep : sweeps_) {
    const Elimination found = each(*sweep);
    result.reciprocal_condition = std::min(result.reciprocal_condition, found.reciprocal_condition);
    result.largest_right_side = larger(result.largest_right_side, found.largest_right_side);
    result.residual = larger(result.residual, found.residual);
  }
  return result;
}

Elimination MixedSweep::solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* scratch,
                              double* lambda, double* w) {
  return join([&](Sweep& sweep) { return sweep.solve(parallel, motion, blocks, scratch, lambda, w); });
}

Elimination MixedSweep::factorize(const Parallel& parallel, const double* blocks) {
  return join([&](Sweep& sweep) { return sweep.factorize(parallel, blocks); });
}

void MixedSweep::solve_negative(const Parallel& parallel, const double* b, double* x) {
  for (const auto& sweep : sweeps_) sweep->solve_negative(parallel, b, x);
}

}  // namespace tanor
