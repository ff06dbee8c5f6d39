#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>

#include "base/parallel.hpp"
#include "base/root_bracket.hpp"
#include "methods.hpp"
#include "motion/toys.hpp"

namespace tanor {
using namespace detail;
namespace {

using std::numbers::pi;
using toys::Block;
using toys::SwitchingToy;
using toys::Travel;

/// A point with x'' = c and event functions f(t, x, v). Each test says what a switch does.
class Free final : public SwitchingToy {
 public:
  using Function = std::function<double(double t, double x, double v)>;
  Free(double acceleration, std::vector<Function> functions)
      : SwitchingToy(1), acceleration_(acceleration), functions_(std::move(functions)) {}

  std::function<void(double* v)> on_switch = [](double*) {};
  std::vector<std::vector<std::size_t>> vanished;
  std::size_t evaluations = 0;

  Outcome push(double, const double*, const double*, double* a) override {
    ++evaluations;
    a[0] = acceleration_;
    return {};
  }
  std::size_t num_events() const override { return functions_.size(); }
  void evaluate_events(const Kinematics& at, const Reactions&, double* values) override {
    for (std::size_t k = 0; k < functions_.size(); ++k) values[k] = functions_[k](at.t, at.x[0], at.v[0]);
  }
  Outcome switch_equations(double t, const double* x, double* v, std::span<const std::size_t> which, const Request&,
                           const AccelerationOutput& to) override {
    switch_times.push_back(t);
    vanished.emplace_back(which.begin(), which.end());
    on_switch(v);
    Outcome found = push(t, x, v, to.a);
    *to.power = power(v);
    return found;
  }

  bool has_work() const override { return true; }
  Power power(const double* v) override { return {.forces = acceleration_ * v[0]}; }

  void forget_events() { functions_.clear(); }
  void push_with(double acceleration) { acceleration_ = acceleration; }

 private:
  double acceleration_;
  std::vector<Function> functions_;
};

const MotionOptions sharp{.step = 0.01, .rtol = 1e-10, .atol = 1e-12};

// ---- an oscillator with dry friction turns at (-1)^n (A - 2 n F/k), half a period apart ----

constexpr double stiffness = 4.0, amplitude = 1.0, friction = 0.44;  // F/k = 0.11, so that it sticks at the fifth turn

struct Oscillator {
  explicit Oscillator(Method method, const MotionOptions& options)
      : block(stiffness, 0.0, friction, friction), run(block, method, options, {amplitude}, {0.0}) {
    block.direction = -1;
    run.place(block, 0.0, {amplitude}, {0.0});
  }

  /// Returns the largest error of the instants of its turns.
  double error() const {
    double result = 0.0;
    for (std::size_t n = 0; n < block.switch_times.size(); ++n) {
      result = larger(result, std::abs(block.switch_times[n] - 0.5 * pi * static_cast<double>(n + 1)));
    }
    return result;
  }

  Block block;
  Travel run;
};

TEST(DryOscillatorTest, TurnsAndSticksWhereTheClosedFormDoes) {
  Oscillator oscillator(Method::Dopri5, sharp);

  const Outcome outcome = oscillator.run.advance(20.0);

  ASSERT_TRUE(outcome.ok()) << outcome.what;
  ASSERT_EQ(oscillator.block.switch_times.size(), 5u);
  EXPECT_LT(oscillator.error(), 1e-9);
  EXPECT_EQ(oscillator.block.direction, 0);
  EXPECT_NEAR(oscillator.run.integration.state.x[0], 0.1, 1e-9);
  EXPECT_EQ(oscillator.run.integration.state.v[0], 0.0);
  EXPECT_EQ(oscillator.run.report.events, 5u);
  EXPECT_NEAR(oscillator.run.report.last_event, 2.5 * pi, 1e-9);
  EXPECT_EQ(oscillator.run.integration.state.t, 20.0);
}

/// The phase of a scheme lags by the part c (omega h)^order of the angle.
struct Expected {
  Method method;
  double order, c;
};

class EqualStepsTest : public testing::TestWithParam<Expected> {};

TEST_P(EqualStepsTest, EventsHaveTheOrderOfTheScheme) {
  const auto [method, order, c] = GetParam();
  const auto measure = [method = method](double step) {
    Oscillator oscillator(method, {.step = step});
    EXPECT_TRUE(oscillator.run.advance(9.0).ok());
    EXPECT_EQ(oscillator.block.switch_times.size(), 5u);
    return oscillator.error();
  };
  const double coarse = measure(0.1), middle = measure(0.05), fine = measure(0.025);

  EXPECT_NEAR(fine / (c * std::pow(2.0 * 0.025, order) * 2.5 * pi), 1.0, 0.1);
  EXPECT_NEAR(std::log2(coarse / middle), order, 0.3);
  EXPECT_NEAR(std::log2(middle / fine), order, 0.3);
}

TEST_P(EqualStepsTest, AnEventDoesNotShiftTheTimesOfSteps) {
  Oscillator oscillator(GetParam().method, {.step = 0.1});
  std::vector<double> ends;

  ASSERT_TRUE(oscillator.run
                  .advance(3.0,
                           [&](const MotionReport&) {
                             ends.push_back(oscillator.run.integration.state.t);
                             return true;
                           })
                  .ok());

  ASSERT_EQ(ends.size(), 30u);
  for (std::size_t k = 0; k < ends.size(); ++k) EXPECT_DOUBLE_EQ(ends[k], 0.1 * static_cast<double>(k + 1));
  EXPECT_EQ(oscillator.run.report.events, 1u);
  EXPECT_EQ(oscillator.run.report.steps, 31u) << "one of them in two pieces";
}

INSTANTIATE_TEST_SUITE_P(Methods, EqualStepsTest,
                         testing::Values(Expected{Method::Rk4, 4.0, 1.0 / 120},
                                         Expected{Method::Rattle, 2.0, 1.0 / 24}),
                         [](const auto& instance) { return std::string(name_of(instance.param.method)); });

// ---- a drawn block sticks until the spring holds F_s, slides with F_d < F_s, and sticks again ----

class DrawnBlockTest : public testing::TestWithParam<Method> {};

/// While the block slides, y = u t - x - F_d/k goes as d cos + u/omega sin with d = (F_s - F_d)/k. It stops at
/// tan(omega tau/2) = -d omega/u with y = -d, after which the spring is drawn for 2 d/u.
TEST_P(DrawnBlockTest, SticksAndSlipsWhenTheClosedFormDoes) {
  const double omega = std::sqrt(stiffness), drive = 0.1, rest = 1.0, sliding = 0.8;
  const double d = (rest - sliding) / stiffness;
  Block block(stiffness, drive, rest, sliding);
  Travel run(block, GetParam(), {.step = GetParam() == Method::Rattle ? 5e-4 : 4e-3, .rtol = 1e-10, .atol = 1e-12},
             {0.0}, {0.0});

  const Outcome outcome = run.advance(12.0);

  ASSERT_TRUE(outcome.ok()) << outcome.what;
  const double slide = 2.0 * (pi - std::atan(d * omega / drive)) / omega, wait = 2.0 * d / drive;
  std::vector<double> expected;
  for (double t = rest / (stiffness * drive); t < 12.0; t += wait) {
    expected.push_back(t);
    if ((t += slide) < 12.0) expected.push_back(t);
  }
  ASSERT_EQ(block.switch_times.size(), expected.size());
  ASSERT_GE(expected.size(), 6u);
  for (std::size_t n = 0; n < expected.size(); ++n) {
    EXPECT_NEAR(block.switch_times[n], expected[n], GetParam() == Method::Rattle ? 1e-6 : 2e-9) << n;
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, DrawnBlockTest, testing::ValuesIn(sampled_methods),
                         [](const auto& instance) { return std::string(name_of(instance.param)); });

// ---- where in a step ----

const MotionOptions tenth{.step = 0.1};

/// Returns where the event function (x - 0.56)^2 - w^2 with x = t, which is below 0 for a time of 2 w inside one step,
/// is found to vanish, or -1.
double find_dip(double half_width) {
  Free toy(0.0, {[=](double, double x, double) { return (x - 0.56) * (x - 0.56) - half_width * half_width; }});
  Travel run(toy, Method::Rk4, tenth, {0.0}, {1.0});
  toy.on_switch = [&](double*) { toy.forget_events(); };
  EXPECT_TRUE(run.advance(1.0).ok());
  EXPECT_EQ(run.integration.state.t, 1.0);
  return toy.switch_times.size() == 1 ? toy.switch_times[0] : -1.0;
}

TEST(EventPlaceTest, ADipInsideAStepIsMet) {
  EXPECT_NEAR(find_dip(0.02), 0.54, 1e-12);
  EXPECT_NEAR(find_dip(1e-3), 0.559, 1e-12) << "between the places that are looked at: a parabola points there";
}

TEST(EventPlaceTest, ADipThatStaysAboveZeroIsNoEvent) {
  Free toy(0.0, {[](double, double x, double) { return (x - 0.56) * (x - 0.56) + 1e-6; }});
  Travel run(toy, Method::Rk4, tenth, {0.0}, {1.0});

  ASSERT_TRUE(run.advance(1.0).ok());

  EXPECT_TRUE(toy.switch_times.empty());
}

TEST(EventPlaceTest, TheEarliestEventOfAStepIsMetFirst) {
  Free toy(0.0, {[](double, double x, double) { return 0.58 - x; }, [](double, double x, double) { return 0.53 - x; },
                 [](double, double x, double) { return 0.55 - x * x / 0.55; }});
  Travel run(toy, Method::Rk4, tenth, {0.0}, {1.0});
  toy.on_switch = [&](double*) { toy.forget_events(); };

  ASSERT_TRUE(run.advance(1.0).ok());

  ASSERT_EQ(toy.vanished.size(), 1u);
  EXPECT_EQ(toy.vanished[0], std::vector<std::size_t>{1});
  EXPECT_NEAR(toy.switch_times[0], 0.53, 1e-15);
}

TEST(EventPlaceTest, TwoEventsAtOneInstantAreSwitchedTogether) {
  Free toy(0.0, {[](double, double x, double) { return 3.0 * (0.53 - x); },
                 [](double, double x, double) { return 0.5300001 - x; },
                 [](double, double x, double) { return 0.53 * 0.53 - x * x; }});
  Travel run(toy, Method::Rk4, tenth, {0.0}, {1.0});
  toy.on_switch = [&](double*) { toy.forget_events(); };

  ASSERT_TRUE(run.advance(1.0).ok());

  ASSERT_EQ(toy.vanished.size(), 1u);
  EXPECT_EQ(toy.vanished[0], (std::vector<std::size_t>{0, 2}));
}

TEST(EventPlaceTest, AnEventAtTheEndOfAStepIsMetAtThatEnd) {
  Free toy(0.0, {[](double t, double, double) { return 0.5 - t; }});
  Travel run(toy, Method::Rk4, tenth, {0.0}, {1.0});
  toy.on_switch = [&](double*) { toy.forget_events(); };

  ASSERT_TRUE(run.advance(1.0).ok());

  ASSERT_EQ(toy.switch_times.size(), 1u);
  EXPECT_EQ(toy.switch_times[0], 0.5);
  EXPECT_EQ(run.report.steps, 10u);
}

TEST(EventPlaceTest, AFunctionThatJumpsIsMetAtItsJump) {
  Free toy(0.0, {[](double t, double, double) { return t < 0.537 ? 1.0 : -1.0; }});
  Travel run(toy, Method::Rk4, tenth, {0.0}, {1.0});
  toy.on_switch = [&](double*) { toy.forget_events(); };

  ASSERT_TRUE(run.advance(1.0).ok());

  ASSERT_EQ(toy.switch_times.size(), 1u);
  EXPECT_NEAR(toy.switch_times[0], 0.537, 1e-14);
}

/// A function that is 0 at the start and rises is no event there, but it is one where it falls again, however soon.
TEST(EventPlaceTest, AFlightFromTheGroundEndsWhereItFallsBack) {
  for (const double speed : {0.4, 1e-3}) {
    Free toy(-10.0, {[](double, double x, double) { return x; }});
    Travel run(toy, Method::Rk4, tenth, {0.0}, {speed});
    toy.on_switch = [&](double* v) { v[0] = 0.0, toy.forget_events(); };

    ASSERT_TRUE(run.advance(1.0).ok());

    ASSERT_EQ(toy.switch_times.size(), 1u) << speed;
    EXPECT_NEAR(toy.switch_times[0], speed / 5.0, 1e-15) << speed;
  }
}

TEST(EventPlaceTest, AFunctionThatFallsAtTheStartIsMetAtTheStart) {
  Free toy(0.0, {[](double, double x, double) { return -x; }});
  Travel run(toy, Method::Dopri5, sharp, {0.0}, {1.0});
  toy.on_switch = [&](double*) { toy.forget_events(); };

  ASSERT_TRUE(run.advance(1.0).ok());

  EXPECT_EQ(toy.switch_times, std::vector<double>{0.0});
}

/// A force pushes from x = 0.53 on. Its power begins there at once and grows with v.
TEST(EventWorkTest, IsThatOfTheEquationsBeforeAndAfter) {
  for (const Method method : sampled_methods) {
    Free toy(0.0, {[](double, double x, double) { return 0.53 - x; }});
    Travel run(toy, method, tenth, {0.0}, {1.0});
    toy.on_switch = [&](double*) { toy.forget_events(), toy.push_with(2.0); };

    ASSERT_TRUE(run.advance(1.0).ok());

    const double v = 1.0 + 2.0 * 0.47;
    EXPECT_NEAR(run.integration.state.v[0], v, 1e-14);
    EXPECT_NEAR(run.integration.state.work.forces, 0.5 * (v * v - 1.0), 1e-14) << name_of(method);
  }
}

/// The run goes on after an event with a good first step, not with the short one that ended there.
TEST(EventPlaceTest, StepsAfterAnEventAreAsLongAsBefore) {
  Oscillator with(Method::Dopri5, sharp);
  ASSERT_TRUE(with.run.advance(2.5 * pi).ok());
  Oscillator without(Method::Dopri5, sharp);
  ASSERT_TRUE(without.run.advance(0.49 * pi).ok());
  ASSERT_EQ(without.run.report.events, 0u);

  EXPECT_LE(with.run.report.steps, 5 * (without.run.report.steps + 4));
}

TEST(EventPlaceTest, FunctionsFarFromZeroAreNotSearchedInsideSteps) {
  const auto count = [](std::vector<Free::Function> functions) {
    Free toy(-1.0, std::move(functions));
    Travel run(toy, Method::Rk4, tenth, {0.0}, {1.0});
    EXPECT_TRUE(run.advance(1.0).ok());
    return toy.evaluations;
  };

  const std::size_t without = count({}), with = count({[](double, double x, double) { return 2.0 - x; }});

  EXPECT_EQ(with - without, 1u + 4u) << "at the start, and in the first step, of which no trend is known";
}

// ---- trouble ----

TEST(EndlessSwitchingTest, IsReportedWithItsTime) {
  for (const Method method : sampled_methods) {
    Free toy(0.0, {[](double, double x, double) { return 0.25 - x; }});
    Travel run(toy, method, {.step = 0.1, .rtol = 1e-8, .atol = 1e-10}, {0.0}, {1.0});

    const Outcome outcome = run.advance(1.0);

    EXPECT_EQ(outcome.status, Status::NotConverged);
    EXPECT_EQ(outcome.what, "equations switch without end at t = 0.25");
    EXPECT_NEAR(run.integration.state.t, 0.25, 1e-15);
    EXPECT_EQ(toy.switch_times.size(), 51u);
  }
}

/// A ball that keeps half of its speed at each bounce comes to rest after infinitely many bounces. They are at
/// t_n = T (3 - 4/2^n), where T is the instant of the first.
TEST(EndlessSwitchingTest, IsReportedWhereSwitchesAccumulate) {
  Free toy(-10.0, {[](double, double x, double) { return x; }});
  Travel run(toy, Method::Dopri5, sharp, {0.05}, {0.0});
  toy.on_switch = [](double* v) { v[0] *= -0.5; };

  const Outcome outcome = run.advance(1.0);

  EXPECT_EQ(outcome.status, Status::NotConverged);
  EXPECT_NEAR(run.integration.state.t, 0.3, 1e-7) << "flights of 1e-8 s are lower than the rounding of heights";
  ASSERT_GT(toy.switch_times.size(), 20u);
  for (std::size_t n = 0; n < 20; ++n) {
    EXPECT_NEAR(toy.switch_times[n], 0.1 * (3.0 - 2.0 * std::exp2(-static_cast<double>(n))), 1e-9) << n;
  }
}

TEST(EventFunctionTest, MustBeFinite) {
  Free toy(0.0, {[](double, double x, double) { return 1.0 + std::sqrt(0.33 - x); }});
  Travel run(toy, Method::Rk4, tenth, {0.0}, {1.0});

  const Outcome outcome = run.advance(1.0);

  EXPECT_LT(run.integration.state.t, 0.33);
  EXPECT_EQ(outcome.status, Status::NotFinite) << outcome.what;
}

// ---- snapshots ----

class EventSnapshotTest : public testing::TestWithParam<Method> {};

TEST_P(EventSnapshotTest, ARestoredRunGoesOnBitByBitAcrossEvents) {
  const MotionOptions options{.step = 0.05, .rtol = 1e-8, .atol = 1e-10};
  Oscillator whole(GetParam(), options);
  ASSERT_TRUE(whole.run.advance(9.0).ok());

  for (const std::size_t stop : {3u, 40u, 70u, 100u}) {
    Oscillator first(GetParam(), options), second(GetParam(), options);
    std::size_t steps = 0;
    ASSERT_TRUE(first.run.advance(9.0, [&](const MotionReport&) { return ++steps < stop; }).ok());
    ASSERT_LT(first.run.integration.state.t, 9.0);
    Snapshot snapshot;
    snapshot.report = first.run.report;
    first.run.integration.write(&snapshot);

    second.run.integration.restore(snapshot);
    second.run.report = snapshot.report;
    const State& state = first.run.integration.state;
    second.run.place(second.block, state.t, state.x, state.v);
    ASSERT_TRUE(second.run.advance(9.0).ok());

    EXPECT_EQ(second.run.integration.state.x, whole.run.integration.state.x) << stop;
    EXPECT_EQ(second.run.integration.state.v, whole.run.integration.state.v) << stop;
    EXPECT_EQ(second.run.report.events, whole.run.report.events);
    EXPECT_EQ(second.run.report.last_event, whole.run.report.last_event);
    EXPECT_EQ(second.run.report.steps, whole.run.report.steps);
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, EventSnapshotTest, testing::ValuesIn(sampled_methods),
                         [](const auto& instance) { return std::string(name_of(instance.param)); });

// ---- the parts ----

TEST(DenseOutputTest, IsExactForPolynomialsOfDegreeFive) {
  const auto x = [](double t) { return 1 + t * (2 + t * (-3 + t * (1 + t * (0.5 - 2 * t)))); };
  const auto v = [](double t) { return 2 + t * (-6 + t * (3 + t * (2 - 10 * t))); };
  const auto a = [](double t) { return -6 + t * (6 + t * (6 - 40 * t)); };
  const auto at = [&](double t) {
    State state;
    state.t = t;
    state.x = {x(t)};
    state.v = {v(t)};
    state.a = {a(t)};
    return state;
  };
  const State from = at(0.3), to = at(1.1);
  toys::Block block(1.0, 0.0, 0.0, 0.0);
  const std::unique_ptr<Scheme> scheme = make_scheme(Method::Rk4, {}, block);
  DenseOutput dense(*scheme, from, to);

  for (const double fraction : {0.0, 0.1, 0.5, 0.77, 1.0}) {
    double found_x = 0.0, found_v = 0.0;
    ASSERT_TRUE(dense.evaluate(Parallel(1), fraction, &found_x, &found_v).ok());
    EXPECT_NEAR(found_x, x(dense.time(fraction)), 1e-14);
    EXPECT_NEAR(found_v, v(dense.time(fraction)), 1e-13);
  }
}

int count_evaluations(const std::function<double(double)>& f, double tolerance, double* root) {
  RootBracket bracket(0.0, f(0.0), 1.0, f(1.0), tolerance);
  int count = 0;
  for (; !bracket.is_narrow(); ++count) {
    const double x = bracket.next();
    bracket.narrow(x, f(x));
  }
  *root = bracket.root();
  return count;
}

TEST(RootBracketTest, IsFastOnSmoothFunctionsAndNeverSlowerThanBisection) {
  double root = 0.0;
  EXPECT_LE(count_evaluations([](double x) { return std::cos(x) - x; }, 1e-10, &root), 9);
  EXPECT_NEAR(root, 0.7390851332151607, 1e-10);
  // Bisection takes log2(1/(2e-10)) = 32.2 evaluations.
  EXPECT_LE(count_evaluations([](double x) { return x < 0.3 ? 1.0 : -1e-3; }, 1e-10, &root), 34);
  EXPECT_NEAR(root, 0.3, 2e-10);
  EXPECT_LE(count_evaluations([](double x) { return std::pow(0.9 - x, 9); }, 1e-10, &root), 34);
  EXPECT_NEAR(root, 0.9, 2e-10);
}

}  // namespace
}  // namespace tanor
