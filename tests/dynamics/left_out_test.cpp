/// Computations that a scene does not need are left out, and each omission is proven by counting.

#include <algorithm>

#include <gtest/gtest.h>

#include <tanor/tanor.hpp>

#include "scenes.hpp"

namespace tanor {
namespace {

System make_bent_chain(Index rods, double last_mass = scenes::mass) {
  std::vector<Vector3> places;
  for (Index i = 0; i <= rods; ++i) places.push_back({0.1 * i, 0.0, 0.03 * i * i});
  System system = scenes::make_chain_through(places);
  system.masses.back() = last_mass;
  return system;
}

/// Makes beads on rails, all of them linear.
System make_rails() {
  System system;
  for (Index i = 0; i < 5; ++i) {
    system.positions.insert(system.positions.end(), {0.0, 1.0 * i, 0.0});
    system.velocities.insert(system.velocities.end(), {1.0, 0.0, 0.0});
    system.masses.push_back(1.0 + i);
  }
  system.constraints = {Lines{"rails", {0, 1, 2, 3, 4}, Vector3{}, Vector3{1.0, 0.0, 0.0}}};
  auto& rails = std::get<Lines>(system.constraints[0]);
  rails.points = {0};
  for (Index i = 1; i < 5; ++i) {
    system.constraints.push_back(Lines{"", {i}, Vector3{0.0, 1.0 * i, 0.0}, Vector3{1.0, 0.0, 0.0}});
  }
  system.forces = {Springs{"springs", {{0, 1}, {1, 2}, {3, 4}}, 10.0, 0.1, 0.5}};
  return system;
}

bool says(const PlanSummary& plan, const std::string& words) {
  return std::ranges::any_of(plan.left_out, [&](const std::string& what) { return what.find(words) == 0; });
}

struct StartedDynamics {
  Dynamics dynamics;
  std::vector<double> r, v;
  SolveReport report;

  explicit StartedDynamics(const System& system, const SolverOptions& options = {})
      : dynamics(system, options), r(system.positions), v(system.velocities) {
    EXPECT_TRUE(dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Check).outcome.ok());
    report = dynamics.solve(state());
  }
  StateView state() const { return {.time = 0.0, .positions = r, .velocities = v}; }
  Split split() { return dynamics.split(state()); }
};

TEST(LeftOut, ConstantKIsFactorizedOnceInAWholeRun) {
  Simulation simulation(make_rails(), {.step = 0.01});

  ASSERT_TRUE(simulation.advance_to(1.0).ok());

  EXPECT_EQ(simulation.report().steps, 100U);
  EXPECT_EQ(simulation.report().counters.factorizations, 1U);
  EXPECT_TRUE(says(simulation.plan(), "refactorization"));
}

TEST(LeftOut, MovingRodsAreFactorizedAtEveryStage) {
  Simulation simulation(make_bent_chain(5), {.method = Method::Rk4, .step = 0.01});

  ASSERT_TRUE(simulation.advance_to(0.1).ok());

  EXPECT_GE(simulation.report().counters.factorizations, 40U);
  EXPECT_FALSE(says(simulation.plan(), "refactorization"));
}

TEST(LeftOut, NothingIsFactorizedWithoutConstraints) {
  System system = make_bent_chain(5);
  system.constraints.clear();
  Simulation simulation(system, {.step = 0.01});

  ASSERT_TRUE(simulation.advance_to(0.1).ok());

  EXPECT_EQ(simulation.report().counters.factorizations, 0U);
  EXPECT_EQ(simulation.report().counters.solves, 0U);
  EXPECT_EQ(simulation.plan().factor_nonzeros, 0U);
  EXPECT_TRUE(says(simulation.plan(), "factorization"));
}

TEST(LeftOut, GammaIsMadeForTheSplitAlone) {
  StartedDynamics solved(make_bent_chain(5, 0.7));
  EXPECT_EQ(solved.dynamics.counters().split_factorizations, 0U);

  const Split split = solved.split();

  EXPECT_TRUE(split.outcome.ok());
  EXPECT_EQ(solved.dynamics.counters().split_factorizations, 1U);
}

TEST(LeftOut, Equation36_OneMassNeedsNoSecondFactor) {
  StartedDynamics solved(make_bent_chain(5));

  const Split split = solved.split();

  EXPECT_TRUE(split.outcome.ok());
  EXPECT_EQ(solved.dynamics.counters().split_factorizations, 0U);
  EXPECT_TRUE(says(solved.dynamics.plan(), "second factorization"));
}

TEST(LeftOut, Equation44_MassCouplingIsMeasuredWhereItHoldsAndWhereItDoesNot) {
  // With equal masses the equation holds always. It also holds for beads on rails of their own with any masses, and for
  // a heavy tip if the chain is straight but not if it is bent (docs/theory.md).
  EXPECT_LT(StartedDynamics(make_bent_chain(5)).split().mass_coupling, 1e-13);
  EXPECT_GT(StartedDynamics(make_bent_chain(5, 0.7)).split().mass_coupling, 1e-2);
  EXPECT_LT(StartedDynamics(make_rails()).split().mass_coupling, 1e-13);
  System straight = make_bent_chain(5, 0.7);
  for (std::size_t i = 2; i < straight.positions.size(); i += 3) straight.positions[i] = 0.0;
  EXPECT_LT(StartedDynamics(straight).split().mass_coupling, 1e-13);
}

TEST(LeftOut, Equation44_MassCouplingIsMeasuredByCoordinatesToo) {
  System system = make_bent_chain(4, 0.7);
  system.coordinates = {ChainAngles{"angles", {1, 2, 3, 4}, 0, {}, {}}};
  System coordinates_alone = system;
  coordinates_alone.constraints.clear();

  EXPECT_GT(StartedDynamics(coordinates_alone).split().mass_coupling, 1e-2);
  coordinates_alone.masses.assign(5, 0.3);
  EXPECT_LT(StartedDynamics(coordinates_alone).split().mass_coupling, 1e-13);
}

TEST(LeftOut, TangentFormNeitherProjectsNorFactorizesS) {
  // Each bead has one angle on its circle, so that H is diagonal. S would have two rows a bead.
  System system;
  for (Index i = 0; i < 8; ++i) {
    system.positions.insert(system.positions.end(), {1.0, 0.0, 1.0 * i});
    system.velocities.insert(system.velocities.end(), {0.0, 0.1 * i, 0.0});
    system.masses.push_back(1.0 + i);
    const Vector3 center{0.0, 0.0, 1.0 * i}, normal{0.0, 0.0, 1.0};
    system.constraints.push_back(Circles{"", {i}, center, normal, 1.0});
    system.coordinates.push_back(CircleCoordinates{"", {i}, center, normal, 1.0});
  }
  system.forces = {Gravity{"", {-1.0, 0.0, 0.0}}};
  Simulation simulation(system, {.step = 0.01});

  ASSERT_TRUE(simulation.advance_to(0.1).ok());

  EXPECT_EQ(simulation.plan().form, Form::Tangent);
  EXPECT_TRUE(says(simulation.plan(), "steps by constraints"));
  // Ten steps of four stages take one solve each. S is factorized once for the multipliers that are published at start
  // and end.
  const Counters& counters = simulation.report().counters;
  EXPECT_LE(counters.factorizations, 10U * 4U + 8U);
  EXPECT_LE(counters.solves, 10U * 4U + 12U);
  EXPECT_LE(simulation.report().violation.position, 1e-15);
}

TEST(LeftOut, SinglePointAndBeadsOnTheirOwnSurfacesAreSolvedInClosedForm) {
  System bead;
  bead.positions = {1.0, 0.0, 0.5};
  bead.velocities = {0.0, 2.0, 0.0};
  bead.masses = {2.0};
  bead.constraints = {Circles{"hoop", {0}, Vector3{0.0, 0.0, 0.5}, Vector3{0.0, 0.0, 1.0}, {}}};
  bead.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  System beads;
  for (Index i = 0; i < 2000; ++i) {
    beads.positions.insert(beads.positions.end(), {1.0 + i, 0.0, 0.0});
    beads.masses.push_back(1.0 + i % 3);
  }
  beads.velocities.assign(beads.positions.size(), 0.0);
  beads.constraints = {Planes{"floor", {}, Vector3{0.0, 0.0, 2.0}, 0.0}};
  for (Index i = 0; i < 2000; ++i) std::get<Planes>(beads.constraints[0]).points.push_back(i);
  beads.forces = bead.forces;
  Dynamics on_hoop(bead), on_floor(beads);
  std::vector<double> w(3), lambda(2), w_floor(6000), lambda_floor(2000);

  ASSERT_TRUE(on_hoop
                  .solve({.time = 0.0, .positions = bead.positions, .velocities = bead.velocities},
                         {.accelerations = w, .multipliers = lambda})
                  .outcome.ok());
  ASSERT_TRUE(on_floor
                  .solve({.time = 0.0, .positions = beads.positions, .velocities = beads.velocities},
                         {.accelerations = w_floor, .multipliers = lambda_floor})
                  .outcome.ok());

  // The answer is v^2/r towards the axis, and the plane carries the weight.
  EXPECT_NEAR(w[0], -4.0, 1e-15);
  EXPECT_NEAR(lambda[0], 2.0 * 9.81, 1e-14);
  EXPECT_NEAR(lambda[1], -8.0, 1e-14);
  for (Index i = 0; i < 2000; ++i) EXPECT_NEAR(lambda_floor[i], (1.0 + i % 3) * 9.81, 1e-13);
  EXPECT_EQ(on_hoop.plan().factorization(), "closed_form");
  EXPECT_EQ(on_floor.plan().factorization(), "closed_form");
  EXPECT_EQ(Dynamics(make_bent_chain(5), {.linear_solver = LinearSolver::General}).plan().factorization(),
            "simplicial");
}

TEST(LeftOut, SmoothSystemsHaveNoRowsSolvesOrTimeOfFriction) {
  System smooth = make_rails();
  for (std::size_t i = 0; i < smooth.constraints.size(); ++i)
    std::get<Lines>(smooth.constraints[i]).name = "rail" + std::to_string(i);
  System rough = smooth;
  rough.friction = {Coulomb{.name = "", .at = {"rail0", "rail1"}, .coefficient = 0.1}};
  Simulation none(smooth, {.step = 0.01}), some(rough, {.step = 0.01});

  ASSERT_TRUE(none.advance_to(0.1).ok());
  ASSERT_TRUE(some.advance_to(0.1).ok());

  // A rail has two rows, joined at their bead. For a bead that may stick a third row is joined to both.
  EXPECT_EQ(none.plan().equations, 10U);
  EXPECT_EQ(none.plan().pattern_nonzeros, 5U * 3U);
  EXPECT_EQ(some.plan().pattern_nonzeros, 3U * 3U + 2U * 6U);
  EXPECT_EQ(none.report().counters.friction_solves, 0U);
  EXPECT_EQ(none.report().counters.friction_iterations, 0U);
  EXPECT_EQ(none.report().counters.factorizations, 1U);
  EXPECT_EQ(none.report().times.friction, 0.0);
  EXPECT_GE(some.report().counters.friction_solves, 40U);
}

/// A function of time is evaluated once an instant, however many rods share it, and not again while time stands still.
TEST(LeftOut, FunctionsOfTimeAreEvaluatedOnceAnInstant) {
  for (const Index rods : {3, 50}) {
    System moving = make_bent_chain(rods);
    // The rods have the length that they are drawn with, all by one function.
    for (Index i = 0; i <= rods; ++i) {
      for (int axis = 0; axis < 3; ++axis) moving.positions[3 * i + axis] = axis == 0 ? 0.1 * i : 0.0;
    }
    int calls = 0;
    std::get<Rods>(moving.constraints[0]).length = ScalarFunction::custom([&calls](const Jet<2>& t) {
      ++calls;
      return 0.1 + 0.01 * t * t;
    });
    StartedDynamics driven(moving);
    calls = 0;
    for (const double t : {0.1, 0.2, 0.3}) {
      EXPECT_TRUE(driven.dynamics.solve({.time = t, .positions = driven.r, .velocities = driven.v}, {}).outcome.ok());
    }
    EXPECT_EQ(calls, 3) << rods;
    EXPECT_TRUE(driven.dynamics.solve({.time = 0.3, .positions = driven.r, .velocities = driven.v}, {}).outcome.ok());
    EXPECT_EQ(calls, 3) << rods;
  }
}

/// Runs a bead in a bowl that is said to depend on time or not, and counts the calls of its function.
struct BowlRun {
  int calls = 0;
  MotionReport report;
  PlanSummary plan;

  BowlRun(Method method, bool depends_on_time) {
    System system;
    system.positions = {1.0, 0.0, 1.0};
    system.velocities = {0.0, 1.0, 0.0};
    system.masses = {1.0};
    system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
    const auto bowl = [this](const auto& r, const auto&) {
      ++calls;
      return r[2] - r[0] * r[0] - r[1] * r[1];
    };
    UserConstraints constraint{"bowl", {{0}}, make_constraint_kernel<1>(bowl, false)};
    constraint.kernel.depends_on_time = depends_on_time;
    system.constraints = {constraint};
    Simulation simulation(system, {.method = method, .step = method == Method::Rk4 ? 0.01 : 0.0});
    plan = simulation.plan();
    calls = 0;
    EXPECT_TRUE(simulation.advance_to(1.0).ok());
    report = simulation.report();
  }
};

/// The work of a constraint that might move is integrated, which leaves the rounding and the errors of a quadrature,
/// and the work of any other constraint is exactly 0. Time alone costs no evaluation, since xi, its rate and phi come
/// from one call each.
TEST(LeftOut, TimeTermsAreLeftOutWhereNothingDependsOnTime) {
  for (const Method method : {Method::Rk4, Method::Dopri5, Method::Dop853}) {
    SCOPED_TRACE(name_of(method));

    const BowlRun still(method, false), moving(method, true);

    EXPECT_EQ(still.report.energy.work_of_supports, 0.0);
    EXPECT_NE(moving.report.energy.work_of_supports, 0.0);
    EXPECT_LT(std::abs(moving.report.energy.work_of_supports), 1e-6);
    EXPECT_EQ(still.calls, moving.calls);
    // The calls are those of xi and its gradient, of rate and phi, and of the chord iterations at the end of each step.
    EXPECT_LE(still.calls, static_cast<int>(4 * still.report.counters.evaluations));
    EXPECT_TRUE(says(still.plan, "moving constraints"));
    EXPECT_TRUE(says(still.plan, "work integral"));
    EXPECT_FALSE(says(moving.plan, "moving constraints"));
    EXPECT_FALSE(says(moving.plan, "work integral"));
  }
}

/// A function of time is called at each instant at which the equations are evaluated, at stages and between them.
/// Without rods that have one it is never called.
TEST(LeftOut, AFunctionOfTimeIsCalledForItsOwnConstraintsAlone) {
  const auto count_calls = [](Index driven_rods) {
    System system = make_bent_chain(50);
    auto& rods = std::get<Rods>(system.constraints[0]);
    Rods driven{"driven", {rods.pairs.end() - driven_rods, rods.pairs.end()}, {}, {}};
    rods.pairs.erase(rods.pairs.end() - driven_rods, rods.pairs.end());
    // At t = 0 the rods have the lengths that they are drawn with.
    for (Index i = 51 - driven_rods; i <= 50; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto last = 3 * static_cast<std::size_t>(i);
        system.positions[last + axis] = system.positions[last - 3 + axis] + (axis == 0 ? 0.1 : 0.0);
      }
    }
    int calls = 0;
    driven.length = ScalarFunction::custom([&calls](const Jet<2>& t) {
      ++calls;
      return 0.1 + 0.001 * t * t;
    });
    if (driven_rods > 0) system.constraints.push_back(driven);
    Simulation simulation(system, {.method = Method::Rk4, .step = 1e-4});
    calls = 0;
    EXPECT_TRUE(simulation.advance_to(0.01).ok()) << simulation.outcome().what;
    EXPECT_EQ(simulation.report().steps, 100u);
    return calls;
  };

  const int one = count_calls(1), many = count_calls(20), none = count_calls(0);

  EXPECT_EQ(none, 0);
  EXPECT_EQ(one, many);
  EXPECT_GE(one, 200) << "the middle and the end of each step";
  EXPECT_LE(one, 6000) << "and some forty instants, at which a step is looked at";
}

/// A bond along a rod is allowed, and the plan says so.
TEST(LeftOut, BondsAlongRodsHaveAConstantEnergy) {
  System system = make_bent_chain(4);
  system.forces = {Bonds{"bonds", {{1, 0}, {2, 3}, {0, 2}}, BondLaw::Fene, 1.0, {}, 9.0, {}, {}}};
  EXPECT_TRUE(says(Dynamics(system).plan(), "bonds: the energy of 2 bonds along rods is constant"));

  system.forces = {Bonds{"bonds", {{0, 2}}, BondLaw::Fene, 1.0, {}, 9.0, {}, {}}};
  EXPECT_FALSE(says(Dynamics(system).plan(), "bonds:"));
}

}  // namespace
}  // namespace tanor
