#include "factor/independent_columns.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tanor::detail {

namespace {

/// Estimates from above of some of the smallest singular values, increasing, and orthonormal vectors that have them.
struct SmallestSingularValues {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;  ///< [rho x number]
};

/// Iterates `number` vectors with (R'R)^-1 (subspace iteration).
SmallestSingularValues find_smallest_singular_values(const TriangularFactor& R, Eigen::Index number,
                                                     int most_iterations) {
  const auto rank = static_cast<Eigen::Index>(R.rank());
  number = std::min(number, rank);
  SmallestSingularValues smallest{Eigen::VectorXd::Constant(number, std::numeric_limits<double>::infinity()),
                                  Eigen::MatrixXd(rank, number)};
  if (rank == 0) return smallest;
  // The start vectors are fixed, and no structure of a scene is orthogonal to them.
  for (Eigen::Index k = 0; k < rank; ++k) {
    for (Eigen::Index l = 0; l < number; ++l)
      smallest.vectors(k, l) = 1.0 + std::sin(12.9898 * static_cast<double>((k + 1) * (l + 1)));
  }
  Eigen::MatrixXd& V = smallest.vectors;
  const auto orthonormalize = [&] {
    V = Eigen::HouseholderQR<Eigen::MatrixXd>(V).householderQ() * Eigen::MatrixXd::Identity(rank, number);
  };
  orthonormalize();
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    // V := R^-T V, whose singular values are at most 1/sigma.
    for (Eigen::Index l = 0; l < number; ++l) R.solve_transposed(V.col(l).data());
    const Eigen::MatrixXd triangle =
        Eigen::HouseholderQR<Eigen::MatrixXd>(V).matrixQR().topRows(number).triangularView<Eigen::Upper>();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(triangle, Eigen::ComputeFullV);
    const Eigen::VectorXd values = svd.singularValues().cwiseInverse();
    V = V * svd.matrixV();
    for (Eigen::Index l = 0; l < number; ++l) R.solve(V.col(l).data());
    orthonormalize();
    const bool settled = (values.array() > 0.9 * smallest.values.array()).all();
    smallest.values = smallest.values.cwiseMin(values);
    if (settled) break;
  }
  return smallest;
}

/// Leaves out a column for each of the smallest singular values that is below the tolerance: the columns that pivots of
/// QR choose in the rows of their vectors.
void leave_out_columns(const TriangularFactor& R, double tolerance, std::vector<int>* left_out) {
  constexpr Eigen::Index most_at_once = 16;
  const auto [values, vectors] = find_smallest_singular_values(R, most_at_once, 3);
  const Eigen::Index number = std::max<Eigen::Index>(1, (values.array() < tolerance).count());
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> pivots(vectors.leftCols(number).transpose());
  for (Eigen::Index k = 0; k < number; ++k)
    left_out->push_back(R.independent[static_cast<std::size_t>(pivots.colsPermutation().indices()(k))]);
  std::ranges::sort(*left_out);
}

}  // namespace

double find_smallest_singular_value(const TriangularFactor& R) {
  if (R.rank() == 0) return std::numeric_limits<double>::infinity();
  return find_smallest_singular_values(R, 1, 30).values(0);
}

std::vector<int> all_but(const std::vector<int>& left_out, std::size_t num_columns) {
  std::vector<int> result;
  for (int j = 0; j < static_cast<int>(num_columns); ++j)
    if (!std::binary_search(left_out.begin(), left_out.end(), j)) result.push_back(j);
  return result;
}

TriangularFactor factorize_columns(const SparseColumns& C, const std::vector<int>& wanted, double tolerance,
                                   QrFunction& factorize) {
  TriangularFactor factor = factorize(columns_of(C, wanted), tolerance);
  for (int& j : factor.independent) j = wanted[static_cast<std::size_t>(j)];
  for (int& j : factor.dependent) j = wanted[static_cast<std::size_t>(j)];
  return factor;
}

IndependentColumns find_independent_columns(const SparseColumns& C, double tolerance, QrFunction& factorize) {
  IndependentColumns found{factorize(C, tolerance), 0.0};
  std::vector<int> left_out;
  while (true) {
    found.smallest_singular_value = find_smallest_singular_value(found.factor);
    // A number that is not finite ends the loop, too.
    if (!(found.smallest_singular_value < tolerance)) break;
    leave_out_columns(found.factor, tolerance, &left_out);
    found.factor = factorize_columns(C, all_but(left_out, C.num_columns()), tolerance, factorize);
  }
  std::vector<int>& dependent = found.factor.dependent;
  dependent.insert(dependent.end(), left_out.begin(), left_out.end());
  std::ranges::sort(dependent);
  return found;
}

}  // namespace tanor::detail
