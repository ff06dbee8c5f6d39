#include "statics/smallest_multipliers.hpp"

namespace tanor {

Outcome SmallestMultipliers::find(const std::vector<double>& r, const std::vector<double>& given,
                                  std::vector<double>* lambda) {
  const Model& model = equations_.model();
  const double t = equations_.time();
  for (std::vector<double>* each : {&xi_, &b_}) each->resize(model.num_rows());
  for (std::vector<double>* each : {&w_, &dw_}) each->assign(3 * model.num_points(), 0.0);
  g_.resize(equations_.size());
  if (Outcome outcome = linearization_.update(t, r.data()); !outcome.ok()) return outcome;
  // S (lambda - given) = -K'M^-1(f + K given)
  if (!std::isfinite(equations_.evaluate(r.data(), given.data(), g_.data(), xi_.data()))) return model.not_finite(t);
  for (std::size_t i = 0; i < g_.size(); ++i) w_[i] = model.inverse_mass[i / 3] * g_[i];
  (void)linearization_.apply_transposed(w_.data(), nullptr, b_.data());
  lambda->assign(model.num_rows(), 0.0);
  linearization_.solve_refined(b_.data(), lambda->data(), dw_.data());
  linearization_.minimize_multiplier_norm(r.data(), lambda->data());
  for (std::size_t a = 0; a < lambda->size(); ++a) (*lambda)[a] += given[a];
  return {};
}

}  // namespace tanor
