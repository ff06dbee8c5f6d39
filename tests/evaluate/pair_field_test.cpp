/// The tests compare pair forces with closed forms and with a plain double loop over all pairs, in extended precision.

#include "evaluate/pair_field.hpp"

#include <cmath>
#include <optional>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "evaluate/forces.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

const double root_6_of_2 = std::pow(2.0, 1.0 / 6.0);

/// The forces on all points, in the user's order, and the potential.
struct Result {
  std::vector<double> f;
  double potential = 0.0;
  bool operator==(const Result&) const = default;
};

/// Evaluates a system's only group of pair forces at places in the user's order. It reuses its state between calls.
class Field {
 public:
  explicit Field(const System& system, int threads = 1)
      : numbering_(number(system)),
        field_(system, std::get<PairForces>(system.forces[0]), numbering_),
        of_supports_(system, std::get<PairForces>(system.forces[0]), numbering_, PairField::Which::OfSupports),
        parallel_(threads) {}

  Result operator()(const std::vector<double>& places) {
    std::vector<double> r(places.size()), f(places.size(), 0.0);
    numbering_.gather_points(places, r);
    field_.add_forces(parallel_, r.data(), f.data());
    if (!of_supports_.empty()) of_supports_.add_forces(parallel_, r.data(), f.data());
    Result result{std::vector<double>(places.size()), field_.potential(parallel_, r.data())};
    numbering_.scatter_points(f, result.f);
    return result;
  }

 private:
  Numbering numbering_;
  PairField field_, of_supports_;
  Parallel parallel_;
};

System make_pair(const PairForces& pairs, double distance) {
  System system;
  system.positions = {1.0, 2.0, 3.0, 1.0, 2.0 + distance, 3.0};
  system.masses = {1.0, 1.0};
  system.forces = {pairs};
  return system;
}

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
  const System system = make_pair(pairs, distance);

  const Result result = Field(system)(system.positions);

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
  const System inside = make_pair(pairs, 4.999), outside = make_pair(pairs, 5.001);

  EXPECT_LT(Field(inside)(inside.positions).f[4], 0.0);
  EXPECT_EQ(Field(outside)(outside.positions).f[4], 0.0);
}

TEST(PairFieldTest, PointsFeelTheNearestImageWhereverTheyAre) {
  PairForces pairs = wca;
  pairs.box = {16.0, 32.0, 0.0};
  System system = make_pair(pairs, sigma);

  for (const double shift : {-96.0, -32.0, 0.0, 32.0, 64.0}) {
    std::vector<double> places = system.positions;
    places[4] += shift;
    places[3] -= 0.5 * shift;
    const Result result = Field(system)(places);

    EXPECT_NEAR(result.f[4], 24.0 * epsilon / sigma, 1e-11) << shift;
    EXPECT_EQ(result.f[3], 0.0);
  }
  system.positions[5] += 32.0;  // this axis is not periodic
  EXPECT_EQ(Field(system)(system.positions).f[4], 0.0);
}

// ---- many points ---------------------------------------------------------------------------------------------------

/// The force on a point by the plain formula, and the sum of the rounding errors that its pairs may have.
struct Plain {
  std::array<long double, 3> force{};
  long double potential = 0.0, largest_error = 0.0;
};

/// Evaluates the pairs in a double loop, with images by the standard library's remainder.
std::vector<Plain> evaluate_plainly(const System& system, const std::vector<double>& r) {
  using Real = long double;
  const auto& pairs = std::get<PairForces>(system.forces[0]);
  const auto n = static_cast<Index>(system.num_points());
  std::vector<char> takes_part(n, pairs.points.empty()), is_support(n, false);
  for (const Index i : pairs.points) takes_part[i] = true;
  for (const Support& support : system.supports)
    for (const Index i : support.points) is_support[i] = true;
  const auto are_joined = [&](Index i, Index j) {
    for (const Constraint& constraint : system.constraints)
      for (const auto& [a, b] : std::get<Rods>(constraint).pairs)
        if ((a == i && b == j) || (a == j && b == i)) return true;
    return false;
  };
  const Real cutoff =
      pairs.law == PairLaw::Wca ? powl(2, 1 / 6.0L) * pairs.sigma : pairs.cutoff.value_or(2.5 * pairs.sigma);
  const auto lennard_jones = [&](Real distance) {
    const Real s6 = powl(pairs.sigma / distance, 6);
    return 4 * pairs.epsilon * (s6 * s6 - s6);
  };
  std::vector<Plain> result(n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      if (i == j || !takes_part[i] || !takes_part[j]) continue;
      if (pairs.exclude_rods && are_joined(i, j)) continue;
      std::array<Real, 3> d;
      Real largest = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        d[k] = static_cast<Real>(r[3 * i + k]) - r[3 * j + k];
        largest = std::max({largest, std::abs(static_cast<Real>(r[3 * i + k])), std::abs(d[k])});
        if (pairs.box[k] > 0.0) d[k] = remainderl(d[k], pairs.box[k]);
      }
      const Real distance = sqrtl(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      Real pull = 0.0, potential = 0.0, size = 0.0;
      if (pairs.law == PairLaw::Log) {
        pull = size = pairs.strength / distance;
        potential = -pairs.strength * logl(distance);
      } else if (distance < cutoff) {
        const Real s6 = powl(pairs.sigma / distance, 6);
        pull = 24 * pairs.epsilon / distance * (2 * s6 * s6 - s6);
        size = 24 * pairs.epsilon / distance * (2 * s6 * s6 + s6);
        potential = lennard_jones(distance) - lennard_jones(cutoff);
      }
      for (std::size_t k = 0; k < 3; ++k) result[i].force[k] += pull * d[k] / distance;
      if (!is_support[i] || !is_support[j]) result[i].potential += potential / 2;
      // The bound is 20 roundings and those of the distance, which its 14th power enlarges.
      result[i].largest_error += 1.1e-16L * std::abs(size) * (20 + 14 * 4 * largest / distance);
    }
  }
  return result;
}

/// Makes points all over a box and its images, with rods, supports and a law.
System make_random_pairs(std::size_t num_points, std::mt19937& random) {
  const auto uniform = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const auto any_point = [&] { return static_cast<Index>(random() % num_points); };
  System system;
  PairForces pairs;
  pairs.law = std::array{PairLaw::Wca, PairLaw::Lj, PairLaw::Log}[random() % 3];
  pairs.epsilon = uniform(0.1, 3.0);
  pairs.sigma = uniform(0.5, 1.5);
  pairs.strength = uniform(-2.0, 2.0);
  pairs.exclude_rods = random() % 2;
  if (random() % 2) pairs.cutoff = uniform(0.8, 3.0) * pairs.sigma;
  const double extent = uniform(2.0, 12.0);
  for (double& edge : pairs.box) {
    if (pairs.law != PairLaw::Log && random() % 3) edge = uniform(5.0, 12.0) * pairs.sigma;
    if (pairs.cutoff && edge > 0.0) edge = std::max(edge, 2.0 * *pairs.cutoff);
  }
  for (std::size_t i = 0; i < num_points; ++i) {
    for (int k = 0; k < 3; ++k) system.positions.push_back(uniform(-extent, extent));
    system.masses.push_back(1.0);
    if (random() % 5 == 0) system.supports.push_back({"", {static_cast<Index>(i)}, {}});
    if (random() % 4) pairs.points.push_back(static_cast<Index>(num_points - 1 - i));
  }
  if (random() % 2) pairs.points.clear();
  Rods rods;
  for (std::size_t k = 0; k < num_points / 2; ++k) {
    const Index i = any_point(), j = any_point();
    if (i != j) rods.pairs.push_back({i, j});
  }
  system.constraints = {rods};
  system.forces = {pairs};
  return system;
}

RC_GTEST_PROP(PairField, AgreesWithADoubleLoopWhileThePointsMove, ()) {
  const auto num_points = *rc::gen::inRange<std::size_t>(2, 120).as("points");
  std::mt19937 random(*rc::gen::noShrink(rc::gen::arbitrary<std::uint32_t>()).as("seed"));
  const System system = make_random_pairs(num_points, random);
  Field field(system);
  std::vector<double> r = system.positions;
  for (const double move : {0.0, 0.01, 0.05, 0.05, 0.1, 1.0, 0.02}) {
    for (double& x : r) x += std::uniform_real_distribution<double>(-move, move)(random);

    const Result result = field(r);

    const std::vector<Plain> expected = evaluate_plainly(system, r);
    long double potential = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < num_points; ++i) {
      potential += expected[i].potential;
      scale += expected[i].largest_error;
      for (std::size_t k = 0; k < 3; ++k) {
        RC_ASSERT(std::abs(result.f[3 * i + k] - expected[i].force[k]) <= expected[i].largest_error);
      }
    }
    RC_ASSERT(std::abs(result.potential - potential) <= 20.0 * scale + 1e-12);
  }
}

RC_GTEST_PROP(PairField, TakesAsMuchMomentumAsItGives, ()) {
  const auto num_points = *rc::gen::inRange<std::size_t>(2, 120).as("points");
  std::mt19937 random(*rc::gen::noShrink(rc::gen::arbitrary<std::uint32_t>()).as("seed"));
  const System system = make_random_pairs(num_points, random);

  const Result result = Field(system)(system.positions);

  long double scale = 0.0;
  std::array<long double, 3> sum{};
  for (const Plain& plain : evaluate_plainly(system, system.positions)) scale += plain.largest_error;
  for (std::size_t c = 0; c < result.f.size(); ++c) sum[c % 3] += result.f[c];
  for (const long double component : sum) RC_ASSERT(std::abs(component) <= scale);
}

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

  const Result one = Field(system, 1)(system.positions);

  EXPECT_TRUE(std::isfinite(one.potential));
  for (const int threads : {2, 3, 5}) EXPECT_TRUE(one == Field(system, threads)(system.positions)) << threads;
}

/// Earlier places have no effect, so that a resumed run goes on bit by bit.
TEST_P(LawTest, EarlierPlacesLeaveNoTrace) {
  const System system = make_grid(8, GetParam());
  std::mt19937 random(3);
  std::normal_distribution<double> move(0.0, 0.03);
  Field field(system);
  std::vector<double> r = system.positions;

  for (int k = 0; k < 20; ++k) {
    for (double& x : r) x += move(random);
    EXPECT_TRUE(field(r) == Field(system)(r)) << "move " << k;
  }
}

TEST_P(LawTest, ForceIsMinusTheSlopeOfThePotential) {
  const System system = make_smooth_grid(GetParam());
  const Result result = Field(system)(system.positions);
  Field field(system);
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
  System system = make_pair(wca, sigma);
  system.positions.insert(system.positions.end(), {1e9, 1e9, -1e9});
  system.masses.push_back(1.0);

  const Result result = Field(system)(system.positions);

  EXPECT_NEAR(result.f[4], 24.0 * epsilon / sigma, 1e-11);
  EXPECT_EQ(result.f[6], 0.0);
}

TEST(PairFieldTest, ForcesOfCoincidentAndLostPointsAreNan) {
  for (const PairForces& pairs : {wca, lj, logarithm}) {
    const System on_top = make_pair(pairs, 0.0), lost = make_pair(pairs, NAN);

    EXPECT_TRUE(std::isnan(Field(on_top)(on_top.positions).f[4]));
    EXPECT_TRUE(std::isnan(Field(lost)(lost.positions).f[4]));
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

  const Result result = Field(system, 2)(system.positions);

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

/// For few points and laws with a definition over a scalar type, the sums by hand are those of the single pairs.
TEST(SmoothPairTest, ForcesByHandAreThoseOfTheDefinition) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  System system;
  std::vector<double> charges;
  for (int i = 0; i < 12; ++i) {
    for (int axis = 0; axis < 3; ++axis) system.positions.push_back(uniform(random));
    charges.push_back(uniform(random));
  }
  system.masses.assign(12, 1.0);
  system.supports = {Support{"", {3, 8}}};
  system.constraints = {Rods{"rods", {{0, 1}, {1, 2}}}};
  const PairForces laws[] = {
      {.law = PairLaw::Coulomb, .strength = -2.0, .exclude_rods = true, .charges = charges},
      {.points = {5, 2, 8, 3, 1}, .law = PairLaw::Coulomb, .strength = 1.5, .charges = {1.0, 2.0, 3.0, 4.0, 5.0}},
      {.law = PairLaw::Yukawa, .strength = 0.7, .length = 0.6},
      {.law = PairLaw::Morse, .depth = 0.4, .width = 1.3, .rest_length = 0.8}};
  for (const PairForces& pairs : laws) {
    system.forces = {pairs};
    const Numbering numbering = number(system);
    PairField field(system, pairs, numbering);
    const PotentialFamily family(make_pair_energies(system, pairs), numbering);
    std::vector<double> r(36), f(36, 0.0), by_pair(6 * family.size()), rates(family.size()), energies(family.size()),
        wanted(36, 0.0);
    numbering.gather_points(system.positions, r);
    field.add_forces(Parallel(1), r.data(), f.data());
    family.evaluate_forces(Parallel(1), 0.0, r.data(), by_pair.data(), rates.data());
    family.evaluate_energies(Parallel(1), 0.0, r.data(), energies.data());
    double energy = 0.0, largest = 0.0;
    for (std::size_t k = 0; k < family.size(); ++k) {
      energy += energies[k];
      for (std::size_t i = 0; i < 2; ++i)
        add_to(wanted.data(), family.point(k, i), load(by_pair.data(), i * family.size() + k));
    }
    for (const double x : wanted) largest = std::max(largest, std::abs(x));
    EXPECT_NEAR(field.potential(Parallel(1), r.data()), energy, 1e-13 * (std::abs(energy) + 1.0));
    for (std::size_t i = 0; i < 36; ++i)
      EXPECT_NEAR(f[i], wanted[i], 1e-13 * largest) << static_cast<int>(pairs.law) << i;
  }
}

/// Points of an excluded rod may meet, since no energy is unbounded there.
TEST(PairFieldTest, OnlyPairsThatFeelEachOtherCollide) {
  for (const std::optional<double> cutoff : {std::optional<double>(), std::optional(2.0)}) {
    PairForces pull{.law = PairLaw::Yukawa, .cutoff = cutoff, .strength = -1.0, .length = 0.7};
    System system = make_pair(pull, 0.1);
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

/// The law is cut and shifted in a periodic box, where the force is that of the nearest images within the cutoff.
TEST(SmoothPairTest, ACutoffShiftsTheEnergy) {
  for (const PairForces& pairs :
       {PairForces{.law = PairLaw::Yukawa, .cutoff = 1.5, .strength = 2.0, .box = {4, 4, 4}, .length = 0.5},
        PairForces{
            .law = PairLaw::Morse, .cutoff = 1.5, .box = {4, 4, 4}, .depth = 1.2, .width = 2.0, .rest_length = 1.0}}) {
    const System system = make_pair(pairs, 3.2);  // the distance to the image is 0.8
    const Numbering numbering = number(system);
    PairField field(system, pairs, numbering);
    std::vector<double> r(6), f(6, 0.0);
    numbering.gather_points(system.positions, r);
    field.add_forces(Parallel(1), r.data(), f.data());
    const auto u = [&](double x) { return KindOf<PairForces>::smooth_energy(pairs, x, 1.0); };
    const double e = 1e-6, force = -(u(0.8 + e) - u(0.8 - e)) / (2.0 * e);
    EXPECT_NEAR(field.potential(Parallel(1), r.data()), u(0.8) - u(1.5), 1e-14);
    EXPECT_NEAR(std::abs(f[0]) + std::abs(f[1]) + std::abs(f[2]), std::abs(force), 1e-8);
  }
}

}  // namespace
}  // namespace tanor
