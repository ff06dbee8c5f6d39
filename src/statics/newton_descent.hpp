#pragma once

#include <limits>
#include <string>
#include <vector>

#include "statics/kkt_solver.hpp"

namespace tanor {

/// Where an iteration stands, in the inner order.
struct StaticState {
  std::vector<double> r;       // [3 points], m
  std::vector<double> lambda;  // [rows]
};

/// How far from equilibrium a state is.
struct StaticResidual {
  double force = 0.0;      ///< largest |g| of a point, N
  double known = 0.0;      ///< the same of points where it is more than rounding
  double scale = 0.0;      ///< the largest force there, N
  double violation = 0.0;  ///< largest |xi|/|gradient|/length
  std::size_t worst_point = 0;

  double relative_force() const { return scale > 0.0 ? force / scale : 0.0; }
};

/// Small forces alone are no equilibrium: far out, as of exp(-x), they die away and nothing is at rest. So Newton's
/// next step has to be short as well, beside the scene's size, with each coordinate held by a small spring (see
/// StiffnessMatrix::hold_rows). Where forces are small, so many steps may still be long.
inline constexpr double short_step = 1e-4, held_rows = 1e-11;
inline constexpr int most_long_steps = 40;
/// m, of the moves of points.
double longest(const std::vector<double>& dr);
/// That forces die away, as those of `residual` after so many iterations.
Outcome explain_fading(const Model& model, const StaticResidual& residual, int iterations);

struct NewtonLimits {
  double force_tolerance = 1e-10;
  int max_iterations = 500;
};

/// Newton's method for g = 0, xi = 0, from far.
///
/// Near an equilibrium, where A = W + K C K' is positive definite and a full step makes the residual smaller, the step
/// is Newton's own. Elsewhere it is one of a sequential quadratic program: W without what compressed rods take away,
/// and with a tension sigma more in every rod, so that no rod turns by more than the linear model knows; accepted by
/// the exact penalty U + nu'|xi| (Nocedal & Wright, chapter 18), after one or two corrections of second order, with the
/// same factor, for the lengths that a turn changes. Sigma follows the ratio of what is gained to what was predicted.
/// Where A is still indefinite, masses are added (Waechter & Biegler 2006). So it ends at minima, not at saddles.
class NewtonDescent {
 public:
  NewtonDescent(EquilibriumEquations& equations, Ordering ordering)
      : equations_(equations), model_(equations.model()), solver_(equations, ordering) {}

  /// From `state`; ok: an equilibrium to the tolerance. `residuals`: of each iteration, N.
  Outcome run(const NewtonLimits& limits, StaticState* state, std::vector<double>* residuals);
  const StaticResidual& residual() const { return residual_; }
  int iterations() const { return iterations_; }  ///< of the last run
  int factorizations() const { return factorizations_; }
  KktSolver& solver() { return solver_; }
  StaticResidual measure(const StaticState& state);

 private:
  struct Step {
    std::vector<double> dr, dlambda;
  };
  bool is_small(const NewtonLimits& limits) const;
  bool is_small_here(const NewtonLimits& limits, const StaticState& state);
  bool is_linear_near(const StaticState& state);
  bool rests(const StaticState& state);
  bool try_newton(StaticState* state);
  StiffnessMatrix::Curvature choose_curvature(const StaticState& state);
  template <class Judge>
  bool take_full_step(StaticState* state, const Judge& is_better);
  bool halves(StaticState* state);
  bool try_descent(StaticState* state);
  Outcome explain(const char* why) const;
  bool factorize(double shift);
  bool factorize_nearly_exact();
  bool factorize_with_masses();
  double find_frequency2() const;
  void solve_step(Step* step, double share = 1.0, int refinements = 3);
  void solve_consistent_step(Step* step, double share);
  bool take_step(const Step& step, double share, const std::vector<double>& penalties_before, StaticState* state);
  void disturb(StaticState* state);
  double merit(const std::vector<double>& r);
  double find_tension() const;
  void correct_lengths(double share, std::vector<double>* r);
  double violation_tolerance() const;
  static double combined(const StaticResidual& residual) {
    return (residual.scale > 0.0 ? residual.known / residual.scale : 0.0) + residual.violation;
  }

  EquilibriumEquations& equations_;
  const Model& model_;
  KktSolver solver_;
  StaticResidual residual_;
  std::vector<double> g_, xi_;     // at the state
  std::vector<double> penalties_;  // nu [row]
  double tension_ = 0.0;           // sigma, N
  double mass_shift_ = 0.0;        // 1/s^2
  double last_move_ = 0.0;         // m, of the last step; infinite where it was none of Newton's own
  double largest_scale_ = 0.0;     // N, of all forces on the way
  int iterations_ = 0, factorizations_ = 0, disturbances_ = 0;
  int slow_steps_ = 0;  // one after the other
};

}  // namespace tanor
