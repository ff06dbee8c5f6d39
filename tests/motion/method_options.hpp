#pragma once

#include <tanor/motion.hpp>

namespace tanor {

/// Fixed steps, or the tolerance 1e-12 of the method that chooses its own.
inline MotionOptions with(Method method, double step) {
  MotionOptions options;
  options.method = method;
  if (method == Method::Dopri5) {
    options.rtol = options.atol = 1e-12;
  } else {
    options.step = step;
  }
  return options;
}

}  // namespace tanor
