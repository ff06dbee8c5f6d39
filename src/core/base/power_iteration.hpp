#pragma once

#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "base/numbers.hpp"

namespace tanor::detail {

/// Returns |A| of a symmetric matrix A by power iterations; apply() overwrites x by A x. The answer is 0 if x is empty.
template <class Apply>
double estimate_norm(std::vector<double>* x, int iterations, const Apply& apply) {
  const auto norm = [&] { return std::sqrt(std::inner_product(x->begin(), x->end(), x->begin(), 0.0)); };
  double result = 0.0;
  for (std::size_t k = 0; k < x->size(); ++k) (*x)[k] = irregular(k);
  double before = norm();
  for (int i = 0; i < iterations && !x->empty(); ++i) {
    apply();
    const double after = norm();
    if (after == 0.0) return 0.0;
    result = after / before;
    for (double& each : *x) each /= after;
    before = 1.0;
  }
  return result;
}

}  // namespace tanor::detail
