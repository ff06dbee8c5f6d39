#pragma once

#include <optional>
#include <string>
#include <vector>

#include "certificate/second_factor.hpp"
#include "dynamics/multiplier_form.hpp"
#include "dynamics/workspace.hpp"

namespace tanor {

/// Gamma = K'K over the moving points, and the Euclidean projector K Gamma^-1 K' onto the normal space (15).
class EuclideanSplit {
 public:
  /// `second`: a factor of S, which serves where all masses are equal, Gamma = m S (36); null: there is none.
  /// It, K and the rest outlive the split. `condition`: the reciprocal condition of S.
  EuclideanSplit(Workspace& work, const std::vector<double>& K, const MultiplierForm& form, SecondWay way,
                 SecondFactor* second, double condition);

  /// Why there is no factor of Gamma, or empty.
  std::string trouble() const { return factor_ == nullptr ? own_->trouble() : ""; }
  double reciprocal_condition() const { return condition_; }
  /// K Gamma^-1 K'u
  std::vector<double> project_onto_normal(const std::vector<double>& u);

 private:
  Workspace& work_;
  const Model& model_;
  const std::vector<double>& K_;
  std::optional<SecondFactor> own_;
  SecondFactor* factor_ = nullptr;  // own_, or that of S
  std::vector<double> scale_;       // [point] 1; 1/m where the factor is that of S; supports: 0
  double condition_;
};

}  // namespace tanor
