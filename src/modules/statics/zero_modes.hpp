#pragma once

#include <vector>

#include "statics/islands.hpp"
#include "statics/mode_finder.hpp"

namespace tanor::detail {

/// The bound below which omega^2 counts as zero, for equilibria and modes alike. It is the rounding error of q'Wq,
/// estimated as a part of the rows of W.
///
/// In islands of up to 100 points multipliers, and factors with penalties in the place of constraints, are accurate to
/// 1e-9. In larger islands the part is 1e-9 (100/points)^2, at least 1e-13, because the lowest omega^2 of a long chain
/// is as small by nature. Without constraints the part is 1e-12 for dense matrices and 1e-13 for a factor. Where
/// positions are known to an error only, as at the minimum of x^4, a hundred times the change of W over it counts, and
/// where loads cancel, their rounding over a length; where all forces of an island are rounding, a hundred times these.
class ZeroModes {
 public:
  enum class Found { ByDenseMatrices, ByFactor };

  /// The bounds belong to the W of the last linearisation of `equations`, and to the forces of their last evaluation.
  ZeroModes(const EquilibriumEquations& equations, Found found);

  /// The bound of each moving point, d_i/m_i > 0, 1/s^2, where q'Dq is the rounding error of q'Wq.
  const std::vector<double>& of_points() const { return of_points_; }
  /// Returns q'Dq of a mode with q'Mq = 1.
  double of_mode(const Eigen::Ref<const Eigen::VectorXd>& shape) const;
  /// Raises the bounds of each island for its largest residual force [moving point], N, whether it is rounding or not.
  /// Multipliers are then known to a hundred times this force at best, and W to that force over a length.
  void raise(const std::vector<double>& forces);
  static constexpr double share_of_residual = 100.0;

 private:
  const Model& model_;
  const std::vector<StaticsIsland> islands_;
  std::vector<double> of_points_;  // [moving point], 1/s^2
};

}  // namespace tanor::detail
