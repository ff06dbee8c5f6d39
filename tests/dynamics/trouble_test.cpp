/// Systems and states without a (unique) answer are reported by status and name, never by a crash or a NaN, and have no
/// effect on later calls.

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "random_systems.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Makes a chain 0 -- 1 -- 2 -- 3 bent in a plane, with gravity.
System make_bent_chain() {
  System system = scenes::make_chain_through({{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {1.5, 0.8, 0.0}, {2.5, 0.7, 0.0}});
  system.masses.assign(4, 1.0);
  return system;
}

struct Answer {
  SolveReport report;
  std::vector<double> w, lambda;
};

Answer solve(Dynamics& dynamics, const std::vector<double>& r, const std::vector<double>& v) {
  Answer answer{{}, std::vector<double>(r.size(), -1.0), std::vector<double>(dynamics.num_equations(), -1.0)};
  answer.report = dynamics.solve({.time = 0.0, .positions = r, .velocities = v},
                                 {.accelerations = answer.w, .multipliers = answer.lambda});
  return answer;
}

Answer solve_at_rest(const System& system) {
  Dynamics dynamics(system);
  return solve(dynamics, system.positions, std::vector<double>(system.positions.size(), 0.0));
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// ---- K without full rank -----------------------------------------------------------------------------------------

TEST(Trouble, DoubledRodIsRedundantAndNamedInEveryOrdering) {
  const Answer single = solve_at_rest(make_bent_chain());
  System system = make_bent_chain();
  system.constraints.push_back(Rods{"brace", {{2, 1}}, {}, {}});
  for (const Ordering ordering : {Ordering::Natural, Ordering::Amd, Ordering::Metis, Ordering::Nesdis}) {
    Dynamics dynamics(system, {.ordering = ordering});

    const Answer answer = solve(dynamics, system.positions, std::vector<double>(12, 0.0));
    const RankReport rank = dynamics.rank({.time = 0.0, .positions = system.positions});

    ASSERT_TRUE(answer.report.outcome.ok()) << answer.report.outcome.what;
    for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(answer.w[i], single.w[i], 1e-13);
    // The two rods share the load, which is the choice with the smallest multipliers.
    EXPECT_NEAR(answer.lambda[1], 0.5 * single.lambda[1], 1e-13);
    EXPECT_NEAR(answer.lambda[3], 0.5 * single.lambda[1], 1e-13);
    EXPECT_EQ(rank.rank, 3U);
    EXPECT_EQ(rank.degrees_of_freedom, 6U);
    EXPECT_EQ(rank.multipliers_unique, (std::vector<bool>{true, false, true, false}));
    ASSERT_EQ(rank.dependences.size(), 1U);
    const std::string& what = rank.dependences[0].what;
    EXPECT_TRUE(what == "rods[1] depends on brace[0]" || what == "brace[0] depends on rods[1]") << what;
  }
}

TEST(Trouble, TautChainBetweenTwoSupportsIsTold) {
  // The chain is straight between its ends, so that rods and supports hold each other and the tension is not
  // determined.
  System system;
  Rods rods;
  for (Index k = 0; k <= 5; ++k) {
    for (const double x : {0.25 * k, 0.0, 0.0}) system.positions.push_back(x);
    if (k > 0) rods.pairs.push_back({k - 1, k});
  }
  system.masses.assign(6, 1.0);
  system.supports = {{"", {0, 5}, {}}};
  system.constraints = {rods};
  Dynamics dynamics(system);

  const Answer answer = solve(dynamics, system.positions, std::vector<double>(18, 0.0));
  const RankReport rank = dynamics.rank({.time = 0.0, .positions = system.positions});

  EXPECT_TRUE(answer.report.outcome.ok()) << answer.report.outcome.what;
  EXPECT_EQ(rank.rank, 4U);
  EXPECT_EQ(rank.multipliers_unique, std::vector<bool>(5, false));
  EXPECT_EQ(rank.prestress_rigid_points, (std::vector<Index>{1, 2, 3, 4}));
}

/// Makes a flat square net of unit meshes whose border is held.
System make_framed_net(Index side) {
  System system;
  Rods rods;
  Support border;
  for (Index x = 0; x < side; ++x) {
    for (Index y = 0; y < side; ++y) {
      const Index i = x * side + y;
      for (const double c : {1.0 * x, 1.0 * y, 0.0}) system.positions.push_back(c);
      system.masses.push_back(1.0);
      if (x == 0 || y == 0 || x == side - 1 || y == side - 1) border.points.push_back(i);
      if (x > 0) rods.pairs.push_back({i - side, i});
      if (y > 0) rods.pairs.push_back({i - 1, i});
    }
  }
  system.supports = {border};
  system.constraints = {rods};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}

TEST(Trouble, FlatNetInAStiffFrameIsTautEverywhere) {
  System system = make_framed_net(6);
  std::vector<double> r = system.positions, v(r.size(), 0.0);
  Dynamics dynamics(system);

  const StartReport report = dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Check);
  const RankReport rank = dynamics.rank({.time = 0.0, .positions = r, .velocities = v});

  EXPECT_TRUE(report.outcome.ok()) << report.outcome.what;
  // Four lines each way are held at both ends, and the frame itself has 20 rods.
  EXPECT_EQ(rank.dependences.size(), 8U + 20U);
  EXPECT_EQ(rank.prestress_rigid_points.size(), 16U);
}

TEST(Trouble, PointAtTheSingularPlaceOfAnAngleIsSingular) {
  // The system is asked at three points in a line, where cos = -1 has no slope.
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0};
  system.masses.assign(3, 1.0);
  system.constraints = {Angles{"bend", {{0, 1, 2}}, {}}};

  Dynamics dynamics(system);
  const Answer answer =
      solve(dynamics, std::vector<double>{0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0}, std::vector<double>(9, 0.0));

  EXPECT_EQ(answer.report.outcome.status, Status::Singular);
  EXPECT_TRUE(contains(answer.report.outcome.what, "gradient of bend[0] vanishes")) << answer.report.outcome.what;
}

TEST(Trouble, SplitOfARedundantSystemIsThatOfItsIndependentRows) {
  const System single = make_bent_chain();
  System system = single;
  system.constraints.push_back(Rods{"brace", {{2, 1}}, {}, {}});
  const std::vector<double> v{0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 2.0, 0.0, 1.0, 0.0};
  Dynamics dynamics(system), reference(single);
  const StateView state{.time = 0.0, .positions = system.positions, .velocities = v};

  const Split split = dynamics.split(state), expected = reference.split(state);

  ASSERT_TRUE(split.outcome.ok()) << split.outcome.what;
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_NEAR(split.normal_accelerations[i], expected.normal_accelerations[i], 1e-12);
    EXPECT_NEAR(split.tangent_accelerations[i], expected.tangent_accelerations[i], 1e-12);
    EXPECT_NEAR(split.normal_forces[i], expected.normal_forces[i], 1e-12);
  }
}

TEST(Trouble, RodsOfOnePairThatMoveApartContradictEachOther) {
  System system = make_bent_chain();
  system.constraints.push_back(Rods{"brace", {{2, 1}}, ScalarFunction::formula("0.9433981132056604+0.1*t^2"), {}});

  const Answer answer = solve_at_rest(system);

  EXPECT_EQ(answer.report.outcome.status, Status::Contradictory);
  const std::string& what = answer.report.outcome.what;
  EXPECT_TRUE(contains(what, "rods[1]") && contains(what, "contradicts") && contains(what, "brace[0]")) << what;
  EXPECT_EQ(answer.w, std::vector<double>(12, -1.0)) << "arrays are left alone";
}

TEST(Trouble, RodsOfOnePairAndTwoLengthsContradictEachOther) {
  System system = make_bent_chain();
  system.constraints.push_back(Rods{"brace", {{2, 1}}, 0.9434, {}});
  Dynamics dynamics(system);
  std::vector<double> r = system.positions, v(12, 0.0);

  const StartReport start = dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Check);

  EXPECT_EQ(start.outcome.status, Status::Contradictory);
  const std::string& what = start.outcome.what;
  EXPECT_TRUE(contains(what, "rods[1]") && contains(what, "brace[0]")) << what;
}

// ---- states that are no states -----------------------------------------------------------------------------------

class BadState : public testing::Test {
 protected:
  const System system = make_bent_chain();
  Dynamics dynamics{system};
  const std::vector<double> at_rest = std::vector<double>(12, 0.0);

  std::vector<double> with(std::vector<double> numbers, std::size_t place, double value) const {
    numbers[place] = value;
    return numbers;
  }

  /// Expects the answer of a fresh object.
  void expect_recovery() {
    const Answer fresh = solve_at_rest(system), again = solve(dynamics, system.positions, at_rest);
    ASSERT_TRUE(again.report.outcome.ok()) << again.report.outcome.what;
    EXPECT_EQ(again.w, fresh.w);
    EXPECT_EQ(again.lambda, fresh.lambda);
  }
};

TEST_F(BadState, NumbersThatAreNotFiniteAreToldAndForgotten) {
  for (const double bad : {nan, HUGE_VAL}) {
    for (const std::size_t place : {std::size_t{3}, std::size_t{11}}) {
      EXPECT_EQ(solve(dynamics, with(system.positions, place, bad), at_rest).report.outcome.status, Status::NotFinite);
      EXPECT_EQ(solve(dynamics, system.positions, with(at_rest, place, bad)).report.outcome.status, Status::NotFinite);
    }
  }
  expect_recovery();
}

TEST_F(BadState, VelocitiesThatOverflowAreNotFinite) {
  EXPECT_EQ(solve(dynamics, system.positions, with(at_rest, 4, 1e200)).report.outcome.status, Status::NotFinite);
  expect_recovery();
}

TEST_F(BadState, PointsOnTopOfEachOtherAreToldAndForgotten) {
  std::vector<double> coincident = system.positions;
  for (std::size_t k = 0; k < 3; ++k) coincident[6 + k] = coincident[3 + k];

  const Answer answer = solve(dynamics, coincident, at_rest);

  EXPECT_FALSE(answer.report.outcome.ok());
  expect_recovery();
}

TEST_F(BadState, ProjectionsOfBadNumbersAreToldAndForgotten) {
  // This is the first of all calls, whose state must not stay.
  std::vector<double> bad = with(system.positions, 3, nan), v = with(at_rest, 4, nan), r = system.positions;

  EXPECT_FALSE(dynamics.project_positions({.time = 0.0, .positions = bad}).outcome.ok());
  EXPECT_FALSE(dynamics.project_velocities({.time = 0.0, .positions = bad, .velocities = v}).outcome.ok());
  EXPECT_FALSE(dynamics.project_velocities({.time = 0.0, .positions = r, .velocities = v}).outcome.ok());

  expect_recovery();
}

/// A system whose tables end before t = 2 s. `dynamics` is asked at 0.5 s and then at 2 s, and `fresh` only at 0.5 s.
struct RefusedTime {
  explicit RefusedTime(const System& system) : dynamics(system), fresh(system), v(system.velocities.size(), 0.1) {
    expected = accelerations_at(0.5, &fresh);
    (void)accelerations_at(0.5, &dynamics);
    EXPECT_THROW((void)accelerations_at(2.0, &dynamics), InputError);
  }

  std::vector<double> accelerations_at(double t, Dynamics* of) const {
    std::vector<double> w(v.size());
    EXPECT_TRUE(of->solve({.time = t, .positions = of->system().positions, .velocities = v}, {.accelerations = w})
                    .outcome.ok());
    return w;
  }

  Dynamics dynamics, fresh;
  std::vector<double> v, expected;
};

TEST(Trouble, TimeOutsideATableIsAnInputErrorAndForgotten) {
  // The sphere's moving center comes in time before the rod's table, which ends at 1.
  System system = make_bent_chain();
  std::get<Rods>(system.constraints[0]).length = ScalarFunction::table({0.0, 0.5, 1.0}, {1.0, 1.1, 1.0});
  system.constraints.push_back(
      Spheres{"", {3}, VectorFunction(ScalarFunction::formula("5*t"), 0.0, -2.0), ScalarFunction::formula("2+t")});

  RefusedTime refused(system);

  EXPECT_EQ(refused.accelerations_at(0.5, &refused.dynamics), refused.expected);
}

TEST(Trouble, ATimeThatOneTableRefusesLeavesEarlierTimesUsable) {
  // The rods' length is set first and stands at the new time when the pulley's table refuses.
  System system = make_bent_chain();
  std::get<Rods>(system.constraints[0]).length = ScalarFunction::formula("1+0.1*t^2");
  system.constraints.push_back(
      Pulleys{"", {{1, 3}}, {0.0, 0.0, 2.0}, {3.0, 0.0, 2.0}, ScalarFunction::table({0.0, 0.5, 1.0}, {4.0, 4.1, 4.0})});

  RefusedTime refused(system);

  const StateView then{.time = 0.5, .positions = system.positions};
  EXPECT_EQ(refused.dynamics.position_violation(then), refused.fresh.position_violation(then));
}

TEST(Trouble, SupportsThatMoveApartContradictTheRodBetweenThem) {
  // In (0) - (1) -> t^2 the rod "bar" joins the two, and "link" hangs on the second.
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, -1.0};
  system.masses.assign(3, 1.0);
  system.supports = {{"", {0}, {}}, {"", {1}, VectorFunction(ScalarFunction::formula("t^2"), 0.0, 0.0)}};
  system.constraints = {Rods{"bar", {{0, 1}}, {}, {}}, Rods{"link", {{1, 2}}, {}, {}}};
  Dynamics dynamics(system);
  std::vector<double> r = system.positions, v(9, 0.0);

  const Answer answer = solve(dynamics, r, v);
  const ProjectionReport projected = dynamics.project_positions({.time = 0.5, .positions = r});

  EXPECT_EQ(answer.report.outcome.status, Status::Contradictory);
  EXPECT_TRUE(contains(answer.report.outcome.what, "bar[0]")) << answer.report.outcome.what;
  EXPECT_EQ(projected.outcome.status, Status::Contradictory);
  EXPECT_TRUE(contains(projected.outcome.what, "bar[0]")) << projected.outcome.what;
}

TEST(Trouble, ContradictoryLengthsDoNotConverge) {
  // The lengths are those of a triangle with sides 1, 1 and 3.
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.8, 0.0};
  system.masses.assign(3, 1.0);
  system.constraints = {Rods{"side", {{0, 1}, {1, 2}, {2, 0}}, std::vector{1.0, 1.0, 3.0}, {}}};
  Dynamics dynamics(system);
  std::vector<double> r = system.positions, v(9, 0.0);

  const ProjectionReport projected = dynamics.project_positions({.time = 0.0, .positions = r});
  const StartReport start = dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Project);

  EXPECT_FALSE(projected.outcome.ok());
  EXPECT_FALSE(start.outcome.ok());
  EXPECT_EQ(r, system.positions) << "arrays are left alone";
}

}  // namespace
}  // namespace tanor
