/// Motions pass configurations where the constraints are redundant, all the time or for a moment.

#include <cmath>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "base/parallel.hpp"
#include "motion/method_options.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

using scenes::make_four_bar;

/// Makes three parallel cranks of length 1 that carry rods 3-4, 4-5 and 3-5 in a line, one rod too many (case 18a).
System make_parallelogram() {
  System system = scenes::make_cranks({0.0, 1.0, 2.5}, 0.7 - 0.5 * M_PI, 0.0);
  system.masses = {1, 1, 1, 1, 2, 3};
  system.constraints = {Rods{"cranks", {{0, 3}, {1, 4}, {2, 5}}, 1.0, {}},
                        Rods{"couplers", {{3, 4}, {4, 5}, {3, 5}}, std::vector{1.0, 1.5, 2.5}, {}}};
  system.forces = {Gravity{"", {0, -9.81, 0}}};
  return system;
}

TEST(Singular, RedundantParallelogramMovesAsThePendulumItIs) {
  Simulation simulation(make_parallelogram(), with(Method::Dopri5, 0.0));

  ASSERT_TRUE(simulation.advance_to(5.0).ok()) << simulation.outcome().what;

  // The numbers are those of the first mass at t = 5 in case 18a.
  EXPECT_NEAR(simulation.positions()[9], -0.5703965679671275, 1e-11);
  EXPECT_NEAR(simulation.positions()[10], -0.8213694389562604, 1e-11);
  EXPECT_NEAR(simulation.velocities()[9], -0.8650017313892577, 1e-10);
  EXPECT_NEAR(simulation.accelerations()[9], 5.228653577295534, 1e-9);
  EXPECT_EQ(simulation.rank().rank, 5U);
  EXPECT_EQ(simulation.report().rank_changes.start, 5U);
  EXPECT_EQ(simulation.report().rank_changes.count, 0U) << "redundant from the start on is no change";
  EXPECT_EQ(simulation.report().singular_passages.count, 0U);
}

TEST(Singular, ParallelogramHasTheSmallestMultipliers) {
  Simulation simulation(make_parallelogram(), with(Method::Dopri5, 0.0));

  // At t = 0 of case 18a the cranks carry, and the couplers do nothing.
  const std::vector<double> expected{-7.503101857260695, -15.006203714521602, -22.50930557178245, 0, 0, 0};
  for (std::size_t a = 0; a < 6; ++a) EXPECT_NEAR(simulation.multipliers()[a], expected[a], 1e-12);
  EXPECT_EQ(simulation.rank().multipliers_unique, (std::vector<bool>{true, true, true, false, false, false}));
}

class FourBar : public testing::TestWithParam<Method> {};

TEST_P(FourBar, LeavesTheFlatPlaceOnTheBranchOfItsMomentum) {
  Simulation simulation(make_four_bar(0.0, -1.0), with(GetParam(), 1e-3));
  EXPECT_EQ(simulation.rank().rank, 4U);

  ASSERT_TRUE(simulation.advance_to(1.0).ok()) << simulation.outcome().what;

  // Both cranks turn at the same constant rate, as a parallelogram.
  EXPECT_NEAR(simulation.positions()[6], std::cos(1.0), 1e-6);
  EXPECT_NEAR(simulation.positions()[7], -std::sin(1.0), 1e-6);
  EXPECT_NEAR(simulation.positions()[9], 1.0 + std::cos(1.0), 1e-6);
  EXPECT_NEAR(simulation.positions()[10], -std::sin(1.0), 1e-6);
  EXPECT_EQ(simulation.rank().rank, 5U);
  const RankChanges& changes = simulation.report().rank_changes;
  EXPECT_EQ(changes.start, 4U);
  ASSERT_EQ(changes.count, 1U);
  EXPECT_LT(changes.first[0].time, 0.1);
  EXPECT_EQ(changes.first[0].rank, 5U);
}

TEST_P(FourBar, PassesTheFlatPlace) {
  MotionOptions options = with(GetParam(), 0.9e-3);
  options.rtol = options.atol = 1e-10;
  Simulation simulation(make_four_bar(0.5, -1.0), options);

  ASSERT_TRUE(simulation.advance_to(1.5).ok()) << simulation.outcome().what;

  EXPECT_NEAR(simulation.positions()[6], std::cos(1.0), 1e-6);
  EXPECT_NEAR(simulation.positions()[7], -std::sin(1.0), 1e-6);
  EXPECT_NEAR(simulation.positions()[10], -std::sin(1.0), 1e-6);
  EXPECT_NEAR(simulation.report().nearest_to_singular.time, 0.5, 5e-2);
  EXPECT_LT(simulation.report().nearest_to_singular.reciprocal_condition, 1e-2);
  ASSERT_EQ(simulation.report().singular_passages.count, 1U);
  EXPECT_NEAR(simulation.report().singular_passages.first[0].time, 0.5, 1e-4);
}

TEST_P(FourBar, NamesEveryFlatPlaceOfALongRun) {
  constexpr double pi = 3.14159265358979323846;
  Simulation simulation(make_four_bar(0.5, -1.0), with(GetParam(), 1e-3));

  ASSERT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;

  EXPECT_NEAR(simulation.positions()[6], std::cos(9.5), 1e-4);
  EXPECT_NEAR(simulation.positions()[9], 1.0 + std::cos(9.5), 1e-4);
  EXPECT_NEAR(simulation.positions()[10], -std::sin(9.5), 1e-4);
  const SingularPassages& passages = simulation.report().singular_passages;
  ASSERT_EQ(passages.count, 4U);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(passages.first[k].time, 0.5 + static_cast<double>(k) * pi, 1e-4);
}

/// Both masses slide over a rough plane. The cranks are slowed down evenly, by mu g, on both sides of the flat place.
TEST_P(FourBar, TellsTheWorkOfFrictionThroughTheFlatPlace) {
  constexpr double g = 9.81, mu = 0.02, t_end = 1.5, way = t_end - 0.5 * mu * g * t_end * t_end;
  System system = make_four_bar(0.5, -1.0);
  system.forces = {Gravity{"", {0, 0, -g}}};
  system.friction = {Coulomb{.name = "rust", .at = {"plane"}, .coefficient = mu}};
  MotionOptions options = with(GetParam(), 0.9e-3);
  options.rtol = options.atol = 1e-10;
  Simulation simulation(system, options);

  ASSERT_TRUE(simulation.advance_to(t_end).ok()) << simulation.outcome().what;

  EXPECT_EQ(simulation.report().singular_passages.count, 1U);
  EXPECT_NEAR(simulation.positions()[6], std::cos(0.5 - way), 1e-6);
  EXPECT_NEAR(simulation.report().energy.work_of_friction, -2.0 * mu * g * way, 1e-6);
  EXPECT_NEAR(simulation.report().energy.drift_relative(), 0.0, 1e-6);
}

/// The angle of the cranks while a constant force pulls one of the two masses: 3 angle'' = -force cos(angle).
struct Pendulum {
  double force, angle, rate;

  void advance(double t) {
    constexpr int steps = 20'000;
    const double h = t / steps;
    const auto turn = [&](double at) { return -force * std::cos(at) / 3.0; };
    for (int k = 0; k < steps; ++k) {  // RK4
      const double k1 = turn(angle), k2 = turn(angle + 0.5 * h * rate),
                   k3 = turn(angle + 0.5 * h * (rate + 0.5 * h * k1)), k4 = turn(angle + h * (rate + 0.5 * h * k2));
      angle += h * (rate + h * (k1 + k2 + k3) / 6.0);
      rate += h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
    }
  }
  /// Finds the time of angle = 0 by Newton's method.
  double find_flat_time() const {
    double t = 0.3;
    for (int k = 0; k < 20; ++k) {
      Pendulum there = *this;
      there.advance(t);
      t -= there.angle / there.rate;
    }
    return t;
  }
};

struct Landing {
  Method method;
  double accuracy;  // rtol, or the flat time over the step
  double at_flat, at_end;
};

class LoadedFourBar : public testing::TestWithParam<Landing> {};

TEST_P(LoadedFourBar, StaysAParallelogramHoweverNearAStepEndsToTheFlatPlace) {
  const Pendulum start{6.0, 0.5, -1.0};
  const double flat = start.find_flat_time();
  Pendulum end = start;
  end.advance(1.2);
  System system = make_four_bar(start.angle, start.rate);
  system.masses[3] = 2.0;  // the force drives the coupler, not the cranks alike
  system.forces = {ConstantForce{"", {2}, VectorFunction(Vector3{0.0, -start.force, 0.0})}};
  MotionOptions options;
  options.method = GetParam().method;
  if (has_fixed_steps(options.method))
    options.step = flat / GetParam().accuracy;
  else
    options.rtol = options.atol = GetParam().accuracy;

  for (const double offset : {0.0, -1e-12, 1e-10, -1e-9, 1e-8, 1e-7, -1e-6, 1e-5, -1e-4, 1e-4, 1e-3}) {
    SCOPED_TRACE(offset);
    Simulation simulation(system, options);

    ASSERT_TRUE(simulation.advance_to(flat + offset).ok()) << simulation.outcome().what;
    Pendulum there = start;
    there.advance(flat + offset);
    const double tolerance = GetParam().at_flat;
    for (const std::size_t point : {2U, 3U}) {
      EXPECT_NEAR(simulation.positions()[3 * point + 1], std::sin(there.angle), tolerance);
      EXPECT_NEAR(simulation.velocities()[3 * point], -there.rate * std::sin(there.angle), tolerance);
      EXPECT_NEAR(simulation.velocities()[3 * point + 1], there.rate * std::cos(there.angle), tolerance);
    }

    ASSERT_TRUE(simulation.advance_to(1.2).ok()) << simulation.outcome().what;
    for (const std::size_t point : {2U, 3U}) {
      const double pivot = point == 2 ? 0.0 : 1.0;
      EXPECT_NEAR(simulation.positions()[3 * point], pivot + std::cos(end.angle), GetParam().at_end);
      EXPECT_NEAR(simulation.positions()[3 * point + 1], std::sin(end.angle), GetParam().at_end);
    }
    const SingularPassages& passages = simulation.report().singular_passages;
    ASSERT_EQ(passages.count, 1U);
    EXPECT_NEAR(passages.first[0].time, flat, 5e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Motion, LoadedFourBar,
    testing::Values(Landing{Method::Dopri5, 1e-6, 2e-6, 5e-6}, Landing{Method::Dopri5, 1e-9, 2e-9, 5e-9},
                    Landing{Method::Dopri5, 1e-12, 1e-8, 5e-12}, Landing{Method::Taylor, 1e-9, 2e-8, 5e-9},
                    Landing{Method::Taylor, 1e-12, 2e-8, 1e-11}, Landing{Method::Rk4, 50.0, 2e-7, 1e-6},
                    Landing{Method::Rk4, 500.0, 2e-8, 1e-10}, Landing{Method::Rk4, 500.5, 2e-8, 1e-10},
                    Landing{Method::Rattle, 500.0, 2e-6, 5e-6}, Landing{Method::Rattle, 500.5, 2e-6, 5e-6}));

/// Method `dop853` sees such a place late.
TEST(Singular, Dop853ArrivesHoweverNearAnAdvanceEndedToTheFlatPlace) {
  const Pendulum start{6.0, 0.5, -1.0};
  Pendulum end = start;
  end.advance(1.2);
  System system = make_four_bar(start.angle, start.rate);
  system.masses[3] = 2.0;
  system.forces = {ConstantForce{"", {2}, VectorFunction(Vector3{0.0, -start.force, 0.0})}};
  for (const double offset : {0.0, 1e-10, -1e-8, 1e-7, -1e-6, 1e-5, -1e-4, 1e-3}) {
    SCOPED_TRACE(offset);
    Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-9, .atol = 1e-9});

    ASSERT_TRUE(simulation.advance_to(start.find_flat_time() + offset).ok()) << simulation.outcome().what;
    ASSERT_TRUE(simulation.advance_to(1.2).ok()) << simulation.outcome().what;

    EXPECT_NEAR(simulation.positions()[7], std::sin(end.angle), 5e-9);
    EXPECT_NEAR(simulation.positions()[10], std::sin(end.angle), 5e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Motion, FourBar, testing::ValuesIn(sampled_methods));

/// Makes N + 1 uniform links on the ground and N uniform couplers between them, each 1 m and 1 kg, upright and on their
/// way with 1 m/s (IFToMM benchmark A02). A uniform rod is two end masses of 1/6 and one of 4/6 in its middle.
System make_many_four_bars(int bars) {
  System system;
  const auto add = [&](double x, double y, double mass, double speed) {
    system.positions.insert(system.positions.end(), {x, y, 0.0});
    system.velocities.insert(system.velocities.end(), {speed, 0.0, 0.0});
    system.masses.push_back(mass);
    return static_cast<Index>(system.masses.size() - 1);
  };
  std::vector<Index> ground, top;
  for (int i = 0; i <= bars; ++i) ground.push_back(add(i, 0.0, 1.0, 0.0));
  for (int i = 0; i <= bars; ++i) top.push_back(add(i, 1.0, (1.0 + (i > 0) + (i < bars)) / 6.0, 1.0));
  Rods rods{"rods", {}, 1.0, {}};
  std::vector<std::vector<Index>> middles;
  for (std::size_t i = 0; i < top.size(); ++i) {
    rods.pairs.push_back({ground[i], top[i]});
    middles.push_back({add(static_cast<double>(i), 0.5, 4.0 / 6.0, 0.5), ground[i], top[i]});
  }
  for (std::size_t i = 0; i + 1 < top.size(); ++i) {
    rods.pairs.push_back({top[i], top[i + 1]});
    middles.push_back({add(static_cast<double>(i) + 0.5, 1.0, 4.0 / 6.0, 1.0), top[i], top[i + 1]});
  }
  system.supports = {{"ground", ground, {}}};
  system.constraints = {rods, Planes{"plane", top, Vector3{0, 0, 1}, 0.0}};
  for (const Vector3& e : {Vector3{1, 0, 0}, Vector3{0, 1, 0}, Vector3{0, 0, 1}}) {
    const Vector3 back{-e[0], -e[1], -e[2]}, twice{2 * e[0], 2 * e[1], 2 * e[2]};
    system.constraints.push_back(Linears{"", middles, {twice, back, back}, 0.0});
  }
  system.forces = {Gravity{"", {0, -9.81, 0}}};
  return system;
}

TEST(Singular, FortyFourBarsGoThroughAllTheirFlatPlacesAsOnePendulum) {
  MotionOptions options;
  options.method = Method::Dopri5;
  options.rtol = 1e-10;
  options.atol = 1e-12;
  Simulation simulation(make_many_four_bars(40), options);

  ASSERT_TRUE(simulation.advance_to(20.0).ok()) << simulation.outcome().what;

  EXPECT_NEAR(simulation.positions()[3 * 41], 0.410901153762945, 1e-6);
  EXPECT_NEAR(simulation.positions()[3 * 41 + 1], 0.911679900971981, 1e-6);
  EXPECT_EQ(simulation.report().singular_passages.count, 20U);
}

/// The bar lies on a sheet, free of forces, and turns for ever, flat after each half turn. Wherever steps begin, the
/// run stays on its branch or ends with a reason.
class TurningFourBar : public testing::TestWithParam<std::pair<Method, double>> {};

TEST_P(TurningFourBar, StaysOnItsBranchFromAnyAngle) {
  const auto [method, rtol] = GetParam();
  int stopped = 0;
  for (int k = 0; k < 20; ++k) {
    const double angle = 0.2 + 0.14 * k, end = angle - 20.0;
    SCOPED_TRACE(angle);
    Simulation simulation(make_four_bar(angle, -1.0), {.method = method, .rtol = rtol, .atol = 0.01 * rtol});

    if (!simulation.advance_to(20.0).ok()) {
      ++stopped;
      EXPECT_NE(simulation.outcome().what.find("constraints depend on each other"), std::string::npos);
      continue;
    }
    EXPECT_NEAR(simulation.positions()[9], 1.0 + std::cos(end), 1e-7 + 100.0 * rtol);
    EXPECT_NEAR(simulation.positions()[10], std::sin(end), 1e-7 + 100.0 * rtol);
  }
  EXPECT_LE(stopped, 1);
}

INSTANTIATE_TEST_SUITE_P(Motion, TurningFourBar,
                         testing::Values(std::pair{Method::Taylor, 1e-6}, std::pair{Method::Taylor, 1e-8},
                                         std::pair{Method::Taylor, 1e-9}, std::pair{Method::Taylor, 1e-10},
                                         std::pair{Method::Taylor, 1e-11}, std::pair{Method::Taylor, 1e-12},
                                         std::pair{Method::Dop853, 1e-8}, std::pair{Method::Dop853, 1e-10},
                                         std::pair{Method::Dop853, 1e-12}));

/// Times are right also where steps turn the cranks by more than 90 degrees. The cranks lie flat at angle, angle + pi
/// and so on.
class PassageTimes : public testing::TestWithParam<std::pair<Method, double>> {};

TEST_P(PassageTimes, MatchTheMotionHoweverLongStepsAre) {
  const auto [method, rtol] = GetParam();
  for (int k = 0; k < 20; ++k) {
    const double angle = 0.2 + 0.14 * k;
    SCOPED_TRACE(angle);
    Simulation simulation(make_four_bar(angle, -1.0), {.method = method, .rtol = rtol, .atol = 0.01 * rtol});

    ASSERT_TRUE(simulation.advance_to(20.0).ok()) << simulation.outcome().what;

    const SingularPassages& passages = simulation.report().singular_passages;
    ASSERT_EQ(passages.count, 1 + static_cast<std::size_t>((20.0 - angle) / M_PI));
    for (std::size_t i = 0; i < passages.count; ++i) {
      EXPECT_NEAR(passages.first[i].time, angle + M_PI * static_cast<double>(i), 3e-9 + 100.0 * rtol);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Motion, PassageTimes,
                         testing::Values(std::pair{Method::Taylor, 1e-5}, std::pair{Method::Taylor, 1e-8},
                                         std::pair{Method::Taylor, 1e-11}, std::pair{Method::Dop853, 1e-5},
                                         std::pair{Method::Dop853, 1e-8}, std::pair{Method::Dop853, 1e-11},
                                         std::pair{Method::Dopri5, 1e-5}, std::pair{Method::Dopri5, 1e-8},
                                         std::pair{Method::Radau5, 1e-5}, std::pair{Method::Radau5, 1e-8}));

void expect_same_run(const Simulation& a, const Simulation& b) {
  const auto bits = [](std::span<const double> numbers) { return std::vector(numbers.begin(), numbers.end()); };
  EXPECT_EQ(a.time(), b.time());
  EXPECT_EQ(bits(a.positions()), bits(b.positions()));
  EXPECT_EQ(bits(a.velocities()), bits(b.velocities()));
  EXPECT_EQ(a.report().steps, b.report().steps);
  EXPECT_EQ(a.report().rejected, b.report().rejected);
  EXPECT_EQ(a.report().energy.work_of_forces, b.report().energy.work_of_forces);
  const SingularPassages &of_a = a.report().singular_passages, &of_b = b.report().singular_passages;
  ASSERT_EQ(of_a.count, of_b.count);
  for (std::size_t k = 0; k < of_a.first.size(); ++k) {
    EXPECT_EQ(of_a.first[k].time, of_b.first[k].time);
    EXPECT_EQ(of_a.first[k].reciprocal_condition, of_b.first[k].reciprocal_condition);
  }
}

class FourBarSnapshot : public testing::TestWithParam<Method> {};

/// The snapshot may be taken anywhere: before a flat place, on the way past it, behind it.
TEST_P(FourBarSnapshot, ARestoredRunPassesFlatPlacesBitByBit) {
  System system = make_four_bar(0.5, -1.0);
  system.masses[3] = 2.0;
  system.forces = {ConstantForce{"", {2}, VectorFunction(Vector3{0.0, -0.5, 0.0})}, Drag{"air", {3}, 0.01, 0.0}};
  MotionOptions options{.method = GetParam(), .rtol = 1e-8, .atol = 1e-10};
  if (has_fixed_steps(options.method)) options.step = 0.02;
  const double places[] = {0.3, 0.5, 1.0, 4.0};
  for (const double end : places) {
    SCOPED_TRACE(end);
    Simulation whole(system, options);
    std::vector<std::vector<std::byte>> saved;
    std::vector<double> times;
    ASSERT_TRUE(whole.advance_to(end).ok()) << whole.outcome().what;
    ASSERT_TRUE(whole
                    .advance_to(8.0,
                                [&](const MotionReport&) {
                                  saved.push_back(whole.save());
                                  times.push_back(whole.time());
                                  return true;
                                })
                    .ok());
    ASSERT_GE(whole.report().singular_passages.count, 1U);

    for (std::size_t k = 0; k + 1 < saved.size(); ++k) {
      SCOPED_TRACE(times[k]);
      Simulation other(system, options);
      other.restore(saved[k]);
      ASSERT_TRUE(other.advance_to(8.0).ok()) << other.outcome().what;
      expect_same_run(other, whole);
      if (HasFailure()) return;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Motion, FourBarSnapshot,
                         testing::Values(Method::Taylor, Method::Dop853, Method::Dopri5, Method::Rk4));

/// The steps of `taylor` lead beyond the places where branches part.
TEST(Singular, SeriesGoThroughFortyFourBarsInThreeHundredSteps) {
  Simulation simulation(make_many_four_bars(40), {.method = Method::Taylor, .rtol = 1e-10, .atol = 1e-12});

  ASSERT_TRUE(simulation.advance_to(20.0).ok()) << simulation.outcome().what;

  EXPECT_NEAR(simulation.positions()[3 * 41], 0.410901153762945, 1e-7);
  EXPECT_NEAR(simulation.positions()[3 * 41 + 1], 0.911679900971981, 1e-7);
  EXPECT_EQ(simulation.report().singular_passages.count, 20U);
  EXPECT_LT(simulation.report().steps, 400U);
}

/// Success does not rest on rounding: with other numbers in the tenth digit the motion goes the same way through all
/// places. A step that was tried at one place says nothing about the next one.
TEST(Singular, SeriesGoThroughFortyFourBarsThatAreSentOffALittleFaster) {
  for (const double more : {-4e-10, -1e-10, 1e-10, 3e-10, 5e-10, 1e-9}) {
    System system = make_many_four_bars(40);
    for (double& v : system.velocities) v *= 1.0 + more;
    Simulation simulation(system, {.method = Method::Taylor, .rtol = 1e-10, .atol = 1e-12});

    ASSERT_TRUE(simulation.advance_to(20.0).ok()) << simulation.outcome().what;

    EXPECT_NEAR(simulation.positions()[3 * 41], 0.410901153762945, 1e-7) << more;
    EXPECT_NEAR(simulation.positions()[3 * 41 + 1], 0.911679900971981, 1e-7) << more;
    EXPECT_EQ(simulation.report().singular_passages.count, 20U) << more;
  }
}

}  // namespace
}  // namespace tanor
