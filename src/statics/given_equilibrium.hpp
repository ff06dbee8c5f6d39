#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

#include "statics/equilibrium_equations.hpp"
#include "statics/kkt_solver.hpp"

namespace tanor {

/// A system that stands at positions which somebody says are an equilibrium, with the multipliers that belong to them.
class GivenEquilibrium {
 public:
  struct Claim {
    std::span<const double> positions;    // [3n], users' order
    std::span<const double> multipliers;  // [equations]; empty: those of f + K lambda = 0
    double time, force_tolerance;
    bool ignore_friction;
  };
  /// Throws InputError where it is none, naming the worst point or equation.
  GivenEquilibrium(const System& system, const Claim& claim, const SolverOptions& options);

  const Model& model() const { return work_.model(); }
  EquilibriumEquations& equations() { return equations_; }
  const std::vector<double>& positions() const { return r_; }   ///< [3 points], inner order
  const std::vector<double>& multipliers() const { return lambda_; }  ///< [rows], inner order
  double relative_residual() const { return relative_residual_; }     ///< largest |f + K lambda| over the largest force

  /// How K depends on itself there; rank d without a look where it cannot.
  const RankReport& rank() const { return rank_; }
  /// Some lambda that forces do not determine changes Z'WZ; the answer names its rows. Empty: none does.
  std::string find_ambiguous_stiffness();

  /// lambda [rows] of K lambda = -f in the sense of least squares, and what is left: f + K lambda into f [3 moving].
  std::vector<double> balance(std::vector<double>* f);
  /// x [3 moving] := its part that K'x = 0 lets move, in the M-norm.
  void project(std::vector<double>* x);

 private:
  KktSolver& heavy();
  void find_multipliers(std::span<const double> given);
  void check(double force_tolerance);
  std::vector<double> self_stress(const RowDependence& dependence) const;

  System system_;
  Workspace work_;
  EquilibriumEquations equations_;
  std::vector<double> r_, lambda_;
  double relative_residual_ = 0.0;
  RankReport rank_;
  std::unique_ptr<KktSolver> heavy_;  // with so much mass that stiffness hardly counts
};

}  // namespace tanor
