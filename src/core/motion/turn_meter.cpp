#include "motion/turn_meter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "base/instruction_sets.hpp"
#include "base/pack.hpp"

namespace tanor::detail {

namespace {

/// Returns the largest |f(…)| of the numbers [begin, end) of some arrays.
template <std::size_t count, class Function>
double largest_magnitude(const std::array<const double*, count>& of, const Function& f, std::size_t begin,
                         std::size_t end) {
  return dispatch([=]<class Lanes>(std::type_identity<Lanes>) {
    const auto evaluate = [&](const auto& load) __attribute__((always_inline)) {
      return [&]<std::size_t... k>(std::index_sequence<k...>) __attribute__((always_inline)) {
        return f(load(of[k])...);
      }
      (std::make_index_sequence<count>());
    };
    Lanes largest{};
    double rest = 0.0;
    std::size_t i = begin;
    for (; i + num_lanes <= end; i += num_lanes)
      largest.include_magnitudes(evaluate([&](const double* x) { return Lanes::at(x + i); }));
    for (; i < end; ++i) rest = std::max(rest, std::abs(evaluate([&](const double* x) { return x[i]; })));
    return largest.largest(rest);
  });
}

/// Returns the same over all numbers of the mechanics' variables.
template <std::size_t count, class Function>
double largest(Mechanics& mechanics, const std::array<const double*, count>& of, const Function& f) {
  return mechanics.largest(mechanics.parallel().max_over_ranges(
      mechanics.size(), [&](std::size_t begin, std::size_t end) { return largest_magnitude(of, f, begin, end); }));
}
double largest(Mechanics& mechanics, const std::vector<double>& x) {
  return largest(mechanics, std::array{x.data()}, [](const auto& each) { return each; });
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
  const double half = 0.5 * h;
  const double missed = largest(
      mechanics, std::array{from.x.data(), from.v.data(), to.x.data(), to.v.data()},
      [half](const auto& x0, const auto& v0, const auto& x1, const auto& v1) { return x1 - x0 - half * (v0 + v1); });
  const double by_x = 12.0 * missed / (h * fastest_);
  if (!knows_acceleration) return std::sqrt(by_x);
  const double changed = largest(mechanics, std::array{from.a.data(), to.a.data()},
                                 [](const auto& a0, const auto& a1) { return a1 - a0; });
  return std::sqrt(std::max(by_x, h * changed / fastest_));
}

}  // namespace tanor::detail
