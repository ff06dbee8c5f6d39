#include "motion/turn_meter.hpp"

#include <algorithm>
#include <cmath>

#include "base/instruction_sets.hpp"
#include "base/pack.hpp"

namespace tanor::detail {

namespace {

/// The largest magnitude seen so far.
template <class Lanes>
struct Sizes {
  Lanes lanes{};
  double rest = 0.0;

  [[gnu::always_inline]] void see(const Lanes& x) { lanes.include_magnitudes(x); }
  [[gnu::always_inline]] void see(double x) { rest = std::max(rest, std::abs(x)); }
  [[gnu::always_inline]] double largest() const { return lanes.largest(rest); }
};

double largest_change(const double* from, const double* to, std::size_t begin, std::size_t end) {
  return dispatch([=]<class Lanes>(std::type_identity<Lanes>) {
    Sizes<Lanes> sizes;
    std::size_t i = begin;
    for (; i + num_lanes <= end; i += num_lanes) sizes.see(Lanes::at(to + i) - Lanes::at(from + i));
    for (; i < end; ++i) sizes.see(to[i] - from[i]);
    return sizes.largest();
  });
}

double largest_number(const double* x, std::size_t begin, std::size_t end) {
  return dispatch([=]<class Lanes>(std::type_identity<Lanes>) {
    Sizes<Lanes> sizes;
    std::size_t i = begin;
    for (; i + num_lanes <= end; i += num_lanes) sizes.see(Lanes::at(x + i));
    for (; i < end; ++i) sizes.see(x[i]);
    return sizes.largest();
  });
}

struct StepEnds {
  const double *x0, *v0, *x1, *v1;
};
/// Finds the largest |x1 - x0 - h (v0 + v1)/2| of these numbers.
double largest_missed(const StepEnds& ends, double half_step, std::size_t begin, std::size_t end) {
  return dispatch([=]<class Lanes>(std::type_identity<Lanes>) {
    Sizes<Lanes> sizes;
    const auto see = [&](const auto& x0, const auto& v0, const auto& x1, const auto& v1)
        __attribute__((always_inline)) {
      sizes.see(x1 - x0 - half_step * (v0 + v1));
    };
    const auto [x0, v0, x1, v1] = ends;
    std::size_t i = begin;
    for (; i + num_lanes <= end; i += num_lanes)
      see(Lanes::at(x0 + i), Lanes::at(v0 + i), Lanes::at(x1 + i), Lanes::at(v1 + i));
    for (; i < end; ++i) see(x0[i], v0[i], x1[i], v1[i]);
    return sizes.largest();
  });
}

/// Returns the largest of_range(begin, end) over all numbers of the mechanics' variables.
template <class OfRange>
double largest(Mechanics& mechanics, const OfRange& of_range) {
  return mechanics.largest(mechanics.parallel().max_over_ranges(mechanics.size(), of_range));
}

}  // namespace

void TurnMeter::note(Mechanics& mechanics, const State& to) {
  before_ = fastest_;
  fastest_ = std::max(fastest_, largest(mechanics, [&](std::size_t begin, std::size_t end) {
                        return largest_number(to.v.data(), begin, end);
                      }));
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
  const double place =
      largest(mechanics, [&](std::size_t begin, std::size_t end) { return largest_number(to.x.data(), begin, end); });
  if (!(h * fastest_ > least_move * place)) return 0.0;
  const StepEnds ends{from.x.data(), from.v.data(), to.x.data(), to.v.data()};
  const double missed =
      largest(mechanics, [&](std::size_t begin, std::size_t end) { return largest_missed(ends, 0.5 * h, begin, end); });
  const double by_x = 12.0 * missed / (h * fastest_);
  if (!knows_acceleration) return std::sqrt(by_x);
  const double changed = largest(mechanics, [&](std::size_t begin, std::size_t end) {
    return largest_change(from.a.data(), to.a.data(), begin, end);
  });
  return std::sqrt(std::max(by_x, h * changed / fastest_));
}

}  // namespace tanor::detail
