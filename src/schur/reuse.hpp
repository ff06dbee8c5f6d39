#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "assembly/gather_plan.hpp"
#include "base/memory.hpp"
#include "factor/incomplete_cholesky.hpp"
#include "schur/conjugate_gradients.hpp"
#include "schur/gram_solver.hpp"
#include "schur/multiplier_history.hpp"

namespace tanor {

/// Solves S lambda = -b at configurations inside a step, where S has no factor of its own. Conjugate gradients go on
/// from the last solutions. They are preconditioned by the factor of another configuration, or by an incomplete one in
/// the order of rows, which runs along rods. Operations and the iterations of earlier solves tell which is cheaper. No
/// clock is asked, so the bits are the same every time.
class Reuse {
 public:
  /// `kept` has the factor of the other configuration.
  Reuse(const GramOperator& S, std::span<const Incidence> incidences, GramSolver& kept);

  /// Whether a few iterations cost less than a factor of S.
  static bool pays(const GramSolver::Summary& factor, std::size_t num_rows, std::size_t num_incidences);

  /// The incomplete factor is made anew where it is wanted next; it serves as well all over a step.
  void renew() { is_renewed_ = false; }

  /// lambda [d] and dw = M^-1 K lambda [3n], to an error of dw in the M-norm of about `allowed`. False: for a
  /// factorization to do, lambda and dw mean nothing.
  bool solve(const Parallel& parallel, double t, const double* blocks, const double* b, double allowed,
             std::vector<double>* lambda, double* dw);
  /// Adds a solution that was found otherwise.
  void add(double t, const std::vector<double>& lambda) { history_.add(t, lambda); }
  /// rows := -S^-1 rows to five digits, dw = M^-1 K rows [3n]; as preconditioned as the last solve. False likewise.
  bool correct(const Parallel& parallel, const double* blocks, double* rows, double* dw);
  /// Of the last solve or correction.
  std::size_t num_iterations() const { return num_iterations_; }

  /// All solutions and counts.
  void forget();
  /// What the next solve starts from.
  void exchange_memory(Memory& memory);

 private:
  enum Preconditioner { Incomplete, Kept };
  /// Multiplications of an iteration, and how many iterations solves took: a mean over the last ones.
  struct Candidate {
    double products, iterations;
  };

  int most_iterations(const Candidate& candidate) const;
  bool make_incomplete(const double* blocks);
  ConjugateGradients::Result iterate(const Parallel& parallel, const double* blocks, const double* b,
                                     const ConjugateGradients::Target& target, double* lambda, double* dw);

  GramSolver& kept_;
  ConjugateGradients conjugate_gradients_;
  GatherPlan plan_;
  IncompleteCholesky incomplete_;
  bool is_renewed_ = false;
  double factor_products_;
  std::array<Candidate, 2> candidates_;
  Preconditioner used_ = Incomplete;
  MultiplierHistory history_;
  std::vector<double> correction_;  // [d]
  std::size_t num_iterations_ = 0;
};

}  // namespace tanor
