#pragma once

#include <vector>

#include "dynamics/contact_state.hpp"
#include "schur/gram_solver.hpp"

namespace tanor {

/// Contacts that stick may hold more than can move, and then no law divides the load among them: the least friction
/// that holds is taken. A little compliance of their rows finds it, and refinement removes the compliance again
/// (refined solutions lie in the range of S).
class LoadSharing {
 public:
  /// Both arguments must outlive it.
  LoadSharing(ContactState& state, GramSolver& S) : state_(state), S_(S) {}

  /// Contacts that stick depend on constraints, or on each other: from now on their rows are compliant in the factor of
  /// S. Returns whether S is to be factorized anew: false where nothing sticks, or rows are compliant already.
  bool begin();
  /// The set of contacts that stick has changed, or their shares: check again whether they hold too much.
  void forget();

  /// Some contacts that stick have references, so they hold more than can move.
  bool has_references() const;
  /// Each gives way the more, the nearer it is to its limit (Lawson's algorithm for the share in which the most loaded
  /// contact has most to spare). `loads` [contact]: of those that stick, held over limit; else negative.
  void share_again(const std::vector<double>& loads);

 private:
  static constexpr double compliance = 1e-4;  // rounding grows by its inverse, each refinement wins its digits

  ContactState& state_;
  GramSolver& S_;
};

}  // namespace tanor
