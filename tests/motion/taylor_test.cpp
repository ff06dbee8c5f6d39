/// Tests of method `taylor`: closed forms, what it counts, what it passes by other means.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "base/parallel.hpp"
#include "motion/elliptic.hpp"
#include "motion/taylor.hpp"
#include "motion/toys.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

using std::numbers::pi;

double distance(const Simulation& a, const Simulation& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.positions().size(); ++i)
    worst = larger(worst, std::abs(a.positions()[i] - b.positions()[i]));
  return worst;
}

/// Returns the error in IFToMM benchmark A01: l = 1, from (-1, 0) at rest, g = 9.81.
double error_of_pendulum(double t_end, double rtol, MotionReport* report = nullptr) {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({-1, 0, 0}, &system);
  system.supports = {{.points = {0}}};
  system.constraints = {Rods{"rod", {{0, 1}}}};
  system.forces = {scenes::gravity};
  Simulation simulation(system, {.method = Method::Taylor, .rtol = rtol, .atol = rtol});
  const Outcome outcome = simulation.advance_to(t_end);
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  if (report != nullptr) *report = simulation.report();
  const double angle = elliptic::swing(-0.5 * pi, std::sqrt(9.81), t_end).angle;
  const auto r = simulation.positions();
  return std::hypot(r[3] - std::sin(angle), r[5] + std::cos(angle));
}

TEST(Taylor, FollowsAPendulumForTwoThousandSeconds) {
  EXPECT_LT(error_of_pendulum(2000.0, 1e-7), 1e-3);
  EXPECT_LT(error_of_pendulum(2000.0, 1e-10), 1e-6);
  EXPECT_LT(error_of_pendulum(10.0, 1e-13), 1e-12);
}

TEST(Taylor, TakesOneFactorizationAStepAndASolveAnOrder) {
  MotionReport report;
  // The rounding of accelerations is measured at the start and after every 64 steps, with a factor beside the state and
  // one at it.
  const auto of_rounding = [&] { return 2 * (1 + report.steps / 64); };
  error_of_pendulum(10.0, 1e-10, &report);
  EXPECT_LE(report.counters.factorizations, report.steps + 4 + of_rounding());
  EXPECT_LE(report.counters.solves, report.steps * (20 + 3));  // the order at this tolerance, and projections
  EXPECT_EQ(report.rejected, 0u);
  EXPECT_LT(report.steps, 150u);  // dopri5 takes about 3000

  // Long steps turn rods far. A second factor, while it is cheap, leads back onto them.
  error_of_pendulum(10.0, 1e-4, &report);
  EXPECT_LE(report.counters.factorizations, 2 * report.steps + 4 + of_rounding());
  EXPECT_LE(report.counters.solves, report.steps * (10 + 3));
}

/// Such steps reach beyond where the series converges, which only the acceleration at their end tells. The motion is
/// chaotic: masses that differ by 1e-12 scatter the drift of 24 runs between 0.003 and 0.12, so the median of nine
/// counts.
TEST(Taylor, LongSeriesAtALooseToleranceAreHeldInCheckByTheirEnds) {
  std::vector<double> drifts;
  for (int run = 0; run < 9; ++run) {
    System chain = scenes::make_chain(20);
    for (std::size_t i = 0; i < chain.masses.size(); ++i) chain.masses[i] *= 1.0 + 1e-13 * run * static_cast<double>(i);
    Simulation simulation(chain, {.method = Method::Taylor, .rtol = 0.1, .atol = 0.01, .order = 24});
    ASSERT_TRUE(simulation.advance_to(3.0).ok()) << simulation.outcome().what;
    EXPECT_GT(simulation.report().rejected, 0U);
    drifts.push_back(std::abs(simulation.report().energy.drift_relative()));
  }
  std::ranges::nth_element(drifts, drifts.begin() + 4);
  EXPECT_LT(drifts[4], 0.1);
}

/// A toy with x'' = 2 x^3 from x = x' = 1, so that x = 1/(1 - t). Its series says nothing from t = 1 on.
class Blowup : public toys::Toy, private SeriesExpansion {
 public:
  Blowup() : Toy(1) {}

  std::size_t num_error_ratios = 0;

  Outcome push(double, const double* x, const double*, double* a) override {
    a[0] = 2.0 * x[0] * x[0] * x[0];
    return {};
  }
  ErrorRatios error_ratios(double t, const StepErrors& errors, double atol, double rtol) override {
    ++num_error_ratios;
    return Toy::error_ratios(t, errors, atol, rtol);
  }
  SeriesExpansion* series(std::string*) override { return this; }
  Power power_along(const Kinematics&, int) override { return {}; }
  bool has_cheap_terms() const override { return false; }
  bool leaves_out_terms() const override { return false; }
  std::span<const Index> neighbourhoods() const override { return {}; }
  void find_largest(std::span<double>) override {}
  Outcome expand(const Kinematics&, const double*, const Reactions&, const SeriesDemand&,
                 std::span<double* const> coefficients, SeriesExtent* extent) override {
    for (double* const coefficient : coefficients) *coefficient = 1.0;
    extent->smooth_until = std::numeric_limits<double>::infinity();
    return {};
  }
};

struct BlowupTest : testing::Test {
  BlowupTest() {
    for (State* state : {&from, &to}) state->x = state->v = state->a = {1.0};
    from.a = {2.0};
  }
  StepResult step(Taylor* taylor, double h) {
    to.t = h;
    return taylor->step(from, h, &to);
  }

  Blowup blowup;
  State from, to;
};

TEST_F(BlowupTest, ARejectedStepDoesNotLengthenTheNextOne) {
  Taylor taylor(MotionOptions{.rtol = 1e-8, .atol = 1e-8}, blowup);
  const double proposed = taylor.propose_step(from);

  EXPECT_GT(step(&taylor, 2.0).error, 1.0);

  EXPECT_EQ(taylor.propose_step(from), proposed);
}

/// Beyond t = 1 the fewest terms leave the least error; before it, all terms together do.
TEST_F(BlowupTest, TermsAreChosenForEachStepThatIsTried) {
  Taylor taylor(MotionOptions{.rtol = 1e-8, .atol = 1e-8}, blowup),
      other(MotionOptions{.rtol = 1e-8, .atol = 1e-8}, blowup);
  const double proposed = taylor.propose_step(from);
  const double error = step(&other, proposed).error, x = to.x[0];
  ASSERT_NEAR(x, 1.0 / (1.0 - proposed), 1e-7);

  EXPECT_GT(step(&taylor, 2.0).error, 1.0);

  EXPECT_EQ(step(&taylor, proposed).error, error);
  EXPECT_EQ(to.x[0], x);
}

TEST_F(BlowupTest, EachTermIsMeasuredOnce) {
  Taylor taylor(MotionOptions{.rtol = 1e-8, .atol = 1e-8, .order = 20}, blowup);
  taylor.propose_step(from);
  for (const double h : {3.0, 2.0, 1.5}) step(&taylor, h);

  EXPECT_LE(blowup.num_error_ratios, 20U + 6U) << "and the ends of three steps, which projections may move";
}

/// The same, where some terms are left out of a series that is wanted for a step.
struct ShortenedBlowup : Blowup {
  std::vector<double> wanted;

  Outcome expand(const Kinematics& at, const double* a, const Reactions& found, const SeriesDemand& demand,
                 std::span<double* const> coefficients, SeriesExtent* extent) override {
    wanted.push_back(demand.h);
    extent->longest = demand.h;
    return Blowup::expand(at, a, found, demand, coefficients, extent);
  }
};

struct ShortenedBlowupTest : testing::Test {
  ShortenedBlowupTest() {
    from.x = from.v = from.a = {1.0};
    first = taylor.propose_step(from);
    from.t = first;
  }

  ShortenedBlowup blowup;
  State from;
  double first = 0.0;
  Taylor taylor{MotionOptions{.rtol = 1e-8, .atol = 1e-8}, blowup};
};

TEST_F(ShortenedBlowupTest, ASeriesIsWantedForALittleMoreThanTheLastOne) {
  taylor.propose_step(from);

  ASSERT_EQ(blowup.wanted.size(), 2U);
  EXPECT_EQ(blowup.wanted[0], any_length);
  EXPECT_GT(blowup.wanted[1], first);
  EXPECT_LT(blowup.wanted[1], 1.5 * first);
}

TEST_F(ShortenedBlowupTest, ALongStepBringsAllTermsBack) {
  const double proposed = taylor.propose_step(from);
  State to = from;
  to.t = from.t + proposed;
  (void)taylor.step(from, proposed, &to);
  EXPECT_EQ(blowup.wanted.size(), 2U);
  to.t = from.t + 1.2 * proposed;
  (void)taylor.step(from, 1.2 * proposed, &to);

  ASSERT_EQ(blowup.wanted.size(), 3U);
  EXPECT_EQ(blowup.wanted[2], any_length);
}

TEST_F(ShortenedBlowupTest, ASnapshotAsksForTheSameSeriesAgain) {
  std::vector<double> before, after;
  Memory appended(&before);
  taylor.exchange_memory(appended);
  taylor.propose_step(from);
  Memory appended_after(&after);
  taylor.exchange_memory(appended_after);
  for (const std::vector<double>& numbers : {before, after}) {
    Taylor other(MotionOptions{.rtol = 1e-8, .atol = 1e-8}, blowup);
    Memory read(numbers);
    other.exchange_memory(read);
    other.propose_step(from);
    EXPECT_EQ(blowup.wanted.back(), blowup.wanted[1]);
  }
}

/// Its series ends at an order below that of others.
struct EndedBlowup : Blowup {
  std::uint8_t last;
  explicit EndedBlowup(int order) : last(static_cast<std::uint8_t>(order)) {}

  Outcome expand(const Kinematics& at, const double* a, const Reactions& found, const SeriesDemand& demand,
                 std::span<double* const> coefficients, SeriesExtent* extent) override {
    Outcome outcome = Blowup::expand(at, a, found, demand, coefficients, extent);
    for (double* const coefficient : coefficients.subspan(last + 1u)) *coefficient = 0.0;
    extent->last_term = {last};
    return outcome;
  }
};

/// A series that ends early misses no less than one that has no more terms, and little more.
TEST(Taylor, MeasuresTheErrorOfSeriesThatEndEarly) {
  constexpr double h = 0.2;
  constexpr int order = 20;
  for (const int last : {10, 13, 19}) {
    Blowup whole;
    EndedBlowup ended(last);
    const MotionOptions options{.rtol = 1e-8, .atol = 1e-8};
    MotionOptions of_few = options, of_many = options;
    of_few.order = last;
    of_many.order = order;
    Taylor few(of_few, whole), many(of_many, ended);
    State from, to;
    from.x = from.v = from.a = {1.0};
    from.a = {2.0};
    to = from;
    to.t = h;
    const double error = few.step(from, h, &to).error, x = to.x[0];
    const double measured = many.step(from, h, &to).error;
    ASSERT_EQ(to.x[0], x);
    EXPECT_GE(measured, (1.0 - 1e-12) * error) << last;
    EXPECT_LE(measured, (order + 1.0) / (last + 1.0) * (1.0 + 1e-12) * error) << last;
  }
}

TEST(Taylor, HigherOrdersTakeLongerSteps) {
  std::size_t last = 1000000;
  for (const int order : {6, 10, 16, 24}) {
    Simulation simulation(scenes::make_pendulum(),
                          {.method = Method::Taylor, .rtol = 1e-9, .atol = 1e-11, .order = order});
    ASSERT_TRUE(simulation.advance_to(3.0).ok());
    EXPECT_LT(simulation.report().steps, last) << order;
    last = simulation.report().steps;
  }
}

/// Drag |v| v has no series at rest. The first step is of another method, and the rest are series.
TEST(Taylor, PassesPlacesWithoutASeries) {
  System system = scenes::make_pendulum();
  system.forces.push_back(Drag{"air", {1}, 0.0, 0.5});
  Simulation series(system, {.method = Method::Taylor, .rtol = 1e-11, .atol = 1e-13});
  Simulation other(system, {.method = Method::Dop853, .rtol = 1e-12, .atol = 1e-14});
  ASSERT_TRUE(series.advance_to(1.0).ok()) << series.outcome().what;
  ASSERT_TRUE(other.advance_to(1.0).ok());
  EXPECT_LT(distance(series, other), 1e-10);
  EXPECT_NEAR(series.report().energy.drift_relative(), 0.0, 1e-10);
}

/// A point is thrown up along a line at v0 against gravity and drag c |v| v. With u = sqrt(m g/c) and T = u/g it has
///
///   v = u tan((t_top - t)/T) up to t_top = T atan(v0/u),   v = -u tanh((t - t_top)/T) from there on.
///
/// The series before the turn knows nothing of the function behind it.
TEST(Taylor, KeepsItsToleranceWhereAPointTurnsRoundAgainstDrag) {
  constexpr double g = 9.81;
  for (const double tolerance : {1e-6, 1e-8, 1e-10, 1e-12}) {
    for (const double c : {0.01, 0.2, 5.0}) {
      for (const double v0 : {0.5, 3.0, 6.75, 10.0}) {
        SCOPED_TRACE(testing::Message() << "tolerance " << tolerance << ", c = " << c << ", v0 = " << v0);
        const double u = std::sqrt(scenes::mass * g / c), time = u / g, top = time * std::atan(v0 / u);
        System system;
        scenes::add_point({0, 0, 0}, &system);
        system.velocities = {0, 0, v0};
        system.constraints = {Lines{"line", {0}, Vector3{0, 0, 0}, Vector3{0, 0, 1}}};
        system.forces = {scenes::gravity, Drag{"air", {0}, 0.0, c}};
        Simulation simulation(system, {.method = Method::Taylor, .rtol = tolerance, .atol = tolerance});

        ASSERT_TRUE(simulation.advance_to(2.0 * top + 0.1).ok()) << simulation.outcome().what;

        const double fallen = (top + 0.1) / time, height = u * time * std::log(std::hypot(1.0, v0 / u));
        EXPECT_NEAR(simulation.positions()[2], height - u * time * std::log(std::cosh(fallen)), 5.0 * tolerance);
        EXPECT_NEAR(simulation.velocities()[2], -u * std::tanh(fallen), 5.0 * tolerance);
        EXPECT_LT(simulation.report().steps, 40U);
      }
    }
  }
}

/// A table is a polynomial from knot to knot, and no step goes beyond a knot.
TEST(Taylor, StopsAtTheKnotsOfATable) {
  std::vector<double> times, values;
  for (int i = 0; i <= 20; ++i) {
    times.push_back(0.1 * i);
    values.push_back(0.02 * std::sin(3.0 * times.back()));
  }
  System system = scenes::make_pendulum();
  system.supports[0].displacement = {ScalarFunction::table(times, values), 0.0, 0.0};
  const MotionOptions options{.rtol = 1e-11, .atol = 1e-13, .start = StartMode::Project};
  MotionOptions taylor = options, other = options;
  taylor.method = Method::Taylor;
  other.method = Method::Dop853;
  other.step = 1e-3;
  Simulation series(system, taylor), second(system, other);
  ASSERT_TRUE(series.advance_to(2.0).ok()) << series.outcome().what;
  ASSERT_TRUE(second.advance_to(2.0).ok());
  EXPECT_LT(distance(series, second), 1e-9);
  EXPECT_EQ(series.report().rejected, 0u);
  EXPECT_NEAR(series.report().energy.drift_relative(), 0.0, 1e-10);
}

/// A moving support does work whose integral balances the energy.
TEST(Taylor, WorkOfSupportsAndForcesBalancesTheEnergy) {
  System system = scenes::make_pendulum();
  system.supports[0].displacement = {ScalarFunction::formula("0.03*sin(7*t)"), 0.0,
                                     ScalarFunction::formula("0.02*t^2")};
  system.forces.push_back(Drag{"air", {1}, 0.05, 0.0});
  system.velocities = {0.21, 0, 0, 0.21, 0, 0};
  Simulation simulation(system, {.method = Method::Taylor, .rtol = 1e-10, .atol = 1e-12, .start = StartMode::Project});
  ASSERT_TRUE(simulation.advance_to(3.0).ok()) << simulation.outcome().what;
  EXPECT_GT(std::abs(simulation.report().energy.work_of_supports), 1e-3);
  EXPECT_LT(simulation.report().energy.work_of_forces, -1e-3);
  EXPECT_NEAR(simulation.report().energy.drift_relative(), 0.0, 1e-10);
}

/// The power of a constraint, whatever it is given by, is its multiplier times its own rate in time.
TEST(Taylor, WorkOfConstraintsThatMoveBalancesTheEnergy) {
  const auto formula = [](const char* text) { return ScalarFunction::formula(text); };
  Parameter length;
  length.functions = {formula("1 + 0.2*sin(2*t)")};
  const VectorFunction moving{formula("0.1*sin(3*t)"), 0.0, formula("0.1*cos(2*t) - 0.1")},
      turning{formula("sin(t)"), 0.0, formula("cos(t)")};
  const std::vector<std::pair<Constraint, Vector3>> guides{
      {Rods{"rod", {{0, 1}}, length}, {1, 0, 0}},
      {Spheres{"sphere", {1}, moving, length}, {1, 0, 0}},
      {Circles{"circle", {1}, moving, turning, length}, {1, 0, 0}},
      {Planes{"plane", {1}, turning, formula("0.3*sin(2*t)")}, {1, 0, 0}},
      {Lines{"line", {1}, moving, {formula("cos(t)"), 0.0, formula("sin(t)")}}, {1, 0, 0}},
      {Pulleys{
           .name = "pulley", .pairs = {{1, 2}}, .a = {1, 0, 3}, .b = {2, 0, 4}, .length = formula("6 + 0.2*sin(2*t)")},
       {1, 0, 0}}};
  for (const auto& [guide, place] : guides) {
    System system;
    for (const Vector3& each : {Vector3{0, 0, 0}, place, Vector3{2, 0, 1}}) scenes::add_point(each, &system);
    system.supports = {{"support", {0}, {}}};
    system.constraints = {guide};
    system.forces = {Gravity{"gravity", {0.5, 1, -9.81}}};
    Simulation simulation(system,
                          {.method = Method::Taylor, .rtol = 1e-11, .atol = 1e-13, .start = StartMode::Project});
    ASSERT_TRUE(simulation.advance_to(1.0).ok()) << simulation.outcome().what;
    const EnergyReport& energy = simulation.report().energy;
    EXPECT_GT(std::abs(energy.work_of_supports), 1e-3 * energy.scale) << constraint_name(system, 0);
    EXPECT_LT(std::abs(energy.drift_relative()), 1e-9) << constraint_name(system, 0);
  }
}

/// Returns the energies of a coarse run of a free bead in a well, beside a point that nothing joins to it.
EnergyReport run_coarsely(const VectorFunction& displacement, const Constraint& beside) {
  System system;
  for (const Vector3& place : {Vector3{0, 0, 0}, Vector3{0, 0, -1}, Vector3{3, 0, 1}})
    scenes::add_point(place, &system);
  system.masses.assign(3, 1.0);
  system.supports = {{"support", {0}, displacement}};
  system.constraints = {beside};
  system.forces = {Potential{
      .name = "well", .points = {{2}}, .kernel = formula_potential("20*z1^2 + (x1 - 2)^4 + 3*x1*sin(5*z1)", 1)}};
  Simulation simulation(system, {.method = Method::Taylor, .rtol = 1e-3});
  EXPECT_TRUE(simulation.advance_to(5.0).ok()) << simulation.outcome().what;
  return simulation.report().energy;
}

/// A support or length that touches nothing that moves does no work, however coarse the series are. Their error is in
/// the drift.
TEST(Taylor, ErrorsOfTheSeriesDoNotCountAsWork) {
  const Rods rod{"rod", {{0, 1}}, 1.0};
  const Planes floor{"floor", {1}, Vector3{0, 0, 1}, -1.0};
  Rods timed = rod;
  timed.length = ScalarFunction::formula("1 + 0*t");
  const double drift = run_coarsely({}, rod).drift_relative();
  ASSERT_GT(std::abs(drift), 1e-6) << "a fine run proves nothing";
  for (const EnergyReport& energy :
       {run_coarsely({}, timed), run_coarsely({ScalarFunction::formula("0.1*sin(5*t)"), 0.0, 0.0}, floor)}) {
    EXPECT_EQ(energy.work_of_supports, 0.0);
    EXPECT_GT(std::abs(energy.drift_relative()), 1e-6);
  }
}

TEST(Taylor, GoesOnFromASnapshotBitByBit) {
  const MotionOptions options{.method = Method::Taylor, .rtol = 1e-9, .atol = 1e-11};
  Simulation whole(scenes::make_pendulum(), options), second(scenes::make_pendulum(), options);
  ASSERT_TRUE(whole.advance_to(0.5).ok());
  second.restore(whole.save());
  ASSERT_TRUE(whole.advance_to(1.0).ok());
  ASSERT_TRUE(second.advance_to(1.0).ok());
  EXPECT_EQ(distance(whole, second), 0.0);
}

/// Steps of 0.01 s come to within a rounding of the knots of a table, and go on beyond them.
TEST(Taylor, StepsOverKnotsThatLieARoundingAhead) {
  std::vector<double> times, places;
  for (int k = 0; k <= 40; ++k) {
    times.push_back(0.1 * k);
    places.push_back(0.1 * std::sin(0.5 * k));
  }
  System system = scenes::make_pendulum();
  system.supports[0].displacement = {ScalarFunction::table(times, places), 0.0, 0.0};
  const auto end = [&](double max_step) {
    Simulation simulation(system, {.method = Method::Taylor, .max_step = max_step, .start = StartMode::Project});
    EXPECT_TRUE(simulation.advance_to(4.0).ok()) << simulation.outcome().what;
    return simulation.positions()[5];
  };

  EXPECT_NEAR(end(0.01), end(0.0), 1e-7);
}

TEST(Taylor, IsWhatAutoTakesWhereEverythingHasASeries) {
  System system = scenes::make_pendulum();
  Simulation simulation(system);
  EXPECT_EQ(simulation.report().method, Method::Taylor);
  EXPECT_EQ(simulation.report().method_reason, "all constraints and forces have series in time");
  system.forces.push_back(PairForces{.name = "pairs", .points = {0, 1}, .law = PairLaw::Log, .strength = 0.1});
  EXPECT_EQ(Simulation(system).report().method, Method::Dop853);
  try {
    Simulation refused(system, {.method = Method::Taylor});
    FAIL() << "taylor took a force without a series";
  } catch (const InputError& error) {
    EXPECT_EQ(error.where(), "/motion/method");
    EXPECT_EQ(std::string(error.what()),
              "taylor: forces[1] cannot be expanded in time: pair forces have no series; take dop853, which needs no "
              "series, or auto");
  }
}

}  // namespace
}  // namespace tanor
