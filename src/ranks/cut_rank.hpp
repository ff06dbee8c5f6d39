#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/workspace.hpp"
#include "factor/rank_solver.hpp"
#include "ranks/agreement.hpp"

namespace tanor {

/// Which rows of K depend on others, where constraints reach from rank to rank. S raises the suspicion; then every rank
/// is told all of K and decides by QR, as Redundancy does for what one rank has alone. Dependent rows take no part in
/// S: their multipliers are 0 unless `minimize_norm` shares the load out again. Functions that decide or solve are
/// collective.
class CutRank {
 public:
  CutRank(Workspace& work, const Part& part, Agreement& agreement);

  /// Decides with K in `blocks`, at r. Returns whether the dependent rows are others than before, somewhere.
  bool decide(const double* blocks, const double* r);
  /// Some row depends on others, somewhere.
  bool is_found() const { return solver_ != nullptr && !solver_->dependences().empty(); }
  /// [inner row of an island] Empty: all take part.
  std::span<const char> active_rows() const { return active_; }
  /// "rods[5] depends on rods[0], rods[3], …", of the first dependent row and with this verb.
  std::string explain(const std::string& verb);
  /// lambda [d] := the multipliers of the same reactions that have the least norm, with the K of the last decision.
  void minimize_norm(double* lambda);

 private:
  SparseColumns gather_columns(const double* blocks, Scaling scaling);

  Workspace& work_;
  const Model& model_;
  Ranks& ranks_;
  Agreement& agreement_;
  // Numbers among all ranks: own rows and points of one rank after those of another, shared rows last.
  std::vector<std::size_t> row_number_;  // [inner row of an island]
  std::vector<char> is_counted_;         // likewise: by this rank
  std::size_t first_point_ = 0, num_all_points_ = 0, num_all_rows_ = 0;
  std::unique_ptr<RankSolver> solver_;  // null: nothing was suspected
  std::vector<char> active_;
};

}  // namespace tanor
