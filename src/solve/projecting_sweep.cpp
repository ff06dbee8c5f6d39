#include "solve/projecting_sweep.hpp"

namespace tanor {

ProjectingSweep::ProjectingSweep(std::unique_ptr<Sweep> sweep, IslandGroup group)
    : sweep_(std::move(sweep)), group_(std::move(group)), rows_(group_.constraints.num_rows()) {}

bool ProjectingSweep::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  if (sweep_->correct(parallel, blocks, rows, points)) return true;
  sweep_->solve_negative(parallel, rows, rows);
  group_.add_reactions(parallel, blocks, rows, points);
  return true;
}

Elimination ProjectingSweep::linearise(const Parallel& parallel, const double* r, double* blocks) {
  if (sweep_->evaluates()) return sweep_->linearise(parallel, r, blocks);
  group_.constraints.evaluate_gradients(parallel, group_.members, r, blocks);
  return sweep_->factorize(parallel, blocks);
}

/// evaluate(rows := what violates them) -> the largest; points += M^-1 K S^-1 (-rows).
template <class Evaluate>
Projection ProjectingSweep::iterate(const Parallel& parallel, const double* blocks, double target,
                                    const Evaluate& evaluate, double* points, double* sum) {
  return iterate_along_chord(
      target, [&] { return evaluate(rows_.data()); },
      [&] {
        correct(parallel, blocks, rows_.data(), points);
        if (sum != nullptr) group_.add_rows(parallel, rows_.data(), sum);
      });
}

Projection ProjectingSweep::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                              double* sum) {
  if (sum != nullptr) group_.add_reactions(parallel, blocks, sum, r);
  const auto evaluate = [&](double* xi) {
    return sweep_->evaluates() ? sweep_->measure_values(parallel, r, xi)
                               : group_.constraints.evaluate_values(parallel, group_.members, r, xi);
  };
  return iterate(parallel, blocks, target, evaluate, r, sum);
}

Projection ProjectingSweep::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                               const double* r, double* v) {
  const auto evaluate = [&](double* rate) {
    return sweep_->evaluates() ? sweep_->measure_rates(parallel, r, v, rate)
                               : group_.constraints.evaluate_rates(parallel, group_.members, r, v, rate);
  };
  return iterate(parallel, blocks, target, evaluate, v, nullptr);
}

void ProjectingSweep::add_reactions(const Parallel& parallel, const double* blocks, const double* rows,
                                    double* points) {
  group_.add_reactions(parallel, blocks, rows, points);
}

}  // namespace tanor
