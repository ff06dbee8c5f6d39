#pragma once

#include <algorithm>
#include <limits>

namespace tanor::detail {

/// The part of its largest term that rounding leaves of a residual: 18 eps, for rows of a dozen terms.
inline constexpr double rounding_of_terms = 4e-15;

/// Returns the residual over its scale below which a solution is not refined (Request::exact).
constexpr double good_enough(bool is_exact) {
  return is_exact ? rounding_of_terms : 1e-12;
}

/// A refinement ends after `most_passes` corrections, or `patience` residuals in a row of half the least or more.
struct RefinementLimits {
  int most_passes;
  int patience = 1;
};

/// Refines a solution iteratively. measure() evaluates the residual and returns its size; correct(pass) solves for it
/// with the current factor and adds the solution. Ends if is_enough(residual) holds. Returns the number of corrections.
template <class Measure, class IsEnough, class Correct>
int refine_solution(const RefinementLimits& limits, const Measure& measure, const IsEnough& is_enough,
                    const Correct& correct) {
  double least = std::numeric_limits<double>::infinity();
  int num_without_gain = 0;
  for (int pass = 0;; ++pass) {
    const double residual = measure();
    num_without_gain = pass == 0 || residual < 0.5 * least ? 0 : num_without_gain + 1;
    least = std::min(least, residual);
    if (is_enough(residual) || pass == limits.most_passes || num_without_gain == limits.patience) return pass;
    correct(pass);
  }
}

/// Does the same with a fixed number of corrections, from the current residual on.
template <class Measure, class Correct>
void refine_solution(int passes, const Measure& measure, const Correct& correct) {
  for (int pass = 0; pass < passes; ++pass) {
    if (pass > 0) measure();
    correct(pass);
  }
}

}  // namespace tanor::detail
