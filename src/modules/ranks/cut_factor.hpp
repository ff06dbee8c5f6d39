#pragma once

#include <memory>
#include <span>
#include <vector>

#include <tanor/ranks.hpp>

#include "assembly/gather_plan.hpp"
#include "dynamics/rank_revealing_factor.hpp"
#include "factor/multifrontal.hpp"
#include "ranks/cut_rank.hpp"

namespace tanor::detail {

/// Makes shared rows that every rank solves for itself, all of them, with one sum for a factorization and one for a
/// solve. `own` are the places, ascending, of this rank's shared rows among the `num_rows` of all ranks.
std::unique_ptr<SharedRows> make_replicated_rows(Ranks& ranks, std::size_t num_rows, std::span<const std::size_t> own,
                                                 int threads);

/// The factor of S where constraints reach from rank to rank. Each rank has the rows of its own points. For a rod that
/// is cut, it has the gradient at its own end, as if the other one were a support. S is the sum of what the ranks have:
///
///   [ S_1         S_1G          ]     each rank eliminates its own rows S_r (Multifrontal), the complements
///   [      S_2    S_2G          ]     C_r = S_GG,r - S_Gr S_r^-1 S_rG are summed on the rows G that they share
///   [ S_G1 S_G2   sum of S_GG,r ]     (SharedRows)
///
/// It is direct: nothing iterates. A rank's part of the shared rows may be singular; its own rows alone are not. If S
/// looks singular, all ranks decide together which rows of K take no part; their multipliers are 0.
class CutFactor final : public RankRevealingFactor {
 public:
  /// Collective, like the functions below.
  CutFactor(Workspace& work, const Part& part, const SolverOptions& options, const std::vector<double>& blocks);

  SchurSolver::Summary summarize() override;
  Outcome factorize(double t, const double* r) override;
  void factorize_again() override { (void)factorize_rows(); }
  bool decide_rank_again(const double* r, RankScope scope) override;
  void decide_rank_of_poor_parts(const double* r, const std::vector<double>&, const std::vector<double>&,
                                 double) override {
    (void)decide_rank_again(r, RankScope::AllRows);
  }
  /// Sets x to -S^-1 b [d]; x may be b. Shared rows have the same b on all ranks that have them, and get the same x.
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  const CutRank& dependences() const override { return rank_; }

 private:
  struct Order;
  CutFactor(Workspace& work, const Part& part, const SolverOptions& options, const std::vector<double>& blocks,
            Order order);
  bool factorize_rows();
  bool factorize_without_dependent_rows();
  void leave_out_rows();
  void scale_shared_rows();
  std::size_t num_shared() const { return factor_.num_kept(); }

  CutRank rank_;
  std::vector<int> permutation_;  // [place] -> inner row; shared rows last
  std::vector<char> is_counted_;  // [own shared row] 1 if this rank adds its b
  std::vector<char> is_active_;   // [place] 0 for rows that take no part; empty if all do
  GatherPlan plan_;
  Multifrontal factor_;
  std::vector<double> values_;  // beside the rows of `plan_`
  Ranks& ranks_;
  std::unique_ptr<SharedRows> shared_;
  std::vector<std::size_t> shared_place_;  // [own shared row] its place among those of all ranks
  std::vector<double> triangle_;
  const bool keeps_diagonal_;         // the diagonal of S stays the same on all ranks, since gradients keep their sizes
  bool knows_diagonal_ = false;       // `shared_scale_` is that of the present rows
  std::vector<double> diagonal_;      // [shared row of all ranks] of S, scratch
  std::vector<double> shared_scale_;  // [own shared row] 1/sqrt of the diagonal of S
  std::vector<double> x_;
};

}  // namespace tanor::detail
