#include "motion/turn_meter.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/instruction_sets.hpp"

namespace tanor::detail {

namespace {

/// Returns the largest |f(i)| over all numbers of the mechanics' variables.
template <class Function>
double largest(Mechanics& mechanics, const Function& f) {
  return mechanics.largest(
      mechanics.parallel().max_over_ranges(mechanics.size(), [f](std::size_t begin, std::size_t end) {
        return dispatch([=] {
          double most = 0.0;
#pragma omp simd reduction(max : most)
          for (std::size_t i = begin; i < end; ++i) {
            const double size = std::abs(f(i));
            most = size > most ? size : most;
          }
          return most;
        });
      }));
}
double largest(Mechanics& mechanics, const std::vector<double>& numbers) {
  return largest(mechanics, [x = numbers.data()](std::size_t i) { return x[i]; });
}

}  // namespace

void TurnMeter::note(Mechanics& mechanics, const State& to) {
  before_ = fastest_;
  fastest_ = std::max(fastest_, largest(mechanics, to.v));
}

/// Computes the angle theta by which a step turns the motion, from two relations that hold on a circle:
///
///   |x1 - x0 - h (v0 + v1)/2| = theta^2/12 h |v|,   h |a1 - a0| = theta^2 |v|
double TurnMeter::angle(Mechanics& mechanics, const State& from, const State& to, bool knows_acceleration) const {
  constexpr double least_move = 1e-9;  // relative to positions, whose rounding would dominate below
  // While a motion gains speed, as from rest, there is no speed yet to compare with.
  constexpr double gathering = 1.2;
  if (fastest_ > gathering * before_) return 0.0;
  const double h = to.t - from.t;
  const double place = largest(mechanics, to.x);
  if (!(h * fastest_ > least_move * place)) return 0.0;
  const double missed =
      largest(mechanics, [half = 0.5 * h, x0 = from.x.data(), v0 = from.v.data(), x1 = to.x.data(),
                          v1 = to.v.data()](std::size_t i) { return x1[i] - x0[i] - half * (v0[i] + v1[i]); });
  const double by_x = 12.0 * missed / (h * fastest_);
  if (!knows_acceleration) return std::sqrt(by_x);
  const double changed =
      largest(mechanics, [a0 = from.a.data(), a1 = to.a.data()](std::size_t i) { return a1[i] - a0[i]; });
  return std::sqrt(std::max(by_x, h * changed / fastest_));
}

}  // namespace tanor::detail
