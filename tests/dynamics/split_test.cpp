/// The split by the Euclidean projectors and the reactions by cause satisfy the paper's equations on random systems.

#include <algorithm>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "solved.hpp"

namespace tanor {
namespace {

using Eigen::VectorXd;

/// A random system that is solved and split, with the dense terms of the paper's equations.
struct Halves {
  Solved solved;
  reference::Paper paper;
  Split split;
  VectorXd w_T, w_N, f_T, f_N;
  double accuracy;

  explicit Halves(RandomSystem random)
      : solved(std::move(random)), paper(solved.dense), split(solved.split()), accuracy(solved.accuracy) {
    RC_ASSERT(solved.report.outcome.ok() && split.outcome.ok());
    w_T = solved.dense.pick(split.tangent_accelerations);
    w_N = solved.dense.pick(split.normal_accelerations);
    f_T = solved.dense.pick(split.tangent_forces);
    f_N = solved.dense.pick(split.normal_forces);
    // The condition of Gamma counts as well as that of S.
    reference::Mechanics euclidean = solved.dense;
    euclidean.M.setOnes();
    accuracy = std::max(accuracy, 1e-12 * euclidean.sqrt_condition());
  }
  /// Return true if the results agree. Forces are compared as accelerations, M^-1 x.
  bool agree(const VectorXd& a, const VectorXd& b) const { return (a - b).norm() <= 10.0 * accuracy * solved.size; }
  bool agree_as_forces(const VectorXd& a, const VectorXd& b) const {
    return solved.as_acceleration(a - b) <= 10.0 * accuracy * solved.size;
  }
};

RC_GTEST_PROP(Split, Equations15And16_ForcesAreProjectedOntoTAndN, ()) {
  const Halves halves(any_system());
  const VectorXd& f = halves.paper.f;

  const double rounding = halves.accuracy * (1.0 + f.norm());
  RC_ASSERT((halves.f_N - halves.paper.normal_part(f)).norm() <= rounding);
  RC_ASSERT((halves.f_T - halves.paper.tangent_part(f)).norm() <= rounding);
  RC_ASSERT((halves.f_T + halves.f_N - f).norm() <= 1e-14 * (1.0 + f.norm()));
  RC_ASSERT((halves.paper.K.transpose() * halves.f_T).norm() <= 1e-13 * (1.0 + halves.paper.K.norm() * f.norm()));
}

RC_GTEST_PROP(Split, Equation4_PIsNonsingularAndItsInverseSplitsAnyForce, ()) {
  const Halves halves(any_system());
  const reference::Paper& paper = halves.paper;

  // f = K a + A b
  const auto lu = paper.P().fullPivLu();
  const VectorXd parts = lu.solve(paper.f);

  const Eigen::Index d = paper.K.cols();
  const double rounding = 10.0 * halves.accuracy * (1.0 + paper.f.norm());
  RC_ASSERT(lu.isInvertible());
  RC_ASSERT((halves.f_N - paper.K * parts.head(d)).norm() <= rounding);
  RC_ASSERT((halves.f_T - paper.A * parts.tail(parts.size() - d)).norm() <= rounding);
}

RC_GTEST_PROP(Split, Equations21And22_NormalAccelerationNeedsNoMass, ()) {
  const Halves halves(any_system());

  RC_ASSERT(halves.agree(halves.w_N, halves.paper.w_N()));
  // Any psi with K'psi = -phi will do, and w is one.
  RC_ASSERT(halves.agree(halves.w_N, halves.paper.w_N_by_A(halves.solved.w)));
}

RC_GTEST_PROP(Split, Equations19And20_TangentAccelerationIsTheSameByKAndByA, ()) {
  const Halves halves(any_system());

  RC_ASSERT(halves.agree(halves.w_T, halves.paper.w_T_by_K(halves.paper.f)));
  RC_ASSERT(halves.agree(halves.w_T, halves.paper.w_T_by_A(halves.paper.f)));
}

RC_GTEST_PROP(Split, Equations23And24_ReactionIsTheSameByKAndByA, ()) {
  const Halves halves(any_system());

  RC_ASSERT(halves.agree_as_forces(halves.solved.eta, halves.paper.eta_by_K(halves.paper.f)));
  RC_ASSERT(halves.agree_as_forces(halves.solved.eta, halves.paper.eta_by_A(halves.paper.f)));
}

RC_GTEST_PROP(Split, Equation27_ThirdDynamicMatrixGivesMultipliersAndTangentAcceleration, ()) {
  const Halves halves(any_system());
  const reference::Paper& paper = halves.paper;

  const VectorXd x = paper.solve_27();

  const Eigen::Index d = paper.K.cols();
  RC_ASSERT(halves.agree_as_forces(halves.solved.eta, paper.K * x.head(d)));
  RC_ASSERT(halves.agree(halves.w_T, paper.A * x.tail(x.size() - d)));
}

RC_GTEST_PROP(Split, Equations32And33_NormalForcesNeverMoveTheSystem, ()) {
  const Halves halves(any_system());

  RC_ASSERT(halves.agree(halves.w_T, halves.paper.w_T_by_K(halves.f_T)));
  RC_ASSERT(halves.agree(halves.w_T, halves.paper.w_T_by_A(halves.f_T)));
}

RC_GTEST_PROP(Split, Equations34And35_NormalForcesAreCancelledOneToOne, ()) {
  const Halves halves(any_system());

  RC_ASSERT(halves.agree_as_forces(halves.solved.eta, halves.paper.eta_by_K(halves.f_T) - halves.f_N));
  RC_ASSERT(halves.agree_as_forces(halves.solved.eta, halves.paper.eta_by_A(halves.f_T) - halves.f_N));
}

RC_GTEST_PROP(Split, Equations36To40_WithOneMassBothHalvesAreExplicit, ()) {
  RandomSystem random = any_system();
  const double m = 1.7;
  std::fill(random.system.masses.begin(), random.system.masses.end(), m);
  const Halves halves(std::move(random));

  RC_ASSERT(halves.agree(halves.w_T, halves.f_T / m));                          // (37)
  RC_ASSERT(halves.agree(halves.w_N, halves.paper.w_N()));                      // (38)
  RC_ASSERT(halves.agree(halves.solved.eta / m, halves.w_N - halves.f_N / m));  // (39)
  RC_ASSERT(halves.agree(halves.solved.w, halves.w_N + halves.f_T / m));        // (40)
  RC_ASSERT(halves.solved.dynamics.counters().split_factorizations == 0U);      // Gamma = m S
}

// ---- what it costs -----------------------------------------------------------------------------------------------

std::size_t count(const Dynamics& dynamics, const std::string& left_out) {
  const auto& list = dynamics.plan().left_out;
  return static_cast<std::size_t>(std::count(list.begin(), list.end(), left_out));
}

TEST(Split, GammaIsMadeOnlyWhereTheSplitIsAskedFor) {
  Solved solved(make_random_system(12, 3));
  EXPECT_EQ(solved.dynamics.counters().split_factorizations, 0U);

  EXPECT_TRUE(solved.split().outcome.ok());

  EXPECT_EQ(solved.dynamics.counters().split_factorizations, 1U);
  EXPECT_EQ(count(solved.dynamics, "second factorization for the parts along and across the motion: all points have one mass"), 0U);
}

TEST(Split, PlanSaysThatGammaIsLeftOutWithOneMass) {
  RandomSystem random = make_random_system(12, 3);
  std::fill(random.system.masses.begin(), random.system.masses.end(), 0.3);
  const Dynamics dynamics(random.system);

  EXPECT_EQ(count(dynamics, "second factorization for the parts along and across the motion: all points have one mass"), 1U);
}

TEST(Split, NeedsNoSolveBeforehand) {
  const RandomSystem random = make_random_system(5, 1);
  const StateView state{.time = random.t, .positions = random.positions, .velocities = random.velocities};
  Dynamics fresh(random.system), solved(random.system);
  ASSERT_TRUE(solved.solve(state).outcome.ok());

  EXPECT_EQ(fresh.split(state).normal_accelerations, solved.split(state).normal_accelerations);
  EXPECT_EQ(Dynamics(random.system).reactions_by_cause(state).parts[0].reactions,
            solved.reactions_by_cause(state).parts[0].reactions);
}

// ---- coordinates alone -------------------------------------------------------------------------------------------

/// A bead on a swinging sphere and one on a growing circle, with gravity and drag, by constraints and by coordinates.
struct TwoGuides {
  System by_constraints, by_coordinates;
  double t = 0.4;
  std::vector<double> r, v;

  TwoGuides() {
    System system;
    system.positions = {0.6, 0.0, 0.8, 2.0, 0.0, 0.0};
    system.masses = {0.7, 1.9};
    system.forces = {Gravity{"weight", {0.0, -2.0, -9.81}}, Drag{"air", {0, 1}, 0.3, 0.1}};
    by_constraints = by_coordinates = system;
    const VectorFunction center{ScalarFunction::formula("0.3*sin(2*t)"), 0.0, 0.0};
    const ScalarFunction radius = ScalarFunction::formula("2 + 0.5*t^2");
    by_constraints.constraints = {Spheres{"ball", {0}, center, 1.0},
                                  Circles{"hoop", {1}, Vector3{}, Vector3{0, 0, 1}, radius}};
    by_coordinates.coordinates = {SphereCoordinates{"ball", {0}, center, 1.0},
                                  CircleCoordinates{"hoop", {1}, Vector3{}, Vector3{0, 0, 1}, radius}};
    r = {0.6, 0.1, 0.8, 1.9, 0.4, 0.0};
    v = {0.3, -1.0, 0.4, 0.5, 2.0, 0.0};
    Dynamics dynamics(by_constraints);
    EXPECT_TRUE(dynamics.project_positions({.time = t, .positions = r}).outcome.ok());
    EXPECT_TRUE(dynamics.project_velocities({.time = t, .positions = r, .velocities = v}).outcome.ok());
  }
  StateView state() const { return {.time = t, .positions = r, .velocities = v}; }
  std::vector<double> solve(Dynamics& dynamics) const {
    std::vector<double> w(6), eta(6);
    EXPECT_TRUE(dynamics.solve(state(), {.accelerations = w, .reactions = eta}).outcome.ok());
    return eta;
  }
};

void expect_near(const std::vector<double>& a, const std::vector<double>& b, double error) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], error) << "number " << i;
}

TEST(Split, IsTheSameByCoordinatesAndByConstraints) {
  const TwoGuides guides;
  Dynamics by_K(guides.by_constraints), by_A(guides.by_coordinates);
  guides.solve(by_K);
  guides.solve(by_A);

  const Split expected = by_K.split(guides.state()), split = by_A.split(guides.state());

  ASSERT_TRUE(split.outcome.ok());
  expect_near(split.normal_accelerations, expected.normal_accelerations, 1e-13);
  expect_near(split.tangent_accelerations, expected.tangent_accelerations, 1e-13);
  expect_near(split.normal_forces, expected.normal_forces, 1e-13);
  expect_near(split.tangent_forces, expected.tangent_forces, 1e-13);
  EXPECT_EQ(by_A.counters().split_factorizations, 1U);
}

TEST(ReactionsByCause, AddUpToEtaByCoordinatesAndForcesCountAsByConstraints) {
  const TwoGuides guides;
  Dynamics by_K(guides.by_constraints), by_A(guides.by_coordinates);
  guides.solve(by_K);
  const std::vector<double> eta = guides.solve(by_A);

  const ReactionsByCause expected = by_K.reactions_by_cause(guides.state()),
                         causes = by_A.reactions_by_cause(guides.state());

  ASSERT_EQ(causes.parts.size(), 4U);
  std::vector<double> sum(6, 0.0);
  for (const ReactionPart& part : causes.parts) {
    for (std::size_t i = 0; i < 6; ++i) sum[i] += part.reactions[i];
    EXPECT_TRUE(part.multipliers.empty());
  }
  expect_near(sum, eta, 1e-12);
  expect_near(causes.parts[0].reactions, expected.parts[0].reactions, 1e-12);
  expect_near(causes.parts[1].reactions, expected.parts[1].reactions, 1e-12);
}

// ---- the reaction by its causes ----------------------------------------------------------------------------------

RC_GTEST_PROP(ReactionsByCause, AddUpToTheMultipliersAndTheReactions, ()) {
  Solved solved(any_system());

  const ReactionsByCause causes = solved.dynamics.reactions_by_cause(solved.state());

  RC_ASSERT(causes.outcome.ok());
  VectorXd lambda = VectorXd::Zero(solved.lambda.size()), eta = VectorXd::Zero(solved.eta.size());
  double parts_size = 1.0;
  for (const ReactionPart& part : causes.parts) {
    lambda += reference::vector(part.multipliers);
    eta += solved.dense.pick(part.reactions);
    parts_size += solved.as_acceleration(solved.dense.pick(part.reactions));
  }
  const VectorXd root = solved.dense.S().diagonal().cwiseSqrt();
  RC_ASSERT(solved.as_acceleration(eta - solved.eta) <= solved.accuracy * (parts_size + solved.size));
  RC_ASSERT(root.cwiseProduct(lambda - solved.lambda).norm() <=
            solved.accuracy * (parts_size + solved.size + root.cwiseProduct(solved.lambda).norm()));
}

TEST(ReactionsByCause, AddUpToTheSmallestMultipliersOfRedundantRods) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0};
  system.velocities = {0.0, 0.0, 0.0, 0.0, 0.0, 2.0};
  system.masses = {1.0, 3.0};
  system.supports = {{"", {0}, {}}};
  system.constraints = {Rods{"rods", {{0, 1}, {1, 0}}, {}, {}}};
  system.forces = {Gravity{"", {5.0, 0.0, -9.81}}};
  Dynamics dynamics(system);
  std::vector<double> w(6), lambda(2);
  ASSERT_TRUE(dynamics
                  .solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                         {.accelerations = w, .multipliers = lambda})
                  .outcome.ok());

  const ReactionsByCause causes =
      dynamics.reactions_by_cause({.time = 0.0, .positions = system.positions, .velocities = system.velocities});

  ASSERT_TRUE(causes.outcome.ok()) << causes.outcome.what;
  for (std::size_t row = 0; row < 2; ++row) {
    double sum = 0.0;
    for (const ReactionPart& part : causes.parts) sum += part.multipliers[row];
    EXPECT_NEAR(sum, lambda[row], 1e-12);
    EXPECT_NEAR(lambda[row], -0.5 * (3.0 * 5.0 + 3.0 * 4.0), 1e-12);  // half of m g_x + m v^2/l each
  }
}

RC_GTEST_PROP(ReactionsByCause, PartOfAForceIsTheReactionToItAloneAtRest, ()) {
  Solved solved(any_system({.time_dependent = false}));

  const ReactionsByCause causes = solved.dynamics.reactions_by_cause(solved.state());

  RC_ASSERT(causes.outcome.ok());
  const System& system = solved.random.system;
  RC_ASSERT(causes.parts.size() == system.forces.size() + 1);
  RC_ASSERT(causes.parts.back().cause == "inertia");
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    System alone = system;
    alone.forces = {system.forces[k]};
    reference::Paper paper(solved.dense);
    paper.phi.setZero();
    const VectorXd f = solved.dense.pick(
        reference::evaluate_forces(alone, solved.random.t, solved.random.positions, solved.random.velocities));
    const VectorXd expected = paper.eta_by_K(f);
    RC_ASSERT(causes.parts[k].cause == force_name(system, k));
    RC_ASSERT(solved.as_acceleration(solved.dense.pick(causes.parts[k].reactions) - expected) <=
              10.0 * solved.accuracy * solved.size);
  }
}

TEST(ReactionsByCause, AreThoseByHandUnderARisingSupport) {
  // 2 kg pass the lowest point of a rod of 0.5 m at 3 m/s relative to a support that is lifted by t^2 (2 m/s^2), so
  // that tension = m g + m v^2/l + m a = 19.62 + 36 + 4.
  System system;
  system.positions = {0.0, 0.0, 0.5, 0.0, 0.0, 0.0};
  system.masses = {1.0, 2.0};
  system.supports = {{"", {0}, {0.0, 0.0, ScalarFunction::formula("t^2")}}};
  system.constraints = {Rods{"rod", {{0, 1}}, {}, {}}};
  system.forces = {Gravity{"weight", {0.0, 0.0, -9.81}}};
  Dynamics dynamics(system);
  const std::vector<double> v{0, 0, 0, 3, 0, 0};

  const std::vector<ReactionPart> parts =
      dynamics.reactions_by_cause({.time = 0.0, .positions = system.positions, .velocities = v}).parts;

  ASSERT_EQ(parts.size(), 3U);
  EXPECT_EQ(parts[0].cause, "weight");
  EXPECT_NEAR(parts[0].multipliers[0], -19.62, 1e-13);
  EXPECT_EQ(parts[1].cause, "inertia");
  EXPECT_NEAR(parts[1].multipliers[0], -36.0, 1e-13);
  EXPECT_EQ(parts[2].cause, "drive");
  EXPECT_NEAR(parts[2].multipliers[0], -4.0, 1e-13);
  EXPECT_NEAR(parts[2].reactions[5], 4.0, 1e-13);
  EXPECT_NEAR(parts[2].reactions[2], -4.0, 1e-13);
}

TEST(ReactionsByCause, AreThoseByHandOnATurningPlane) {
  // The plane turns around z at 2 rad/s, n = (-sin 2t, cos 2t, 0), and the bead of 1 kg slides outwards at 3 m/s from 1
  // m. K'w = -phi with phi = 2 v'n_t + r'n_tt, which is the Coriolis force 2 m omega v = 12 N, all of it drive.
  System system;
  system.positions = {1.0, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {
      Planes{"blade", {0}, {ScalarFunction::formula("-sin(2*t)"), ScalarFunction::formula("cos(2*t)"), 0.0}, 0.0}};
  Dynamics dynamics(system);
  const std::vector<double> v{3, 2, 0};

  const std::vector<ReactionPart> parts =
      dynamics.reactions_by_cause({.time = 0.0, .positions = system.positions, .velocities = v}).parts;

  ASSERT_EQ(parts.size(), 2U);
  EXPECT_NEAR(parts[0].multipliers[0], 0.0, 1e-13);
  EXPECT_NEAR(parts[1].multipliers[0], 12.0, 1e-13);
}

// ---- one point ---------------------------------------------------------------------------------------------------

TEST(SinglePoint, HasTheExplicitSolutionOnASphere) {
  System system;
  system.positions = {0.6, 0.0, 0.8};
  system.masses = {1.3};
  system.constraints = {Spheres{"ball", {0}, Vector3{}, 1.0}};
  system.forces = {Gravity{"weight", {0.5, -0.2, -9.81}}};
  const std::vector<double> v = {0.8, 1.0, -0.6};
  Dynamics dynamics(system);
  std::vector<double> w(3), lambda(1);
  ASSERT_TRUE(dynamics
                  .solve({.time = 0.0, .positions = system.positions, .velocities = v},
                         {.accelerations = w, .multipliers = lambda})
                  .outcome.ok());

  // For |r| - 1, phi = |v|^2/|r| where v is tangent.
  const reference::Solution expected =
      reference::solve_single_point(1.3, 1.3 * Eigen::Vector3d(0.5, -0.2, -9.81), {0.6, 0.0, 0.8}, 2.0);

  for (Eigen::Index c = 0; c < 3; ++c) EXPECT_NEAR(w[static_cast<std::size_t>(c)], expected.w[c], 1e-14 * 20.0);
  EXPECT_NEAR(lambda[0], expected.lambda[0], 1e-14 * 20.0);
}

}  // namespace
}  // namespace tanor
