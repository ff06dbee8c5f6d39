#include "motion/turn_meter.hpp"

#include <algorithm>
#include <cmath>

#include "base/eight.hpp"
#include "base/instruction_sets.hpp"

namespace tanor {

namespace {

/// The largest |number(at, i)| for i in [begin, end), eight side by side: `at` reads one number or eight from an
/// address.
template <class Number>
[[gnu::always_inline]] inline double largest(std::size_t begin, std::size_t end, const Number& number) {
  const auto read_eight = [](const double* from) __attribute__((always_inline))->Eight {
    return eight_at(from);
  };
  const auto read_one = [](const double* from) __attribute__((always_inline)) {
    return *from;
  };
  Eight lanes{};
  std::size_t i = begin;
  for (; i + num_lanes <= end; i += num_lanes) {
    const Eight x = number(read_eight, i), size = x < 0.0 ? -x : x;
    lanes = size > lanes ? size : lanes;
  }
  double result = 0.0;
  for (; i < end; ++i) result = std::max(result, std::abs(number(read_one, i)));
  for (std::size_t lane = 0; lane < num_lanes; ++lane) result = std::max(result, lanes[lane]);
  return result;
}

TANOR_EACH_INSTRUCTION_SET
double largest_size(const double* x, std::size_t begin, std::size_t end) {
  return largest(
      begin, end, [=](const auto& at, std::size_t i) __attribute__((always_inline)) { return at(x + i); });
}
TANOR_EACH_INSTRUCTION_SET
double largest_change(const double* from, const double* to, std::size_t begin, std::size_t end) {
  return largest(
      begin,
      end, [=](const auto& at, std::size_t i) __attribute__((always_inline)) { return at(to + i) - at(from + i); });
}
/// x1 - x0 - h (v0 + v1)/2
struct StepEnds {
  const double *x0, *v0, *x1, *v1;
};
TANOR_EACH_INSTRUCTION_SET
double largest_miss(const StepEnds& ends, double half_step, std::size_t begin, std::size_t end) {
  return largest(
      begin, end, [&ends, half_step ](const auto& at, std::size_t i) __attribute__((always_inline)) {
        return at(ends.x1 + i) - at(ends.x0 + i) - half_step * (at(ends.v0 + i) + at(ends.v1 + i));
      });
}

}  // namespace

void TurnMeter::note(const Parallel& parallel, const std::vector<double>& v) {
  before_ = fastest_;
  const double speed = parallel.max_over_ranges(
      v.size(), [&](std::size_t begin, std::size_t end) { return largest_size(v.data(), begin, end); });
  fastest_ = std::max(fastest_, speed);
}

/// Turned by theta in a step, on a circle:
///
///   |x1 - x0 - h (v0 + v1)/2| = theta^2/12 h |v|,   h |a1 - a0| = theta^2 |v|
double TurnMeter::angle(const Parallel& parallel, const State& from, const State& to, bool knows_acceleration) const {
  constexpr double least_move = 1e-9;  // over positions, whose rounding would be seen
  // While a motion gathers its speed, as from rest, there is none yet to compare with.
  constexpr double gathering = 1.2;
  if (fastest_ > gathering * before_) return 0.0;
  const double h = to.t - from.t;
  const auto over_ranges = [&](const auto& of_range) { return parallel.max_over_ranges(to.x.size(), of_range); };
  const double size =
      over_ranges([&](std::size_t begin, std::size_t end) { return largest_size(to.x.data(), begin, end); });
  if (!(h * fastest_ > least_move * size)) return 0.0;
  const StepEnds ends{from.x.data(), from.v.data(), to.x.data(), to.v.data()};
  const double missed =
      over_ranges([&](std::size_t begin, std::size_t end) { return largest_miss(ends, 0.5 * h, begin, end); });
  const double by_x = 12.0 * missed / (h * fastest_);
  if (!knows_acceleration) return std::sqrt(by_x);
  const double changed = over_ranges(
      [&](std::size_t begin, std::size_t end) { return largest_change(from.a.data(), to.a.data(), begin, end); });
  return std::sqrt(std::max(by_x, h * changed / fastest_));
}

}  // namespace tanor
