#pragma once

#include <optional>
#include <vector>

#include "dynamics/linearization.hpp"
#include "statics/equilibrium_equations.hpp"

namespace tanor::detail {

/// The multipliers that come nearest to balancing the forces at one configuration, and the rank of K there:
///
///   K lambda = -f   in the metric of M^-1, with the least |lambda - given| if lambda is not unique.
class SmallestMultipliers {
 public:
  SmallestMultipliers(EquilibriumEquations& equations, const SolverOptions& options)
      : equations_(equations), linearization_(equations.work(), options) {}

  /// Finds lambda [rows] at r [3 points]; `given` is [rows].
  Outcome find(const std::vector<double>& r, const std::vector<double>& given, std::vector<double>* lambda);
  /// Finds lambda and decides the rank of K, on which everything that is reported about an equilibrium rests. Rows that
  /// a collapsed net has brought together count as dependent, although the positions show it to a millionth only. If
  /// lambda is not found, all rows count as independent.
  Outcome find_and_decide(const std::vector<double>& r, const std::vector<double>& given, std::vector<double>* lambda,
                          RankReport* rank);
  /// Returns the part of lambda [rows] with K lambda = 0, which no load determines, by the last decision.
  std::vector<double> keep_self_stress(std::vector<double> lambda) const;
  /// Returns a state of self-stress [rows], with a part in each multiplier that is not unique; empty if all are.
  std::vector<double> find_self_stress() const;
  /// Returns the rank of K where `find` was called last.
  RankReport rank() const { return linearization_.dependences().report(); }
  /// The linearization there: K and the factor of S.
  Linearization& linearization() { return linearization_; }

 private:
  double evaluate(const std::vector<double>& r, const std::vector<double>& lambda);
  void solve_by_qr(const std::vector<double>& r, std::vector<double>* lambda);

  EquilibriumEquations& equations_;
  Linearization linearization_;
  std::optional<Dependences> dependences_;  // from the last decision
  std::vector<double> g_, xi_, b_;          // scratch [3 moving points], [rows]
  std::vector<double> w_, dw_;              // scratch [3 points]
};

/// Returns the rows of the model that depend on others [inner order].
std::vector<std::size_t> list_dependent_rows(const Model& model, const RankReport& rank);

}  // namespace tanor::detail
