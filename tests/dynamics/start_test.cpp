/// Consistent starts and projections find the nearest state in the M-norm, and are refused as docs/scene-format.md
/// says.

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "dense.hpp"
#include "solved.hpp"

namespace tanor {
namespace {

using Eigen::VectorXd;

/// Returns positions or velocities with every coordinate of the moving points changed by up to `size`.
std::vector<double> disturbed(const RandomSystem& random, std::vector<double> numbers, double size,
                              std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> any(-size, size);
  const std::vector<char> is_support = reference::find_supports(random.system);
  for (std::size_t c = 0; c < numbers.size(); ++c) {
    if (!is_support[c / 3]) numbers[c] += any(generator);
  }
  return numbers;
}

reference::Mechanics mechanics_at(const RandomSystem& random, const std::vector<double>& r,
                                  const std::vector<double>& v) {
  return reference::make_mechanics(random.system, random.t, r, v);
}

/// Returns the norm of the part of x outside the range of the columns of K.
double outside_range(const Eigen::MatrixXd& K, const VectorXd& x) {
  if (K.cols() == 0) return x.norm();
  const Eigen::MatrixXd basis = reference::orthonormal_basis(K.colwise().normalized()).leftCols(K.cols());
  return (x - basis * (basis.transpose() * x)).norm();
}

// ---- velocities: a linear problem --------------------------------------------------------------------------------

RC_GTEST_PROP(ProjectVelocities, IsTheOrthogonalProjectionInTheMassMetric, ()) {
  const RandomSystem random = any_system();
  const std::vector<double> given = disturbed(random, random.velocities, 1.0, 3);
  Dynamics dynamics(random.system);
  std::vector<double> v = given;

  const ProjectionReport report =
      dynamics.project_velocities({.time = random.t, .positions = random.positions, .velocities = v});

  // The projection is v - M^-1 K S^-1 (K'v + xi_t).
  RC_ASSERT(report.outcome.ok());
  const reference::Mechanics dense = mechanics_at(random, random.positions, given);
  const VectorXd rate = dense.K.transpose() * dense.v + dense.rheonomic_rate;
  const VectorXd move = -(dense.K * reference::solve_definite(dense.S(), rate)).cwiseQuotient(dense.M);
  const double accuracy = 1e-12 * dense.sqrt_condition() * (1.0 + dense.v.norm());
  RC_ASSERT((dense.pick(v) - dense.v - move).norm() <= 10.0 * accuracy);
  RC_ASSERT((dense.K.transpose() * dense.pick(v) + dense.rheonomic_rate).norm() <= accuracy * (1.0 + dense.K.norm()));
  // The move is M-orthogonal to everything admissible, so that M move lies in the range of K.
  const VectorXd M_move = dense.M.cwiseProduct(dense.pick(v) - dense.v);
  RC_ASSERT(outside_range(dense.K, M_move) <= accuracy * dense.M.maxCoeff());
}

RC_GTEST_PROP(ProjectVelocities, LeavesAdmissibleVelocitiesAsTheyAre, ()) {
  const RandomSystem random = any_system();
  Dynamics dynamics(random.system);
  std::vector<double> once = disturbed(random, random.velocities, 1.0, 3);
  (void)dynamics.project_velocities({.time = random.t, .positions = random.positions, .velocities = once});
  std::vector<double> twice = once;

  const ProjectionReport report =
      dynamics.project_velocities({.time = random.t, .positions = random.positions, .velocities = twice});

  RC_ASSERT(report.outcome.ok());
  const double accuracy = 1e-12 * mechanics_at(random, random.positions, once).sqrt_condition();
  RC_ASSERT((reference::vector(twice) - reference::vector(once)).norm() <=
            accuracy * (1.0 + reference::vector(once).norm()));
}

RC_GTEST_PROP(ProjectVelocities, SplitsTheKineticEnergy, ()) {
  // Nothing is driven, so that T(given) = T(projected) + T(move) and the projection never adds energy.
  const RandomSystem random = any_system({.time_dependent = false});
  Dynamics dynamics(random.system);
  const std::vector<double> given = disturbed(random, random.velocities, 1.0, 3);
  std::vector<double> v = given;

  (void)dynamics.project_velocities({.time = random.t, .positions = random.positions, .velocities = v});

  const reference::Mechanics dense = mechanics_at(random, random.positions, given);
  const auto energy = [&](const VectorXd& x) { return 0.5 * x.dot(dense.M.cwiseProduct(x)); };
  const VectorXd after = dense.pick(v);
  RC_ASSERT(std::abs(energy(dense.v) - energy(after) - energy(dense.v - after)) <=
            1e-12 * dense.sqrt_condition() * (1.0 + energy(dense.v)));
}

TEST(ProjectVelocities, ReportsTheLargestMove) {
  // Point 1 (twice the mass) moves off at 3 m/s along the rod. Both points end with 2 m/s. Point 0 changes by 2, point
  // 1 by 1.
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0};
  system.masses = {1.0, 2.0};
  system.constraints = {Rods{"", {{0, 1}}, {}, {}}};
  Dynamics dynamics(system);
  std::vector<double> v = {0.0, 0.0, 0.5, 3.0, 0.0, 0.0};

  const ProjectionReport report =
      dynamics.project_velocities({.time = 0.0, .positions = system.positions, .velocities = v});

  const double expected[] = {2.0, 0.0, 0.5, 2.0, 0.0, 0.0};
  for (std::size_t c = 0; c < 6; ++c) EXPECT_NEAR(v[c], expected[c], 1e-15);
  EXPECT_NEAR(report.correction, 2.0, 1e-15);
  EXPECT_LE(report.violation, 1e-15);
}

// ---- positions ---------------------------------------------------------------------------------------------------

RC_GTEST_PROP(ProjectPositions, SmallDisturbancesAreRemovedToRounding, ()) {
  const RandomSystem random = any_system();
  Dynamics dynamics(random.system);
  std::vector<double> r = disturbed(random, random.positions, 1e-4, 5);

  const ProjectionReport report = dynamics.project_positions({.time = random.t, .positions = r});

  RC_ASSERT(report.outcome.ok());
  RC_ASSERT(report.violation <= 1e-13);
  const auto numbers = reference::evaluate_constraints(random.system, random.t, r, random.velocities);
  RC_ASSERT(numbers.xi.size() == 0 ||
            numbers.xi.lpNorm<Eigen::Infinity>() <= 1e-12 * (1.0 + reference::vector(r).norm()));
  RC_ASSERT(dynamics.position_violation({.time = random.t, .positions = r}) <= 1e-13);
}

TEST(ProjectPositions, AdmissiblePositionsStayBitByBit) {
  const RandomSystem random = make_random_system(20, 11);
  Dynamics dynamics(random.system);
  std::vector<double> once = random.positions;
  ASSERT_TRUE(dynamics.project_positions({.time = random.t, .positions = once}).outcome.ok());
  std::vector<double> twice = once;

  const ProjectionReport report = dynamics.project_positions({.time = random.t, .positions = twice});

  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ(report.correction, 0.0);
  EXPECT_EQ(twice, once);
}

// ---- starts ------------------------------------------------------------------------------------------------------

RC_GTEST_PROP(Start, ProjectFindsTheStationaryPointOfTheDistanceInTheMassMetric, ()) {
  // The first-order condition of the nearest point is that M (r - r*) lies in the range of K(r) with xi(r) = 0.
  const RandomSystem random = any_system();
  Dynamics dynamics(random.system);
  const std::vector<double> wanted = disturbed(random, random.positions, 0.02, 5);
  std::vector<double> r = wanted, v = random.velocities;

  const StartReport report = dynamics.start({.time = random.t, .positions = r, .velocities = v}, StartMode::Project);

  RC_ASSERT(report.outcome.ok());
  const reference::Mechanics dense = mechanics_at(random, r, v);
  const VectorXd pull = dense.M.cwiseProduct(dense.pick(r) - dense.pick(wanted));
  RC_ASSERT(outside_range(dense.K, pull) <= 1e-9 * dense.M.maxCoeff() * dense.sqrt_condition());
  RC_ASSERT(dynamics.position_violation({.time = random.t, .positions = r}) <= 1e-12);
  RC_ASSERT(dynamics.velocity_violation({.time = random.t, .positions = r, .velocities = v}) <= 1e-12);
}

TEST(Start, ProjectMovesTwoMassesInInverseProportion) {
  // The distance is 3, the rod has length 1, and the masses are 1 and 3. The light one moves 1.5 and the heavy one 0.5.
  System system;
  system.positions = {0.0, 0.0, 0.0, 3.0, 0.0, 0.0};
  system.masses = {1.0, 3.0};
  system.constraints = {Rods{"", {{0, 1}}, 1.0, {}}};
  Dynamics dynamics(system);
  std::vector<double> r = system.positions, v = {1.0, 2.0, 0.0, 0.0, 0.0, 0.0};

  const StartReport report = dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Project);

  ASSERT_TRUE(report.outcome.ok());
  EXPECT_NEAR(r[0], 1.5, 1e-13);
  EXPECT_NEAR(r[3], 2.5, 1e-13);
  EXPECT_NEAR(report.position_correction, 1.5, 1e-13);
  // Momentum along the rod is shared, 1/4 each, and velocities across it do not change.
  EXPECT_NEAR(v[0], 0.25, 1e-13);
  EXPECT_NEAR(v[3], 0.25, 1e-13);
  EXPECT_EQ(v[1], 2.0);
  EXPECT_NEAR(report.velocity_correction, 0.75, 1e-13);
}

TEST(Start, ProjectFindsTheNearestPointOfASphereFromFarAway) {
  // The starts are five radii outside and near the center, and the path is along the ray.
  for (const double distance : {5.0, 0.1}) {
    System system;
    system.positions = {0.6 * distance, 0.0, 0.8 * distance, 0.0, 0.0, 10.0};
    system.masses = {2.0, 1.0};
    system.constraints = {Spheres{"", {0}, {}, 1.0}};
    Dynamics dynamics(system);
    std::vector<double> r = system.positions, v(6, 0.0);

    const StartReport report = dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Project);

    ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
    EXPECT_NEAR(r[0], 0.6, 1e-13);
    EXPECT_NEAR(r[1], 0.0, 1e-13);
    EXPECT_NEAR(r[2], 0.8, 1e-13);
    EXPECT_NEAR(report.position_correction, std::abs(distance - 1.0), 1e-13);
  }
}

TEST(Start, ProjectFindsTheNearestPointOfACircle) {
  // The start is off the plane and outside. The nearest point is down in the plane and in at the radius.
  System system;
  system.positions = {3.0, 4.0, 2.0};
  system.masses = {2.0};
  system.constraints = {Circles{"", {0}, {}, Vector3{0.0, 0.0, 2.0}, 1.0}};
  Dynamics dynamics(system);
  std::vector<double> r = system.positions, v = {1.0, 1.0, 1.0};

  ASSERT_TRUE(dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Project).outcome.ok());

  EXPECT_NEAR(r[0], 0.6, 1e-13);
  EXPECT_NEAR(r[1], 0.8, 1e-13);
  EXPECT_NEAR(r[2], 0.0, 1e-13);
  // The part of (1, 1, 1) along the tangent (-0.8, 0.6, 0) is -0.2.
  EXPECT_NEAR(v[0], 0.16, 1e-13);
  EXPECT_NEAR(v[1], -0.12, 1e-13);
  EXPECT_NEAR(v[2], 0.0, 1e-13);
}

/// Returns the least squared M-distance from the wanted places to a double pendulum with arms l1, l2, by refining a
/// grid of its angles.
double smallest_distance(const std::vector<double>& wanted, const std::vector<double>& masses, double l1, double l2) {
  const auto distance = [&](double a, double b) {
    const double x1 = l1 * std::sin(a), z1 = -l1 * std::cos(a);
    const double x2 = x1 + l2 * std::sin(b), z2 = z1 - l2 * std::cos(b);
    return masses[1] * (std::pow(x1 - wanted[3], 2) + std::pow(z1 - wanted[5], 2)) +
           masses[2] * (std::pow(x2 - wanted[6], 2) + std::pow(z2 - wanted[8], 2));
  };
  double best_a = 0.0, best_b = 0.0, best = HUGE_VAL;
  double width = 3.2;
  for (int round = 0; round < 60; ++round, width *= 0.6) {
    const double a0 = best_a, b0 = best_b;
    for (int i = -10; i <= 10; ++i) {
      for (int j = -10; j <= 10; ++j) {
        const double a = a0 + 0.1 * width * i, b = b0 + 0.1 * width * j;
        if (distance(a, b) < best) {
          best = distance(a, b);
          best_a = a;
          best_b = b;
        }
      }
    }
  }
  return best;
}

TEST(Start, ProjectFindsTheNearestDoublePendulum) {
  // The chain (0) - 1 - 2 has arms 1 and 0.7, and the wanted places are half a length away. A search over the two
  // angles is the witness.
  System system;
  system.positions = {0.0, 0.0, 0.0, 0.9, 0.0, -0.9, 1.9, 0.0, -0.7};
  system.masses = {1.0, 0.4, 2.5};
  system.supports = {{"", {0}, {}}};
  system.constraints = {Rods{"", {{0, 1}, {1, 2}}, std::vector{1.0, 0.7}, {}}};
  Dynamics dynamics(system);
  std::vector<double> r = system.positions, v(9, 0.0);

  const StartReport report = dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Project);

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  double distance = 0.0;
  for (std::size_t c = 3; c < 9; ++c) distance += system.masses[c / 3] * std::pow(r[c] - system.positions[c], 2);
  EXPECT_NEAR(distance, smallest_distance(system.positions, system.masses, 1.0, 0.7), 1e-12);
}

TEST(Start, ProjectReachesRodsAThirdAsLongAsTheStartSays) {
  // The rods of a bent chain must shrink to a third. Each point is far outside the sphere around its neighbour.
  System system;
  Rods rods{"", {}, 0.1, {}};
  for (Index k = 0; k <= 10; ++k) {
    for (const double x : {0.3 * k, 0.05 * std::sin(2.0 * k), 0.05 * std::cos(3.0 * k)}) system.positions.push_back(x);
    system.masses.push_back(1.0 + 0.5 * std::sin(k));
    if (k > 0) rods.pairs.push_back({k - 1, k});
  }
  system.supports = {{"", {0}, {}}};
  system.constraints = {rods};
  Dynamics dynamics(system);
  std::vector<double> r = system.positions, v(r.size(), 0.0);

  const StartReport report = dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Project);

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  const reference::Mechanics dense = reference::make_mechanics(system, 0.0, r, v);
  const VectorXd pull = dense.M.cwiseProduct(dense.pick(r) - dense.pick(system.positions));
  EXPECT_LE(outside_range(dense.K, pull), 1e-9);
  EXPECT_LE(dynamics.position_violation({.time = 0.0, .positions = r}), 1e-12);
}

TEST(Start, PositionsAreScaledByTheLengthsAndReported) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0005, 0.0, 0.0};
  system.masses = {1.0, 1.0};
  system.constraints = {Rods{"", {{0, 1}}, 1.0, {}}};
  Dynamics dynamics(system);
  std::vector<double> r = system.positions, v(6, 0.0);

  const StartReport report = dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Check);

  ASSERT_TRUE(report.outcome.ok());
  EXPECT_NEAR(report.position_correction, 0.00025, 1e-15);
  EXPECT_NEAR(report.relative, 0.00025 / 1.0005, 1e-15);
  EXPECT_NEAR(r[3] - r[0], 1.0, 1e-15);
}

RC_GTEST_PROP(Start, CheckCorrectsSmallDisturbances, ()) {
  RandomSystem random = any_system();
  Dynamics dynamics(random.system);
  std::vector<double> r = disturbed(random, random.positions, 1e-6, 7),
                      v = disturbed(random, random.velocities, 1e-6, 8);

  const StartReport report = dynamics.start({.time = random.t, .positions = r, .velocities = v}, StartMode::Check);

  RC_ASSERT(report.outcome.ok());
  RC_ASSERT(report.relative <= 1e-3);
  RC_ASSERT(dynamics.position_violation({.time = random.t, .positions = r}) <= 1e-12);
  RC_ASSERT(dynamics.velocity_violation({.time = random.t, .positions = r, .velocities = v}) <= 1e-12);
}

class RefusedStart : public testing::Test {
 protected:
  System system;
  std::vector<double> r, v = std::vector<double>(12, 0.0);

  void SetUp() override {
    system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 2.0, 1.0, 0.0};
    system.masses.assign(4, 1.0);
    system.supports = {{"", {0}, {}}};
    system.constraints = {Rods{"links", {{0, 1}, {1, 2}, {2, 3}}, {}, {}}};
    system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
    r = system.positions;
  }

  InputError refusal() {
    Dynamics dynamics(system);
    try {
      (void)dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Check);
    } catch (const InputError& error) {
      return error;
    }
    ADD_FAILURE() << "the start is accepted";
    return {"", ""};
  }
};

TEST_F(RefusedStart, NamesTheConstraintWhosePositionsAreWorst) {
  r[5] += 0.1;   // bends links[0] a little, links[1] a little
  r[10] += 0.2;  // bends links[2]
  r[9] += 0.5;

  const InputError error = refusal();

  EXPECT_EQ(error.where(), "/motion/start");
  EXPECT_NE(std::string(error.what()).find("the initial positions violate links[2] by 0.5"), std::string::npos)
      << error.what();
}

TEST_F(RefusedStart, NamesTheConstraintWhoseVelocitiesAreWorst) {
  v[4] = 1.0;  // along links[1]

  const InputError error = refusal();

  EXPECT_EQ(error.where(), "/motion/start");
  EXPECT_NE(std::string(error.what()).find("the initial velocities violate links[1] by 1"), std::string::npos)
      << error.what();
}

TEST_F(RefusedStart, ProjectAcceptsTheSameStart) {
  r[9] += 0.5;
  v[4] = 1.0;
  Dynamics dynamics(system);

  const StartReport report = dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Project);

  EXPECT_TRUE(report.outcome.ok());
  EXPECT_LE(dynamics.position_violation({.time = 0.0, .positions = r}), 1e-13);
  EXPECT_LE(dynamics.velocity_violation({.time = 0.0, .positions = r, .velocities = v}), 1e-13);
}

TEST(Start, SystemWithoutConstraintsStartsAsItIs) {
  System system;
  system.positions = {1.0, 2.0, 3.0};
  system.masses = {1.0};
  Dynamics dynamics(system);
  std::vector<double> r = system.positions, v = {4.0, 5.0, 6.0};

  const StartReport report = dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Check);

  EXPECT_TRUE(report.outcome.ok());
  EXPECT_EQ(report.relative, 0.0);
  EXPECT_EQ(r, system.positions);
  EXPECT_EQ(v, (std::vector{4.0, 5.0, 6.0}));
}

}  // namespace
}  // namespace tanor
