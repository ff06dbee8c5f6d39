#pragma once

#include "dynamics/mechanics.hpp"
#include "dynamics/model.hpp"

namespace tanor::detail {

/// The linearized equations that a chord iteration onto xi = 0 needs. They own the array `rows`, which takes the
/// residual.
class ChordEquations {
 public:
  /// Computes rows := xi at r and returns the largest |xi|/length.
  virtual double evaluate_values(const double* r) = 0;
  /// Returns the largest |xi|/|gradient|/length among the rows where it exceeds both `allowed` and `times` the rounding
  /// of their positions, or 0 if there is none. `rows` are those that `evaluate_values` has just found at r, and
  /// `violation` is the largest of them.
  virtual double beyond_rounding(const double* r, double violation, double allowed, double times) = 0;
  /// Evaluates K at (t, r) and factorizes S.
  virtual Outcome linearise_at(double t, const double* r) = 0;
  /// Solves S mu = -rows, then adds M^-1 K mu to r, and mu to `sum` unless it is null.
  virtual void correct_positions(double* r, double* sum) = 0;
  /// Decides the rank at r. Returns true if rows that depended on others at the last K are independent here.
  virtual bool decide_rank_again(const double* r) = 0;
  /// Says why the iteration stalls.
  virtual Outcome explain_stall(double t, double violation) const = 0;

 protected:
  ~ChordEquations() = default;
};

struct ChordLimits {
  double target;        ///< |xi|/length at which the iteration has arrived
  double largest_left;  ///< |xi|/length accepted where it stalls; so is twice the rounding of positions
  double far;           ///< violation above which K is evaluated before the first correction
};

/// Projects r onto xi = 0 by chord iterations along the present M^-1 K. Evaluates K anew where they stall and where
/// they begin far away. If `sum` is given, all multipliers are added to it and K is kept throughout, since they belong
/// to one K. `report` tells what was done before.
ProjectionReport project_along_chord(const Model& model, ChordEquations& equations, const ChordLimits& limits, double t,
                                     double* r, double* sum, ProjectionReport report);

}  // namespace tanor::detail
