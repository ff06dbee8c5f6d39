#include "solve/mixed_sweep.hpp"

#include <algorithm>

namespace tanor {

MixedSweep::MixedSweep(std::vector<std::unique_ptr<Sweep>> sweeps) : sweeps_(std::move(sweeps)) {
  for (const auto& sweep : sweeps_) {
    ensure(sweep->projects(), "each part of a mixture projects");
    const Summary& each = sweep->summary();
    summary_.name += (summary_.name.empty() ? "" : "+") + each.name;
    summary_.reason += (summary_.reason.empty() ? "" : "; ") + each.reason;
    if (each.ordering != "natural") summary_.ordering = each.ordering;
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
    result.own_residual = larger(result.own_residual, found.own_residual);
    result.refinements = std::max(result.refinements, found.refinements);
  }
  return result;
}

Elimination MixedSweep::solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* scratch,
                              double* lambda, double* w) {
  return join([&](Sweep& sweep) { return sweep.solve(parallel, motion, blocks, scratch, lambda, w); });
}

Elimination MixedSweep::solve_again(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* scratch,
                                    double* lambda, double* w) {
  return join([&](Sweep& sweep) { return sweep.solve_again(parallel, motion, blocks, scratch, lambda, w); });
}

Elimination MixedSweep::factorize(const Parallel& parallel, const double* blocks) {
  return join([&](Sweep& sweep) { return sweep.factorize(parallel, blocks); });
}

void MixedSweep::solve_negative(const Parallel& parallel, const double* b, double* x) {
  for (const auto& sweep : sweeps_) sweep->solve_negative(parallel, b, x);
}

bool MixedSweep::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  for (const auto& sweep : sweeps_)
    ensure(sweep->correct(parallel, blocks, rows, points), "each part of a mixture corrects");
  return true;
}

// ---- projections ----

template <class Each>
Projection MixedSweep::join_projections(const Each& each) {
  Projection result;
  for (const auto& sweep : sweeps_) {
    const Projection found = each(*sweep);
    result.violation = larger(result.violation, found.violation);
    result.iterations = std::max(result.iterations, found.iterations);
  }
  return result;
}

Elimination MixedSweep::linearise(const Parallel& parallel, const double* r, double* blocks) {
  return join([&](Sweep& sweep) { return sweep.linearise(parallel, r, blocks); });
}

Projection MixedSweep::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                         double* sum) {
  return join_projections([&](Sweep& sweep) { return sweep.project_positions(parallel, blocks, target, r, sum); });
}

Projection MixedSweep::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                          const double* r, double* v) {
  return join_projections([&](Sweep& sweep) { return sweep.project_velocities(parallel, blocks, target, r, v); });
}

void MixedSweep::add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) {
  for (const auto& sweep : sweeps_) sweep->add_reactions(parallel, blocks, rows, points);
}

}  // namespace tanor
