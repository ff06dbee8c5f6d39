/// The motion of rods along paths and rings as a power series is compared order by order with that of the general
/// solver.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "schur/compare_series.hpp"

namespace tanor {
using namespace detail;
namespace {

using series::agreement;
using series::compare;

/// Paths of rods with random shapes, masses and numbering, some with supports at their ends or inside, moving at
/// random.
struct RandomPaths {
  std::mt19937 random;
  System system;
  Rods rods;
  std::vector<Index> supports;

  /// Adds rings of so many rods behind the paths.
  RandomPaths(const std::vector<std::size_t>& lengths, std::uint32_t seed, bool has_offsets,
              const std::vector<std::size_t>& rings = {})
      : random(seed) {
    std::vector<Vec3> places, velocities;
    for (const std::size_t length : lengths) {
      Vec3 place{draw(), draw(), draw()}, velocity{draw(), draw(), draw()};
      const double held = draw();
      const auto first = static_cast<Index>(places.size());
      for (std::size_t i = 0; i <= length; ++i) {
        places.push_back(place);
        velocities.push_back(velocity);
        const Vec3 step{0.6 + 0.3 * draw(), 0.5 * draw(), 0.5 * draw()};
        // The next point turns about this one.
        velocity = velocity + cross(Vec3{draw(), draw(), draw()}, step);
        place = place + step;
        const auto point = static_cast<Index>(places.size() - 1);
        if (i > 0) rods.pairs.push_back(draw() > 0.0 ? std::array{point - 1, point} : std::array{point, point - 1});
      }
      const auto last = static_cast<Index>(places.size() - 1);
      if (held > 0.3) supports.push_back(first);
      if (std::abs(held) > 0.6) supports.push_back(last);
      if (held < -0.8 && length > 4) supports.push_back(first + 2);
    }
    for (const std::size_t length : rings) {
      const auto first = static_cast<Index>(places.size()), count = static_cast<Index>(length);
      for (Index i = 0; i < count; ++i) {
        places.push_back({draw(), draw(), draw()});
        velocities.push_back({draw(), draw(), draw()});
        rods.pairs.push_back({first + i, first + (i + 1) % count});
      }
    }
    places.push_back({9.0, 9.0, 9.0});  // free
    velocities.push_back({1.0, 0.0, 0.0});
    for (std::size_t i = 0; i < places.size(); ++i) {
      const bool rests = std::find(supports.begin(), supports.end(), static_cast<Index>(i)) != supports.end();
      const Vec3 v = rests ? Vec3{} : velocities[i];
      system.positions.insert(system.positions.end(), {places[i].x, places[i].y, places[i].z});
      system.velocities.insert(system.velocities.end(), {v.x, v.y, v.z});
      system.masses.push_back(std::exp(draw()));
    }
    if (has_offsets) {
      // The offset leads to an image of the second point elsewhere.
      for (std::size_t k = 0; k < rods.pairs.size(); ++k) rods.offsets.push_back({draw(), draw(), draw()});
    }
    std::shuffle(rods.pairs.begin(), rods.pairs.end(), random);
    system.supports = {Support{"held", supports}};
    system.constraints = {rods};
    system.forces = {Gravity{"g", {0.3, -0.2, -9.81}}};
  }

  double draw() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); }
};

RC_GTEST_PROP(PathSeries, AgreesWithTheGeneralSolver, ()) {
  const auto lengths = *rc::gen::nonEmpty(rc::gen::container<std::vector<std::size_t>>(rc::gen::inRange(1, 30)));
  const auto seed = *rc::gen::arbitrary<std::uint32_t>();
  RC_ASSERT(compare(RandomPaths(lengths, seed, false).system) <= agreement);
}

TEST(PathSeries, AgreesWithTheGeneralSolverOnOnePathThatIsCut) {
  for (const std::size_t length : {64, 65, 71, 72, 73, 200, 1001}) {
    for (std::uint32_t seed = 0; seed < 4; ++seed)
      EXPECT_LE(compare(RandomPaths({length}, seed, false).system), agreement) << length << ", " << seed;
  }
}

TEST(PathSeries, AgreesWithTheGeneralSolverOnPathsOfAllLengths) {
  EXPECT_LE(compare(RandomPaths({100, 3, 1, 1, 80, 2, 30, 30, 29, 5, 5, 300, 7}, 5, false).system), agreement);
}

TEST(PathSeries, AgreesWithTheGeneralSolverOnRings) {
  for (const std::size_t length : {3, 15, 16, 24, 25, 513, 1030}) {
    for (std::uint32_t seed = 0; seed < 3; ++seed)
      EXPECT_LE(compare(RandomPaths({}, seed, false, {length}).system), agreement) << length << ", " << seed;
  }
  EXPECT_LE(compare(RandomPaths({40, 3, 90}, 4, false, {30, 7, 100}).system), agreement);
}

/// A further solve finds what a solve in lanes leaves, next to nothing.
TEST(PathSeries, MorePassesAgreeToo) {
  for (const int extra_passes : {1, 2}) {
    const System system = RandomPaths({40, 3, 700, 90}, 6, false, {30, 7, 600}).system;
    EXPECT_LE(compare(system, extra_passes), agreement);
    const series::Expanded once(system), more(system, extra_passes);
    for (std::size_t k = 0; k < once.coefficients.size(); ++k) {
      double largest = 0.0, difference = 0.0;
      for (std::size_t i = 0; i < once.coefficients[k].size(); ++i) {
        largest = larger(largest, std::abs(once.coefficients[k][i]));
        difference = larger(difference, std::abs(once.coefficients[k][i] - more.coefficients[k][i]));
      }
      EXPECT_LE(difference, 1e-9 * largest) << k;
    }
  }
}

/// All threads work on a long path together, and each takes some of the others.
TEST(PathSeries, GivesTheSameBitsOnAnyThreads) {
  const System system = RandomPaths({6000, 20, 700, 90, 3000, 5, 400}, 7, false, {5000, 30, 600}).system;
  for (const SeriesDemand& wanted : {SeriesDemand{}, SeriesDemand{.h = 1e-3, .atol = 1e-9, .rtol = 1e-7}}) {
    const series::Expanded one(system, 1, wanted, 1);
    ASSERT_TRUE(one.outcome.ok()) << one.outcome.what;
    for (const int threads : {2, 3}) {
      const series::Expanded other(system, 1, wanted, threads);
      EXPECT_EQ(other.coefficients, one.coefficients);
      EXPECT_EQ(other.extent.last_term, one.extent.last_term);
    }
  }
}

TEST(PathSeries, KnowsTheImagesOfPeriodicPoints) {
  for (const std::size_t length : {1, 10, 90})
    EXPECT_LE(compare(RandomPaths({length, length}, 3, true).system), agreement) << length;
}

}  // namespace
}  // namespace tanor
