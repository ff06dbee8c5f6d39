#pragma once

#include <tanor/motion.hpp>

namespace tanor {

/// Returns options with fixed steps, or with the tolerance 1e-12 if the method chooses its steps.
inline MotionOptions with(Method method, double step) {
  MotionOptions options;
  options.method = method;
  if (has_fixed_steps(method)) {
    options.step = step;
  } else {
    options.rtol = options.atol = 1e-12;
  }
  return options;
}

}  // namespace tanor
