#include "factor/independent_columns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tanor {

namespace {

double norm(const std::vector<double>& x) {
  return std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.0));
}

void normalize(std::vector<double>* x) {
  const double length = norm(*x);
  for (double& value : *x) value /= length;
}

struct SingularPair {
  double value;
  std::vector<double> vector;  ///< [rho] right singular vector, unit length
};

SingularPair find_smallest_singular_pair(const TriangularFactor& R) {
  constexpr int most_iterations = 30;
  SingularPair smallest{std::numeric_limits<double>::infinity(), std::vector<double>(R.rank())};
  std::vector<double>& v = smallest.vector;
  if (v.empty()) return smallest;
  // The start vector is fixed, and no structure of a scene is orthogonal to it.
  for (std::size_t k = 0; k < v.size(); ++k) v[k] = 1.0 + std::sin(12.9898 * static_cast<double>(k + 1));
  normalize(&v);
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    // v := R^-T v, and |R^-T v| <= 1/sigma.
    R.solve_transposed(v.data());
    const double value = 1.0 / norm(v);
    R.solve(v.data());
    normalize(&v);
    const bool settled = value > 0.9 * smallest.value;
    smallest.value = std::min(smallest.value, value);
    if (settled) break;
  }
  return smallest;
}

std::size_t find_largest(const std::vector<double>& x) {
  const auto is_smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
  return static_cast<std::size_t>(std::max_element(x.begin(), x.end(), is_smaller) - x.begin());
}

}  // namespace

double find_smallest_singular_value(const TriangularFactor& R) {
  return find_smallest_singular_pair(R).value;
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
    const SingularPair smallest = find_smallest_singular_pair(found.factor);
    found.smallest_singular_value = smallest.value;
    // A number that is not finite ends the loop, too.
    if (!(smallest.value < tolerance)) break;
    left_out.push_back(found.factor.independent[find_largest(smallest.vector)]);
    std::ranges::sort(left_out);
    found.factor = factorize_columns(C, all_but(left_out, C.num_columns()), tolerance, factorize);
  }
  std::vector<int>& dependent = found.factor.dependent;
  dependent.insert(dependent.end(), left_out.begin(), left_out.end());
  std::ranges::sort(dependent);
  return found;
}

}  // namespace tanor
