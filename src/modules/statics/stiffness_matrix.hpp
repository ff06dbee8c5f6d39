#pragma once

#include <Eigen/SparseCore>
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "base/block3.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

inline double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Returns the number of an entry in compressed rows (see compress_pairs), or -1 if there is none.
inline int find_slot(std::span<const int> start, std::span<const int> entries, int row, int entry) {
  const auto begin = entries.begin() + start[static_cast<std::size_t>(row)];
  const auto end = entries.begin() + start[static_cast<std::size_t>(row) + 1];
  const auto at = std::lower_bound(begin, end, entry);
  return at != end && *at == entry ? static_cast<int>(at - entries.begin()) : -1;
}

/// The response of forces and reactions to a small move of the points, at fixed lambda and t and at rest:
///
///   W = -df/dr - sum over rows a of lambda_a Hess xi_a      [3n x 3n], N/m, of the n moving points
///
/// The first part is the material stiffness, the second the geometric stiffness, which comes from tensions. W is stored
/// as blocks of 3 x 3 numbers by rows of points, both triangles, in the inner order. It is symmetric if all forces have
/// a potential.
class StiffnessMatrix {
 public:
  explicit StiffnessMatrix(Workspace& work);

  /// Convex omits the destabilizing part of compressed rods, so that W is less often indefinite. Far from an
  /// equilibrium that leads downhill.
  enum class Curvature { Exact, Convex };
  /// Evaluates W at (t, r, lambda); r [3 points], lambda [rows].
  void evaluate(double t, const double* r, const double* lambda, Curvature curvature = Curvature::Exact);

  /// Returns D = -df/dv [3n, 3n], N s/m, at rest at (t, r), in the pattern of W. Springs, linear drag and formulas
  /// contribute to it; friction does not.
  Eigen::SparseMatrix<double> find_damping(double t, const double* r) const;

  /// Adds the stiffness of a tension, N, in every rod, both against turning and against stretching: tension/length
  /// between the ends of the rod. Points without rods get tension over the scene's size.
  void add_tension(double tension, const double* r);
  /// Adds a spring to every coordinate: the given share of the largest entry in its row, or `otherwise`, N/m, if that
  /// is 0. Rounding errors of forces then move nothing far along motions that cost nothing.
  void hold_rows(double share, double otherwise);

  /// Returns a number that changes when blocks come and go: pair forces with a cutoff have blocks for the pairs within
  /// it.
  std::size_t pattern_version() const { return pattern_version_; }
  std::size_t num_points() const { return start_.size() - 1; }  ///< that move
  /// The blocks of point i are start()[i] … start()[i + 1] - 1, in the increasing columns().
  std::span<const int> start() const { return start_; }
  std::span<const int> columns() const { return columns_; }
  std::span<const Block3> blocks() const { return blocks_; }
  /// Calls visit(i, j, k) for all blocks k, which stand in the row of point i and the column of point j, row by row.
  template <class Visit>
  void for_each_block(const Visit& visit) const {
    for (std::size_t i = 0; i < num_points(); ++i) {
      for (auto k = static_cast<std::size_t>(start_[i]); k < static_cast<std::size_t>(start_[i + 1]); ++k)
        visit(i, static_cast<std::size_t>(columns_[k]), k);
    }
  }

  /// Computes y = W x [3 num_points()].
  void multiply(const double* x, double* y) const;
  /// Returns W X, column by column.
  Eigen::MatrixXd multiply(const Eigen::MatrixXd& X) const;
  /// The work y'Wz, and the sum of its absolute terms, to which its rounding error is proportional.
  struct Work {
    double sum = 0.0, terms = 0.0;
  };
  /// Returns y'Wz, or y'(W - without)z of another matrix with the same pattern.
  Work find_work(const double* y, const double* z, const StiffnessMatrix* without = nullptr) const;
  /// Returns for each point the largest sum of |W_ij| over one of its rows, N/m. |q_i'Wq| is at most this sum times
  /// |q_i| if all |q_j| are equal.
  std::vector<double> sum_rows() const;
  /// Returns the largest |W - W'| over the largest |W|. Some force has no potential if it exceeds rounding.
  double asymmetry() const;
  /// Return the largest |W_ij|, N/m, of all rows, and of those of one point.
  double largest() const;
  double largest_of(std::size_t point) const;

 private:
  /// `r` are the positions that decide about pair forces; null leaves these out.
  void make_pattern(const double* r);
  bool knows_all_pairs(const double* r);
  void add_pairs(const double* r);
  int slot(int i, int j) const { return find_slot(start_, columns_, i, j); }  ///< of block (i, j)
  void add_coupling(std::size_t k, const Block3& derivative, std::vector<Block3>* to) const;

  Workspace& work_;
  const Model& model_;
  std::size_t pattern_version_ = 0, num_pairs_ = 0;  // pairs that interact, by forces of pairs
  std::vector<int> start_{0}, columns_;
  std::vector<Block3> blocks_;
  std::vector<int> diagonal_;  // [moving point] its own block

  /// Couplings are those of springs, then of rods; influences are those of tuples with an energy, then of curved
  /// constraints.
  struct CoupledBlocks {
    Coupling points;
    int ij, ji;  // -1 if one of the points does not move
  };
  std::vector<CoupledBlocks> couplings_;
  std::vector<int> influence_slots_;
  std::size_t num_springs_, num_energies_;
  std::vector<Block3> point_positions_, point_velocities_, coupling_positions_, coupling_velocities_, influences_;
  std::vector<double> at_rest_;  // [3 points] velocities: 0
};

}  // namespace tanor::detail
