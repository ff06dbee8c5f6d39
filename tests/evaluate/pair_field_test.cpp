/// The tests compare pair forces with closed forms, and on grids of points with their own potential.

#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "evaluate/evaluated_pairs.hpp"
#include "evaluate/forces.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

const double root_6_of_2 = std::pow(2.0, 1.0 / 6.0);

// ---- two points ----------------------------------------------------------------------------------------------------

struct ClosedForm {
  const char* what;
  PairForces pairs;
  double distance;   // m
  double repulsion;  // N, pushes the points apart
  double potential;  // J
};

class ClosedFormTest : public testing::TestWithParam<ClosedForm> {};

TEST_P(ClosedFormTest, IsTheForceBetweenTwoPoints) {
  const auto& [what, pairs, distance, repulsion, potential] = GetParam();
  const System system = make_two_points(pairs, distance);

  const PairResult result = PairEvaluator(system)(system.positions);

  const double scale = pairs.law == PairLaw::Log ? 1.0 : 24.0 * pairs.epsilon / pairs.sigma;
  EXPECT_NEAR(result.f[4], repulsion, 1e-14 * scale);
  EXPECT_EQ(result.f[1], -result.f[4]);
  EXPECT_NEAR(result.potential, potential, 1e-14 * scale);
  for (const std::size_t c : {0, 2, 3, 5}) EXPECT_EQ(result.f[c], 0.0);
}

constexpr double epsilon = 1.5, sigma = 0.8;
const PairForces wca{.law = PairLaw::Wca, .epsilon = epsilon, .sigma = sigma};
const PairForces lj{.law = PairLaw::Lj, .epsilon = epsilon, .sigma = sigma, .cutoff = 2.0 * sigma};
const PairForces logarithm{.law = PairLaw::Log, .strength = 0.7};
// The value of the Lennard-Jones potential at 2 sigma.
constexpr double lj_shift = 4.0 * epsilon * (1.0 / 4096 - 1.0 / 64);

INSTANTIATE_TEST_SUITE_P(
    Laws, ClosedFormTest,
    testing::Values(ClosedForm{"wca_at_sigma", wca, sigma, 24.0 * epsilon / sigma, epsilon},
                    ClosedForm{"wca_at_its_cutoff", wca, root_6_of_2* sigma, 0.0, 0.0},
                    ClosedForm{"wca_beyond_its_cutoff", wca, 1.2 * sigma, 0.0, 0.0},
                    ClosedForm{"lj_at_sigma", lj, sigma, 24.0 * epsilon / sigma, -lj_shift},
                    ClosedForm{"lj_at_its_minimum", lj, root_6_of_2* sigma, 0.0, -epsilon - lj_shift},
                    ClosedForm{"lj_before_its_cutoff", lj, 1.9999999999999 * sigma,
                               24.0 * epsilon / (2.0 * sigma) * (2.0 / 4096 - 1.0 / 64), 0.0},
                    ClosedForm{"lj_at_its_cutoff", lj, 2.0 * sigma, 0.0, 0.0},
                    ClosedForm{"log_at_e", logarithm, M_E, 0.7 / M_E, -0.7},
                    ClosedForm{"log_at_2", logarithm, 2.0, 0.35, -0.7 * M_LN2},
                    ClosedForm{"log_at_a_thousandth", logarithm, 1.0 / 1024, 0.7 * 1024, 7.0 * M_LN2}),
    [](const auto& instance) { return instance.param.what; });

TEST(PairFieldTest, CutoffOfLennardJonesIsTwoAndAHalfSigmaByDefault) {
  const PairForces pairs{.law = PairLaw::Lj, .sigma = 2.0};
  const System inside = make_two_points(pairs, 4.999), outside = make_two_points(pairs, 5.001);

  EXPECT_LT(PairEvaluator(inside)(inside.positions).f[4], 0.0);
  EXPECT_EQ(PairEvaluator(outside)(outside.positions).f[4], 0.0);
}

TEST(PairFieldTest, PointsFeelTheNearestImageWhereverTheyAre) {
  PairForces pairs = wca;
  pairs.box = {16.0, 32.0, 0.0};
  System system = make_two_points(pairs, sigma);

  for (const double shift : {-96.0, -32.0, 0.0, 32.0, 64.0}) {
    std::vector<double> places = system.positions;
    places[4] += shift;
    places[3] -= 0.5 * shift;
    const PairResult result = PairEvaluator(system)(places);

    EXPECT_NEAR(result.f[4], 24.0 * epsilon / sigma, 1e-11) << shift;
    EXPECT_EQ(result.f[3], 0.0);
  }
  system.positions[5] += 32.0;  // this axis is not periodic
  EXPECT_EQ(PairEvaluator(system)(system.positions).f[4], 0.0);
}

// ---- grids ----------------------------------------------------------------------------------------------------------

/// Makes a shaken periodic grid of `count`^3 points at the density of a melt, with rods along one axis and one support.
System make_grid(int count, PairLaw law) {
  System system = scenes::make_shaken_grid({count, count, count}, 1.06, 7);
  Rods rods;
  for (Index point = 0; point < count * count * count; ++point) {
    if (point % count > 0) rods.pairs.push_back({point - 1, point});
  }
  system.constraints = {rods};
  system.supports = {{"", {1}, {}}};
  PairForces pairs{.law = law, .exclude_rods = true};
  if (law != PairLaw::Log) pairs.box = {1.06 * count, 1.06 * count, 1.06 * count};
  system.forces = {pairs};
  return system;
}

/// Makes few points, none of which crosses the cutoff of Lennard-Jones, where the force jumps.
System make_smooth_grid(PairLaw law) {
  System system = make_grid(4, law);
  auto& pairs = std::get<PairForces>(system.forces[0]);
  if (law == PairLaw::Lj) {
    pairs.cutoff = 20.0;
    pairs.box = {};
  }
  return system;
}

class LawTest : public testing::TestWithParam<PairLaw> {};

TEST_P(LawTest, AnyNumberOfThreadsGivesTheSameBits) {
  const System system = make_grid(14, GetParam());

  const PairResult one = PairEvaluator(system, 1)(system.positions);

  EXPECT_TRUE(std::isfinite(one.potential));
  for (const int threads : {2, 3, 5}) EXPECT_TRUE(one == PairEvaluator(system, threads)(system.positions)) << threads;
}

/// Earlier places have no effect, so that a resumed run goes on bit by bit.
TEST_P(LawTest, EarlierPlacesLeaveNoTrace) {
  const System system = make_grid(8, GetParam());
  std::mt19937 random(3);
  std::normal_distribution<double> move(0.0, 0.03);
  PairEvaluator field(system);
  std::vector<double> r = system.positions;

  for (int k = 0; k < 20; ++k) {
    for (double& x : r) x += move(random);
    EXPECT_TRUE(field(r) == PairEvaluator(system)(r)) << "move " << k;
  }
}

TEST_P(LawTest, ForceIsMinusTheSlopeOfThePotential) {
  const System system = make_smooth_grid(GetParam());
  const PairResult result = PairEvaluator(system)(system.positions);
  PairEvaluator field(system);
  const auto potential = [&](std::size_t c, double e) {
    std::vector<double> r = system.positions;
    r[c] += e;
    return field(r).potential;
  };

  for (std::size_t c = 6; c < 30; ++c) {
    // By Richardson's extrapolation central differences of h and h/2 make one of fourth order.
    constexpr double h = 1e-3;
    const auto difference = [&](double e) { return (potential(c, e) - potential(c, -e)) / (2.0 * e); };
    const double slope = (4.0 * difference(0.5 * h) - difference(h)) / 3.0;

    EXPECT_NEAR(slope, -result.f[c], 1e-7 * std::max(1.0, std::abs(result.f[c]))) << "coordinate " << c;
  }
}

TEST_P(LawTest, PotentialGrowsByTheWorkOfMovingPointsAndOfSupports) {
  const System system = make_smooth_grid(GetParam());
  const Numbering numbering = number(system);
  Forces forces(system, numbering);
  std::mt19937 random(3);
  std::normal_distribution<double> component;
  std::vector<double> r(system.positions.size()), v(r.size()), f(r.size());
  numbering.gather_points(system.positions, r);
  for (double& x : v) x = component(random);
  const Parallel parallel(1);
  const auto potential = [&](double e) {
    std::vector<double> moved = r;
    for (std::size_t c = 0; c < r.size(); ++c) moved[c] += e * v[c];
    return forces.potential(parallel, 0.0, moved.data());
  };

  forces.evaluate(parallel, 0.0, r.data(), v.data(), f.data());
  const double by_supports = forces.elastic_power_of_supports(parallel, r.data(), v.data());

  double by_points = 0.0;
  for (std::size_t c = 0; c < 3 * numbering.num_moving; ++c) by_points -= f[c] * v[c];
  constexpr double h = 1e-4;
  const auto difference = [&](double e) { return (potential(e) - potential(-e)) / (2.0 * e); };
  EXPECT_NEAR((4.0 * difference(0.5 * h) - difference(h)) / 3.0, by_points + by_supports,
              1e-6 * (std::abs(by_points) + std::abs(by_supports)));
  EXPECT_GT(std::abs(by_supports), 1e-3 * std::abs(by_points)) << "a support without a part in it proves nothing";
}

std::string name_law(const testing::TestParamInfo<PairLaw>& law) {
  return law.param == PairLaw::Wca ? "wca" : law.param == PairLaw::Lj ? "lj" : "log";
}

INSTANTIATE_TEST_SUITE_P(Laws, LawTest, testing::Values(PairLaw::Wca, PairLaw::Lj, PairLaw::Log), name_law);

/// The third point is far from the others, and cells over the space between would be far more than there are points.
TEST(PairFieldTest, PointsFarApartNeedNoMemoryForTheSpaceBetween) {
  System system = make_two_points(wca, sigma);
  system.positions.insert(system.positions.end(), {1e9, 1e9, -1e9});
  system.masses.push_back(1.0);

  const PairResult result = PairEvaluator(system)(system.positions);

  EXPECT_NEAR(result.f[4], 24.0 * epsilon / sigma, 1e-11);
  EXPECT_EQ(result.f[6], 0.0);
}

TEST(PairFieldTest, ForcesOfCoincidentAndLostPointsAreNan) {
  for (const PairForces& pairs : {wca, lj, logarithm}) {
    const System on_top = make_two_points(pairs, 0.0), lost = make_two_points(pairs, NAN);

    EXPECT_TRUE(std::isnan(PairEvaluator(on_top)(on_top.positions).f[4]));
    EXPECT_TRUE(std::isnan(PairEvaluator(lost)(lost.positions).f[4]));
  }
}

/// The sum over thousands of points, (N - 1)/2 outwards on the unit sphere, is good to a few roundings of its terms.
TEST(PairFieldTest, LogarithmicForcesOfThousandsAreGoodToAFewRoundings) {
  constexpr int count = 3000;
  std::mt19937 random(5);
  std::normal_distribution<double> component;
  System system;
  for (int i = 0; i < count; ++i) {
    const Vec3 place{component(random), component(random), component(random)};
    const Vec3 unit = (1.0 / norm(place)) * place;
    system.positions.insert(system.positions.end(), {unit.x, unit.y, unit.z});
    system.masses.push_back(1.0);
  }
  system.forces = {PairForces{.law = PairLaw::Log}};

  const PairResult result = PairEvaluator(system, 2)(system.positions);

  for (int i = 0; i < count; i += 100) {
    std::array<long double, 3> sum{};
    long double scale = 0.0;
    for (int j = 0; j < count; ++j) {
      if (i == j) continue;
      std::array<long double, 3> d;
      for (int k = 0; k < 3; ++k)
        d[k] = static_cast<long double>(system.positions[3 * i + k]) - system.positions[3 * j + k];
      const long double r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
      for (int k = 0; k < 3; ++k) sum[k] += d[k] / r2;
      scale += 1.0L / sqrtl(r2);
    }
    for (int k = 0; k < 3; ++k) EXPECT_LE(std::abs(result.f[3 * i + k] - sum[k]), 4e-16 * scale) << i;
  }
}

/// Points of an excluded rod may meet, since no energy is unbounded there.
TEST(PairFieldTest, OnlyPairsThatFeelEachOtherCollide) {
  for (const std::optional<double> cutoff : {std::optional<double>(), std::optional(2.0)}) {
    PairForces pull{.law = PairLaw::Yukawa, .cutoff = cutoff, .strength = -1.0, .length = 0.7};
    System system = make_two_points(pull, 0.1);
    system.constraints = {Rods{"rods", {{0, 1}}}};
    const std::vector<double> v = {0, 1, 0, 0, -1, 0};  // they meet after 0.05 s
    for (const bool is_excluded : {false, true}) {
      pull.exclude_rods = is_excluded;
      const Numbering numbering = number(system);
      PairField field(system, pull, numbering);
      std::vector<double> r(6), own_v(6), f(6, 0.0);
      numbering.gather_points(system.positions, r);
      numbering.gather_points(v, own_v);
      field.add_forces(Parallel(1), r.data(), f.data());

      const std::optional<PairField::Collision> found = field.find_collision(r.data(), own_v.data(), 0.06);

      EXPECT_EQ(found.has_value(), !is_excluded) << cutoff.has_value();
      EXPECT_FALSE(field.find_collision(r.data(), own_v.data(), 0.04)) << cutoff.has_value();
    }
  }
}

}  // namespace
}  // namespace tanor
