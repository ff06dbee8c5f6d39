#pragma once

namespace tanor {

/// Where a system is at one instant. Positions and velocities stand in the variables of whoever is asked.
struct Kinematics {
  double t;             ///< s
  const double *x, *v;  ///< m and m/s, or coordinates and their rates
};

/// Whether a computation evaluates K (and factorizes S) at its own configuration or keeps those of the last one.
enum class Gradients { Evaluate, Keep };

/// How much is asked about other solutions of friction than the one that was found: nothing; of few contacts, as in
/// every step; of more of them.
enum class Judgement { None, Quick, Thorough };

/// How accelerations are asked for. Each call says it anew.
struct Request {
  Gradients gradients = Gradients::Evaluate;
  /// Refine to the rounding of the residual; else to 1e-12 of its scale.
  bool exact = false;
  Judgement judgement = Judgement::None;
  /// Several accelerations that obey the laws of friction are a failure; else the nearest one is taken and reported.
  bool refuses_several = false;
  /// Error that accelerations may have, as `InexactSolves` measures it; K then stands there, its factor need not. 0:
  /// rounding alone.
  double allowed_error = 0.0;
  /// [3n] N, what acts in place of the model's forces, at the inner points; null: those of the model.
  const double* forces = nullptr;
};

}  // namespace tanor
