#pragma once

#include <set>
#include <vector>

#include "statics/one_sided.hpp"

namespace tanor::detail {

/// Finds the equilibrium of a system whose constraints all act both ways, in a frame whose inertia is among the forces,
/// from `start` [3n]. If `assesses_stability` is
/// false, any equilibrium is accepted and its stability is not computed.
EquilibriumResult rest_from(const System& system, const SteadyFrame& frame, const EquilibriumOptions& options,
                            const std::vector<double>& prestress, const std::vector<double>& start,
                            bool assesses_stability);

/// Alternates between equilibria with the closed one-sided constraints and changes of this set, until no closed one
/// pulls and no open one is broken (the primal-dual active sets of Hintermueller, Ito & Kunisch 2002). Only then is the
/// stability computed; if that leads away from an unstable equilibrium, rounds continue from there.
class OneSidedSearch {
 public:
  OneSidedSearch(const StaticsInput& input, const EquilibriumOptions& options)
      : input_(input), options_(options), rows_(input, options), positions_(input.system.positions) {}

  EquilibriumResult run();

 private:
  EquilibriumResult rest(bool assesses_stability);
  OneSidedRows::Rows change_after(const EquilibriumResult& failed);
  OneSidedRows::Rows take_part_of_change();
  EquilibriumResult write(EquilibriumResult found);

  const StaticsInput& input_;
  const EquilibriumOptions& options_;
  OneSidedRows rows_;
  Exchange exchange_;
  OneSidedRows::Rows wanted_, changed_;  // what should change before this round, and what did
  std::vector<double> positions_;        // last equilibrium
  std::set<std::vector<bool>> failed_;   // sets that have no equilibrium
  bool has_rested_ = false;
  EquilibriumSearch search_;  // over all rounds
};

}  // namespace tanor::detail
