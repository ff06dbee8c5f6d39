#pragma once

#include <memory>
#include <span>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// The energies of forces that reach from rank to rank: each is counted by one rank, and this one tells what others
/// count.
class CutEnergies {
 public:
  CutEnergies(Workspace& work, const Part& part);

  /// The part of the potential of all forces here that others count, J, and its explicit rate, W.
  double potential_elsewhere(double t, const double* r);
  double rate_elsewhere(const Kinematics& at);
  /// The rows here, inner, whose power others count.
  std::span<const std::size_t> rows_elsewhere() const { return rows_elsewhere_; }

 private:
  /// Pair forces without a cutoff between own points and guests.
  struct PairsWithGuests {
    std::size_t entry;    // among the pair forces of the system
    PairField among_own;  // those between own points, which no other rank has
  };
  void add_pairs(std::size_t entry, const PairForces& pairs);

  Workspace& work_;
  const Model& model_;
  std::unique_ptr<Forces> counted_elsewhere_;  // forces whose energies other ranks count; null if there are none
  std::vector<PairsWithGuests> pairs_with_guests_;
  std::vector<std::size_t> rows_elsewhere_;
};

}  // namespace tanor::detail
