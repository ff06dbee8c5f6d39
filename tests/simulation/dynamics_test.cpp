/// Dynamics solves forward dynamics in its caller's arrays, for systems of every size and with every option.

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "dynamics/solved.hpp"
#include "measures.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

// ---- small and empty systems -------------------------------------------------------------------------------------

System falling_points(std::size_t count) {
  System system;
  for (std::size_t i = 0; i < count; ++i) {
    for (const double x : {static_cast<double>(i), 0.0, 0.0}) system.positions.push_back(x);
    system.masses.push_back(1.0 + static_cast<double>(i));
  }
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}

TEST(Dynamics, SinglePointFallsFreely) {
  Dynamics dynamics(falling_points(1));
  std::vector<double> w(3, nan), eta(3, nan);

  const SolveReport report = dynamics.solve(
      {.time = 0.0, .positions = dynamics.system().positions, .velocities = dynamics.system().velocities},
      {.accelerations = w, .reactions = eta});

  EXPECT_TRUE(report.outcome.ok());
  EXPECT_EQ(w, (std::vector{0.0, 0.0, -9.81}));
  EXPECT_EQ(eta, (std::vector{0.0, 0.0, 0.0}));
  EXPECT_EQ(dynamics.num_equations(), 0U);
}

TEST(Dynamics, SinglePointOnAnInclinedPlaneSlidesDown) {
  // The normal is (0, -sin a, cos a), a = 30 degrees: w = g sin a down the slope, reaction m g cos a along the normal.
  const double sine = 0.5, cosine = std::sqrt(0.75), m = 3.0, g = 9.81;
  System system = falling_points(1);
  system.masses[0] = m;
  system.constraints = {Planes{"", {0}, Vector3{0.0, -sine, cosine}, 0.0}};
  Dynamics dynamics(system);
  std::vector<double> w(3), lambda(1), eta(3);

  ASSERT_TRUE(dynamics
                  .solve({.time = 0.0, .positions = system.positions, .velocities = std::vector(3, 0.0)},
                         {.accelerations = w, .multipliers = lambda, .reactions = eta})
                  .outcome.ok());

  EXPECT_NEAR(w[1], -g * sine * cosine, 1e-14);
  EXPECT_NEAR(w[2], -g * sine * sine, 1e-14);
  EXPECT_DOUBLE_EQ(lambda[0], m * g * cosine);
  EXPECT_DOUBLE_EQ(eta[1], -m * g * cosine * sine);
  EXPECT_DOUBLE_EQ(eta[2], m * g * cosine * cosine);
}

TEST(Dynamics, PendulumHangsOnItsTension) {
  // A bob swings through its lowest point: tension = m g + m v^2/l = -lambda, and the support carries it.
  System system = falling_points(2);
  system.positions = {0.0, 0.0, 0.0, 0.0, 0.0, -0.5};
  system.supports = {{"", {0}, {}}};
  system.constraints = {Rods{"", {{0, 1}}, {}, {}}};
  Dynamics dynamics(system);
  std::vector<double> w(6), lambda(1), eta(6), carried(6);
  const double tension = 2.0 * (9.81 + 3.0 * 3.0 / 0.5);

  ASSERT_TRUE(
      dynamics
          .solve({.time = 0.0, .positions = system.positions, .velocities = std::vector{0.0, 0.0, 0.0, 3.0, 0.0, 0.0}},
                 {.accelerations = w, .multipliers = lambda, .reactions = eta, .support_forces = carried})
          .outcome.ok());

  EXPECT_NEAR(lambda[0], -tension, 1e-13);
  EXPECT_NEAR(w[5], 3.0 * 3.0 / 0.5, 1e-13);
  EXPECT_NEAR(eta[5], tension, 1e-13);
  EXPECT_NEAR(carried[2], -tension, 1e-13);
  EXPECT_EQ(carried[5], 0.0);
}

TEST(Dynamics, FreePointsBesideConstrainedOnesFallFreely) {
  System system = falling_points(5);
  system.constraints = {Rods{"", {{1, 3}}, {}, {}}};
  Dynamics dynamics(system);
  std::vector<double> w(15);

  ASSERT_TRUE(
      dynamics
          .solve({.time = 0.0, .positions = system.positions, .velocities = std::vector(15, 0.0)}, {.accelerations = w})
          .outcome.ok());

  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(w[3 * i + 2], -9.81, 1e-14) << "point " << i;
}

TEST(Dynamics, SystemOfSupportsAloneCarriesWhatActsOnIt) {
  System system = falling_points(2);
  system.supports = {{"", {0, 1}, VectorFunction(ScalarFunction::formula("t^2"), 0.0, 0.0)}};
  system.forces = {ConstantForce{"", {1}, Vector3{1.0, 2.0, 3.0}}};
  Dynamics dynamics(system);
  std::vector<double> w(6), carried(6);

  ASSERT_TRUE(dynamics
                  .solve({.time = 1.0, .positions = system.positions, .velocities = std::vector(6, 0.0)},
                         {.accelerations = w, .support_forces = carried})
                  .outcome.ok());

  EXPECT_EQ(w, (std::vector{2.0, 0.0, 0.0, 2.0, 0.0, 0.0}));
  EXPECT_EQ(carried, (std::vector{0.0, 0.0, 0.0, 1.0, 2.0, 3.0}));
}

TEST(Dynamics, RowBetweenSupportsIsIdle) {
  // In (0) - (1) - 2 the first rod joins two supports.
  System system = falling_points(3);
  system.supports = {{"", {0, 1}, {}}};
  system.constraints = {Rods{"", {{0, 1}, {1, 2}}, {}, {}}};
  Dynamics dynamics(system);
  std::vector<double> w(9), lambda(2, nan), eta(9);

  ASSERT_TRUE(dynamics
                  .solve({.time = 0.0, .positions = system.positions, .velocities = std::vector(9, 1.0)},
                         {.accelerations = w, .multipliers = lambda, .reactions = eta})
                  .outcome.ok());

  EXPECT_EQ(dynamics.plan().idle_equations, std::vector<std::size_t>{0});
  EXPECT_EQ(lambda[0], 0.0);
  // The velocity across the rod of length 1 has v^2 = 2.
  EXPECT_NEAR(lambda[1], -3.0 * 2.0, 1e-13);
}

// ---- the caller's arrays -------------------------------------------------------------------------------------------

RC_GTEST_PROP(Dynamics, StatesAndMassesOfSupportsAreIgnored, ()) {
  RandomSystem random = any_system();
  const Solved expected(random);
  for (const Support& support : random.system.supports) {
    for (const Index i : support.points) {
      random.system.masses[static_cast<std::size_t>(i)] = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        random.positions[3 * static_cast<std::size_t>(i) + k] = nan;
        random.velocities[3 * static_cast<std::size_t>(i) + k] = nan;
      }
    }
  }
  Dynamics dynamics(random.system);
  std::vector<double> w(random.positions.size()), lambda(dynamics.num_equations());

  const SolveReport report =
      dynamics.solve({.time = random.t, .positions = random.positions, .velocities = random.velocities},
                     {.accelerations = w, .multipliers = lambda});

  RC_ASSERT(report.outcome.ok());
  RC_ASSERT(w == expected.accelerations);
  RC_ASSERT(lambda == expected.multipliers);
}

/// Accelerations and multipliers of points in the inner order need no copies, whatever was asked before.
TEST(Dynamics, ArraysThatAreReadInPlaceGiveTheSameBits) {
  System system;
  constexpr std::size_t n = 20;  // the last point is a support that is carried along
  for (std::size_t i = 0; i < n; ++i) {
    const double x = static_cast<double>(n - 1 - i);
    system.positions.insert(system.positions.end(), {0.6 * x, 0.0, -0.8 * x});
    system.velocities.insert(system.velocities.end(), {0.3, 0.1 * x, 0.0});
    system.masses.push_back(1.0 + static_cast<double>(i % 3));
  }
  Rods rods{"rods", {}, {}, {}};
  for (Index i = 0; i + 1 < static_cast<Index>(n); ++i) rods.pairs.push_back({i, i + 1});
  system.constraints = {rods};
  system.supports = {{"", {n - 1}, {ScalarFunction::formula("0.3*t"), 0.0, ScalarFunction::formula("0.1*t^2")}}};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  const StateView here{.positions = system.positions, .velocities = system.velocities};
  std::vector<double> turned = system.velocities;
  for (std::size_t k = 0; k + 3 < turned.size(); ++k) turned[k] = -turned[k];
  const StateView there{.positions = system.positions, .velocities = turned};

  Dynamics copies(system), dynamics(system);
  std::vector<double> w(3 * n), eta(3 * n), lambda(n - 1), own_w(3 * n), own_lambda(n - 1);
  for (const StateView& state : {here, there, here}) {
    ASSERT_TRUE(copies.solve(state, {.accelerations = w, .multipliers = lambda, .reactions = eta}).outcome.ok());
    ASSERT_TRUE(dynamics.solve(state, {.accelerations = own_w, .multipliers = own_lambda}).outcome.ok());
    EXPECT_EQ(own_w, w);
    EXPECT_EQ(own_lambda, lambda);
    EXPECT_EQ(own_w[3 * n - 1], 0.2);
    EXPECT_EQ(dynamics.solution(there).accelerations, copies.solution(there).accelerations);
  }
}

/// The factor of a lattice leaves more than rounding of the residual. Refinement is left out where that is enough.
TEST(Dynamics, InexactSolvesAreNotRefined) {
  const System lattice = scenes::make_lattice(12);
  const StateView start{.positions = lattice.positions, .velocities = lattice.velocities};
  Dynamics exact(lattice), inexact(lattice, {.exact = false});
  std::vector<double> w(start.positions.size()), inexact_w(w);
  const SolveReport report = exact.solve(start, {.accelerations = w});
  const SolveReport other = inexact.solve(start, {.accelerations = inexact_w});

  EXPECT_LE(report.residual, 4e-15);
  EXPECT_GE(report.refinements, 1);
  EXPECT_GT(other.residual, report.residual);
  EXPECT_LE(other.residual, 1e-12);
  EXPECT_EQ(other.refinements, 0);
  const double largest = *std::ranges::max_element(w, {}, [](double x) { return std::abs(x); });
  for (std::size_t k = 0; k < w.size(); ++k) EXPECT_NEAR(inexact_w[k], w[k], 1e-11 * std::abs(largest));
}

/// In a large net dw is much larger than phi, so that its own rounding is all that one refinement leaves. Another one
/// would take as long and find the same.
TEST(Dynamics, RefinementEndsWhereTheResidualIsRounding) {
  System net = scenes::make_grid({160, 160, 1});
  for (std::size_t k = 0; k < net.velocities.size(); k += 3)
    net.velocities[k + 2] = std::sin(3.0 * net.positions[k]) * std::cos(2.0 * net.positions[k + 1]);
  std::vector<double> w(net.positions.size());
  const SolveReport report =
      Dynamics(net).solve({.positions = net.positions, .velocities = net.velocities}, {.accelerations = w});
  EXPECT_EQ(report.refinements, 1);
  EXPECT_GT(report.residual, 4e-15);
  EXPECT_LE(report.residual, 1e-14);
}

TEST(Dynamics, EmptySpansAreNotComputed) {
  RandomSystem random = make_random_system(12, 3);
  Dynamics dynamics(random.system);
  std::vector<double> alone(dynamics.num_equations()), together(alone), w(36), eta(36);

  ASSERT_TRUE(dynamics
                  .solve({.time = random.t, .positions = random.positions, .velocities = random.velocities},
                         {.multipliers = alone})
                  .outcome.ok());
  ASSERT_TRUE(dynamics
                  .solve({.time = random.t, .positions = random.positions, .velocities = random.velocities},
                         {.accelerations = w, .multipliers = together, .reactions = eta})
                  .outcome.ok());

  EXPECT_EQ(alone, together);
}

TEST(Dynamics, ArrayOfTheWrongSizeIsNamed) {
  System system = falling_points(2);
  system.constraints = {Rods{"", {{0, 1}}, {}, {}}};
  Dynamics dynamics(system);
  std::vector<double> good(6, 0.0), bad(5, 0.0), rows(1);
  const std::vector<double>& r = system.positions;
  const auto message_of = [](const auto& call) {
    try {
      call();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };

  EXPECT_EQ(message_of([&] {
              (void)dynamics.solve({.time = 0.0, .positions = bad, .velocities = good}, {.accelerations = good});
            }),
            "positions has 5 numbers; 6 are needed");
  EXPECT_EQ(message_of([&] {
              (void)dynamics.solve({.time = 0.0, .positions = r, .velocities = bad}, {.accelerations = good});
            }),
            "velocities has 5 numbers; 6 are needed");
  EXPECT_EQ(message_of([&] {
              (void)dynamics.solve({.time = 0.0, .positions = r, .velocities = good}, {.accelerations = bad});
            }),
            "accelerations has 5 numbers; 6 are needed");
  EXPECT_EQ(message_of([&] {
              (void)dynamics.solve({.time = 0.0, .positions = r, .velocities = good},
                                   {.accelerations = good, .multipliers = bad});
            }),
            "multipliers has 5 numbers; 1 is needed");
  EXPECT_EQ(message_of([&] {
              (void)dynamics.solve({.time = 0.0, .positions = r, .velocities = good},
                                   {.accelerations = good, .multipliers = rows, .reactions = bad});
            }),
            "reactions has 5 numbers; 6 are needed");
  EXPECT_EQ(message_of([&] { (void)dynamics.solve({.time = 0.0, .positions = r}, {.support_forces = bad}); }),
            "support_forces has 5 numbers; 6 are needed");
}

TEST(Dynamics, MovedObjectGoesOn) {
  RandomSystem random = make_random_system(10, 4);
  Dynamics first(random.system);
  std::vector<double> before(30), after(30);
  ASSERT_TRUE(first
                  .solve({.time = random.t, .positions = random.positions, .velocities = random.velocities},
                         {.accelerations = before})
                  .outcome.ok());

  Dynamics second = std::move(first);
  ASSERT_TRUE(second
                  .solve({.time = random.t, .positions = random.positions, .velocities = random.velocities},
                         {.accelerations = after})
                  .outcome.ok());

  EXPECT_EQ(before, after);
}

TEST(Dynamics, CountsItsWork) {
  RandomSystem random = make_random_system(10, 4);
  Dynamics dynamics(random.system);
  std::vector<double> w(30);

  (void)dynamics.solve({.time = random.t, .positions = random.positions, .velocities = random.velocities},
                       {.accelerations = w});
  (void)dynamics.solve({.time = random.t, .positions = random.positions, .velocities = random.velocities},
                       {.accelerations = w});

  EXPECT_EQ(dynamics.counters().evaluations, 2U);
  EXPECT_EQ(dynamics.counters().factorizations, 2U);
  EXPECT_GE(dynamics.counters().solves, 2U);
}

TEST(Dynamics, ConstantGradientsAreFactorizedOnce) {
  System system = falling_points(4);
  system.constraints = {Planes{"", {0, 1, 2, 3}, Vector3{0.0, 0.3, 1.0}, 0.0},
                        Linears{"", {{0, 1}, {2, 3}}, {Vector3{1.0, 0.0, 0.0}, Vector3{-1.0, 0.0, 0.0}}, {}}};
  Dynamics dynamics(system);
  std::vector<double> w(12);

  for (int k = 0; k < 3; ++k)
    (void)dynamics.solve({.time = 0.1 * k, .positions = system.positions, .velocities = std::vector(12, 0.0)},
                         {.accelerations = w});

  EXPECT_EQ(dynamics.counters().factorizations, 1U);
}

// ---- options -----------------------------------------------------------------------------------------------------

RC_GTEST_PROP(Dynamics, EveryOrderingGivesTheSameAnswer, ()) {
  const RandomSystem random = any_system();
  const auto ordering = *rc::gen::element(Ordering::Amd, Ordering::Metis, Ordering::Nesdis, Ordering::Natural);

  const Solved expected(random), solved(random, {.ordering = ordering});

  RC_ASSERT(solved.is_small(solved.w - expected.w));
}

TEST(Dynamics, TwoThreadsGiveTheSameBits) {
  // There are 300 chains of 30 rods at random positions: several parts, and every loop is long enough to be split.
  System system;
  Rods rods;
  std::mt19937 generator(2);
  std::normal_distribution<double> normal;
  for (Index chain = 0; chain < 300; ++chain) {
    for (Index k = 0; k <= 30; ++k) {
      for (int c = 0; c < 3; ++c) system.positions.push_back(k + normal(generator));
      system.masses.push_back(std::exp(normal(generator)));
      if (k > 0) rods.pairs.push_back({31 * chain + k - 1, 31 * chain + k});
    }
  }
  system.constraints = {rods};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  std::vector<double> velocities(system.positions.size());
  for (double& x : velocities) x = normal(generator);
  struct Result {
    std::vector<double> v, r, w, lambda, eta, w_T, w_N;
    bool operator==(const Result&) const = default;
  };
  const auto run = [&](int threads) {
    Dynamics dynamics(system, {.threads = threads});
    const std::size_t size = velocities.size();
    Result result{velocities,
                  system.positions,
                  std::vector<double>(size),
                  std::vector<double>(dynamics.num_equations()),
                  std::vector<double>(size),
                  std::vector<double>(size),
                  std::vector<double>(size)};
    for (std::size_t c = 0; c < size; ++c) result.r[c] += 1e-4 * velocities[c];
    EXPECT_TRUE(dynamics.project_positions({.time = 0.0, .positions = result.r}).outcome.ok());
    EXPECT_TRUE(dynamics.project_velocities({.time = 0.0, .positions = result.r, .velocities = result.v}).outcome.ok());
    EXPECT_TRUE(dynamics
                    .solve({.time = 0.0, .positions = result.r, .velocities = result.v},
                           {.accelerations = result.w, .multipliers = result.lambda, .reactions = result.eta})
                    .outcome.ok());
    const Split split = dynamics.split({.time = 0.0, .positions = result.r, .velocities = result.v});
    EXPECT_TRUE(split.outcome.ok());
    result.w_T = split.tangent_accelerations;
    result.w_N = split.normal_accelerations;
    return result;
  };

  const Result one = run(1), two = run(2);

  EXPECT_TRUE(one == two);
}

TEST(Dynamics, PlanTellsWhatTheSystemNeeds) {
  // The system has two chains of two rods on one support and one free point.
  System system = falling_points(6);
  system.supports = {{"", {0}, {}}};
  system.constraints = {Rods{"", {{0, 1}, {1, 2}, {0, 3}, {3, 4}}, {}, {}}};
  const Dynamics dynamics(system, {.linear_solver = LinearSolver::General});

  const PlanSummary& plan = dynamics.plan();

  EXPECT_EQ(plan.points, 6U);
  EXPECT_EQ(plan.supports, 1U);
  EXPECT_EQ(plan.equations, 4U);
  EXPECT_EQ(plan.islands, 2U);
  EXPECT_EQ(plan.parts, 1U);
  EXPECT_EQ(plan.pattern_nonzeros, 6U);
  EXPECT_EQ(plan.factor_nonzeros, 6U);
  EXPECT_EQ(plan.ordering(), "natural");
  EXPECT_EQ(plan.factorization(), "simplicial");
  EXPECT_EQ(std::count(plan.left_out.begin(), plan.left_out.end(), "spring forces: none"), 1);
  EXPECT_EQ(std::count(plan.left_out.begin(), plan.left_out.end(), "refactorization: K is constant"), 0);
}

// ---- calls at one state after others ---------------------------------------------------------------------------

TEST(Dynamics, SplitIsThatOfItsStateWhateverWasAskedInBetween) {
  RandomSystem random = make_random_system(12, 3);
  Solved solved(random);
  const Split expected = solved.split();
  const std::vector<double> carried = solved.support_forces();
  std::vector<double> elsewhere = random.positions, velocities = random.velocities;
  for (double& x : elsewhere) x *= 1.01;

  (void)solved.dynamics.position_violation({.time = random.t + 1.0, .positions = elsewhere});
  (void)solved.dynamics.velocity_violation({.time = random.t + 1.0, .positions = elsewhere, .velocities = velocities});
  const Split split = solved.split();

  EXPECT_EQ(split.normal_accelerations, expected.normal_accelerations);
  EXPECT_EQ(split.tangent_accelerations, expected.tangent_accelerations);
  EXPECT_EQ(solved.support_forces(), carried);
}

TEST(Dynamics, CertificateOfASolvedStateIsThatOfAFreshOne) {
  RandomSystem random = make_random_system(12, 3);
  const StateView state{.time = random.t, .positions = random.positions, .velocities = random.velocities};
  Dynamics anew(random.system), stands(random.system), without_reactions(random.system);
  std::vector<double> w(36), eta(36);

  ASSERT_TRUE(stands.solve(state, {.accelerations = w, .reactions = eta}).outcome.ok());
  ASSERT_TRUE(without_reactions.solve(state, {.accelerations = w}).outcome.ok());
  const Certificate expected = anew.certify(state);

  EXPECT_TRUE(expected.passed()) << expected.line();
  for (Dynamics* const dynamics : {&stands, &without_reactions}) {
    const Certificate certificate = dynamics->certify(state);
    ASSERT_EQ(certificate.checks.size(), expected.checks.size());
    for (std::size_t k = 0; k < expected.checks.size(); ++k)
      EXPECT_EQ(certificate.checks[k].error, expected.checks[k].error) << expected.checks[k].identity;
  }
  EXPECT_EQ(stands.counters().factorizations, anew.counters().factorizations);
  EXPECT_EQ(without_reactions.counters().factorizations, anew.counters().factorizations + 1);
}

TEST(Dynamics, ReactionsAtSupportsAreThoseOfTheirStateWhateverWasProjectedSince) {
  RandomSystem random = make_random_system(12, 3);
  Solved solved(random);
  const Split expected = solved.split();
  const std::vector<double> carried = solved.support_forces();
  std::vector<double> elsewhere = random.positions;
  for (double& x : elsewhere) x *= 1.001;

  ASSERT_TRUE(solved.dynamics.project_positions({.time = random.t, .positions = elsewhere}).outcome.ok());
  const Split split = solved.split();

  EXPECT_EQ(solved.support_forces(), carried);
  EXPECT_EQ(split.normal_accelerations, expected.normal_accelerations);
}

}  // namespace
}  // namespace tanor
