/// A host runs velocity Verlet with a Constrainer: energy, time reversal, bits, redundant constraints.

#include <gtest/gtest.h>
#include <tanor/velocity_verlet.hpp>

#include <limits>
#include <utility>

#include "host/velocity_verlet.hpp"

namespace tanor::host {
namespace {

struct EnergyRun {
  double trend, largest;  // of the energy over the run, over the largest kinetic energy
};

/// Fits the trend of the energy by least squares over all steps.
EnergyRun run_energy(Host* host, double h, int num_steps) {
  host->start();
  EXPECT_TRUE(host->outcome.ok()) << host->outcome.what;
  const double at_start = host->energy();
  double kinetic = host->kinetic(), largest = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (int k = 0; k < num_steps; ++k) {
    EXPECT_TRUE(host->step(h)) << host->outcome.what << " in step " << k;
    if (!host->outcome.ok()) break;
    const double x = k, y = host->energy() - at_start;
    kinetic = std::max(kinetic, host->kinetic());
    largest = std::max(largest, std::abs(y));
    sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const double n = num_steps, slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {slope * n / kinetic, largest / kinetic};
}

constexpr int many = 100'000;

void expect_energy_kept(Host* host, double h, const EnergyRun& allowed) {
  const EnergyRun run = run_energy(host, h, many);
  EXPECT_LE(std::abs(run.trend), allowed.trend);
  EXPECT_LE(run.largest, allowed.largest);
  EXPECT_LE(host->violation, 1e-13);
}

TEST(VelocityVerlet, KeepsTheEnergyOfAPendulumFromTheHorizontal) {
  Host host = make_hanging_chain(1, 1.0, 1.0, 1.0, 0.0);
  host.set_gravity(9.81);

  expect_energy_kept(&host, 1e-3, {.trend = 1e-7, .largest = 1e-5});
}

TEST(VelocityVerlet, KeepsTheEnergyOfADoublePendulum) {
  Host host = make_hanging_chain(2, 1.0, 1.0, std::sin(0.3), -std::cos(0.3));
  host.set_gravity(9.81);

  expect_energy_kept(&host, 2e-3, {.trend = 1e-7, .largest = 2e-5});
}

TEST(VelocityVerlet, KeepsTheEnergyOfTwentyHangingRods) {
  Host host = make_hanging_chain(20, 0.1, 0.1, 0.0, -1.0);
  host.set_gravity(9.81);
  for (std::size_t i = 0; i <= 20; ++i) {
    const double s = static_cast<double>(i);
    host.v[3 * i] = 0.5 * s / 20.0;
    host.v[3 * i + 2] = i > 0 ? 0.3 * std::sin(0.3 * s) : 0.0;
  }

  expect_energy_kept(&host, 1e-3, {.trend = 1e-7, .largest = 5e-5});
}

TEST(VelocityVerlet, KeepsTheEnergyOfAFreeThermalChain) {
  std::vector<double> r;
  for (int i = 0; i < 10; ++i) r.insert(r.end(), {std::cos(0.6) * i, i % 2 == 1 ? std::sin(0.6) : 0.0, 0.0});
  Host host(std::vector<double>(10, 1.0), r, {make_chain_of_rods(10)});
  host.set_well(1.0);
  unsigned random = 12345;
  for (double& v : host.v) {
    random = random * 1664525U + 1013904223U;
    v = static_cast<double>(random >> 8U) / (1 << 24) * 2.0 - 1.0;
  }

  expect_energy_kept(&host, 5e-3, {.trend = 5e-6, .largest = 5e-4});
}

// ---- redundant constraints ----

TEST(VelocityVerlet, CarriesMethaneWithAllTenDistances) {
  const double a = 0.629;
  Host host({12.0, 1.0, 1.0, 1.0, 1.0}, {0, 0, 0, a, a, a, a, -a, -a, -a, a, -a, -a, -a, a}, {make_all_distances(5)});
  host.set_well(1.0, false);
  for (std::size_t k = 0; k < 15; ++k) host.v[k] = std::sin(3.0 * static_cast<double>(k) + 1.0);

  const EnergyRun run = run_energy(&host, 2e-3, many);

  EXPECT_LE(run.largest, 1e-5);
  EXPECT_LE(host.violation, 1e-13);
  EXPECT_EQ(host.constrainer.rank(host.r).rank, 9U);
}

/// The case of openmm#3603 is two triangles on one side.
TEST(VelocityVerlet, CarriesADiamondOfFiveRods) {
  Rods rods{"rods", {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 2}}, {}, {}};
  Host host({1.0, 2.0, 1.5, 1.0}, {0, 0, 0, 0.8, 0.5, 0, 1.6, 0, 0.1, 0.8, -0.6, 0}, {rods});
  host.set_well(1.0, false);
  for (std::size_t k = 0; k < 12; ++k) host.v[k] = std::sin(3.0 * static_cast<double>(k) + 1.0);

  const EnergyRun run = run_energy(&host, 2e-3, many);

  EXPECT_LE(run.largest, 1e-4);
  EXPECT_LE(host.violation, 1e-13);
}

// ---- many chains ----

Host make_hanging_chains(std::size_t num_chains, int threads) {
  constexpr std::size_t num_points = 101;
  std::vector<double> r;
  std::vector<Constraint> constraints;
  Rods all{"rods", {}, {}, {}};
  for (std::size_t c = 0; c < num_chains; ++c) {
    for (std::size_t i = 0; i < num_points; ++i)
      r.insert(r.end(), {0.8 * static_cast<double>(i), i % 2 == 1 ? 0.6 : 0.0, 3.0 * static_cast<double>(c)});
    const Rods own = make_chain_of_rods(num_points, static_cast<Index>(c * num_points));
    all.pairs.insert(all.pairs.end(), own.pairs.begin(), own.pairs.end());
  }
  return {std::vector<double>(r.size() / 3, 1.0), r, {all}, {.threads = threads}};
}

void set_springs_to_start(Host* host) {
  host->set_forces = [at_start = host->r](const std::vector<double>& r, std::vector<double>* f) {
    for (std::size_t k = 0; k < r.size(); ++k) (*f)[k] = -0.3 * (r[k] - at_start[k]);
  };
  for (std::size_t k = 0; k < host->v.size(); ++k) host->v[k] = std::sin(1.0 + 7.3 * static_cast<double>(k));
}

TEST(VelocityVerlet, GoesBackTheWayItCame) {
  constexpr int num_steps = 500;
  Host host = make_hanging_chains(100, 1);
  set_springs_to_start(&host);
  const std::vector<double> at_start = host.r;
  host.start();
  for (int k = 0; k < num_steps; ++k) ASSERT_TRUE(host.step(2e-3)) << host.outcome.what;

  for (double& v : host.v) v = -v;
  for (int k = 0; k < num_steps; ++k) ASSERT_TRUE(host.step(2e-3)) << host.outcome.what;

  double largest = 0.0;
  for (std::size_t k = 0; k < host.r.size(); ++k) largest = std::max(largest, std::abs(host.r[k] - at_start[k]));
  EXPECT_LE(largest, 1e-10);
}

TEST(VelocityVerlet, HasTheSameBitsWithOneAndTwoThreads) {
  std::vector<double> states[2];
  for (const int threads : {1, 2}) {
    Host host = make_hanging_chains(100, threads);
    set_springs_to_start(&host);
    host.start();
    for (int k = 0; k < 20; ++k) ASSERT_TRUE(host.step(2e-3)) << host.outcome.what;
    std::vector<double> lambda(host.constrainer.num_rows()), w(host.r.size());
    const ConstraintReport report = host.constrainer.solve({.positions = host.r,
                                                            .velocities = host.v,
                                                            .forces = host.f,
                                                            .accelerations = w,
                                                            .wanted = {.multipliers = lambda}});
    std::vector<double>& state = states[threads - 1];
    for (const auto& array : {host.r, host.v, lambda, w}) state.insert(state.end(), array.begin(), array.end());
    state.insert(state.end(), report.virial.begin(), report.virial.end());
  }
  EXPECT_EQ(states[0], states[1]);
}

/// A step needs one factorization: positions, velocities and an instant in the same configuration share it.
TEST(VelocityVerlet, FactorizesOnceAStep) {
  Host host = make_hanging_chains(3, 1);
  set_springs_to_start(&host);
  host.start();
  ASSERT_TRUE(host.step(2e-3));
  const std::size_t before = host.constrainer.counters().factorizations;

  for (int k = 0; k < 10; ++k) {
    ASSERT_TRUE(host.step(2e-3));
    ASSERT_TRUE(host.constrainer.solve({.positions = host.r, .velocities = host.v, .forces = host.f}).outcome.ok());
  }

  EXPECT_EQ(host.constrainer.counters().factorizations, before + 10);
}

/// Measurements, and what a call may keep from another one, change no bit of the motion.
TEST(VelocityVerlet, IsTheSameWithAFreshHandleEachStep) {
  Host host = make_hanging_chains(2, 1), fresh = make_hanging_chains(2, 1);
  for (Host* const each : {&host, &fresh}) {
    set_springs_to_start(each);
    each->start();
  }
  host.measures = true;
  for (int k = 0; k < 10; ++k) {
    ASSERT_TRUE(host.step(2e-3));
    Host next = make_hanging_chains(2, 1);
    next.set_forces = fresh.set_forces;
    next.v = fresh.v;
    next.f = fresh.f;
    next.r = fresh.r;
    ASSERT_TRUE(next.step(2e-3));
    fresh.r = next.r;
    fresh.v = next.v;
    fresh.f = next.f;
  }
  for (std::size_t k = 0; k < host.r.size(); ++k) ASSERT_NEAR(host.r[k], fresh.r[k], 1e-12);
}

// ---- the loop of the library ----

VelocityVerlet loop_of(Host* host, double step, std::size_t steps) {
  return {.step = step,
          .steps = steps,
          .positions = host->r,
          .velocities = host->v,
          .forces = host->f,
          .set_forces = [host](double) { host->set_forces(host->r, &host->f); }};
}

TEST(Run, HasTheBitsOfTheLoopByHand) {
  Host by_hand = make_hanging_chains(2, 1), host = make_hanging_chains(2, 1);
  for (Host* const each : {&by_hand, &host}) {
    set_springs_to_start(each);
    each->start();
  }
  VelocityVerlet loop = loop_of(&host, 2e-3, 20);
  loop.time = 5.0;
  std::vector<double> times;
  loop.observe = [&](const VelocityVerletProgress& now) {
    EXPECT_TRUE(by_hand.step(2e-3));
    EXPECT_EQ(host.r, by_hand.r);
    EXPECT_EQ(host.v, by_hand.v);
    EXPECT_LE(now.positions.violation, 1e-13);
    EXPECT_TRUE(now.velocities.outcome.ok());
    times.push_back(now.time);
    return now.steps < 12;
  };

  const VelocityVerletReport report = run(&host.constrainer, loop);

  EXPECT_TRUE(report.outcome.ok());
  EXPECT_EQ(report.steps, 12U);
  ASSERT_EQ(times.size(), 12U);
  EXPECT_DOUBLE_EQ(report.time, 5.024);
  EXPECT_EQ(times.back(), report.time);
}

TEST(Run, TakesTheMassesThatAnObserverSets) {
  Host by_hand = make_hanging_chains(2, 1), host = make_hanging_chains(2, 1);
  for (Host* const each : {&by_hand, &host}) {
    set_springs_to_start(each);
    each->start();
  }
  const std::vector<Index> points{3, 17};
  const std::vector<double> masses{5.0, 0.25};
  VelocityVerlet loop = loop_of(&host, 2e-3, 10);
  loop.observe = [&](const VelocityVerletProgress& now) {
    EXPECT_TRUE(by_hand.step(2e-3));
    EXPECT_EQ(host.r, by_hand.r) << "after step " << now.steps;
    if (now.steps == 5) {
      for (Host* const each : {&by_hand, &host}) each->constrainer.set_masses(points, masses);
      for (std::size_t k = 0; k < points.size(); ++k) by_hand.masses[static_cast<std::size_t>(points[k])] = masses[k];
    }
    return true;
  };

  const VelocityVerletReport report = run(&host.constrainer, loop);

  EXPECT_TRUE(report.outcome.ok()) << report.outcome.what;
  EXPECT_EQ(report.steps, 10U);
}

TEST(Run, EndsWithTheLastGoodStep) {
  Host host = make_hanging_chains(2, 1);
  set_springs_to_start(&host);
  host.start();
  VelocityVerlet loop = loop_of(&host, 2e-3, 20);
  std::vector<double> r, v, f;
  loop.observe = [&](const VelocityVerletProgress& now) {
    r = host.r, v = host.v, f = host.f;
    return now.steps < 20;
  };
  const auto set_forces = std::exchange(loop.set_forces, {});
  int calls = 0;
  loop.set_forces = [&](double time) {
    set_forces(time);
    if (++calls == 8) host.f[4] = std::numeric_limits<double>::quiet_NaN();
  };

  const VelocityVerletReport report = run(&host.constrainer, loop);

  EXPECT_EQ(report.outcome.status, Status::NotFinite);
  EXPECT_EQ(report.steps, 7U);
  EXPECT_EQ(host.r, r);
  EXPECT_EQ(host.v, v);
  EXPECT_EQ(host.f, f);
}

TEST(Run, ComplainsBeforeAnythingMoves) {
  Host host = make_hanging_chains(1, 1);
  const std::vector<double> r = host.r;
  std::fill(host.v.begin(), host.v.end(), 1.0);
  EXPECT_THROW((void)run(&host.constrainer, loop_of(&host, 0.0, 1)), InputError);
  VelocityVerlet loop = loop_of(&host, 1e-3, 1);
  loop.forces = {};
  EXPECT_THROW((void)run(&host.constrainer, loop), InputError);
  EXPECT_EQ(host.r, r);
}

}  // namespace
}  // namespace tanor::host
