#pragma once

#include <utility>
#include <vector>

#include <tanor/dynamics.hpp>

#include "base/memory.hpp"
#include "base/point_source.hpp"
#include "dynamics/power.hpp"

namespace tanor::detail {

/// The state of a system at one instant. Positions and velocities are in the variables of the object that is called.
struct Kinematics {
  double t;             ///< s
  const double *x, *v;  ///< m and m/s, or coordinates and their rates
};

/// Tells if K is evaluated (and S factorized) at the present configuration, or kept from the last one.
enum class Gradients { Evaluate, Keep };

/// Tells when the uniqueness of friction is verified: never, at the ends of steps, where K is kept, or wherever
/// accelerations are computed.
enum class Verification { None, AtStepEnds, Always };

/// Accelerations M^-1 f of moving points by a host's forces f, and positions and velocities that are not there yet.
/// Each is brought into its own array when it is needed.
class GivenMotion : public PointSource {
 public:
  /// Returns the largest |M^-1 f| that was brought, m/s^2, or NaN if any is not finite.
  virtual double largest() const = 0;
};

/// The options of one computation of accelerations.
struct Request {
  Gradients gradients = Gradients::Evaluate;
  /// Refines to the rounding of the residual if true, otherwise to 1e-12 of its scale.
  bool exact = false;
  Verification verification = Verification::None;
  /// If true, several accelerations that obey the laws of friction are a failure. Otherwise the nearest one is taken
  /// and reported.
  bool refuses_several = false;
  /// The error that accelerations may have, as measured by `InexactSolves`; 0 allows rounding alone. K is then
  /// evaluated at this configuration, but S need not be factorized.
  double allowed_error = 0.0;
  /// The source of forces in place of the model's, and of the part of the state not there yet; null for the model's
  /// forces.
  const GivenMotion* given = nullptr;

  /// Returns the same request with K evaluated anew, which never happens at the end of a step.
  Request evaluated_anew() const {
    Request anew = *this;
    anew.gradients = Gradients::Evaluate;
    if (verification == Verification::AtStepEnds) anew.verification = Verification::None;
    return anew;
  }
};

/// The reactions of constraints and friction that belong to accelerations as these belong to a state. A caller hands
/// them back to the mechanics for quantities that follow from them.
struct Reactions {
  std::vector<double> lambda;    ///< [rows] multipliers, of equations that have them
  std::vector<double> friction;  ///< [3 contacts] N, of contacts that slide and of those that stick
  int refinements = 0;           ///< of the multipliers; solves with the same factor need as many
  std::vector<double> w, w0;     ///< [3n] with reactions and without, of equations in coordinates; w0 where it is known
  bool knows_w0 = false;         ///< w0 has been evaluated

  void exchange_memory(Memory& memory) { memory.exchange(lambda, friction, refinements, w, w0, knows_w0); }

  friend void swap(Reactions& one, Reactions& other) noexcept {
    using std::swap;
    for (auto array : {&Reactions::lambda, &Reactions::friction, &Reactions::w, &Reactions::w0})
      (one.*array).swap(other.*array);
    swap(one.refinements, other.refinements);
    swap(one.knows_w0, other.knows_w0);
  }
};

/// The outputs of one computation of accelerations; null pointers are not written.
struct AccelerationOutput {
  // NOLINTNEXTLINE(google-explicit-constructor): an array alone is a whole answer.
  AccelerationOutput(double* accelerations, Power* with_power = nullptr, SolveReport* with_report = nullptr,
                     Reactions* with_reactions = nullptr)
      : a(accelerations), power(with_power), report(with_report), reactions(with_reactions) {}

  double* a;
  Power* power;          ///< entering the system at this state
  SolveReport* report;   ///< complete but for the outcome, which is returned; also written on failure
  Reactions* reactions;  ///< those that belong to `a`
};

}  // namespace tanor::detail
