#include "certificate/euclidean_split.hpp"

#include "dynamics/split.hpp"

namespace tanor::detail {

EuclideanSplit::EuclideanSplit(const Model& model, const std::vector<double>& K, const MultiplierForm& form,
                               SecondFactorization by, SecondFactor* second, double condition)
    : weights_(model.inverse_mass), condition_(condition) {
  if (second != nullptr && has_one_mass(model)) {
    factor_ = second;
    return;
  }
  for (double& weight : weights_) weight = weight > 0.0 ? 1.0 : 0.0;
  own_.emplace(model, K.data(), weights_, form.orderings(), by);
  if (!own_->trouble().empty()) return;
  factor_ = &*own_;
  condition_ = own_->estimate_reciprocal_condition();
}

}  // namespace tanor::detail
