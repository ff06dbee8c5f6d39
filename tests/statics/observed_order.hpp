#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tanor {

/// Returns log(e_{k+1}/e_k)/log(e_k/e_{k-1}) of the last three steps above rounding, e_{n-3} … e_n: two numbers, the
/// last one first, or none where there are fewer steps. A residual below rounding stands for the last one where it
/// gives
/// a higher order: without rounding it would be smaller, so that the order is no less.
inline std::vector<double> observed_orders(const std::vector<double>& residuals, double rounding) {
  std::size_t above = residuals.size();
  while (above > 0 && residuals[above - 1] < rounding) --above;
  const auto order = [&](std::size_t n) {  // with the n-th residual as the last one
    if (n < 3 || n > residuals.size() || residuals[n - 1] <= 0.0) return 0.0;
    return std::log(residuals[n - 1] / residuals[n - 2]) / std::log(residuals[n - 2] / residuals[n - 3]);
  };
  const auto least = [&](std::size_t n) { return std::min(order(n), order(n - 1)); };
  const std::size_t last = above + 1 <= residuals.size() && least(above + 1) >= least(above) ? above + 1 : above;
  if (last < 4) return {};
  return {order(last), order(last - 1)};
}

}  // namespace tanor
