/// The tests take friction apart: its split, its part of the reactions, the paper's three blocks (43), and what a given
/// motion says of it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <tanor/tanor.hpp>

#include "friction/rough_lines.hpp"
#include "measures.hpp"

namespace tanor {
namespace {

using Eigen::VectorXd;

/// Returns beads on rough lines that slide, single beads that are stuck at rest, and pairs without a rod in which one
/// bead
/// slides and the other one sticks.
std::vector<System> scenes() {
  std::vector<System> result;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    System slides = make_rough_lines(seed, 4, 0.3, seed % 2 == 0);
    if (DenseFriction(slides, 0.3).find_all().size() == 1) result.push_back(slides);
    System sticks = make_rough_lines(seed, 1, 3.0, false);
    sticks.velocities.assign(3, 0.0);
    sticks.forces.push_back(ConstantForce{"push", {0}, Vector3{1.0, 0.5, 2.0}});
    result.push_back(sticks);

    System mixed = make_rough_lines(seed, 2, 3.0, false);
    mixed.constraints.pop_back();
    std::fill_n(mixed.velocities.begin(), 3, 0.0);
    result.push_back(mixed);
  }
  return result;
}

struct Solved {
  Dynamics dynamics;
  std::vector<double> w, lambda, eta, tau;
  SolveReport report;

  explicit Solved(const System& system) : dynamics(system) {
    const std::size_t size = system.positions.size();
    for (auto* array : {&w, &eta, &tau}) array->resize(size);
    lambda.resize(dynamics.num_equations());
    report = dynamics.solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                            {.accelerations = w, .multipliers = lambda, .reactions = eta, .friction_forces = tau});
    EXPECT_TRUE(report.outcome.ok()) << report.outcome.what;
  }
};

TEST(FrictionParts, SplitIsThatOfTheDenseProjectors) {
  int sticking = 0, sliding = 0;
  for (const System& system : scenes()) {
    Solved solved(system);
    (solved.report.friction.sticking > 0 ? sticking : sliding) += 1;
    const Split split =
        solved.dynamics.split({.time = 0.0, .positions = system.positions, .velocities = system.velocities});
    ASSERT_TRUE(split.outcome.ok());
    reference::Mechanics euclidean = reference::make_mechanics(system, 0.0, system.positions, system.velocities);
    const reference::Paper paper(euclidean);
    euclidean.M.setOnes();
    const VectorXd tau = reference::vector(solved.tau);
    const double rounding = 1e-13 * tau.norm() * std::pow(euclidean.sqrt_condition(), 2);
    EXPECT_LE((reference::vector(split.normal_friction) - paper.normal_part(tau)).norm(), rounding);
    EXPECT_LE((reference::vector(split.tangent_friction) - paper.tangent_part(tau)).norm(), rounding);
    EXPECT_GT(tau.norm(), 0.0);
    // The split obeys (19) and (20) with f + tau.
    const VectorXd w_T = reference::vector(split.tangent_accelerations);
    EXPECT_LE((w_T - paper.w_T_by_K(paper.f + tau)).norm(), 1e-11 * (1.0 + paper.f.norm() + tau.norm()));
  }
  EXPECT_GT(sticking, 50);
  EXPECT_GT(sliding, 10);
}

TEST(FrictionParts, ReactionsByCauseAddUpWhateverSlidesOrSticks) {
  for (const System& system : scenes()) {
    Solved solved(system);
    const ReactionsByCause causes = solved.dynamics.reactions_by_cause(
        {.time = 0.0, .positions = system.positions, .velocities = system.velocities});
    ASSERT_TRUE(causes.outcome.ok());
    std::vector<double> lambda(solved.lambda.size(), 0.0), eta(solved.eta.size(), 0.0);
    double size = 0.0;
    bool has_friction = false;
    for (const ReactionPart& part : causes.parts) {
      has_friction = has_friction || part.cause == "friction";
      for (std::size_t a = 0; a < lambda.size(); ++a) lambda[a] += part.multipliers[a];
      for (std::size_t i = 0; i < eta.size(); ++i) eta[i] += part.reactions[i];
      size = std::max({size, largest(part.multipliers), largest(part.reactions)});
    }
    EXPECT_TRUE(has_friction);
    for (std::size_t a = 0; a < lambda.size(); ++a) EXPECT_NEAR(lambda[a], solved.lambda[a], 1e-11 * size);
    for (std::size_t i = 0; i < eta.size(); ++i) EXPECT_NEAR(eta[i], solved.eta[i], 1e-11 * size);
  }
}

// ---- (43), (44) --------------------------------------------------------------------------------------------------

TEST(FrictionBlocks, Equation43_ThreeBlocksFindWhatTheSmallestFormFinds) {
  int tried = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const System system = make_rough_lines(seed, 4, 0.3, seed % 2 == 0);
    if (DenseFriction(system, 0.3).find_all().size() != 1) continue;
    Solved solved(system);
    const FrictionBlocks blocks = solved.dynamics.friction_by_blocks(
        {.time = 0.0, .positions = system.positions, .velocities = system.velocities});
    if (!blocks.outcome.ok()) continue;  // no contraction: Theorem B (i) does not hold
    ++tried;
    SCOPED_TRACE("seed " + std::to_string(seed));
    const double allowed = 1e-10 * largest(solved.lambda);
    for (std::size_t a = 0; a < solved.lambda.size(); ++a)
      EXPECT_NEAR(blocks.multipliers[a], solved.lambda[a], allowed);
    for (std::size_t i = 0; i < solved.tau.size(); ++i) EXPECT_NEAR(blocks.friction[i], solved.tau[i], allowed);
    // By (44) the tangent block is left out for equal masses.
    EXPECT_EQ(blocks.tangent_block_left_out, seed % 2 == 0);
  }
  EXPECT_GT(tried, 20);
}

// ---- inverse dynamics -------------------------------------------------------------------------------------------

TEST(InverseDynamicsWithFriction, FindsTheFrictionOfEachInstantAndNoControl) {
  int slid = 0;
  for (const System& system : scenes()) {
    Solved solved(system);
    if (std::all_of(system.velocities.begin(), system.velocities.begin() + 3, [](double v) { return v == 0.0; }))
      continue;
    ++slid;
    InverseDynamics problem(system);
    const MotionForces forces = problem.evaluate(0.0, {system.positions, system.velocities, solved.w});
    ASSERT_TRUE(forces.outcome.ok()) << forces.outcome.what;
    ASSERT_EQ(forces.multipliers.size(), solved.lambda.size());
    const double allowed = 1e-10 * largest(solved.lambda);
    EXPECT_LE(forces.largest_control, allowed);
    for (std::size_t a = 0; a < solved.lambda.size(); ++a)
      EXPECT_NEAR(forces.multipliers[a], solved.lambda[a], allowed);
    for (std::size_t i = 0; i < solved.tau.size(); ++i) EXPECT_NEAR(forces.friction[i], solved.tau[i], allowed);
  }
  EXPECT_GT(slid, 10);
}

/// At rest the law bounds friction but does not determine it.
TEST(InverseDynamicsWithFriction, FrictionThatHoldsAPointAtRestIsPartOfTheControl) {
  System system = make_rough_lines(3, 1, 5.0, false);
  system.velocities.assign(3, 0.0);
  Solved solved(system);
  ASSERT_EQ(solved.report.friction.sticking, 1u);
  InverseDynamics problem(system);
  const MotionForces forces = problem.evaluate(0.0, {system.positions, system.velocities, solved.w});
  ASSERT_TRUE(forces.outcome.ok());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(forces.friction[i], 0.0);
    EXPECT_NEAR(forces.control_forces[i], solved.tau[i], 1e-14 * largest(solved.tau));
  }
}

TEST(InverseDynamicsWithFriction, RoundTripOfASlidingMotionNeedsNoControl) {
  // Two beads lie on crossing rough rails with a rod between them.
  System system;
  system.positions = {1.0, 0.0, 0.0, 0.0, -2.0, 0.0};
  system.masses = {1.0, 2.5};
  system.velocities = {1.0, 0.0, 0.0, 0.0, 0.5, 0.0};  // x x' + y y' = 0
  system.constraints = {Lines{"across", {0}, Vector3{}, Vector3{1.0, 0.0, 0.0}},
                        Lines{"down", {1}, Vector3{}, Vector3{0.0, 1.0, 0.0}}, Rods{"rod", {{0, 1}}, {}, {}}};
  system.forces = {Gravity{"", {3.0, 0.0, -9.81}}};
  system.friction = {Coulomb{.name = "", .at = {"across", "down"}, .coefficient = 0.1}};

  Simulation simulation(system, {.method = Method::Dopri5, .rtol = 1e-13, .atol = 1e-14});
  const double h = 0.002;
  std::vector<double> times, values;
  std::vector<std::vector<double>> reactions;
  for (std::size_t k = 0; k <= 200; ++k) {
    if (k > 0) {
      ASSERT_TRUE(simulation.advance_to(static_cast<double>(k) * h).ok());
    }
    times.push_back(simulation.time());
    values.insert(values.end(), simulation.positions().begin(), simulation.positions().end());
    reactions.emplace_back(simulation.reactions().begin(), simulation.reactions().end());
  }
  const MotionTable table(times, values, system.positions.size());
  InverseDynamics problem(system);
  double size = 0.0;
  for (std::size_t k = 20; k + 20 < times.size(); ++k) {
    const MotionForces forces = problem.evaluate(times[k], table.at(times[k]));
    ASSERT_TRUE(forces.outcome.ok()) << forces.outcome.what;
    size = largest(reactions[k]);
    EXPECT_LE(forces.largest_control, 1e-6 * size) << times[k];
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(forces.reactions[i], reactions[k][i], 1e-6 * size);
    EXPECT_GT(largest(forces.friction), 0.1);
  }
}

}  // namespace
}  // namespace tanor
