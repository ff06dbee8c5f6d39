#pragma once

#include <cmath>

namespace tanor::cli {

/// The first of the output times k * output_every (k = 1, 2, …) and t_end that lies after `time`.
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
