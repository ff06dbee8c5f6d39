#include "statics/smallest_multipliers.hpp"

namespace tanor {

Outcome SmallestMultipliers::find(const std::vector<double>& r, const std::vector<double>& given,
                                  std::vector<double>* lambda) {
  const Model& model = equations_.model();
  const double t = equations_.time();
  std::vector<double> g(equations_.size()), xi(model.num_rows());
  if (Outcome outcome = linearization_.update(t, r.data()); !outcome.ok()) return outcome;
  // S (lambda - given) = -K'M^-1(f + K given)
  if (!std::isfinite(equations_.evaluate(r.data(), given.data(), g.data(), xi.data()))) return model.not_finite(t);
  std::vector<double> w(3 * model.num_points(), 0.0), b(model.num_rows()), dw(w.size());
  for (std::size_t i = 0; i < g.size(); ++i) w[i] = model.inverse_mass[i / 3] * g[i];
  (void)linearization_.apply_transposed(w.data(), nullptr, b.data());
  lambda->assign(model.num_rows(), 0.0);
  linearization_.solve_refined(b.data(), lambda->data(), dw.data());
  linearization_.minimize_multiplier_norm(r.data(), lambda->data());
  for (std::size_t a = 0; a < lambda->size(); ++a) (*lambda)[a] += given[a];
  return {};
}

}  // namespace tanor
