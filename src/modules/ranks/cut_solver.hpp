#pragma once

#include <memory>
#include <span>
#include <vector>

#include <tanor/ranks.hpp>

#include "assembly/gather_plan.hpp"
#include "dynamics/model.hpp"
#include "factor/partial_cholesky.hpp"

namespace tanor::detail {

/// Solves x = -S^-1 b where equations reach from rank to rank. Each rank has the rows of its own points. For a rod that
/// is cut, it has the gradient at its own end, as if the other one were a support. S is the sum of what the ranks have:
///
///   [ S_1         S_1G          ]     each rank eliminates its own rows S_r (PartialCholesky), the complements
///   [      S_2    S_2G          ]     C_r = S_GG,r - S_Gr S_r^-1 S_rG are summed on the rows G that they share
///   [ S_G1 S_G2   sum of S_GG,r ]     (SharedRows)
///
/// It is direct: nothing iterates. A rank's part of the shared rows may be singular; its own rows alone are not.
class CutSolver {
 public:
  /// `keeps_diagonal` is true if the diagonal of S stays the same on all ranks, since gradients keep their sizes.
  CutSolver(const Model& model, const Part& part, Ordering ordering, bool keeps_diagonal);

  /// Sets the rows that take part [inner row of an island]; empty for all. For the others x is 0, whatever b is.
  /// Collective, like the functions below.
  void set_active(std::span<const char> rows);

  struct Quality {
    bool own_is_definite = true, shared_is_definite = true;
    std::size_t weakest_row = 0;        ///< inner, of this rank's own rows
    double reciprocal_condition = 1.0;  ///< of this rank's own rows, and of the shared ones
  };
  /// Assembles and factorizes S from the blocks of K. `Quality` is this rank's own.
  Quality factorize(const double* blocks);
  /// Sets x to -S^-1 b [d]; x may be b. Shared rows have the same b on all ranks that have them, and get the same x.
  void solve_negative(const double* b, double* x);

  std::size_t num_shared() const { return factor_.num_kept(); }
  std::size_t num_all_shared() const { return num_all_shared_; }
  std::size_t pattern_nonzeros() const { return plan_.rows().size(); }
  double num_stored() const { return static_cast<double>(factor_.num_stored()); }

 private:
  struct Order;
  void leave_out_rows();
  void scale_shared_rows();
  CutSolver(const Model& model, const Part& part, Order order, bool keeps_diagonal);

  int threads_;
  std::size_t num_all_shared_;
  std::vector<int> permutation_;  // [place] -> inner row; shared rows last
  std::vector<char> is_counted_;  // [own shared row] 1 if this rank adds its b
  std::vector<char> is_active_;   // [place] empty if all are
  GatherPlan plan_;
  PartialCholesky factor_;
  Ranks& ranks_;
  std::unique_ptr<SharedRows> shared_;
  std::vector<std::size_t> shared_place_;  // [own shared row] its place among those of all ranks
  std::vector<double> triangle_;
  const bool keeps_diagonal_;
  bool knows_diagonal_ = false;       // `shared_scale_` is that of the present rows
  std::vector<double> diagonal_;      // [shared row of all ranks] of S, scratch
  std::vector<double> shared_scale_;  // [own shared row] 1/sqrt of the diagonal of S
  std::vector<double> x_;
};

}  // namespace tanor::detail
