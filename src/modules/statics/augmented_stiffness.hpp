#pragma once

#include <utility>
#include <vector>

#include "base/groups.hpp"
#include "factor/cholesky.hpp"
#include "statics/equilibrium_equations.hpp"

namespace tanor::detail {

/// The stiffness matrix of an equilibrium with a mass shift and with penalties on its constraints,
///
///   A = W + s M + K C K'      (C > 0 diagonal; Gould 1985: A is positive definite for large C where Z'(W + s M)Z is)
///
/// in a fill-reducing elimination order. The pattern is found once; only values change between configurations.
class AugmentedStiffness {
 public:
  /// Reads `equations` where they were linearised last; `equations` must outlive the matrix.
  AugmentedStiffness(const EquilibriumEquations& equations, Ordering ordering);

  /// The pattern version of W for which this matrix was made.
  std::size_t pattern_version() const { return pattern_version_; }
  std::size_t num_points() const { return place_.size(); }
  /// Returns the position of a moving point in the elimination order; its three unknowns are consecutive there.
  std::size_t place(std::size_t point) const { return static_cast<std::size_t>(place_[point]); }

  /// Assembles A for the shifts s [moving point], 1/s^2. Writes the penalties C that it found into `penalties` [rows of
  /// the model], N/m over squared gradients: `stiffer` times a stiffness of the points that a row joins.
  void assemble(const std::vector<double>& shifts, double stiffer, std::vector<double>* penalties);

  /// The lower triangle of the last A.
  const TrianglePattern& lower() const { return lower_; }
  const std::vector<double>& lower_values() const { return values_; }

 private:
  /// A product of two blocks of K, and the block of A to which it is added.
  struct Product {
    int row, block_a, block_b;
    double sign;
    int slot;
  };
  Groups<Incidence> group_by_row() const;
  void order_points(Ordering ordering, std::vector<std::pair<int, int>> entries);
  void list_products(const Groups<Incidence>& by_row);
  template <class Visit>
  void for_each_number(const Visit& visit) const;
  int slot(int i, int j) const;
  void find_penalties(const std::vector<double>& shifts, double stiffer, std::vector<double>* penalties) const;
  std::vector<double> stiffness_of_points(const std::vector<double>& shifts) const;

  const EquilibriumEquations& equations_;
  const Model& model_;
  std::size_t pattern_version_;
  // The upper triangle of A by blocks, with the rows of points in elimination order. Entries start_[i] … start_[i + 1]
  // - 1 have increasing columns and begin with the diagonal block. Unknowns have the order of their points.
  std::vector<int> place_;  // [moving point] -> place in the elimination
  std::vector<int> start_, columns_;
  std::vector<Block3> blocks_;
  std::vector<int> stiffness_slots_;  // [block of W]; -1 if the block is in the other triangle
  std::vector<Product> products_;
  TrianglePattern lower_;
  std::vector<double> values_;
};

}  // namespace tanor::detail
