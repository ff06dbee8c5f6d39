/// A Constrainer works on a host's own arrays: strides, strangers, failures, motion from outside.

#include <gtest/gtest.h>

#include <array>
#include <numeric>
#include <thread>

#include "errors.hpp"
#include "host/velocity_verlet.hpp"
#include "measures.hpp"

namespace tanor::host {
namespace {

/// A zigzag of four points and a pendulum on a support, which no constraint joins to it.
struct Pair {
  std::vector<double> masses{1.0, 2.0, 0.5, 1.0, infinity, 3.0};
  std::vector<double> r{0, 0, 0, 1, 0.5, 0.2, 2, 0, 0, 3, 0.5, 0.1, 5, 5, 5, 5, 5, 4};
  std::vector<Constraint> constraints{Rods{"chain", {{0, 1}, {1, 2}, {3, 2}}, {}, {}},
                                      Rods{"pendulum", {{4, 5}}, {}, {}}};
  std::vector<double> v{0.1, 0.3, -0.2, 0.4, -0.1, 0.6, 0.2, 0.8, -0.5, 0.3, 0.1, 0.7, 0, 0, 0, 1.0, 0.5, 0.2};
  std::vector<double> moved(double h) const {
    std::vector<double> result = r;
    for (std::size_t k = 0; k < r.size(); ++k) result[k] += h * v[k];
    return result;
  }
};

// ---- closed forms ----

/// The bob went straight on by (s, 0, 0); along the old rod it comes back to the circle.
TEST(ConstrainPositions, PutsAPendulumBackAlongItsOldRod) {
  const double length = 0.5, s = 0.03, h = 0.01, m = 2.0;
  const std::vector<double> old{0, 0, 0, 0, 0, -length};
  std::vector<double> r{0, 0, 0, s, 0, -length}, v{0, 0, 0, s / h, 0, 0}, lambda(1), forces(6);
  Constrainer constrainer(std::vector{infinity, m}, {Rods{"rods", {{0, 1}}, {}, {}}}, old);
  const double rise = length - std::sqrt(length * length - s * s);

  const ConstraintReport report =
      constrainer.constrain_positions({.step = h,
                                       .old_positions = old,
                                       .positions = r,
                                       .velocities = v,
                                       .wanted = {.multipliers = lambda, .forces = forces}});

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  EXPECT_EQ(r[3], s);
  EXPECT_NEAR(r[5], -length + rise, 1e-13 * length);
  EXPECT_NEAR(v[5], rise / h, 1e-12);
  EXPECT_NEAR(-lambda[0], 2.0 * m * rise / (h * h), 1e-9);
  EXPECT_NEAR(forces[5], 2.0 * m * rise / (h * h), 1e-9);
  EXPECT_EQ(forces[2], -forces[5]);
  EXPECT_NEAR(report.largest_turn, std::asin(s / length), 1e-14);
  EXPECT_NEAR(report.correction, rise, 1e-13 * length);
  EXPECT_NEAR(report.virial[2], lambda[0] * length, 1e-9);
  EXPECT_EQ(report.work, 0.0);
  EXPECT_EQ(r[0], 0.0);
}

/// The length of a pendulum is wrong by s^2/2, and each iteration along the old rod leaves (1 - cos(turn)) of that
/// error.
TEST(ConstrainPositions, EndsAtTheToleranceThatIsAskedFor) {
  const double s = 0.1;
  const std::vector<double> old{0, 0, 0, 0, 0, -1.0};
  const auto go = [&](double tolerance, std::vector<double>* r) {
    Constrainer constrainer(std::vector{infinity, 1.0}, {Rods{"rods", {{0, 1}}, {}, {}}}, old);
    return constrainer.constrain_positions(
        {.step = 1.0, .old_positions = old, .positions = *r, .tolerance = tolerance});
  };
  int last = 0;
  for (const double tolerance : {1e-1, 1e-4, 1e-7, 1e-10, 0.0}) {
    std::vector<double> r{0, 0, 0, s, 0, -1.0};

    const ConstraintReport report = go(tolerance, &r);

    ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
    EXPECT_LE(report.violation, std::max(tolerance, 1e-13));
    EXPECT_NEAR(report.violation, std::abs(std::hypot(r[3], r[5]) - 1.0), 1e-15);
    EXPECT_TRUE(report.iterations > last || tolerance == 1e-1) << tolerance;
    last = report.iterations;
  }
  EXPECT_EQ(last, 5);  // (s^2/2)^(k + 1) is left after k iterations, here 1.6e-14
}

TEST(ConstrainVelocities, SharesTheChangeByTheMasses) {
  const std::vector<double> r{0, 0, 0, 0, 2, 0};
  std::vector<double> v{1, 0, 0, 0, 4, 0}, lambda(1);
  Constrainer constrainer(std::vector{1.0, 3.0}, {Rods{"rods", {{0, 1}}, {}, {}}}, r);

  const ConstraintReport report =
      constrainer.constrain_velocities({.positions = r, .velocities = v, .wanted = {.multipliers = lambda}});

  ASSERT_TRUE(report.outcome.ok());
  for (const std::size_t k : {1U, 4U}) EXPECT_NEAR(v[k], 3.0, 1e-15);
  EXPECT_EQ(v[0], 1.0);
  EXPECT_NEAR(lambda[0], -3.0, 1e-15);  // an impulse
  EXPECT_NEAR(report.correction, 3.0, 1e-15);
}

TEST(ConstrainVelocities, ToleratesRoundingBesideTheVelocitiesOfTheCall) {
  for (const double size : {1e-9, 1.0, 1e6}) {
    Pair host;
    for (double& v : host.v) v *= size;
    Constrainer constrainer(host.masses, host.constraints, host.r);

    const ConstraintReport report = constrainer.constrain_velocities({.positions = host.r, .velocities = host.v});

    EXPECT_TRUE(report.outcome.ok());
    EXPECT_EQ(report.iterations, 1) << size;
    double rate = 0.0;
    for (std::size_t d = 0; d < 3; ++d) rate += (host.r[3 + d] - host.r[d]) * (host.v[3 + d] - host.v[d]);
    EXPECT_LE(std::abs(rate), 1e-13 * size);
  }
}

TEST(ProjectForces, LeavesWhatMovesNoConstraint) {
  // The masses are equal: the pull along the rod vanishes, the components across it and of the sum stay.
  const std::vector<double> r{0, 0, 0, 0, 2, 0};
  std::vector<double> f{1, 5, 0, 2, -3, 7};
  Constrainer constrainer(std::vector{1.0, 1.0}, {Rods{"rods", {{0, 1}}, {}, {}}}, r);

  const ConstraintReport report = constrainer.project_forces(r, f);

  ASSERT_TRUE(report.outcome.ok());
  EXPECT_EQ(f, (std::vector<double>{1, 1, 0, 2, 1, 7}));
  EXPECT_LE(report.violation, 1e-15);
  ASSERT_TRUE(constrainer.project_forces(r, f).outcome.ok());
  EXPECT_EQ(f, (std::vector<double>{1, 1, 0, 2, 1, 7}));
}

/// At rest the accelerations have the same multipliers, K'M^-1 (f + K lambda) = 0.
TEST(ProjectForces, TellsTheForcesThatSolveTellsAtRest) {
  Pair host;
  const std::size_t n = host.masses.size();
  std::vector<double> f = host.v, first = f, still(3 * n, 0.0), w(3 * n), pull(3 * n), other_pull(3 * n), stress(9 * n),
                      other_stress(9 * n);
  Constrainer constrainer(host.masses, host.constraints, host.r);
  std::vector<double> lambda(constrainer.num_rows()), other_lambda(lambda.size());

  const ConstraintReport report =
      constrainer.project_forces(host.r, f, 0.0, {.multipliers = lambda, .forces = pull, .stress = stress});
  const ConstraintReport solved =
      constrainer.solve({.positions = host.r,
                         .velocities = still,
                         .forces = first,
                         .accelerations = w,
                         .wanted = {.multipliers = other_lambda, .forces = other_pull, .stress = other_stress}});

  ASSERT_TRUE(report.outcome.ok() && solved.outcome.ok());
  const auto expect_near = [](const auto& a, const auto& b) {
    for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 1e-13) << k;
  };
  expect_near(lambda, other_lambda);
  expect_near(pull, other_pull);
  expect_near(stress, other_stress);
  expect_near(report.virial, solved.virial);
  EXPECT_GT(std::abs(report.virial[0]), 1e-3);
  for (std::size_t k = 0; k < f.size(); ++k) {
    if (host.masses[k / 3] == infinity) continue;
    EXPECT_NEAR(f[k], first[k] + pull[k], 1e-13);
  }
}

TEST(ProjectForces, KnowsNoRatesOfLengths) {
  const std::vector<double> r{0, 0, 0, 0, 2, 0};
  std::vector<double> f{1, 5, 0, 2, -3, 7};
  const ScalarFunction growing = ScalarFunction::formula("2 + 0.5*t");
  Constrainer constrainer(std::vector{1.0, 1.0}, {Rods{"rods", {{0, 1}}, growing, {}}}, r);
  ASSERT_TRUE(constrainer.project_forces(r, f).outcome.ok());
  EXPECT_EQ(f, (std::vector<double>{1, 1, 0, 2, 1, 7}));
}

TEST(ProjectForces, WorksAtAnyScaleOfForces) {
  for (const double size : {1e-12, 1e12}) {
    Pair host;
    std::vector<double> f = host.v;
    for (double& each : f) each *= size;
    Constrainer constrainer(host.masses, host.constraints, host.r);
    ASSERT_TRUE(constrainer.project_forces(host.r, f).outcome.ok());
    double rate = 0.0;  // K'M^-1 f of the first rod
    for (std::size_t d = 0; d < 3; ++d)
      rate += (host.r[3 + d] - host.r[d]) * (f[3 + d] / host.masses[1] - f[d] / host.masses[0]);
    EXPECT_LE(std::abs(rate), 1e-14 * size);
  }
}

TEST(Violation, NamesTheWorstRow) {
  Pair host;
  Constrainer constrainer(host.masses, host.constraints, host.r);
  host.r[3 * 3] += 0.1;

  const ConstraintReport report = constrainer.violation(host.r);

  EXPECT_EQ(constrainer.row_name(report.worst_row), "chain[2]");
  EXPECT_GT(report.violation, 0.01);
}

// ---- what moves from outside ----

/// A support that swings along x drags a bob on a rod along x with the force m a and the power m a v.
TEST(Work, IsTheEnergyOfThePointsWhereASupportMoves) {
  const double h = 1e-4;
  Host host({infinity, 2.0}, {0, 0, 0, 0.5, 0, -1.0}, {make_chain_of_rods(2)});
  host.set_gravity(0.0);
  host.measures = true;
  double work = 0.0;
  const auto place = [](double t) { return 0.3 * (1.0 - std::cos(4.0 * t)); };
  const double at_start = host.energy();
  for (int k = 0; k < 5000; ++k) {
    const double t = h * (k + 1);
    host.old = host.r;
    for (std::size_t d = 3; d < 6; ++d) host.r[d] += h * host.v[d];
    host.r[0] = place(t);
    const ConstraintReport first = host.constrainer.constrain_positions(
        {.step = h, .old_positions = host.old, .positions = host.r, .velocities = host.v});
    ASSERT_TRUE(first.outcome.ok()) << first.outcome.what;
    ASSERT_EQ(host.r[0], place(t));
    host.v[0] = 0.3 * 4.0 * std::sin(4.0 * t);
    const ConstraintReport second =
        host.constrainer.constrain_velocities({.step = h, .positions = host.r, .velocities = host.v});
    ASSERT_TRUE(second.outcome.ok());
    work += first.work + second.work;
  }
  const double energy = host.energy() - at_start;
  EXPECT_GT(energy, 0.02);
  EXPECT_NEAR(work, energy, 1e-6 * energy);
}

/// A dumbbell that spins is drawn in: its angular momentum stays, and the work is the energy that it gains.
TEST(Work, IsTheEnergyOfThePointsWhereALengthDependsOnTime) {
  const double h = 1e-4;
  Rods rods{"rods", {{0, 1}}, ScalarFunction::formula("1 - 0.3*t"), {}};
  const std::vector<double> masses{1.0, 1.0};
  std::vector<double> r{0, 0, 0, 0, 1, 0}, v{1, 0.15, 0, -1, -0.15, 0}, old;
  Constrainer constrainer(masses, {rods}, r);
  const auto kinetic = [&] { return 0.5 * std::inner_product(v.begin(), v.end(), v.begin(), 0.0); };
  const double at_start = kinetic();
  double work = 0.0;
  for (int k = 0; k < 10'000; ++k) {
    const double t = h * (k + 1);
    old = r;
    for (std::size_t d = 0; d < 6; ++d) r[d] += h * v[d];
    const ConstraintReport first =
        constrainer.constrain_positions({.step = h, .old_positions = old, .positions = r, .velocities = v, .time = t});
    ASSERT_TRUE(first.outcome.ok()) << first.outcome.what;
    const ConstraintReport second =
        constrainer.constrain_velocities({.step = h, .positions = r, .velocities = v, .time = t});
    ASSERT_TRUE(second.outcome.ok());
    work += first.work + second.work;
  }
  EXPECT_NEAR(std::hypot(r[3] - r[0], r[4] - r[1]), 0.7, 1e-13);
  const double spin = 0.5 / 0.35;  // the speed of each end, for r v stays
  EXPECT_NEAR(kinetic(), spin * spin + 0.15 * 0.15, 1e-6);
  EXPECT_NEAR(work, kinetic() - at_start, 1e-6);
}

// ---- the host's arrays ----

/// A host's structs hold the same numbers, in another order and among strangers.
struct Particle {
  double charge;
  std::array<double, 3> x, v;
  float kind;
};

TEST(PointArrays, AreReadAndWrittenInPlaceWithStrideAndIndex) {
  const double h = 1e-2;
  Pair host;
  Constrainer constrainer(host.masses, host.constraints, host.r);
  std::vector<double> r = host.moved(h), v = host.v, w(18);
  const std::vector<Index> index{7, 2, 5, 0, 3, 8};
  std::vector<Particle> particles(9, {nan, {nan, nan, nan}, {nan, nan, nan}, 1.0F}), old = particles;
  std::vector<double> f(27, 0.5);
  for (std::size_t i = 0; i < 6; ++i) {
    Particle &own = particles[index[i]], &before = old[index[i]];
    for (std::size_t d = 0; d < 3; ++d) {
      own.x[d] = r[3 * i + d];
      own.v[d] = v[3 * i + d];
      before.x[d] = host.r[3 * i + d];
    }
  }
  const PointArray x(particles[0].x.data(), sizeof(Particle), index.data());
  const PointArray speed(particles[0].v.data(), sizeof(Particle), index.data());
  Constrainer strange(host.masses, host.constraints, ConstPointArray(old[0].x.data(), sizeof(Particle), index.data()));

  ASSERT_TRUE(constrainer.constrain_positions({.step = h, .old_positions = host.r, .positions = r, .velocities = v})
                  .outcome.ok());
  ASSERT_TRUE(constrainer.constrain_velocities({.step = h, .positions = r, .velocities = v}).outcome.ok());
  ASSERT_TRUE(constrainer.solve({.positions = r, .velocities = v, .forces = f, .accelerations = w}).outcome.ok());
  ASSERT_TRUE(strange
                  .constrain_positions({.step = h,
                                        .old_positions = {old[0].x.data(), sizeof(Particle), index.data()},
                                        .positions = x,
                                        .velocities = speed})
                  .outcome.ok());
  ASSERT_TRUE(strange.constrain_velocities({.step = h, .positions = x, .velocities = speed}).outcome.ok());
  std::vector<double> accelerations(27, nan);
  ASSERT_TRUE(strange
                  .solve({.positions = x,
                          .velocities = speed,
                          .forces = f,
                          .accelerations = {accelerations.data(), 0, index.data()}})
                  .outcome.ok());

  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_EQ(particles[index[i]].x[d], r[3 * i + d]);
      EXPECT_EQ(particles[index[i]].v[d], v[3 * i + d]);
      EXPECT_EQ(accelerations[3 * index[i] + d], w[3 * i + d]);
    }
  }
  for (const std::size_t stranger : {1U, 4U, 6U}) {
    EXPECT_TRUE(std::isnan(particles[stranger].x[0]) && std::isnan(particles[stranger].v[2]));
    EXPECT_TRUE(std::isnan(accelerations[3 * stranger]));
  }
}

TEST(PointArrays, VelocitiesMayBeAbsent) {
  const double h = 1e-2;
  Pair host;
  Constrainer constrainer(host.masses, host.constraints, host.r), other(host.masses, host.constraints, host.r);
  std::vector<double> r = host.moved(h), same = r, v = host.v;

  ASSERT_TRUE(constrainer.constrain_positions({.step = h, .old_positions = host.r, .positions = r}).outcome.ok());
  ASSERT_TRUE(
      other.constrain_positions({.step = h, .old_positions = host.r, .positions = same, .velocities = v}).outcome.ok());

  EXPECT_EQ(r, same);
}

// ---- the factor that is kept ----

/// A host that goes back to another configuration, or to another time, gets the factor that belongs there.
TEST(Factor, BelongsToThePositionsOfTheCall) {
  const double h = 1e-2;
  Pair host;
  Constrainer kept(host.masses, host.constraints, host.r);
  std::vector<double> elsewhere = host.r, v = host.v;
  for (std::size_t i = 0; i < 4; ++i) std::swap(elsewhere[3 * i], elsewhere[3 * i + 1]);
  ASSERT_TRUE(kept.constrain_velocities({.positions = elsewhere, .velocities = v}).outcome.ok());
  std::vector<double> r = host.moved(h), same = r, lambda(4), same_lambda(4);

  ASSERT_TRUE(
      kept.constrain_positions({.step = h, .old_positions = host.r, .positions = r, .wanted = {.multipliers = lambda}})
          .outcome.ok());

  Constrainer fresh(host.masses, host.constraints, host.r);
  ASSERT_TRUE(fresh
                  .constrain_positions(
                      {.step = h, .old_positions = host.r, .positions = same, .wanted = {.multipliers = same_lambda}})
                  .outcome.ok());
  EXPECT_EQ(r, same);
  EXPECT_EQ(lambda, same_lambda);
}

/// Multipliers of one motion are no guess for another one, and a guess that leads nowhere is given up.
TEST(Factor, GuessesOfAnotherMotionDoNoHarm) {
  const double h = 1e-2;
  Pair host;
  Constrainer constrainer(host.masses, host.constraints, host.r), fresh(host.masses, host.constraints, host.r);
  for (int k = 0; k < 3; ++k) {
    std::vector<double> r = host.r;
    for (std::size_t d = 0; d < 3; ++d) r[d] += 0.6 * (k + 1);
    (void)constrainer.constrain_positions({.step = h, .old_positions = host.r, .positions = r});
  }
  std::vector<double> r = host.moved(h), same = r;

  ASSERT_TRUE(constrainer.constrain_positions({.step = h, .old_positions = host.r, .positions = r}).outcome.ok());
  ASSERT_TRUE(fresh.constrain_positions({.step = h, .old_positions = host.r, .positions = same}).outcome.ok());

  for (std::size_t k = 0; k < r.size(); ++k) EXPECT_NEAR(r[k], same[k], 1e-13);
}

TEST(Handles, AreIndependentInTwoThreads) {
  std::vector<double> states[2];
  const auto run = [&](int own) {
    Host host = make_hanging_chain(20, 0.1, 0.1, 1.0, 0.0);
    host.set_gravity(9.81);
    host.start();
    for (int k = 0; k < 200; ++k) ASSERT_TRUE(host.step(1e-3));
    states[own] = host.r;
  };
  std::thread first(run, 0), second(run, 1);
  first.join();
  second.join();
  EXPECT_EQ(states[0], states[1]);
}

// ---- failures ----

TEST(Failures, LeaveTheArraysUntouchedAndNameTheRow) {
  Pair host;
  Constrainer constrainer(host.masses, host.constraints, host.r);
  std::vector<double> r = host.r, v = host.v, lambda(4, 7.0), forces(18, 7.0);
  r[3 * 1] += 40.0;  // far beyond any step
  const std::vector<double> r_before = r, v_before = v, lambda_before = lambda, forces_before = forces;

  const ConstraintReport report =
      constrainer.constrain_positions({.step = 0.1,
                                       .old_positions = host.r,
                                       .positions = r,
                                       .velocities = v,
                                       .wanted = {.multipliers = lambda, .forces = forces}});

  EXPECT_EQ(report.outcome.status, Status::NotConverged);
  EXPECT_NE(report.outcome.what.find("chain["), std::string::npos) << report.outcome.what;
  EXPECT_EQ(constrainer.row_name(report.worst_row).substr(0, 6), "chain[");
  EXPECT_EQ(r, r_before);
  EXPECT_EQ(v, v_before);
  EXPECT_EQ(lambda, lambda_before);
  EXPECT_EQ(forces, forces_before);

  r = host.moved(1e-2);  // and the handle goes on
  EXPECT_TRUE(constrainer.constrain_positions({.step = 1e-2, .old_positions = host.r, .positions = r}).outcome.ok());
}

TEST(Failures, NanOfTheHostIsAnOutcome) {
  Pair host;
  Constrainer constrainer(host.masses, host.constraints, host.r);
  std::vector<double> bad = host.r, v = host.v;
  bad[4] = nan;
  std::vector<double> r = host.r;

  EXPECT_EQ(constrainer.constrain_positions({.step = 1e-2, .old_positions = bad, .positions = r}).outcome.status,
            Status::NotFinite);
  EXPECT_EQ(r, host.r);
  EXPECT_EQ(constrainer.constrain_positions({.step = 1e-2, .old_positions = r, .positions = bad}).outcome.status,
            Status::NotFinite);
  v[3] = nan;
  EXPECT_EQ(constrainer.constrain_velocities({.positions = r, .velocities = v}).outcome.status, Status::NotFinite);
  EXPECT_EQ(constrainer.solve({.positions = r, .velocities = host.v, .forces = v}).outcome.status, Status::NotFinite);
  EXPECT_EQ(constrainer.project_forces(r, v).outcome.status, Status::NotFinite);
  EXPECT_TRUE(constrainer.constrain_velocities({.positions = r, .velocities = host.v}).outcome.ok());
}

TEST(Failures, PositionsOffTheConstraintsDoNotBeginAStep) {
  Pair host;
  Constrainer constrainer(host.masses, host.constraints, host.r);
  host.r[0] -= 1e-4;
  std::vector<double> r = host.moved(1e-3);

  const Outcome outcome =
      constrainer.constrain_positions({.step = 1e-3, .old_positions = host.r, .positions = r}).outcome;

  EXPECT_EQ(outcome.status, Status::NotConverged);
  EXPECT_NE(outcome.what.find("chain[0]"), std::string::npos) << outcome.what;
  EXPECT_NE(outcome.what.find("project_positions"), std::string::npos);
  ASSERT_TRUE(constrainer.project_positions(host.r).outcome.ok());
  r = host.moved(1e-3);
  EXPECT_TRUE(constrainer.constrain_positions({.step = 1e-3, .old_positions = host.r, .positions = r}).outcome.ok());
}

TEST(Failures, WrongCallsAreInputErrors) {
  Pair host;
  Constrainer constrainer(host.masses, host.constraints, host.r);
  std::vector<double> r = host.r, few(9), v = host.v;
  EXPECT_EQ(error_of([&] { (void)constrainer.constrain_positions({.step = 1e-3, .positions = r}); }),
            "old_positions are missing");
  EXPECT_EQ(error_of([&] {
              (void)constrainer.constrain_positions({.step = 0.0, .old_positions = r, .positions = r});
            }).substr(0, 8),
            "step = 0");
  EXPECT_EQ(
      error_of([&] {
        (void)constrainer.constrain_positions({.step = 1.0, .old_positions = r, .positions = r, .tolerance = -1e-9});
      }),
      "tolerance = -1e-09 is negative");
  EXPECT_EQ(error_of([&] { (void)constrainer.constrain_velocities({.positions = r, .velocities = few}); }),
            "velocities has 9 numbers; 18 are needed");
  EXPECT_EQ(error_of([&] {
              (void)constrainer.constrain_velocities({.positions = r, .velocities = v, .wanted = {.multipliers = few}});
            }),
            "multipliers has 9 numbers; 4 are needed");
  EXPECT_EQ(error_of([&] { (void)constrainer.row_name(4); }), "there is no row 4");
  Constrainer moved = std::move(constrainer);
  EXPECT_NE(error_of([&] { (void)constrainer.num_rows(); }).find("moved from"), std::string::npos);
  EXPECT_EQ(moved.num_rows(), 4U);
}

TEST(Failures, NothingToConstrainIsNoError) {
  std::vector<double> r{0, 0, 0}, v{1, 2, 3}, w(3);
  Constrainer free(std::vector{2.0}, {}, r);
  EXPECT_TRUE(free.constrain_positions({.step = 1.0, .old_positions = r, .positions = v}).outcome.ok());
  EXPECT_EQ(v, (std::vector<double>{1, 2, 3}));
  ASSERT_TRUE(free.solve({.positions = r, .velocities = v, .forces = v, .accelerations = w}).outcome.ok());
  EXPECT_EQ(w, (std::vector<double>{0.5, 1, 1.5}));
}

}  // namespace
}  // namespace tanor::host
