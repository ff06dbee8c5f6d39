#pragma once

#include <vector>

#include <tanor/dynamics.hpp>

#include "base/memory.hpp"
#include "base/point_source.hpp"
#include "dynamics/power.hpp"

namespace tanor {

/// Where a system is at one instant. Positions and velocities stand in the variables of whoever is asked.
struct Kinematics {
  double t;             ///< s
  const double *x, *v;  ///< m and m/s, or coordinates and their rates
};

/// Whether a computation evaluates K (and factorizes S) at its own configuration or keeps those of the last one.
enum class Gradients { Evaluate, Keep };

/// When it is verified that friction has no other solution than the one that was found: never; where a step ends, whose
/// K is kept; wherever accelerations are asked for.
enum class Verification { None, AtStepEnds, Always };

/// Brings M^-1 f of points that move into the array of the accelerations that are asked for, f being somebody else's
/// forces; and of positions and velocities, into theirs, what is not there yet.
class GivenMotion : public PointSource {
 public:
  /// The largest |M^-1 f| that was brought, m/s^2; NaN where any is not finite.
  virtual double largest() const = 0;
};

/// How accelerations are asked for. Each call says it anew.
struct Request {
  Gradients gradients = Gradients::Evaluate;
  /// Refine to the rounding of the residual; else to 1e-12 of its scale.
  bool exact = false;
  Verification verification = Verification::None;
  /// Several accelerations that obey the laws of friction are a failure; else the nearest one is taken and reported.
  bool refuses_several = false;
  /// Error that accelerations may have, as `InexactSolves` measures it; K then stands there, its factor need not. 0:
  /// rounding alone.
  double allowed_error = 0.0;
  /// What acts in place of the model's forces, with the state where it is still on its way; null: those of the model.
  const GivenMotion* given = nullptr;

  /// The same where K is evaluated anew, which no end of a step is.
  Request evaluated_anew() const {
    Request anew = *this;
    anew.gradients = Gradients::Evaluate;
    if (verification == Verification::AtStepEnds) anew.verification = Verification::None;
    return anew;
  }
};

/// What constraints and friction do where accelerations were found. It belongs to these as they belong to their state:
/// whoever asks the mechanics for something that follows from it hands it back.
struct Reactions {
  std::vector<double> lambda;    ///< [rows] multipliers, of equations that have them
  std::vector<double> friction;  ///< [3 contacts] N, of contacts that slide and of those that stick
  int refinements = 0;           ///< that the multipliers took: what the same factor solves takes as many
  std::vector<double> w, w0;     ///< [3n] with reactions and without, of equations in coordinates; w0 where it is known
  bool knows_w0 = false;         ///< else it is evaluated where somebody asks

  void exchange_memory(Memory& memory) { memory.exchange(lambda, friction, refinements, w, w0, knows_w0); }
};

/// Where accelerations are written, and what is found with them; null: nobody asks.
struct AccelerationOutput {
  // NOLINTNEXTLINE(google-explicit-constructor): an array alone is a whole answer.
  AccelerationOutput(double* accelerations, Power* with_power = nullptr, SolveReport* with_report = nullptr,
                     Reactions* with_reactions = nullptr)
      : a(accelerations), power(with_power), report(with_report), reactions(with_reactions) {}

  double* a;
  Power* power;          ///< that enters the system at this state
  SolveReport* report;   ///< all of it but the outcome, which is returned; also where that is a failure
  Reactions* reactions;  ///< those that belong to `a`
};

}  // namespace tanor
