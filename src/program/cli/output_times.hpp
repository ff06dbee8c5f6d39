#pragma once

#include <cmath>
#include <limits>

namespace tanor::cli {

/// Returns the end of a run. If it is an output time up to its rounding, that time is returned to the last bit. So a
/// run that stops at 0.3 s has taken the steps of a longer one, whose third frame stands at 3 * 0.1 =
/// 0.30000000000000004, and can go on.
inline double end_at_output(double t_end, double output_every) {
  if (output_every <= 0.0) return t_end;
  const double nearest = std::round(t_end / output_every) * output_every;
  constexpr double rounding = 4.0 * std::numeric_limits<double>::epsilon();  // for both numbers and their product
  return std::abs(nearest - t_end) <= rounding * std::abs(t_end) ? nearest : t_end;
}

/// Returns the first of the output times k * output_every (k = 1, 2, …) and t_end that lies after `time`.
///
/// They are products, not a running sum, so that frame k of every run, also of a resumed one, has the same time to the
/// last bit. Times within a millionth of an interval count as the same, so that no sliver of a step is left before
/// t_end.
inline double next_output_time(double time, double output_every, double t_end) {
  if (output_every <= 0.0) return t_end;
  const double k = std::floor(time / output_every + 1e-6) + 1.0;
  const double next = k * output_every;
  return next < t_end - 1e-6 * output_every ? next : t_end;
}

}  // namespace tanor::cli
