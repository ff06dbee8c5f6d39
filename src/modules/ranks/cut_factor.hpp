#pragma once

#include <tanor/ranks.hpp>

#include "dynamics/rank_revealing_factor.hpp"
#include "ranks/cut_rank.hpp"
#include "ranks/cut_solver.hpp"

namespace tanor::detail {

/// The factor of S where constraints reach from rank to rank. If it looks singular, all ranks decide together which
/// rows of K take no part.
class CutFactor final : public RankRevealingFactor {
 public:
  CutFactor(Workspace& work, const Part& part, const SolverOptions& options, const std::vector<double>& blocks);

  SchurSolver::Summary summarize() override;
  Outcome factorize(double t, const double* r) override;
  void factorize_again() override { (void)factorize_rows(); }
  bool decide_rank_again(const double* r, RankScope scope) override;
  void decide_rank_of_poor_parts(const double* r, const std::vector<double>&, const std::vector<double>&,
                                 double) override {
    (void)decide_rank_again(r, RankScope::AllRows);
  }
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  const CutRank& dependences() const override { return rank_; }

 private:
  bool factorize_rows();

  CutSolver solver_;
  CutRank rank_;
};

}  // namespace tanor::detail
