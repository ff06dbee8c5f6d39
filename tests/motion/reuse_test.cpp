#include <gtest/gtest.h>

#include "motion/saved.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

/// Makes a net that hangs, folds and falls while waves run through it.
System make_waving_net(int size = 24) {
  System system = scenes::make_net(size, size);
  for (std::size_t i = 0; i < system.positions.size(); i += 3) {
    system.velocities[i + 2] = 0.1 * std::sin(7.0 * system.positions[i] + 3.0 * system.positions[i + 1]);
  }
  return system;
}

MotionOptions options_for(Method method) {
  MotionOptions options{.method = method, .rtol = 1e-7, .atol = 1e-9, .start = StartMode::Project};
  if (method == Method::Rk4) options.step = 1e-3;
  return options;
}

Simulation run(const System& system, const MotionOptions& options, const SolverOptions& solver, double t_end) {
  Simulation simulation(system, options, solver);
  const Outcome outcome = simulation.advance_to(t_end);
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  return simulation;
}

void expect_same_bits(const Simulation& a, const Simulation& b) {
  const auto as_vector = [](std::span<const double> x) { return std::vector(x.begin(), x.end()); };
  EXPECT_EQ(a.time(), b.time());
  EXPECT_EQ(as_vector(a.positions()), as_vector(b.positions()));
  EXPECT_EQ(as_vector(a.velocities()), as_vector(b.velocities()));
  EXPECT_EQ(as_vector(a.multipliers()), as_vector(b.multipliers()));
  EXPECT_EQ(a.report().counters.iterations, b.report().counters.iterations);
}

struct ReusedScene {
  const char* name;
  System (*make)();

  friend std::ostream& operator<<(std::ostream& out, const ReusedScene& scene) { return out << scene.name; }
};

class ReuseTest : public testing::TestWithParam<std::tuple<ReusedScene, Method>> {
 protected:
  System make() const { return std::get<0>(GetParam()).make(); }
  MotionOptions options() const { return options_for(std::get<1>(GetParam())); }
};

TEST_P(ReuseTest, TheMotionIsThatOfAFactorEachTime) {
  const double t_end = 0.1;
  MotionOptions tight = options_for(Method::Dop853);
  tight.rtol = 1e-10;
  tight.atol = 1e-12;
  const Simulation reference = run(make(), tight, {.reuse = false}, t_end);

  const Simulation each = run(make(), options(), {.reuse = false}, t_end);
  const Simulation reused = run(make(), options(), {}, t_end);

  const auto error = [&](const Simulation& simulation) {
    return largest_difference(simulation.positions(), reference.positions());
  };
  EXPECT_LE(error(reused), 1.25 * error(each) + 1e-11);
  EXPECT_LE(reused.report().violation.position, 1e-12);
  EXPECT_LE(reused.report().violation.velocity, 1e-12);
  EXPECT_LE(reused.report().violation.acceleration, 1e-11);
  EXPECT_NEAR(reused.report().energy.drift_relative(), each.report().energy.drift_relative(), 1e-8);
  EXPECT_LE(reused.report().steps, each.report().steps + each.report().steps / 20 + 1);
}

TEST_P(ReuseTest, OneAndTwoThreadsGiveTheSameBits) {
  expect_same_bits(run(make(), options(), {.threads = 1}, 0.1), run(make(), options(), {.threads = 2}, 0.1));
}

TEST_P(ReuseTest, ARestoredRunGoesOnBitByBit) {
  Simulation whole(make(), options()), second(make(), options());
  std::vector<std::byte> saved;
  bool has_memory = false;
  ASSERT_TRUE(whole
                  .advance_to(0.2,
                              [&](const MotionReport& report) {
                                if (report.steps == 5) {
                                  saved = whole.save();
                                  has_memory = !open_saved(whole).memory.empty();
                                }
                                return true;
                              })
                  .ok());
  ASSERT_TRUE(has_memory);

  second.restore(saved);
  ASSERT_LT(second.time(), whole.time());
  ASSERT_TRUE(second.advance_to(0.2).ok());

  expect_same_bits(second, whole);
}

/// A certificate solves at the state itself, with a factor of its own.
TEST_P(ReuseTest, CertificatesNeitherNoticeNorDisturb) {
  const Simulation alone = run(make(), options(), {}, 0.1);
  Simulation watched(make(), options());

  ASSERT_TRUE(watched
                  .advance_to(0.1,
                              [&](const MotionReport&) {
                                const Certificate certificate = watched.certify();
                                EXPECT_TRUE(certificate.passed());
                                return true;
                              })
                  .ok());

  expect_same_bits(watched, alone);
}

const ReusedScene reused_scenes[]{{"net", [] { return make_waving_net(); }},
                                  {"lattice", [] { return scenes::make_lattice(6); }}};

INSTANTIATE_TEST_SUITE_P(Scenes, ReuseTest,
                         testing::Combine(testing::ValuesIn(reused_scenes),
                                          testing::Values(Method::Dop853, Method::Dopri5, Method::Rk4)));

/// Each step makes one factor where it ends, and a few more are made before the iterations are known.
TEST(ReuseGainsTest, AFactorServesAWholeStepOfBigSystems) {
  for (const System& system : {make_waving_net(70), scenes::make_lattice(10)}) {
    for (const Method method : {Method::Dop853, Method::Dopri5}) {
      const MotionReport report = run(system, options_for(method), {}, 0.02).report();

      EXPECT_GT(report.counters.iterations, 0u);
      EXPECT_LE(report.counters.factorizations, 2 * (report.steps + report.rejected) + 4) << name_of(method);
    }
  }
}

struct CountedNet {
  int size;
  Method method;
  std::size_t most;
};

/// The bounds are 2 % above the counted numbers.
TEST(ReuseGainsTest, IterationsInKnownNetsStayAsFewAsTheyAre) {
  for (const auto& [size, method, most] : {CountedNet{24, Method::Dop853, 97}, CountedNet{24, Method::Dopri5, 84},
                                           CountedNet{24, Method::Rk4, 203}, CountedNet{70, Method::Rk4, 238}}) {
    const Counters counters = run(make_waving_net(size), options_for(method), {}, 0.02).report().counters;

    EXPECT_LE(counters.iterations, most) << size << " " << name_of(method);
    EXPECT_GE(counters.iterations, most / 2) << "a net that is not solved by iterations proves nothing";
  }
}

/// Rows that depend on others leave no factor that could be used again.
TEST(ReuseLimitsTest, RedundantRodsHaveAFactorEachTime) {
  System system = make_waving_net();
  auto& rods = std::get<Rods>(system.constraints.front());
  rods.pairs.push_back(rods.pairs[7]);
  const MotionOptions options = options_for(Method::Dop853);

  const Simulation each = run(system, options, {.reuse = false}, 0.05), reused = run(system, options, {}, 0.05);

  EXPECT_EQ(reused.report().counters.iterations, 0u);
  expect_same_bits(reused, each);
}

/// A cheap factor is made each time, as that of a tree in the general solver or of linear constraints.
TEST(ReuseLimitsTest, CheapFactorsAreMadeEachTime) {
  const MotionOptions options = options_for(Method::Dop853);
  const SolverOptions general{.linear_solver = LinearSolver::General},
      never{.linear_solver = LinearSolver::General, .reuse = false};
  Simulation chain = run(scenes::make_chain(50), options, general, 0.1);
  Simulation without = run(scenes::make_chain(50), options, never, 0.1);

  EXPECT_EQ(chain.report().counters.iterations, 0u);
  EXPECT_EQ(open_saved(chain).memory.size(), open_saved(without).memory.size());
}

TEST(ReuseLimitsTest, TaylorHasNoStagesToReuseFor) {
  EXPECT_EQ(run(make_waving_net(), options_for(Method::Taylor), {}, 0.05).report().counters.iterations, 0u);
}

TEST(ReuseLimitsTest, TheMemoryOfAnotherSystemIsRefused) {
  const MotionOptions options = options_for(Method::Dop853);
  Simulation simulation = run(make_waving_net(), options, {}, 0.05);
  Snapshot snapshot = open_saved(simulation);
  ASSERT_FALSE(snapshot.memory.empty());
  snapshot.memory.pop_back();

  try {
    restore(snapshot, &simulation);
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(error.where(), "/snapshot/memory");
  }
}

}  // namespace
}  // namespace tanor
