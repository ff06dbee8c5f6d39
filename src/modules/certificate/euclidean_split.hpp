#pragma once

#include <optional>
#include <string>
#include <vector>

#include "certificate/second_factor.hpp"
#include "dynamics/multiplier_form.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Gamma = K'K over the moving points, and the Euclidean projector K Gamma^-1 K' onto the normal space (15).
class EuclideanSplit {
 public:
  /// `second` is a factor of S, which is used if all masses are equal, Gamma = m S (36), or null. It, K and the rest
  /// must outlive the split. `condition` is the reciprocal condition of S.
  EuclideanSplit(const Model& model, const std::vector<double>& K, const MultiplierForm& form, SecondFactorization by,
                 SecondFactor* second, double condition);

  /// Tells why there is no factor of Gamma; empty if there is one.
  std::string trouble() const { return factor_ == nullptr ? own_->trouble() : ""; }
  double reciprocal_condition() const { return condition_; }
  /// Returns W [point] of the factor, which is that of K'WK: 1, or 1/m with the factor of S; 0 for supports.
  const std::vector<double>& weights() const { return weights_; }
  void solve_negative(double* rows) { factor_->solve_negative(rows); }

 private:
  std::optional<SecondFactor> own_;
  SecondFactor* factor_ = nullptr;  // `own_`, or the factor of S
  std::vector<double> weights_;
  double condition_;
};

}  // namespace tanor::detail
