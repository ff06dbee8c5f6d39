#include "factor/sparse_qr.hpp"

namespace tanor::detail {

TriangularFactor factorize_qr(const SparseColumns& C, double tolerance) {
#if TANOR_GPL
  return factorize_with_suitesparse(C, tolerance);
#else
  return factorize_by_fronts(C, tolerance);
#endif
}

void TriangularFactor::set_rows(const SparseColumns& rows_of_R) {
  static_cast<SparseColumns&>(*this) = columns_of(transpose(rows_of_R), independent);
}

void TriangularFactor::solve(double* x) const {
  for (std::size_t j = rank(); j-- > 0;) {
    if (x[j] == 0.0) continue;
    const auto first = static_cast<std::size_t>(start[j]), diagonal = static_cast<std::size_t>(start[j + 1]) - 1;
    x[j] /= values[diagonal];
    for (std::size_t k = first; k < diagonal; ++k) x[rows[k]] -= values[k] * x[j];
  }
}

void TriangularFactor::solve_transposed(double* x) const {
  for (std::size_t j = 0; j < rank(); ++j) {
    const auto first = static_cast<std::size_t>(start[j]), diagonal = static_cast<std::size_t>(start[j + 1]) - 1;
    double sum = x[j];
    for (std::size_t k = first; k < diagonal; ++k) sum -= values[k] * x[rows[k]];
    x[j] = sum / values[diagonal];
  }
}

}  // namespace tanor::detail
