#pragma once

#include <set>
#include <vector>

#include "statics/one_sided.hpp"

namespace tanor {

/// The equilibrium of a system whose constraints hold both ways, from `start` [3n]; not `is_judged`: whatever its
/// stability, which nobody asks for.
EquilibriumResult rest_from(const System& system, const EquilibriumOptions& options,
                            const std::vector<double>& prestress, const std::vector<double>& start, bool is_judged);

/// Rounds of equilibria with the one-sided constraints that are closed, until none of them pulls and no other is broken
/// (the primal-dual active sets of Hintermueller, Ito & Kunisch 2002). Its stability is judged then; where that moves
/// it away from an unstable one, rounds go on from there.
class OneSidedSearch {
 public:
  OneSidedSearch(const StaticsInput& input, const EquilibriumOptions& options)
      : input_(input), options_(options), rows_(input, options), positions_(input.system.positions) {}

  EquilibriumResult run();

 private:
  EquilibriumResult rest(bool is_judged);
  OneSidedRows::Rows change_after(const EquilibriumResult& failed);
  OneSidedRows::Rows take_part_of_change();
  EquilibriumResult write(EquilibriumResult found);

  const StaticsInput& input_;
  const EquilibriumOptions& options_;
  OneSidedRows rows_;
  Exchange exchange_;
  OneSidedRows::Rows wanted_, changed_;  // what should change before this round, and what of it did
  std::vector<double> positions_;        // where it rested last
  std::set<std::vector<bool>> failed_;   // sets that have no equilibrium
  bool has_rested_ = false;
  EquilibriumSearch search_;  // of all rounds
};

}  // namespace tanor
