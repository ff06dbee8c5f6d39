#include "certificate/euclidean_split.hpp"

#include "certificate/answer_measures.hpp"
#include "dynamics/split.hpp"

namespace tanor::detail {

EuclideanSplit::EuclideanSplit(Workspace& work, const std::vector<double>& K, const MultiplierForm& form,
                               SecondFactorization by, SecondFactor* second, double condition)
    : work_(work), model_(work.model()), K_(K), scale_(model_.inverse_mass), condition_(condition) {
  if (second != nullptr && has_one_mass(model_)) {
    factor_ = second;
    return;
  }
  for (double& weight : scale_) weight = weight > 0.0 ? 1.0 : 0.0;
  own_.emplace(model_, K_.data(), scale_, form.orderings(), by);
  if (!own_->trouble().empty()) return;
  factor_ = &*own_;
  condition_ = own_->estimate_reciprocal_condition();
}

std::vector<double> EuclideanSplit::project_onto_normal(const std::vector<double>& u) {
  std::vector<double> rows(model_.num_rows()), rest = u, change(u.size(), 0.0), result(u.size(), 0.0);
  repeat(most_passes(condition_), [&] {
    work_.constraints.apply_transposed(model_.parallel, K_.data(), rest.data(), nullptr, rows.data());
    factor_->solve_negative(rows.data());
    model_.gather.write_scaled(model_.parallel, K_.data(), rows.data(), scale_.data(), model_.num_moving(),
                               change.data());
    for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) {
      rest[i] += change[i];
      result[i] -= change[i];
    }
    return model_.largest_norm(change.data());
  });
  return result;
}

}  // namespace tanor::detail
