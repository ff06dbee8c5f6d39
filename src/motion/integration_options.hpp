#pragma once

#include <tanor/motion.hpp>

#include "dynamics/instant.hpp"

namespace tanor {

/// What the user asks of a motion, and how its accelerations are asked for.
struct IntegrationOptions : MotionOptions {
  // NOLINTNEXTLINE(google-explicit-constructor): the user's options are complete as they are.
  IntegrationOptions(const MotionOptions& options = {}, bool is_exact = false)
      : MotionOptions(options), exact(is_exact) {}

  bool exact;  ///< see Request

  /// Whether the friction that is found is the only one is asked where a step ends, and K stands.
  Request request(Gradients gradients) const {
    return {.gradients = gradients,
            .exact = exact,
            .verification = gradients == Gradients::Keep ? Verification::AtStepEnds : Verification::None};
  }
};

}  // namespace tanor
