#pragma once

#include <span>
#include <string>
#include <vector>

#include "assembly/gather_plan.hpp"
#include "base/parallel.hpp"
#include "factor/cholesky.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// Solves S x = b, S = K'M^-1K, part by part (groups of islands): assembly + CHOLMOD, the general way.
/// The symbolic work is done once, in the constructor; `factorize` and `solve` only fill numbers.
class NormalSolver {
 public:
  /// `incidences` of all points, `inverse_masses` [point]: 0 for supports. `squared_norms` [block] as GatherPlan takes
  /// them.
  NormalSolver(std::span<const Incidence> incidences, std::span<const double> inverse_masses,
               const Numbering& numbering, Ordering ordering, std::span<const double> squared_norms);

  struct Quality {
    bool positive_definite = true;
    std::size_t weakest_row = 0;        ///< inner row of the smallest pivot, or of the failed one
    double reciprocal_condition = 1.0;  ///< smallest over the parts
  };
  /// Below this the scaled S counts as singular: CHOLMOD may call an exactly singular matrix fine (measured).
  static constexpr double singular_below = 3e-14;

  void assemble(const Parallel& parallel, const double* blocks);
  [[nodiscard]] Quality factorize(const Parallel& parallel);
  /// x = -S^-1 b, [d], with the last factor: the sign that (31) and every projection want. x may be b. Idle rows get 0.
  void solve_negative(const Parallel& parallel, const double* b, double* x);

  struct Summary {
    std::size_t parts = 0, pattern_nonzeros = 0;
    double factor_nonzeros = 0.0, flops = 0.0;
    std::string ordering, factorization;
  };
  const Summary& summary() const { return summary_; }

 private:
  struct Part {
    Index first_row;
    std::vector<int> permutation;  // [place] -> row of the part; empty: as it is
    GatherPlan plan;
    Cholesky cholesky;
    std::vector<double> x;  // right-hand side in the order of elimination
    Quality quality;
  };

  std::vector<Part> parts_;
  std::size_t first_idle_row_, num_rows_;
  Summary summary_;
};

}  // namespace tanor
