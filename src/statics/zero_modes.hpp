#pragma once

#include <vector>

#include "statics/mode_finder.hpp"

namespace tanor {

/// What passes for omega^2 = 0, of equilibria and of modes alike: a part of the largest omega^2 of the island in which
/// a mode swings, 1e-9 of up to 100 points and less of more, as 1e-9 (100/points)^2, since the lowest omega^2 of a
/// long chain is as small by nature; never less than 1e-13 of it.
class ZeroModes {
 public:
  /// Where the equations were linearised last. `all`: all modes there, which tell the largest omega^2 of each island
  /// closer than the rows of W do; null: nobody knows them.
  ZeroModes(const EquilibriumEquations& equations, const ModeSet* all);

  /// [moving point] omega^2 that are zero in its island, 1/s^2, > 0.
  const std::vector<double>& of_points() const { return of_points_; }
  /// That of a mode: the mean of its points', by kinetic energy.
  double of_mode(const Eigen::Ref<const Eigen::VectorXd>& shape) const;
  bool are_equal() const;
  double least() const;
  /// At least such a part of the same largest ones.
  void raise(double part);

 private:
  const Model& model_;
  std::vector<double> of_points_, largest_;  // [moving point], 1/s^2
};

}  // namespace tanor
