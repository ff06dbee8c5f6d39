/// Rings of rods, which the solver of paths takes, are compared with the general solver.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "schur/answers.hpp"

namespace tanor {
namespace {

/// Makes rods of random lengths and directions that come back to where they began, numbered at random, in any order and
/// direction. Points lie up to `height` above and below a circle.
System make_random_ring(Index num_points, double height, AnyNumbers* any) {
  const auto count = static_cast<std::size_t>(num_points);
  std::vector<Index> place(count);
  std::iota(place.begin(), place.end(), 0);
  std::shuffle(place.begin(), place.end(), any->generator());
  System system;
  for (Index k = 0; k < num_points; ++k) (void)add_point({0.0, 0.0, 0.0}, any, &system);
  Rods rods{"ring", {}, {}, {}};
  const double radius = num_points / (2.0 * std::numbers::pi);
  for (Index k = 0; k < num_points; ++k) {
    const double angle = 2.0 * std::numbers::pi * (k + 0.2 * (*any)()) / num_points;
    const Index i = place[static_cast<std::size_t>(k)], j = place[static_cast<std::size_t>((k + 1) % num_points)];
    const Vector3 at{radius * std::cos(angle), radius * std::sin(angle), height * (*any)()};
    std::copy(at.begin(), at.end(), system.positions.begin() + 3 * i);
    rods.pairs.push_back(any->up_to(1) == 0 ? std::array{i, j} : std::array{j, i});
  }
  std::shuffle(rods.pairs.begin(), rods.pairs.end(), any->generator());
  system.constraints = {rods};
  system.forces = {Gravity{"", {0.1, 0.0, -9.81}}};
  return system;
}

/// Makes a ring with lengths that move, offsets, and different forces at some points.
System make_driven_ring(Index num_points, AnyNumbers* any) {
  System system = make_random_ring(num_points, 0.5, any);
  const Rods all = std::get<Rods>(system.constraints[0]);
  Rods plain{"plain", {}, {}, {}}, breathing{"breathing", {}, {}, {}}, across{"across", {}, {}, {}};
  breathing.length.functions = {ScalarFunction::formula("1+0.1*sin(3*t)")};
  for (std::size_t k = 0; k < all.pairs.size(); ++k) {
    if (k % 3 == 0) {
      breathing.pairs.push_back(all.pairs[k]);
    } else if (k % 3 == 1) {
      across.pairs.push_back(all.pairs[k]);
      across.offsets.push_back({0.5, -1.0, 0.25 * (*any)()});
    } else {
      plain.pairs.push_back(all.pairs[k]);
    }
  }
  system.constraints = {breathing, plain, across};
  Drag drag{"", {}, 0.2, 0.1};
  for (Index i = 0; i < num_points; i += 3) drag.points.push_back(i);
  system.forces.push_back(drag);
  return system;
}

/// Appends the points and groups of the second system to those of the first one.
void append(const System& more, System* system) {
  const auto shift = static_cast<Index>(system->masses.size());
  system->positions.insert(system->positions.end(), more.positions.begin(), more.positions.end());
  system->velocities.insert(system->velocities.end(), more.velocities.begin(), more.velocities.end());
  system->masses.insert(system->masses.end(), more.masses.begin(), more.masses.end());
  auto& pairs = std::get<Rods>(system->constraints[0]).pairs;
  for (const auto& [i, j] : std::get<Rods>(more.constraints[0]).pairs) pairs.push_back({shift + i, shift + j});
}

/// Expects agreement with the general solver and at most one refinement more than it takes.
/// tests/schur/path_rings_test.cpp checks the numbers before any refinement.
void expect_agreement_on_ring(const System& system) {
  const Answer general = solve(system, {.linear_solver = LinearSolver::General}, 0.4),
               paths = solve(system, {.linear_solver = LinearSolver::Paths}, 0.4);
  EXPECT_TRUE(paths.report.outcome.ok()) << paths.report.outcome.what;
  EXPECT_LE(paths.report.residual, rounding);
  EXPECT_LE(relative_difference(paths.w, general.w), rounding);
  EXPECT_LE(relative_difference(paths.lambda, general.lambda), rounding);
  EXPECT_LE(relative_difference(paths.eta, general.eta), rounding);
  EXPECT_LE(paths.report.refinements, general.report.refinements + 1);
}

TEST(Rings, AgreeWithTheGeneralSolver) {
  AnyNumbers any(21);
  for (const Index num_points : {3, 4, 5, 6, 7, 17, 63, 64, 65, 128, 129, 130, 131, 256, 257, 258, 259, 260, 700}) {
    SCOPED_TRACE(testing::Message() << num_points << " points");
    expect_agreement_on_ring(make_random_ring(num_points, 0.5, &any));
    expect_agreement_on_ring(make_driven_ring(num_points, &any));
  }
}

/// The rings are nearly straight from rod to rod, so that the last row depends on all others.
TEST(Rings, AgreeWithTheGeneralSolverWhenNearlyFlat) {
  AnyNumbers any(22);
  for (const Index num_points : {5, 40, 300}) {
    SCOPED_TRACE(testing::Message() << num_points << " points");
    expect_agreement_on_ring(make_random_ring(num_points, 0.02, &any));
  }
}

TEST(Rings, AgreeWithTheGeneralSolverBesidePaths) {
  AnyNumbers any(23);
  System system = make_random_ring(90, 0.5, &any);
  for (int k = 0; k < 60; ++k) {
    System one = make_random_ring(3 + any.up_to(40), 0.5, &any);
    if (k % 2 == 0) std::get<Rods>(one.constraints[0]).pairs.pop_back();
    append(one, &system);
  }
  expect_agreement_on_ring(system);
  EXPECT_NE(Dynamics(system, {.linear_solver = LinearSolver::Paths})
                .plan()
                .linear_solver_reason.find("30 paths of rods, 31 rings of rods"),
            std::string::npos);
}

/// Every rod pulls with m w^2 R / (2 sin(pi/n)).
TEST(Rings, PullByTheClosedFormWhenTurning) {
  constexpr double speed = 2.0, mass = 0.7;
  for (const Index n : {3, 24, 1000}) {
    const double radius = 0.1 * n;
    System system;
    Rods rods{"ring", {}, {}, {}};
    for (Index k = 0; k < n; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / n;
      system.positions.insert(system.positions.end(), {radius * std::cos(angle), radius * std::sin(angle), 0.0});
      system.velocities.insert(system.velocities.end(),
                               {-speed * radius * std::sin(angle), speed * radius * std::cos(angle), 0.0});
      system.masses.push_back(mass);
      rods.pairs.push_back({k, (k + 1) % n});
    }
    system.constraints = {rods};

    const Answer answer = solve(system, {.linear_solver = LinearSolver::Paths});

    const double tension = mass * speed * speed * radius / (2.0 * std::sin(std::numbers::pi / n));
    for (const double lambda : answer.lambda) EXPECT_NEAR(lambda, -tension, 1e-12 * tension);
  }
}

TEST(Rings, ThreadsChangeNoBit) {
  AnyNumbers any(24);
  expect_the_same_bits_with_threads(make_random_ring(20011, 0.5, &any), LinearSolver::Paths);
}

/// Projections and corrections are further right sides with a factor.
TEST(Rings, MoveAsWithTheGeneralSolver) {
  AnyNumbers any(25);
  const System system = make_random_ring(150, 0.5, &any);
  for (const Method method : {Method::Rattle, Method::Dop853, Method::Taylor}) {
    MotionOptions motion{.method = method, .rtol = 1e-10, .atol = 1e-10, .start = StartMode::Project};
    if (method == Method::Rattle) motion.step = 1e-3;
    Simulation rings(system, motion, {.linear_solver = LinearSolver::Paths}),
        general(system, motion, {.linear_solver = LinearSolver::General});

    ASSERT_TRUE(rings.advance_to(0.05).ok() && general.advance_to(0.05).ok());

    const std::vector<double> r(rings.positions().begin(), rings.positions().end());
    EXPECT_LE(relative_difference(r, {general.positions().begin(), general.positions().end()}), 1e-10);
    EXPECT_LE(rings.report().violation.position, rounding);
  }
}

/// Four rods, stretched to a line, depend on one another, which the general solver decides.
TEST(Rings, AreLeftToTheGeneralSolverWhenSingular) {
  const System system = make_stretched_ring();

  const Answer paths = solve(system, {.linear_solver = LinearSolver::Paths}),
               general = solve(system, {.linear_solver = LinearSolver::General});

  EXPECT_EQ(paths.report.outcome.status, general.report.outcome.status);
  EXPECT_EQ(paths.w, general.w);
  EXPECT_EQ(paths.lambda, general.lambda);
}

/// A further point hangs on a rod of its own.
TEST(Rings, AreLeftToTheGeneralSolverWithABranch) {
  AnyNumbers any(26);
  System system = make_random_ring(200, 0.5, &any);
  EXPECT_EQ(Dynamics(system).plan().linear_solver(), "paths");
  const Index mate = add_point({0.0, 0.0, 3.0}, &any, &system);
  std::get<Rods>(system.constraints[0]).pairs.push_back({7, mate});

  EXPECT_EQ(Dynamics(system).plan().linear_solver(), "general");
  EXPECT_THROW((void)Dynamics(system, {.linear_solver = LinearSolver::Paths}), InputError);
}

}  // namespace
}  // namespace tanor
