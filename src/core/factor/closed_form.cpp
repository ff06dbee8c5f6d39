#include "factor/closed_form.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tanor::detail {

bool ClosedForm::serves(const TrianglePattern& upper) {
  return upper.rows.size() == upper.size() || upper.size() <= most_rows;
}

ClosedForm::ClosedForm(TrianglePattern upper)
    : pattern_(std::move(upper)), values_(pattern_.rows.size()), inverse_(is_diagonal() ? pattern_.size() : 0) {}

Cholesky::Quality ClosedForm::factorize() {
  double smallest = std::numeric_limits<double>::infinity(), largest = 0.0;
  std::size_t weakest = 0;
  // A pivot that is zero, negative or NaN ends the factorization.
  const auto see = [&](double pivot, std::size_t row) {
    if (!(pivot > 0.0)) return false;
    if (pivot < smallest) weakest = row;
    smallest = std::min(smallest, pivot);
    largest = std::max(largest, pivot);
    return true;
  };
  if (is_diagonal()) {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      if (!see(values_[i], i)) return {false, i, 0.0};
      inverse_[i] = 1.0 / values_[i];
    }
  } else {
    std::array<std::array<double, most_rows>, most_rows> S{};
    for (std::size_t j = 0; j < pattern_.size(); ++j) {
      for (int k = pattern_.start[j]; k < pattern_.start[j + 1]; ++k) {
        S[j][static_cast<std::size_t>(pattern_.rows[static_cast<std::size_t>(k)])] =
            values_[static_cast<std::size_t>(k)];
      }
    }
    // L_ij = (S_ij - sum over k < j of L_ik L_jk)/L_jj
    for (std::size_t i = 0; i < pattern_.size(); ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = S[i][j];
        for (std::size_t k = 0; k < j; ++k) sum -= L_[i][k] * L_[j][k];
        if (j < i) {
          L_[i][j] = sum / L_[j][j];
        } else if (!see(sum, i)) {
          return {false, i, 0.0};
        } else {
          L_[i][i] = std::sqrt(sum);
        }
      }
    }
  }
  return {true, weakest, smallest / largest};
}

void ClosedForm::solve(double* x) const {
  if (is_diagonal()) {
    for (std::size_t i = 0; i < inverse_.size(); ++i) x[i] *= inverse_[i];
    return;
  }
  const std::size_t n = pattern_.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= L_[i][k] * x[k];
    x[i] /= L_[i][i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) x[i] -= L_[k][i] * x[k];
    x[i] /= L_[i][i];
  }
}

}  // namespace tanor::detail
