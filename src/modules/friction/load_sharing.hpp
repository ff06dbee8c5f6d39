#pragma once

#include <vector>

#include "dynamics/constrained_system.hpp"
#include "friction/contact_state.hpp"

namespace tanor::detail {

/// Shares a load among contacts that stick and hold more than can move. Then no law divides the load among them, and
/// the least friction that holds is taken. A small compliance of their rows finds it, and refinement removes the
/// compliance again, since refined solutions lie in the range of S.
class LoadSharing {
 public:
  /// Both arguments must outlive this object.
  LoadSharing(ContactState& state, ConstrainedSystem& system) : state_(state), system_(system) {}

  /// Makes the rows of sticking contacts compliant in the factor of S, because these contacts depend on constraints or
  /// on each other. Returns true if S must be factorized again, and false if nothing sticks or rows are compliant
  /// already.
  bool begin();
  /// Makes no row compliant. Call this when the set of sticking contacts or their shares have changed, so that
  /// redundancy is decided again.
  void forget();

  /// Returns true if some sticking contacts have references, so that they hold more than can move.
  bool has_references() const;
  /// Makes contacts the more compliant the nearer they are to their limits (Lawson's algorithm for the share in which
  /// the most loaded contact has most to spare). `loads` [contact] are held over limit of those that stick, otherwise
  /// negative.
  void share_again(const std::vector<double>& loads);

 private:
  static constexpr double compliance = 1e-4;  // rounding grows by its inverse; refinement reduces errors by this factor

  ContactState& state_;
  ConstrainedSystem& system_;
};

}  // namespace tanor::detail
