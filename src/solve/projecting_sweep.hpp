#pragma once

#include <memory>
#include <vector>

#include "solve/island_group.hpp"
#include "solve/sweep.hpp"

namespace tanor {

/// A sweep that does not project by itself, made one that does: chord iterations with its factor on the rows and points
/// of its islands.
class ProjectingSweep final : public Sweep {
 public:
  ProjectingSweep(std::unique_ptr<Sweep> sweep, IslandGroup group);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* scratch, double* lambda,
                    double* w) override {
    return sweep_->solve(parallel, motion, blocks, scratch, lambda, w);
  }
  Elimination solve_again(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* scratch,
                          double* lambda, double* w) override {
    return sweep_->solve_again(parallel, motion, blocks, scratch, lambda, w);
  }
  Elimination factorize(const Parallel& parallel, const double* blocks) override {
    return sweep_->factorize(parallel, blocks);
  }
  void solve_negative(const Parallel& parallel, const double* b, double* x) override {
    sweep_->solve_negative(parallel, b, x);
  }
  bool correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override;
  const Summary& summary() const override { return sweep_->summary(); }

  bool projects() const override { return true; }
  Elimination linearise(const Parallel& parallel, const double* r, double* blocks) override;
  Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                               double* sum) override;
  Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                double* v) override;
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override;

 private:
  template <class Evaluate>
  Projection iterate(const Parallel& parallel, const double* blocks, double target, const Evaluate& evaluate,
                     double* points, double* sum);

  std::unique_ptr<Sweep> sweep_;
  IslandGroup group_;
  std::vector<double> rows_;  // [d] scratch
};

}  // namespace tanor
