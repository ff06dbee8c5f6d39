#pragma once

#include "dynamics/linearization.hpp"
#include "dynamics/model.hpp"
#include "dynamics/projector.hpp"

namespace tanor {

/// The nearest consistent start in the M-norm.
class ConsistentStart {
 public:
  ConsistentStart(Model& model, Linearization& linearization, Projector& projector)
      : model_(model), linearization_(linearization), projector_(projector) {}

  /// Moves r and v [3n] onto the constraints at t, with what is prescribed at supports. `StartMode::Check` throws
  /// InputError where that moves them by more than rounding of the input.
  StartReport find(double t, double* r, double* v, StartMode mode);

 private:
  void check(const double* r, const double* v) const;

  Model& model_;
  Linearization& linearization_;
  Projector& projector_;
};

}  // namespace tanor
