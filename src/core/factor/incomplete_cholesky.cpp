#include "factor/incomplete_cholesky.hpp"

#include <algorithm>
#include <utility>

namespace tanor::detail {

IncompleteCholesky::IncompleteCholesky(TrianglePattern upper) : pattern_(std::move(upper)) {
  const auto& [start, rows] = pattern_;
  const std::size_t n = pattern_.size(), num_slots = rows.size();
  for (std::vector<double>* array : {&values_, &upper_, &scaled_}) array->resize(num_slots);
  inverse_pivots_.resize(n);
  terms_start_.assign(1, 0);
  terms_start_.reserve(num_slots + 1);
  for (std::size_t j = 0; j < n; ++j) {
    for (int slot = start[j]; slot < start[j + 1]; ++slot) {
      // u_ij needs the rows k < i that both columns have.
      const auto i = static_cast<std::size_t>(rows[static_cast<std::size_t>(slot)]);
      for (int left = start[i], right = start[j]; i != j && left < start[i + 1] - 1 && right < slot;) {
        const int row_left = rows[static_cast<std::size_t>(left)], row_right = rows[static_cast<std::size_t>(right)];
        if (row_left == row_right) terms_.push_back({left, right});
        if (row_left <= row_right) ++left;
        if (row_right <= row_left) ++right;
      }
      terms_start_.push_back(static_cast<int>(terms_.size()));
    }
  }
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
      for (int k = terms_start_[static_cast<std::size_t>(slot)]; k < terms_start_[static_cast<std::size_t>(slot) + 1];
           ++k) {
        const auto [left, right] = terms_[static_cast<std::size_t>(k)];
        sum -= upper_[static_cast<std::size_t>(left)] * scaled_[static_cast<std::size_t>(right)];
      }
      scaled_[static_cast<std::size_t>(slot)] = sum;
      const double u = sum * inverse_pivots_[static_cast<std::size_t>(rows[slot])];
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
