#pragma once

#include <vector>

#include "dynamics/gradient_rank.hpp"
#include "dynamics/linearization.hpp"
#include "schur/redundancy.hpp"
#include "statics/equilibrium_equations.hpp"

namespace tanor {

/// The multipliers that come nearest to balancing the forces at one configuration, and what K says about them:
///
///   K lambda = -f   in the metric of M^-1, |lambda - given| as small as it can be where several serve.
class SmallestMultipliers {
 public:
  SmallestMultipliers(EquilibriumEquations& equations, const SolverOptions& options)
      : equations_(equations), linearization_(equations.work(), options), rank_(equations.work(), linearization_) {}

  /// lambda [rows] at r [3 points]; `given` [rows].
  Outcome find(const std::vector<double>& r, const std::vector<double>& given, std::vector<double>* lambda);
  /// The same with the rank of K, where all that is told about an equilibrium is decided: rows that a collapsed net
  /// has brought together depend on each other, though the places know it to a millionth only.
  Outcome find_and_decide(const std::vector<double>& r, const std::vector<double>& given, std::vector<double>* lambda,
                          RankReport* rank);
  /// The rank of K at r, where `find` was asked last.
  RankReport rank(const std::vector<double>& r) { return rank_.report(r.data(), false); }
  /// K and the factor of S there.
  Linearization& linearization() { return linearization_; }

 private:
  bool wants_decision() const;
  void solve_by_qr(Redundancy* redundancy, const std::vector<double>& r, std::vector<double>* lambda);

  EquilibriumEquations& equations_;
  Linearization linearization_;
  GradientRank rank_;
  std::vector<double> g_, xi_, b_;  // scratch [3 moving points], [rows]
  std::vector<double> w_, dw_;      // scratch [3 points]
};

/// The rows of the model that depend on others [inner order].
std::vector<std::size_t> list_dependent_rows(const Model& model, const RankReport& rank);

}  // namespace tanor
