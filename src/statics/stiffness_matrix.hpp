#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/block3.hpp"
#include "dynamics/workspace.hpp"

namespace tanor {

/// How forces and reactions answer to a small move of the points, at fixed lambda and t and at rest:
///
///   W = -df/dr - sum over rows a of lambda_a Hess xi_a      [3n x 3n], N/m, of the n moving points
///
/// The first part is the material stiffness, the second one the geometric stiffness, which is that of tensions. Stored
/// as blocks of 3 x 3 numbers by rows of points, both triangles, in the inner order. W is symmetric where all forces
/// have a potential.
class StiffnessMatrix {
 public:
  explicit StiffnessMatrix(Workspace& work);

  /// Convex leaves out what compressed rods take away, so that W is less often indefinite: far from an equilibrium that
  /// leads downhill.
  enum class Curvature { Exact, Convex };
  /// W at (t, r, lambda); r [3 points], lambda [rows]. The pattern changes where pair forces meet other neighbours.
  void evaluate(double t, const double* r, const double* lambda, Curvature curvature = Curvature::Exact);

  std::size_t num_points() const { return start_.size() - 1; }  ///< that move
  std::size_t size() const { return 3 * num_points(); }
  /// Blocks of point i: start()[i] … start()[i + 1] - 1, beside increasing columns().
  std::span<const int> start() const { return start_; }
  std::span<const int> columns() const { return columns_; }
  std::span<const Block3> blocks() const { return blocks_; }
  /// Changes when the pattern does.
  std::size_t pattern_version() const { return version_; }

  /// y = W x [size()].
  void multiply(const double* x, double* y) const;
  /// Largest |W - W'| over the largest |W|: beyond rounding, some force has no potential.
  double asymmetry() const;
  /// Largest |W_ij|, N/m.
  double largest() const;

 private:
  struct Contribution;
  void make_pattern(const std::vector<Coupling>& pairs);
  int slot(int i, int j) const;
  void add(int i, int j, double sign, const Block3& block);

  Workspace& work_;
  const Model& model_;
  std::vector<int> start_{0}, columns_;
  std::vector<Block3> blocks_;
  std::size_t version_ = 0;
  std::vector<Coupling> couplings_;       // springs, then rods: a block each in `coupling_blocks_`
  std::vector<Influence> influences_;     // tuples with an energy, then rows of other constraints
  std::vector<Coupling> pairs_;           // pair forces that the pattern knows
  std::vector<Block3> point_blocks_, coupling_blocks_, influence_blocks_, pair_blocks_, scratch_;
  std::vector<double> at_rest_;           // [3 points] velocities: 0
};

}  // namespace tanor
