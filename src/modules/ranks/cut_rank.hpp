#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/workspace.hpp"
#include "factor/rank_solver.hpp"
#include "ranks/agreement.hpp"

namespace tanor::detail {

/// The rows of K that depend on others, where constraints reach from rank to rank. S raises the suspicion; then every
/// rank receives all of K and decides by QR, as Redundancy does on one rank. Dependent rows take no part in S: their
/// multipliers are 0 unless `minimize_norm` shares the load out again. Functions that decide or solve are collective.
class CutRank {
 public:
  CutRank(Workspace& work, const Part& part, Agreement& agreement);

  /// Decides with K in `blocks`, at r. Returns true if the dependent rows have changed on some rank.
  bool decide(const double* blocks, const double* r);
  /// True if some row depends on others, on some rank.
  bool is_found() const { return solver_ != nullptr && !solver_->dependences().empty(); }
  /// Returns [inner row of an island] 1 for rows that take part, 0 for others; empty if all take part.
  std::span<const char> active_rows() const { return active_; }
  /// Returns "rods[5] depends on rods[0], rods[3], …" for the first dependent row, with this verb.
  std::string explain(const std::string& verb);
  /// Sets lambda [d] to the least-norm multipliers of the same reactions, with the K of the last decision.
  void minimize_norm(double* lambda);

 private:
  SparseColumns gather_columns(const double* blocks, Scaling scaling);

  Workspace& work_;
  const Model& model_;
  Ranks& ranks_;
  Agreement& agreement_;
  // Numbers among all ranks: own rows and points of one rank come after those of another, shared rows last.
  std::vector<std::size_t> row_number_;  // [inner row of an island]
  std::vector<char> is_counted_;         // likewise; 1 if this rank counts it
  std::size_t first_point_ = 0, num_all_points_ = 0, num_all_rows_ = 0;
  std::unique_ptr<RankSolver> solver_;  // null if nothing was suspected
  std::vector<char> active_;
};

}  // namespace tanor::detail
