#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "statics/kkt_solver.hpp"
#include "statics/unsymmetric_kkt.hpp"

namespace tanor::detail {

/// The state of an iteration, in the inner order.
struct StaticState {
  std::vector<double> r;       // [3 points], m
  std::vector<double> lambda;  // [rows]
};

/// The distance of a state from equilibrium.
struct StaticResidual {
  double force = 0.0;      ///< largest |g| of a point, N
  double known = 0.0;      ///< the same over points where it exceeds rounding
  double scale = 0.0;      ///< the largest force there, N
  double violation = 0.0;  ///< largest |xi|/|gradient|/length
  std::size_t worst_point = 0;

  double relative_force() const { return scale > 0.0 ? force / scale : 0.0; }
};

/// Small forces alone do not prove an equilibrium: far out, forces like exp(-x) die away and nothing is at rest. So
/// Newton's next step must also be short beside the scene's size, with each coordinate held by a small spring (see
/// StiffnessMatrix::hold_rows).
inline constexpr double short_step = 1e-4, held_rows = 1e-11;
/// Returns the longest move of a point, m.
double longest(const std::vector<double>& dr);

struct NewtonLimits {
  double force_tolerance = 1e-10;
  int max_iterations = 500;
};

/// Solves g = 0, xi = 0 by Newton's method, globalised to start far from an equilibrium.
///
/// Near an equilibrium, where A = W + K C K' is positive definite and a full step reduces the residual, the step is
/// Newton's own. Elsewhere it is a step of sequential quadratic programming (Nocedal & Wright, chapter 18). Its W omits
/// the destabilizing part of compressed rods and has an additional tension sigma in every rod, so that no rod turns
/// beyond the range of the linear model. One or two second-order corrections with the same factor restore the lengths
/// that a turn changes. The exact penalty U + nu'|xi| decides whether the step is accepted, and sigma follows the ratio
/// of actual to predicted gain. If A is still indefinite, masses are added (Waechter & Biegler 2006). The search
/// therefore ends at minima, not at saddles.
///
/// Formulas may have no potential. Then W need not be symmetric, and there is no energy to descend: steps with the
/// factor of the whole matrix are shortened until the residual falls.
class NewtonDescent {
 public:
  NewtonDescent(EquilibriumEquations& equations, Ordering ordering)
      : equations_(equations), model_(equations.model()), solver_(equations, ordering) {
    if (equations.work().forces.has_formulas()) whole_.emplace(equations);
  }

  /// Starts from `state`; ok if it ends at an equilibrium to the tolerance. Appends each iteration's force to
  /// `residuals`, N.
  Outcome run(const NewtonLimits& limits, StaticState* state, std::vector<double>* residuals);
  /// Returns true if all forces are rounding, or small beside those met on the way; `last_move` is finite then.
  bool have_forces_vanished(const NewtonLimits& limits) const {
    const double rounding = equations_.rounding_of_forces(residual_.worst_point);
    return residual_.scale <= std::max(limits.force_tolerance * largest_scale_, rounding) && std::isfinite(last_move_);
  }
  const StaticResidual& residual() const { return residual_; }
  double last_move() const { return last_move_; }  ///< m, of the last step; infinite if that was not Newton's own
  int iterations() const { return iterations_; }   ///< of the last run
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
  bool is_near(const NewtonLimits& limits, const StaticState& state);
  double find_next_step(const StaticState& state);
  bool rests(const StaticState& state);
  bool try_newton(StaticState* state);
  StiffnessMatrix::Curvature choose_curvature(const StaticState& state);
  template <class Accepts>
  bool take_newton_step(const Step& step, double length, StaticState* state, const Accepts& is_better);
  bool try_shortened(StaticState* state);
  bool advance(StaticState* state);
  bool halves(StaticState* state);
  bool try_descent(StaticState* state);
  std::string worst_point() const;
  Outcome explain_failure(const std::string& why) const;
  Outcome explain_fading() const;
  Outcome explain_not_finite() const;
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
  std::optional<UnsymmetricKkt> whole_;  // if formulas act
  StaticResidual residual_;
  std::vector<double> g_, xi_;     // at the state
  std::vector<double> penalties_;  // nu [row]
  double tension_ = 0.0;           // sigma, N
  double mass_shift_ = 0.0;        // 1/s^2
  double last_move_ = 0.0;         // m
  double largest_scale_ = 0.0;     // N, over all states on the way
  int iterations_ = 0, factorizations_ = 0, disturbances_ = 0;
  int slow_steps_ = 0;  // consecutive ones
  bool trusts_newton_ = true;
};

}  // namespace tanor::detail
