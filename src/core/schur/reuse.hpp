#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "assembly/gather_plan.hpp"
#include "assembly/reactions.hpp"
#include "base/memory.hpp"
#include "evaluate/constraints.hpp"
#include "factor/incomplete_cholesky.hpp"
#include "schur/gram_solver.hpp"
#include "schur/multiplier_history.hpp"

namespace tanor::detail {

/// The operator S = K'M^-1K without its entries. It is applied by two products with the blocks of K.
struct GramOperator {
  const Constraints& constraints;
  const ReactionGather& gather;
  const std::vector<double>& inverse_mass;  ///< [point]
  std::size_t num_moving, num_rows;         ///< num_rows: rows that take part, the first ones

  /// Computes dw = M^-1 K x [3n].
  void add_up(const Parallel& parallel, const double* blocks, const double* x, double* dw) const {
    gather.write_scaled(parallel, blocks, x, inverse_mass.data(), num_moving, dw);
  }
};

/// Solves S lambda = -b at configurations inside a step, where S has no factor of its own. Conjugate gradients
/// (M. R. Hestenes, E. Stiefel 1952) start from the last solutions. They are preconditioned by an incomplete factor
/// P ~ S in the order of rows, which runs along rods. The operations and the iterations of earlier solves tell if that
/// is cheaper than a factor. No clock is asked, so the bits are the same every time.
class Reuse {
 public:
  /// `factor` sums up the factor of S that a solve saves. `incidences` outlive this object.
  Reuse(const GramOperator& S, std::span<const Incidence> incidences, const GramSolver::Summary& factor);

  /// Returns true if a few iterations cost less than a factor of S.
  static bool pays(const GramSolver::Summary& factor, std::size_t num_rows, std::size_t num_incidences);

  /// Makes the incomplete factor anew when it is next needed. One factor serves equally well all over a step.
  void renew() { is_renewed_ = false; }

  /// Computes lambda [d] and dw = M^-1 K lambda [3n], with an error of dw of about `allowed` in the M-norm. Returns
  /// false if a factorization has to do it; lambda and dw then mean nothing.
  bool solve(const Parallel& parallel, double t, const double* blocks, const double* b, double allowed,
             std::vector<double>* lambda, double* dw);
  /// Adds a solution that was found in another way.
  void add(double t, const std::vector<double>& lambda) { history_.add(t, lambda); }
  /// Computes rows := -S^-1 rows to five digits and dw = M^-1 K rows [3n] after a solve. Returns false if that
  /// fails.
  bool correct(const Parallel& parallel, const double* blocks, double* rows, double* dw);
  /// Returns the iterations of the last solve or correct.
  std::size_t num_iterations() const { return static_cast<std::size_t>(num_iterations_); }

  /// Forgets all solutions and counts.
  void forget();
  /// Exchanges what the next solve starts from.
  void exchange_memory(Memory& memory);

 private:
  /// The incomplete factor, and how S is assembled for it.
  struct IncompleteFactor {
    GatherPlan plan;
    IncompleteCholesky factor;
  };

  int most_iterations() const;
  bool make_incomplete(const double* blocks);
  bool iterate(const Parallel& parallel, const double* blocks, const double* b, double allowed, double reduction,
               double* lambda, double* dw);
  double dot(const Parallel& parallel, const std::vector<double>& x, const std::vector<double>& y) const;
  bool advance(const Parallel& parallel, const double* blocks, double error2, double beta, double* lambda, double* dw);

  GramOperator S_;
  std::span<const Incidence> incidences_;
  std::vector<double> rho_, z_, p_, q_;           // [d] S lambda + b; -P^-1 rho; direction; S p
  std::unique_ptr<IncompleteFactor> incomplete_;  // planned when it is first needed: schemes of fixed steps never do
  bool is_renewed_ = false;
  double factor_products_, products_;  // multiplications of a factor of S and of an iteration
  double mean_iterations_;             // of a solve
  MultiplierHistory history_;
  std::vector<double> correction_;  // [d]
  int num_iterations_ = 0;
};

}  // namespace tanor::detail
