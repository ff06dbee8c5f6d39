#pragma once

#include "dynamics/mechanics.hpp"
#include "dynamics/model.hpp"

namespace tanor {

/// What an iteration onto xi = 0 asks of equations that are linearized somewhere. `rows`: those that they keep.
class ChordEquations {
 public:
  /// rows := xi at r; returns the largest |xi|/length.
  virtual double evaluate_values(const double* r) = 0;
  /// The largest |xi|/length of rows where it is more than `allowed` and than `times` the rounding of their positions;
  /// 0: there is none. `violation`: the largest of all rows.
  virtual double beyond_rounding(const double* r, double violation, double allowed, double times) = 0;
  /// K at (t, r), and S with its factor.
  virtual Outcome linearise_at(double t, const double* r) = 0;
  /// S mu = -rows, r += M^-1 K mu, sum += mu unless it is null.
  virtual void correct_positions(double* r, double* sum) = 0;
  /// Rows that depended when K was seen last may be independent here. True: some are.
  virtual bool decide_rank_again(const double* r) = 0;
  /// Says why the iteration stalls.
  virtual Outcome explain_stall(double t, double violation) const = 0;

 protected:
  ~ChordEquations() = default;
};

struct ChordLimits {
  double target;        ///< |xi|/length at which the iteration has arrived
  double largest_left;  ///< and where it may end if it goes no further; or at twice the rounding of positions
  double far;           ///< Newton's own slope is taken at once where more than this is violated
};

/// Chord iterations along the M^-1 K that stands, or of the K at r where they stall and where they begin far away. With
/// `sum`, to which all multipliers are added, the slope is never renewed, since they belong to one K. `report` says
/// what has been done before.
ProjectionReport project_along_chord(const Model& model, ChordEquations& equations, const ChordLimits& limits, double t,
                                     double* r, double* sum, ProjectionReport report);

}  // namespace tanor
