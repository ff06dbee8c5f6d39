#pragma once

#include <vector>

#include "statics/mode_finder.hpp"

namespace tanor {

/// What passes for omega^2 = 0, of equilibria and of modes alike: what rounding leaves of q'Wq, a part of the rows of
/// W.
///
/// Multipliers, and factors with penalties in the place of constraints, are known to 1e-9 in islands of up to 100
/// points; in larger ones the part is less, 1e-9 (100/points)^2 and at least 1e-13, since the lowest omega^2 of a long
/// chain is as small by nature. Without constraints it is 1e-12 of dense matrices and 1e-13 of a factor.
class ZeroModes {
 public:
  enum class Found { ByDenseMatrices, ByFactor };

  /// The equations keep the W of their last linearisation, and these zeros are of that one.
  ZeroModes(const EquilibriumEquations& equations, Found found);

  /// [moving point] d_i/m_i, where q'Dq is what rounding leaves of q'Wq, 1/s^2, > 0.
  const std::vector<double>& of_points() const { return of_points_; }
  /// q'Dq of a mode with q'Mq = 1.
  double of_mode(const Eigen::Ref<const Eigen::VectorXd>& shape) const;
  bool are_equal() const;
  double least() const;
  /// Where nothing balances such a force, N, at some point, multipliers are not known closer than a hundred times it,
  /// nor W than that over a length.
  void raise(double force);
  static constexpr double share_of_residual = 100.0;

 private:
  const Model& model_;
  std::vector<double> of_points_;  // [moving point], 1/s^2
};

}  // namespace tanor
