#pragma once

#include "dynamics/linearization.hpp"
#include "dynamics/projector.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Finds the nearest consistent start in the M-norm.
class ConsistentStart {
 public:
  ConsistentStart(Workspace& work, Linearization& linearization, Projector& projector)
      : work_(work), model_(work.model()), linearization_(linearization), projector_(projector) {}

  /// Moves r and v [3n] onto the constraints at t and prescribes the motion of the supports. `StartMode::Check` throws
  /// InputError where that would move them by more than the rounding of the input.
  StartReport find(double t, double* r, double* v, StartMode mode);

 private:
  void check(const double* r, const double* v) const;

  Workspace& work_;
  const Model& model_;
  Linearization& linearization_;
  Projector& projector_;
};

}  // namespace tanor::detail
