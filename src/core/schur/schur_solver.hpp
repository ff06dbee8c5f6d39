#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <tanor/solver_options.hpp>

#include "assembly/reactions.hpp"
#include "base/check.hpp"
#include "base/parallel.hpp"
#include "base/point_source.hpp"
#include "evaluate/constraints.hpp"
#include "schur/factor_summary.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Positions of points and their motion without constraints. All arrays are in the inner order, [3n].
struct FreeMotion {
  const double *r, *v;
  /// The free acceleration: M^-1 f of moving points, the prescribed acceleration of supports.
  const double* w0;
  /// If not null, w0 of every moving point; the array above then holds only that of supports.
  const Vec3* uniform = nullptr;
  /// If not null, the source of the islands' points in all these arrays. A solver brings its own points.
  const PointSource* source = nullptr;
};

/// Says which factor of S is used: a new one, or the last one, which was made at the same configuration.
enum class FactorUse { Renew, Keep };

/// The report of a solver on its solution.
struct Elimination {
  double reciprocal_condition = 1.0;  ///< of S scaled to a unit diagonal, from its pivots; 0 if not positive definite
  double largest_right_side = 0.0;    ///< max |b|/|gradient|, m/s^2; NaN if any number is
  double residual = 0.0;              ///< max |K'(w - w0) + b|/|gradient|, m/s^2, of the resulting w
  double own_residual = 0.0;          ///< largest one of any island over its own |b|; infinite if a solver cannot tell
  int refinements = 0;                ///< passes that w took for that

  /// Keeps the worst of both, for islands that were solved beside these.
  void include(const Elimination& other) {
    reciprocal_condition = std::min(reciprocal_condition, other.reciprocal_condition);
    largest_right_side = larger(largest_right_side, other.largest_right_side);
    residual = larger(residual, other.residual);
    own_residual = larger(own_residual, other.own_residual);
    refinements = std::max(refinements, other.refinements);
  }
};

constexpr double cannot_tell = std::numeric_limits<double>::infinity();

/// Returns the residual of one island over its largest |b|.
inline double own_residual(double residual, double right_side) {
  return residual == 0.0 ? 0.0 : residual / right_side;
}

/// The end of an iteration onto xi = 0 or K'v + xi_t = 0.
struct Projection {
  double violation = 0.0;  ///< relative, or m/s; NaN if any number is
  int iterations = 0;

  /// Keeps the worst of both.
  void include(const Projection& other) {
    violation = larger(violation, other.violation);
    iterations = std::max(iterations, other.iterations);
  }
};

/// Iterates along a chord. evaluate() returns the violation and move() goes along the current slope. Ends if the
/// violation is at most `target`, or no longer becomes much less.
template <class Evaluate, class Move>
Projection iterate_along_chord(double target, const Evaluate& evaluate, const Move& move) {
  constexpr int most_iterations = 20;
  double before = std::numeric_limits<double>::infinity();
  for (int k = 0;; ++k) {
    const double violation = evaluate();
    if (violation <= target || !(violation < 0.3 * before) || k == most_iterations) return {violation, k};
    before = violation;
    move();
  }
}

/// The constituents of S = K'M^-1K. They must outlive the solvers that are made of them.
struct SchurProblem {
  const Constraints& constraints;
  const ReactionGather& gather;           ///< for K lambda
  std::span<const Incidence> incidences;  ///< those of K
  const Numbering& numbering;
  std::span<const double> inverse_mass;  ///< [point], 1/kg; 0 for supports
  std::span<const double> positions;     ///< [3n] at the start, in the user's order
};

/// A factor of S = K'M^-1K, the Schur complement of the mass matrix (Delassus operator), and the operations with it at
/// one configuration. Rows [d] and points [3n] are in the inner order. K is in blocks with the places of
/// Constraints::list_incidences. The results have the same bits for any number of threads. No call allocates.
class SchurFactor {
 public:
  virtual ~SchurFactor() = default;

  /// Computes x := -S^-1 b [d]; x may be b.
  virtual void solve_negative(const Parallel& parallel, const double* b, double* x) = 0;
  /// Computes rows := -S^-1 rows [d] and points += M^-1 K rows [3n].
  virtual void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) = 0;
  /// Computes points += M^-1 K rows.
  virtual void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) = 0;
};

/// Solves S lambda = -b at one configuration for all islands of a system or for some of them, from the evaluation of K
/// on. A solver reads and writes only the rows and the moving points of its islands. RankRevealingFactor answers if S
/// is singular or looks so, if rows come and go, and if pivots are wanted in another order.
class SchurSolver : public SchurFactor {
 public:
  /// Computes blocks := K at r, the factor of S = K'M^-1K, lambda := -S^-1 b [d] with b = phi + K'w0, and w := w0 +
  /// M^-1 K lambda [3n], in one pass or two over the memory. `motion.w0` is w, in which supports have their prescribed
  /// acceleration and keep it. Without a factor lambda and w are undefined. `scratch` is [d]. A factor and blocks that
  /// are kept may be made anew where that is as cheap.
  virtual Elimination solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                            double* scratch, double* lambda, double* w) = 0;
  /// Returns true if `solve` with a factor that is kept serves without w, and without blocks and scratch.
  virtual bool finds_multipliers_alone() const { return false; }

  /// Computes blocks := K at r and the factor of its S. `source` is as in FreeMotion.
  virtual Elimination linearise(const Parallel& parallel, const double* r, const PointSource* source,
                                double* blocks) = 0;

  /// Adds the reactions of `sum` [d] to r as the first guess, then iterates along the chord, each island by itself,
  /// until |xi|/length <= target, or as far as that leads. `sum` becomes the sum of all multipliers. If it is null,
  /// there is no guess and no sum is wanted. `source` is as in FreeMotion.
  virtual Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                       const PointSource* source, double* sum) = 0;
  /// Does so for velocities v at r, until |K'v + xi_t| <= target, m/s. Adds all multipliers to `sum` unless it is null.
  virtual Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                        double* v, double* sum) = 0;

  /// Reads the offsets of rods [d] after they have changed, if it was made with some.
  virtual void read_offsets(std::span<const Vec3> offsets) = 0;

  struct Summary {
    std::vector<LinearSolver> solvers;  ///< as in PlanSummary::linear_solvers
    std::string reason;                 ///< "every island is a path of rods"
    FactorSummary factor;
  };
  const Summary& summary() const { return summary_; }

 protected:
  Summary summary_;
};

}  // namespace tanor::detail
