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
  /// W at (t, r, lambda); r [3 points], lambda [rows].
  void evaluate(double t, const double* r, const double* lambda, Curvature curvature = Curvature::Exact);

  /// As if every rod were tightened by `tension`, N, where it turns and where it is drawn out: tension/length between
  /// its ends; where points have no rods, tension over the scene's size.
  void add_tension(double tension, const double* r);
  /// As if every coordinate were held by a spring of the given share of the largest entry in its row, or `otherwise`,
  /// N/m, where that is 0: what rounding leaves of a force then moves nothing far where motions cost nothing.
  void hold_rows(double share, double otherwise);

  /// Changes where blocks come and go: pair forces with a cutoff have those of the pairs within it.
  std::size_t pattern_version() const { return pattern_version_; }
  std::size_t num_points() const { return start_.size() - 1; }  ///< that move
  /// Blocks of point i: start()[i] … start()[i + 1] - 1, beside increasing columns().
  std::span<const int> start() const { return start_; }
  std::span<const int> columns() const { return columns_; }
  std::span<const Block3> blocks() const { return blocks_; }

  /// y = W x [3 num_points()].
  void multiply(const double* x, double* y) const;
  /// x'Wx is a sum of terms; theirs without signs, of which its rounding is a part.
  double sum_terms(const double* x) const;
  /// Largest |W - W'| over the largest |W|: beyond rounding, some force has no potential.
  double asymmetry() const;
  /// Largest |W_ij|, N/m, and that of the rows of one point.
  double largest() const;
  double largest_of(std::size_t point) const;

 private:
  /// `r`: where pair forces are; null: without them.
  void make_pattern(const double* r);
  bool knows_all_pairs(const double* r);
  void add_pairs(const double* r);
  bool has_block(int i, int j) const;
  int slot(int i, int j) const;
  void add_coupling(std::size_t k, const Block3& derivative);

  Workspace& work_;
  const Model& model_;
  std::size_t pattern_version_ = 0, num_pairs_ = 0;  // pairs that feel each other, by forces of pairs
  std::vector<int> start_{0}, columns_;
  std::vector<Block3> blocks_;
  std::vector<int> diagonal_;  // [moving point] its own block

  /// Of springs, then of rods; of tuples with an energy, then of curved constraints.
  struct CoupledBlocks {
    Coupling points;
    int ij, ji;  // -1: one of them does not move
  };
  std::vector<CoupledBlocks> couplings_;
  std::vector<int> influence_slots_;
  std::size_t num_springs_, num_energies_;
  std::vector<Block3> point_positions_, point_velocities_, coupling_positions_, coupling_velocities_, influences_;
  std::vector<double> at_rest_;  // [3 points] velocities: 0
};

}  // namespace tanor
