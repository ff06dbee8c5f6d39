#pragma once

#include <array>
#include <vector>

#include "factor/cholesky.hpp"

namespace tanor::detail {

/// Factorizes L L' = S in closed form where no sparse factorization is needed: S is diagonal (beads on surfaces of
/// their own), or it belongs to one point, which has at most three rows. It takes the upper triangle and otherwise
/// behaves like Cholesky.
class ClosedForm {
 public:
  static bool serves(const TrianglePattern& upper);

  explicit ClosedForm(TrianglePattern upper);

  double* values() { return values_.data(); }
  [[nodiscard]] Cholesky::Quality factorize();
  /// Solves in place: x := S^-1 x, [n].
  void solve(double* x) const;

 private:
  static constexpr std::size_t most_rows = 3;
  bool is_diagonal() const { return pattern_.rows.size() == pattern_.size(); }

  TrianglePattern pattern_;
  std::vector<double> values_;
  std::vector<double> inverse_;                               // 1/S_ii of a diagonal S
  std::array<std::array<double, most_rows>, most_rows> L_{};  // L of any other S
};

}  // namespace tanor::detail
