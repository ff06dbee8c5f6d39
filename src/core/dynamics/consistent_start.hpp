#pragma once

#include "dynamics/linearization.hpp"
#include "dynamics/projector.hpp"
#include "dynamics/unilateral.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Finds the nearest consistent start in the M-norm.
class ConsistentStart {
 public:
  /// `unilateral` is null if all constraints act to both sides.
  ConsistentStart(Workspace& work, Linearization& linearization, Projector& projector, Unilateral* unilateral)
      : work_(work),
        model_(work.model()),
        linearization_(linearization),
        projector_(projector),
        unilateral_(unilateral) {}

  /// Moves r and v [3n] onto the constraints at t and prescribes the motion of the supports. `StartMode::Check` throws
  /// InputError where that would move them by more than the rounding of the input.
  StartReport find(double t, double* r, double* v, StartMode mode);

 private:
  void check(const double* r, const double* v) const;

  Workspace& work_;
  const Model& model_;
  Linearization& linearization_;
  Projector& projector_;
  Unilateral* unilateral_;
};

}  // namespace tanor::detail
