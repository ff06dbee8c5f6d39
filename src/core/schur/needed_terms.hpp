#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include <tanor/system.hpp>

#include "base/pack.hpp"
#include "base/parallel.hpp"
#include "base/power_series.hpp"

namespace tanor::detail {

/// The step that a series is wanted for, and the errors that each point may have in it.
struct NeededTerms {
  SeriesDemand step;
  std::span<const double> position_atol, velocity_atol;  ///< [point] m and m/s, in place of step.atol if that is 0

  bool are_all() const { return !(step.h < any_length); }

  struct Errors {
    double position, velocity;
  };
  /// Returns the absolute errors that a point may have; any if it is negative, which is another island's or nobody's.
  Errors atol_of(Index point) const {
    if (point < 0) return {HUGE_VAL, HUGE_VAL};
    if (step.atol > 0.0) return {step.atol, step.atol};
    const auto i = static_cast<std::size_t>(point);
    return {position_atol[i], velocity_atol[i]};
  }
};

/// Computes r_3 … r_P of islands from r_0, r_1, r_2 of coefficients[0 … P], each [3n], and from lambda_0 [d]. Those of
/// other points stay as they are; of supports, they are 0 from the third on. Terms that are not needed are 0.
struct LaneExpansion {
  std::span<double* const> coefficients;
  const double* lambda;
  int passes;  ///< the number of solves at each order; more than one refine
  NeededTerms needed;
  std::span<std::uint8_t> last_term;  ///< [n] gets the number of each point's last term that is not 0

  bool is_counting() const { return !needed.are_all(); }
  int order() const { return static_cast<int>(coefficients.size()) - 1; }
  /// Returns how far apart the series of rods stand. The number is odd: with a power of 2, they would meet in the same
  /// few lines of the caches.
  std::size_t stride() const { return coefficients.size() | 1; }
};

/// The motion of some islands as a power series.
class IslandSeries {
 public:
  virtual ~IslandSeries() = default;

  /// Returns in how many parts the islands are expanded, each of which has as many terms as it needs.
  virtual std::size_t num_parts() const = 0;
  /// Returns the longest step that the islands serve whose terms end earlier than others', s.
  virtual double expand(const Parallel& parallel, const LaneExpansion& expansion) = 0;
};

/// The terms that an island has, up to the second of two that are small enough.
struct FoundTerms {
  int last = 0;                 ///< order of the last one
  double longest = any_length;  ///< step that they serve, s; any_length if these are all
};

/// Sets the terms of the points [begin, end) behind the last one to 0, and notes which that is. This series has written
/// orders up to `reached`, and the one before it those up to last_term[begin].
inline void end_series(const FoundTerms& found, int reached, std::size_t begin, std::size_t end,
                       std::span<double* const> coefficients, std::span<std::uint8_t> last_term) {
  for (int k = found.last + 1; k <= std::max<int>(reached, last_term[begin]); ++k)
    std::fill(coefficients[k] + 3 * begin, coefficients[k] + 3 * end, 0.0);
  std::fill(last_term.begin() + begin, last_term.begin() + end, static_cast<std::uint8_t>(found.last));
}

/// Decides how many terms islands in lanes need: order k is the last one if it and the one before it stay within the
/// allowed errors in a step of the length that is needed. This is how the step follows from the last terms elsewhere.
/// Each island decides by itself, whatever the others are, so that any division into lanes gives the same bits.
class TermCounter {
 public:
  /// The inverse squares of the errors that the points in lanes may have.
  struct Weights {
    Pack<> position, velocity;
  };

  /// Counts those of islands in so many lanes.
  explicit TermCounter(const SeriesDemand& step, std::size_t num_islands) : step_(step), num_islands_(num_islands) {}

  /// The largest squares of an order's ratios in each lane.
  struct Largest {
    Pack<> position{}, velocity{};
    Pack<> sum{};  // is NaN if some number is, which comparisons pass over

    /// Finds those of a part of the lanes.
    template <class Lanes>
    [[gnu::always_inline]] void find(const Lanes& part, const Pack3<>* r, const Weights* weights, std::size_t count) {
      typename Lanes::Lane largest_of_r{}, largest_of_v{}, all{};
      for (std::size_t p = 0; p < count; ++p) {
        const auto point = part.of(r[p]);
        const auto square = dot(point, point), of_r = square * part.of(weights[p].position),
                   of_v = square * part.of(weights[p].velocity);
        all += square;
        largest_of_r = of_r > largest_of_r ? of_r : largest_of_r;
        largest_of_v = of_v > largest_of_v ? of_v : largest_of_v;
      }
      part.of(position) = largest_of_r;
      part.of(velocity) = largest_of_v;
      part.of(sum) = all;
    }
    /// Includes those of one lane of others in a lane.
    void include(std::size_t lane, const Largest& others, std::size_t other_lane) {
      position[lane] = std::max(position[lane], others.position[other_lane]);
      velocity[lane] = std::max(velocity[lane], others.velocity[other_lane]);
      sum[lane] += others.sum[other_lane];
    }
  };

  /// Notes order k. Returns true if no island needs more. Orders follow one another.
  bool note(int k, const Largest& largest) {
    power_ = power_ > 0.0 ? power_ * step_.h * step_.h : std::pow(step_.h, 2 * (k - 1));
    const auto is_small = (largest.position * (power_ * step_.h * step_.h) <= 1.0) &
                          (largest.velocity * (power_ * k * k) <= 1.0) & (largest.sum == largest.sum);
    bool are_enough = true;
    for (std::size_t s = 0; s < num_islands_; ++s) {
      const bool ends = k >= least_order && is_small[s] != 0 && was_small_[s] != 0;
      if (ends && found_[s].last == 0)
        found_[s] = {k, std::min(longest_step(k, largest, s), longest_step(k - 1, before_, s))};
      are_enough = are_enough && found_[s].last > 0;
    }
    was_small_ = is_small;
    before_ = largest;
    return are_enough;
  }
  /// Returns what the island of a lane has if its series ends at the given order at the latest.
  FoundTerms found(std::size_t lane, int order) const {
    return found_[lane].last > 0 && found_[lane].last < order ? found_[lane] : FoundTerms{order};
  }

 private:
  static constexpr int least_order = 6;

  static double longest_step(int k, const Largest& largest, std::size_t lane) {
    return std::exp(log_of_longest_step(k, std::sqrt(largest.position[lane]), std::sqrt(largest.velocity[lane])));
  }

  using Mask = decltype(Pack<>{} <= Pack<>{});

  SeriesDemand step_;
  std::size_t num_islands_;
  double power_ = 0.0;                         // h^(2k-2) of the last order
  Mask was_small_{};                           // of the last order
  Largest before_;                             // that of the last order
  std::array<FoundTerms, num_lanes> found_{};  // [lane]; `last` is 0 where more are needed
};

}  // namespace tanor::detail
