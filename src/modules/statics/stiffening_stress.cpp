#include "statics/stiffening_stress.hpp"

#include <cmath>
#include <utility>

#include "base/numbers.hpp"
#include "statics/newton_descent.hpp"

namespace tanor::detail {

namespace {

class StressSearch {
 public:
  StressSearch(EquilibriumEquations& equations, const SmallestMultipliers& multipliers, const FindInertia& find,
               const std::vector<double>& r)
      : equations_(equations), multipliers_(multipliers), find_(find), r_(r) {}

  void choose(std::vector<double>* lambda, ReducedInertia* inertia) {
    if (inertia->is_known && inertia->negative > 0) relax(lambda, inertia);
    const bool is_marginal = inertia->is_known && inertia->negative == 0 && inertia->zero > inertia->rigid_zero;
    if (is_marginal && equations_.size() <= most_dense_unknowns) seek(lambda, inertia);
  }

 private:
  /// Tries a few states of self-stress, with either sign. Motions that cost nothing with the current multipliers, as in
  /// a square with both diagonals, may cost energy with a self-stress.
  void seek(std::vector<double>* lambda, ReducedInertia* inertia) {
    constexpr std::size_t most_tries = 4;
    const double stiffest = equations_.stiffness().largest() * equations_.model().smallest_length,
                 size = stiffest > 0.0 ? stiffest : 1.0;
    for (std::size_t k = 0; k < most_tries; ++k) {
      std::vector<double> stress(lambda->size());
      for (std::size_t a = 0; a < stress.size(); ++a) stress[a] = irregular(a + k * stress.size());
      stress = multipliers_.keep_self_stress(std::move(stress));
      const double length = std::sqrt(dot(stress, stress));
      if (!(length > 0.0)) return;
      for (const double sign : {1.0, -1.0}) {
        std::vector<double> tried = *lambda;
        for (std::size_t a = 0; a < tried.size(); ++a) tried[a] += sign * size / length * stress[a];
        ReducedInertia found = find_(tried);
        if (found.is_known && found.negative > 0) relax(&tried, &found);
        if (!found.is_known || found.negative > 0 || found.zero > found.rigid_zero) continue;
        *lambda = std::move(tried);
        *inertia = std::move(found);
        return;
      }
    }
  }

  /// Moves the multipliers, as long as some motion gains energy, to where it does not, by the relaxation of Agmon and
  /// Motzkin (1954). W must be that of `lambda`.
  void relax(std::vector<double>* lambda, ReducedInertia* inertia) {
    constexpr int most_times = 100;
    constexpr double beyond = 1.5, nothing = 1e-9;
    std::vector<double> moved = *lambda;
    ReducedInertia here = *inertia;
    const double before = equations_.stiffness().largest();
    for (int time = 0; time < most_times && here.is_known && here.negative > 0; ++time) {
      if (here.shape.empty() || !(here.lowest < 0.0)) break;
      const std::vector<double> adds = stiffening(moved, here.shape), stress = multipliers_.keep_self_stress(adds);
      const double gained = dot(adds, stress), wanted = -beyond * here.lowest;
      if (!(gained > 1e-9 * dot(adds, adds))) break;
      for (std::size_t a = 0; a < stress.size(); ++a) moved[a] += wanted / gained * stress[a];
      here = find_(moved);
    }
    // Where a self-stress has relaxed to nothing, the signs of W are those of rounding.
    const bool is_left = equations_.stiffness().largest() > nothing * before;
    if (!here.is_known || here.negative > 0 || !is_left) return;
    *lambda = std::move(moved);
    *inertia = std::move(here);
  }

  /// Returns -q'Hess xi_a q of each row, the stiffness that one unit of its multiplier adds to a motion q.
  std::vector<double> stiffening(const std::vector<double>& lambda, const std::vector<double>& q) {
    constexpr double part = 1e-5;
    const double step = part * equations_.model().scene_size / longest(q);
    std::vector<double> ahead(lambda.size()), behind(lambda.size());
    for (const auto& [sign, rows] : {std::pair{1.0, &ahead}, std::pair{-1.0, &behind}}) {
      std::vector<double> moved = r_;
      for (std::size_t i = 0; i < q.size(); ++i) moved[i] += sign * step * q[i];
      equations_.linearise(moved.data(), lambda.data());
      equations_.apply_transposed(q.data(), rows->data());
    }
    for (std::size_t a = 0; a < ahead.size(); ++a) ahead[a] = (behind[a] - ahead[a]) / (2.0 * step);
    return ahead;
  }

  EquilibriumEquations& equations_;
  const SmallestMultipliers& multipliers_;
  const FindInertia& find_;
  const std::vector<double>& r_;
};

}  // namespace

void choose_self_stress(EquilibriumEquations& equations, const SmallestMultipliers& multipliers,
                        const FindInertia& find, const std::vector<double>& r, std::vector<double>* lambda,
                        ReducedInertia* inertia) {
  StressSearch(equations, multipliers, find, r).choose(lambda, inertia);
}

}  // namespace tanor::detail
