#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/dependences.hpp"
#include "factor/rank_solver.hpp"

namespace tanor::detail {

/// Returns [inner row] the row as several ranks share it, or null.
std::vector<const Part::SharedRow*> find_shared_rows(const Model& model, const Part& part);

/// The rows of K that depend on others, where constraints reach from rank to rank. S raises the suspicion; then every
/// rank receives all of K and decides by QR, as Dependences does on one rank. Dependent rows take no part in S: their
/// multipliers are 0 unless `minimize_norm` shares the load out again. Functions are collective but those about one
/// row.
class CutRank final : public Dependences {
 public:
  CutRank(Workspace& work, const Part& part);

  /// Decides with K in `blocks`, at r. Returns true if the dependent rows have changed on some rank.
  bool decide(const std::vector<double>& blocks, const double* r);
  /// True if some row depends on others, on some rank.
  bool is_found() const override { return solver_ != nullptr && !solver_->dependences().empty(); }
  bool is_dependent(std::size_t row) const override { return row < active_.size() && active_[row] == 0; }
  /// Returns "rods[5] depends on rods[0], rods[3], …" for the first dependent row, with this verb.
  std::string explain(const std::string& verb) const;
  /// Blames the first dependent row.
  Outcome explain_contradiction(double t, const std::vector<double>&, const std::vector<double>&, double,
                                Dimension) const override;
  void minimize_norm(double* lambda) const override;

 private:
  SparseColumns gather_columns(const double* blocks, Scaling scaling);

  Workspace& work_;
  const Model& model_;
  // Numbers among all ranks: own rows and points of one rank come after those of another, shared rows last.
  std::vector<std::size_t> row_number_;  // [inner row of an island]
  std::vector<char> is_counted_;         // likewise; 1 if this rank counts it
  std::size_t first_point_ = 0, num_all_points_ = 0, num_all_rows_ = 0;
  std::unique_ptr<RankSolver> solver_;  // null if nothing was suspected
  std::vector<char> active_;            // [inner row of an island] 1 for rows that take part; empty if all do
};

}  // namespace tanor::detail
