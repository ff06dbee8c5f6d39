#pragma once

#include <vector>

#include "friction/enumeration.hpp"

namespace tanor {

/// Proves by Theorem B that (43) has one solution; a workspace that is kept, since every step asks.
class ContractionBound {
 public:
  /// Largest row sum of (I - R)^-1, R_cj = mu_c |W_cj|, where rho(R) < 1; else NaN.
  double amplification(const SlidingContacts& contacts);

 private:
  std::vector<double> A_, R_, x_;  // [m][m], row by row, I - R and its factors; R; [m]
};

}  // namespace tanor
