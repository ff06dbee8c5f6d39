#include "motion/composition.hpp"

namespace tanor::detail {

/// Suzuki (1990). The fraction 1/(4 - 4^(1/3)) stands twice at each end (GNI, II.4.5).
std::span<const double> suzuki_fractions() {
  static constexpr double outer = 0.41449077179437573714;
  static constexpr std::array fractions{outer, outer, 1.0 - 4.0 * outer, outer, outer};
  return fractions;
}

/// Kahan & Li (1997), nine stages (GNI, V.3.2).
std::span<const double> kahan_li_fractions() {
  static constexpr double g1 = 0.39216144400731413928, g2 = 0.33259913678935943860, g3 = -0.70624617255763935981,
                          g4 = 0.082213596293550800230, g5 = 0.79854399093482996340;
  static constexpr std::array fractions{g1, g2, g3, g4, g5, g4, g3, g2, g1};
  return fractions;
}

Composition::Composition(int order, std::span<const double> fractions, Mechanics& mechanics)
    : order_(order), fractions_(fractions), rattle_(mechanics, order) {
  for (State& state : between_) {
    for (std::vector<double>* array : {&state.x, &state.v, &state.a}) array->resize(mechanics.size());
  }
}

StepResult Composition::step(const State& from, double h, State* to) {
  StepResult result;
  const State* before = &from;
  double gone = 0.0;
  for (std::size_t k = 0; k < fractions_.size(); ++k) {
    const bool is_last = k + 1 == fractions_.size();
    State* const after = is_last ? to : &between_[k % 2];
    gone += fractions_[k];
    if (!is_last) after->t = from.t + gone * h;
    result = rattle_.step(*before, fractions_[k] * h, after);
    if (!result.outcome.ok()) return result;
    before = after;
  }
  return result;
}

}  // namespace tanor::detail
