#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <tanor/system.hpp>

#include "base/pack.hpp"
#include "base/power_series.hpp"

namespace tanor {

/// The step that a series is wanted for, and the errors that each point may have in it.
struct NeededTerms {
  SeriesDemand step;
  std::span<const double> position_atol, velocity_atol;  ///< [point] m and m/s, in place of step.atol if that is 0

  bool are_all() const { return !(step.h < any_length); }

  struct Errors {
    double position, velocity;
  };
  /// Returns the absolute errors that a point may have; 1 if there is no point (-1).
  Errors atol_of(Index point) const {
    if (point < 0) return {1.0, 1.0};
    if (step.atol > 0.0) return {step.atol, step.atol};
    const auto i = static_cast<std::size_t>(point);
    return {position_atol[i], velocity_atol[i]};
  }
};

/// Terms that an island, or several in lanes, had before they fell below what is needed.
struct FoundTerms {
  int last;                     ///< order of the last one
  double longest = any_length;  ///< step that they serve, s; any_length if these are all
};

/// Sets the terms of the points [begin, end) behind the last one to 0, of which those up to last_term[begin] may be
/// others, and notes which the last one is.
inline void end_series(const FoundTerms& found, std::size_t begin, std::size_t end,
                       std::span<double* const> coefficients, std::span<std::uint8_t> last_term) {
  for (int k = found.last + 1; k <= last_term[begin]; ++k)
    std::fill(coefficients[k] + 3 * begin, coefficients[k] + 3 * end, 0.0);
  std::fill(last_term.begin() + begin, last_term.begin() + end, static_cast<std::uint8_t>(found.last));
}

/// Decides how many terms islands in lanes need: order k is the last one if it and the one before it stay within the
/// allowed errors in a step of the length that is needed. This is how the step follows from the last terms elsewhere.
template <std::size_t lanes>
class TermCounter {
 public:
  using Lane = Pack<lanes>;
  using Vector = Pack3<lanes>;
  /// The inverse squares of the errors that the points of the lanes may have.
  struct Weights {
    Lane position, velocity;
  };

  explicit TermCounter(const NeededTerms& needed) : step_(needed.step), is_counting_(!needed.are_all()) {}

  bool is_counting() const { return is_counting_; }

  /// Returns the weight of points at r, or with the velocities r. It is that of an error up to the square root of 2
  /// smaller than the allowed one, which needs no root: (atol + rtol |r|)^2 >= atol^2 + rtol^2 r.r.
  [[gnu::always_inline]] Lane weigh(const Vector& r, const Lane& atol) const {
    return 1.0 / (atol * atol + (step_.rtol * step_.rtol) * dot(r, r));
  }

  /// Writes the absolute errors of a point in the place of its weights.
  static void read_atol(const NeededTerms& needed, Index point, std::size_t lane, Weights* to) {
    const auto [position, velocity] = needed.atol_of(point);
    to->position[lane] = position;
    to->velocity[lane] = velocity;
  }

  /// The largest squares of an order's ratios in each lane.
  struct Largest {
    Lane position{}, velocity{};
    Lane sum{};  // is NaN if some number is, which comparisons pass over

    [[gnu::always_inline]] void include(const Vector& r, const Weights& weights) {
      const Lane square = dot(r, r), of_position = square * weights.position, of_velocity = square * weights.velocity;
      sum += square;
      position = of_position > position ? of_position : position;
      velocity = of_velocity > velocity ? of_velocity : velocity;
    }
  };

  /// Notes order k, of which no point is left out. Returns true if no more are needed. Orders follow one another.
  bool note(int k, const Largest& largest) {
    before_ = here_;
    here_ = {k, 0.0, 0.0};
    double sum = 0.0;
    for (std::size_t s = 0; s < lanes; ++s) {
      sum += largest.sum[s];
      here_.position = std::max(here_.position, largest.position[s]);
      here_.velocity = std::max(here_.velocity, largest.velocity[s]);
    }
    const bool was_small = is_small_;
    power_ = power_ > 0.0 ? power_ * step_.h * step_.h : std::pow(step_.h, 2 * (k - 1));
    is_small_ = here_.is_small(step_.h, power_) && !std::isnan(sum);
    return k >= least_order && was_small && is_small_;
  }
  FoundTerms found() const { return {here_.k, std::min(here_.longest_step(), before_.longest_step())}; }

 private:
  static constexpr int least_order = 6;

  struct Term {
    int k = 0;
    double position = 0.0, velocity = 0.0;  // largest squares

    /// Given h and h^(2k-2).
    bool is_small(double h, double power) const {
      return position * h * h * power <= 1.0 && k * k * velocity * power <= 1.0;
    }
    double longest_step() const { return std::exp(log_of_longest_step(k, std::sqrt(position), std::sqrt(velocity))); }
  };

  SeriesDemand step_;
  bool is_counting_, is_small_ = false;
  double power_ = 0.0;  // h^(2k-2) of the last order
  Term here_, before_;
};

}  // namespace tanor
