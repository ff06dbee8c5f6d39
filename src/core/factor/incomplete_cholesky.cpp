#include "factor/incomplete_cholesky.hpp"

#include <algorithm>
#include <utility>

namespace tanor::detail {

IncompleteCholesky::IncompleteCholesky(TrianglePattern upper) : pattern_(std::move(upper)) {
  for (std::vector<double>* array : {&values_, &upper_, &scaled_}) array->resize(pattern_.rows.size());
  inverse_pivots_.resize(pattern_.size());
}

bool IncompleteCholesky::factorize() {
  if (try_factorize(0.0)) return true;
  for (const double raise : {1e-3, 1e-2, 1e-1, 1.0}) {
    if (try_factorize(raise)) return true;
  }
  return false;
}

/// Computes d_i u_ij = s_ij - sum_k u_ki d_k u_kj and d_j = s_jj (1 + raise) - sum_k d_k u_kj^2.
bool IncompleteCholesky::try_factorize(double raise) {
  constexpr double lowest_pivot = 1e-8;  // relative to the diagonal; less is a sign of indefiniteness
  const int* const start = pattern_.start.data();
  const int* const rows = pattern_.rows.data();
  for (std::size_t j = 0; j < pattern_.size(); ++j) {
    const int diagonal = start[j + 1] - 1;
    double pivot = values_[static_cast<std::size_t>(diagonal)] * (1.0 + raise);
    const double lowest = lowest_pivot * pivot;
    for (int slot = start[j]; slot < diagonal; ++slot) {
      double sum = values_[static_cast<std::size_t>(slot)];
      // The rows k < i that both columns have.
      const int i = rows[slot], end = start[i + 1] - 1;
      for (int left = start[i], right = start[j]; left < end && right < slot;) {
        const int row_left = rows[left], row_right = rows[right];
        if (row_left == row_right)
          sum -= upper_[static_cast<std::size_t>(left)] * scaled_[static_cast<std::size_t>(right)];
        left += row_left <= row_right ? 1 : 0;
        right += row_right <= row_left ? 1 : 0;
      }
      scaled_[static_cast<std::size_t>(slot)] = sum;
      const double u = sum * inverse_pivots_[static_cast<std::size_t>(i)];
      upper_[static_cast<std::size_t>(slot)] = u;
      pivot -= sum * u;
    }
    if (!(pivot > lowest)) return false;
    inverse_pivots_[j] = 1.0 / pivot;
  }
  return true;
}

void IncompleteCholesky::solve_negative(const double* scale, const double* b, double* x) const {
  const int* const start = pattern_.start.data();
  const int* const rows = pattern_.rows.data();
  const double* const u = upper_.data();
  const std::size_t n = pattern_.size();
  // U'y = -D b
  for (std::size_t j = 0; j < n; ++j) {
    double sum = -scale[j] * b[j];
    for (int k = start[j]; k < start[j + 1] - 1; ++k) sum -= u[k] * x[rows[k]];
    x[j] = sum;
  }
  // U (D^-1 x) = D^-1 y
  for (std::size_t j = 0; j < n; ++j) x[j] *= inverse_pivots_[j];
  for (std::size_t j = n; j-- > 0;) {
    const double xj = x[j];
    for (int k = start[j]; k < start[j + 1] - 1; ++k) x[rows[k]] -= u[k] * xj;
    x[j] = scale[j] * xj;
  }
}

}  // namespace tanor::detail
