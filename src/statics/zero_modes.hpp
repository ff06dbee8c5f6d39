#pragma once

#include <vector>

#include "statics/mode_finder.hpp"

namespace tanor {

/// What passes for omega^2 = 0, of equilibria and of modes alike: what rounding leaves of q'Wq.
///
/// Of dense matrices that is 1e-12 of the rows of W. A factor with penalties in the place of constraints knows 1e-9 of
/// them in islands of up to 100 points and less of more, as 1e-9 (100/points)^2, since the lowest omega^2 of a long
/// chain is as small by nature; without constraints, and at least, 1e-13.
class ZeroModes {
 public:
  enum class Found { ByDenseMatrices, ByFactor };

  /// Where the equations were linearised last.
  ZeroModes(const EquilibriumEquations& equations, Found found);

  /// [moving point] d_i/m_i, where q'Dq is what rounding leaves of q'Wq, 1/s^2, > 0.
  const std::vector<double>& of_points() const { return of_points_; }
  /// q'Dq of a mode with q'Mq = 1.
  double of_mode(const Eigen::Ref<const Eigen::VectorXd>& shape) const;
  bool are_equal() const;
  double least() const;
  /// Where nothing balances such a force, N, at some point, W is not known closer than to it over a length.
  void raise(double force);

 private:
  const Model& model_;
  std::vector<double> of_points_;  // [moving point], 1/s^2
};

}  // namespace tanor
