#pragma once

#include <algorithm>

#include <tanor/motion.hpp>

#include "dynamics/instant.hpp"

namespace tanor::detail {

/// The user's options of a motion, and how its accelerations are requested.
struct IntegrationOptions : MotionOptions {
  // NOLINTNEXTLINE(google-explicit-constructor): the user's options are complete as they are.
  IntegrationOptions(const MotionOptions& options = {}, bool is_exact = false, const ContactOptions& contact = {})
      : MotionOptions(options), exact(is_exact), max_contact_events(contact.max_events) {
    rtol = std::max(rtol, nearly_rounding);  // no step meets less, see Scales for atol
  }
  static constexpr double nearly_rounding = 1e-15;

  bool exact;  ///< see Request
  int max_contact_events;

  /// Requests accelerations. Whether friction is unique is verified only at the ends of steps, where K is kept.
  Request request(Gradients gradients) const {
    return {.gradients = gradients,
            .exact = exact,
            .verification = gradients == Gradients::Keep ? Verification::AtStepEnds : Verification::None};
  }
};

}  // namespace tanor::detail
