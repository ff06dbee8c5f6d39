/// Islands in lanes leave out the terms of their power series that no step of the wanted length needs. The terms that
/// they have are those of the whole series, and the last two of them are small enough.

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "base/lane_parts.hpp"
#include "schur/compare_series.hpp"
#include "schur/needed_terms.hpp"

namespace tanor {
using namespace detail;
namespace {

using series::Expanded;
using series::order;

struct Island {
  std::size_t begin, end;  // points
  double speed;
};

/// Long chains, whose pieces share a grove, short ones, and rings, eight of which share one, that move at random at
/// speeds from 1 to 1e-3 m/s.
struct MovingIslands {
  System system;
  std::vector<Island> chains, rings;

  /// Rings of 1 m/s are so many apart.
  explicit MovingIslands(std::uint32_t seed, int apart = 3) {
    std::mt19937 random(seed);
    const auto draw = [&] { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); };
    Rods rods;
    const auto add = [&](Index size, bool is_ring, double speed) {
      const auto first = static_cast<Index>(system.masses.size());
      for (Index i = 0; i < size; ++i) {
        system.positions.insert(system.positions.end(), {0.1 * i + 0.02 * draw(), 0.3 * draw(), 0.3 * draw()});
        system.velocities.insert(system.velocities.end(), {speed * draw(), speed * draw(), speed * draw()});
        system.masses.push_back(std::exp(draw()));
        if (i > 0) rods.pairs.push_back({first + i - 1, first + i});
      }
      if (is_ring) rods.pairs.push_back({first + size - 1, first});
      return Island{static_cast<std::size_t>(first), system.masses.size(), speed};
    };
    for (int k = 0; k < 6; ++k) chains.push_back(add(k % 2 == 0 ? 90 : 20, false, std::pow(10.0, -0.6 * k)));
    for (int k = 0; k < 24; ++k) rings.push_back(add(6, true, k % apart == 0 ? 1.0 : 1e-3));
    system.constraints = {rods};
    system.forces = {Gravity{"g", {0.0, 0.0, -9.81}}};
  }
};

/// The coefficients of points by their numbers in the system.
struct Terms {
  const Expanded& of;

  const double* at(int k, std::size_t point) const {
    return of.coefficients[static_cast<std::size_t>(k)].data() + 3 * inner(point);
  }
  int last(std::size_t point) const { return of.extent.last_term[inner(point)]; }
  std::size_t inner(std::size_t point) const { return static_cast<std::size_t>(of.model.numbering.inner_point[point]); }

  /// Returns the logarithm of the longest step for which order k of an island stays within the errors.
  double log_of_longest(int k, const Island& island, const SeriesDemand& wanted) const {
    double position = 0.0, velocity = 0.0;
    for (std::size_t point = island.begin; point < island.end; ++point) {
      const auto size = [&](const std::vector<double>& array) { return norm(load(array.data(), inner(point))); };
      const double term = norm(load(at(k, point), 0));
      position = std::max(position, term / (wanted.atol + wanted.rtol * size(of.r)));
      velocity = std::max(velocity, term / (wanted.atol + wanted.rtol * size(of.v)));
    }
    return log_of_longest_step(k, position, velocity);
  }
  double log_of_longest(const Island& island, const SeriesDemand& wanted) const {
    const int k = last(island.begin);
    return std::min(log_of_longest(k, island, wanted), log_of_longest(k - 1, island, wanted));
  }
};

RC_GTEST_PROP(NeededTerms, AreThoseOfTheWholeSeriesUntilTwoAreSmall, ()) {
  const MovingIslands islands(*rc::gen::arbitrary<std::uint32_t>());
  const double h = *rc::gen::element(1e-3, 4e-3, 1e-2);
  const SeriesDemand wanted{.h = h, .atol = 1e-9, .rtol = 1e-7};
  const Expanded whole(islands.system), part(islands.system, 0, wanted);
  RC_ASSERT(whole.outcome.ok() && part.outcome.ok());
  const Terms all{whole}, some{part};
  for (std::size_t point = 0; point < islands.system.masses.size(); ++point) {
    for (int k = 0; k <= order; ++k) {
      for (std::size_t c = 0; c < 3; ++c)
        RC_ASSERT(some.at(k, point)[c] == (k <= some.last(point) ? all.at(k, point)[c] : 0.0));
    }
  }
  RC_ASSERT(whole.extent.longest == any_length);
  RC_ASSERT(part.extent.longest >= h);
  // An allowed error is lessened by the square root of 2 at most, where both its parts are equal.
  const double lessened = 0.5 * std::log(2.0);
  std::vector<Island> all_islands = islands.chains;
  all_islands.insert(all_islands.end(), islands.rings.begin(), islands.rings.end());
  for (const Island& island : all_islands) {
    const int last = some.last(island.begin);
    RC_ASSERT(last >= 6);
    if (last == order) continue;
    RC_ASSERT(some.log_of_longest(island, wanted) >= std::log(h));
    RC_ASSERT(std::log(part.extent.longest) <= some.log_of_longest(island, wanted) + 1e-12);
    if (last == 6) continue;
    // One order before, one of two terms was too large.
    RC_ASSERT(some.log_of_longest(last - 2, island, wanted) <= std::log(h) + lessened / (last - 3));
  }
}

TEST(NeededTerms, SlowIslandsHaveFewerThanFastOnes) {
  const MovingIslands islands(1);
  const Expanded part(islands.system, 0, {.h = 2e-2, .atol = 1e-9, .rtol = 1e-7});
  ASSERT_TRUE(part.outcome.ok());
  const Terms some{part};
  EXPECT_EQ(some.last(islands.chains.front().begin), order);
  EXPECT_LT(some.last(islands.chains.back().begin), order);
  // Each ring decides by itself, though eight of them share lanes.
  EXPECT_LT(some.last(islands.rings[1].begin), some.last(islands.rings[0].begin));
}

/// The same islands in other company have the same terms to the last bit.
TEST(NeededTerms, DoNotDependOnIslandsThatShareTheLanes) {
  const SeriesDemand wanted{.h = 2e-2, .atol = 1e-9, .rtol = 1e-7};
  const MovingIslands few(1, 24), many(1, 2);  // the first ring is fast in both
  const Expanded with_slow(few.system, 0, wanted), with_fast(many.system, 0, wanted);
  ASSERT_TRUE(with_slow.outcome.ok() && with_fast.outcome.ok());
  const Terms one{with_slow}, other{with_fast};
  for (const std::size_t ring : {0u, 1u, 3u, 5u}) {
    const Island& island = few.rings[ring];
    for (std::size_t point = island.begin; point < island.end; ++point) {
      EXPECT_EQ(one.last(point), other.last(point)) << ring;
      for (int k = 0; k <= order; ++k)
        for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(one.at(k, point)[c], other.at(k, point)[c]) << ring << ", " << k;
    }
  }
}

/// A term that is not a number is never small enough, whatever the others are.
TEST(NeededTerms, TermsThatAreNoNumbersAreNotTheLast) {
  const Pack<> one = Pack<>{} + 1e-3;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    TermCounter counter(SeriesDemand{.h = 1.0, .atol = 1.0, .rtol = 1.0}, num_lanes);
    TermCounter::Largest fine, broken;
    Pack<> number = one;
    number[lane] = std::nan("");
    const Pack3<> points[]{{one, number, one}, {one, one, one}};
    const TermCounter::Weights weights[]{{one, one}, {one, one}};
    broken.find(detail::Part<num_lanes>(0), points, weights, 2);
    fine.find(detail::Part<num_lanes>(0), points + 1, weights, 1);

    EXPECT_FALSE(counter.note(6, fine));
    EXPECT_FALSE(counter.note(7, broken));
    EXPECT_FALSE(counter.note(8, fine));
    EXPECT_TRUE(counter.note(9, fine));
    for (std::size_t other = 0; other < num_lanes; ++other)
      EXPECT_EQ(counter.found(other, 12).last, other == lane ? 9 : 7);
  }
}

/// A second series in the same arrays clears what the first one has left behind its own last terms.
TEST(NeededTerms, LeaveNothingOfAnEarlierSeries) {
  const MovingIslands islands(2);
  Expanded once(islands.system, 0, {.h = 1e-2, .atol = 1e-9, .rtol = 1e-7});
  ASSERT_TRUE(once.outcome.ok());
  Expanded twice(islands.system);
  std::vector<double*> pointers;
  for (std::vector<double>& c : twice.coefficients) pointers.push_back(c.data());
  Reactions found;
  const Kinematics at{0.0, twice.r.data(), twice.v.data()};
  std::vector<double> a(twice.form.size());
  ASSERT_TRUE(twice.form.accelerations(at, {Gradients::Keep}, {a.data(), nullptr, nullptr, &found}).ok());
  for (const double h : {1e-2, 1e-3, 1e-2}) {
    const SeriesDemand wanted{.h = h, .atol = 1e-9, .rtol = 1e-7};
    ASSERT_TRUE(twice.form.series(nullptr)->expand(at, a.data(), found, wanted, pointers, &twice.extent).ok());
  }
  EXPECT_EQ(twice.extent.last_term, once.extent.last_term);
  for (std::size_t k = 0; k <= order; ++k) EXPECT_EQ(twice.coefficients[k], once.coefficients[k]) << k;
}

}  // namespace
}  // namespace tanor
