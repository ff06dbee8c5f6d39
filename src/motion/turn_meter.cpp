#include "motion/turn_meter.hpp"

#include <algorithm>
#include <cmath>

namespace tanor {

void TurnMeter::note(const std::vector<double>& v) {
  before_ = fastest_;
  for (const double each : v) fastest_ = std::max(fastest_, std::abs(each));
}

/// Turned by theta in a step, on a circle:
///
///   |x1 - x0 - h (v0 + v1)/2| = theta^2/12 h |v|,   h |a1 - a0| = theta^2 |v|
double TurnMeter::angle(const State& from, const State& to, bool knows_acceleration) const {
  constexpr double least_move = 1e-9;  // over positions, whose rounding would be seen
  // While a motion gathers its speed, as from rest, there is none yet to compare with.
  constexpr double gathering = 1.2;
  if (fastest_ > gathering * before_) return 0.0;
  const double h = to.t - from.t;
  double missed = 0.0, changed = 0.0, size = 0.0;
  for (std::size_t i = 0; i < to.x.size(); ++i) {
    missed = std::max(missed, std::abs(to.x[i] - from.x[i] - 0.5 * h * (from.v[i] + to.v[i])));
    changed = std::max(changed, std::abs(to.a[i] - from.a[i]));
    size = std::max(size, std::abs(to.x[i]));
  }
  if (!(h * fastest_ > least_move * size)) return 0.0;
  const double by_x = 12.0 * missed / (h * fastest_), by_a = knows_acceleration ? h * changed / fastest_ : 0.0;
  return std::sqrt(std::max(by_x, by_a));
}

}  // namespace tanor
