/// Every solver of S lambda = b agrees with the general one.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "schur/answers.hpp"

namespace tanor {
namespace {

enum class Ends { Free, First, Last, Both };

/// Makes rods of random lengths and directions in a row, numbered at random, with random masses.
System make_random_chain(std::size_t num_points, Ends ends, double mass_range, std::mt19937* random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto number = [&] { return unit(*random); };
  std::vector<Index> place(num_points);
  std::iota(place.begin(), place.end(), 0);
  std::shuffle(place.begin(), place.end(), *random);
  System system;
  for (std::vector<double>* array : {&system.positions, &system.velocities}) array->resize(3 * num_points);
  system.masses.resize(num_points);
  Rods rods;
  rods.name = "rods";
  double at[3] = {0.0, 0.0, 0.0};
  for (std::size_t k = 0; k < num_points; ++k) {
    const auto i = static_cast<std::size_t>(place[k]);
    for (std::size_t c = 0; c < 3; ++c) {
      system.positions[3 * i + c] = at[c];
      system.velocities[3 * i + c] = number();
      at[c] += number() + (c == 0 ? 0.3 : 0.0);
    }
    system.masses[i] = std::pow(mass_range, 0.5 * number());
    if (k == 0) continue;
    const bool is_turned = number() > 0.0;
    rods.pairs.push_back({place[is_turned ? k : k - 1], place[is_turned ? k - 1 : k]});
  }
  std::shuffle(rods.pairs.begin(), rods.pairs.end(), *random);
  std::vector<Index> held;
  if (ends == Ends::First || ends == Ends::Both) held.push_back(place.front());
  if (ends == Ends::Last || ends == Ends::Both) held.push_back(place.back());
  for (const Index point : held) {
    system.supports.push_back({"", {point}, VectorFunction(0.0, 0.0, 0.0)});
    std::fill_n(system.velocities.begin() + 3 * point, 3, 0.0);
  }
  system.constraints = {rods};
  system.forces = {Gravity{"", {0.1, 0.0, -9.81}}};
  return system;
}

TEST(LinearSolvers, PathsAgreeWithTheGeneralSolver) {
  std::mt19937 random(6);
  int refined = 0, solved = 0;
  for (const Ends ends : {Ends::Free, Ends::First, Ends::Last, Ends::Both}) {
    for (const std::size_t num_points : {2, 3, 4, 5, 17, 64, 65, 66, 129, 130, 131, 257, 1000}) {
      const System system = make_random_chain(num_points, ends, 1e2, &random);
      if (num_points == 2 && ends == Ends::Both) continue;

      const Answer general = solve(system, {.linear_solver = LinearSolver::General}),
                   paths = solve(system, {.linear_solver = LinearSolver::Paths});

      ASSERT_TRUE(paths.report.outcome.ok()) << paths.report.outcome.what;
      refined += paths.report.refinements;
      ++solved;
      EXPECT_LE(relative_difference(paths.w, general.w), 1e-12) << num_points;
      EXPECT_LE(relative_difference(paths.lambda, general.lambda), 1e-12) << num_points;
      EXPECT_LE(relative_difference(paths.eta, general.eta), 1e-12) << num_points;
    }
  }
  EXPECT_LT(4 * refined, solved);  // badly conditioned ones alone: else wrong numbers were mended
}

TEST(LinearSolvers, PathsAgreeWhereMassesAreFarApart) {
  std::mt19937 random(7);
  for (const Ends ends : {Ends::Free, Ends::First, Ends::Both}) {
    const System system = make_random_chain(300, ends, 1e6, &random);

    const Answer general = solve(system, {.linear_solver = LinearSolver::General}),
                 paths = solve(system, {.linear_solver = LinearSolver::Paths});

    EXPECT_LE(paths.report.residual, 1e-14);
    EXPECT_LE(relative_difference(paths.w, general.w), 1e-12);
    EXPECT_LE(relative_difference(paths.lambda, general.lambda), 1e-12);
  }
}

TEST(LinearSolvers, HangingPathCarriesTheWeightBelow) {
  constexpr Index num_points = 1001;
  constexpr double g = 9.81;
  System system;
  Rods rods;
  for (Index i = 0; i < num_points; ++i) {
    system.positions.insert(system.positions.end(), {0.0, 0.0, -0.5 * i});
    system.masses.push_back(1.0 + i % 3);
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  system.velocities.assign(system.positions.size(), 0.0);
  system.supports = {{"", {0}, VectorFunction(0.0, 0.0, 0.0)}};
  system.constraints = {rods};
  system.forces = {Gravity{"", {0.0, 0.0, -g}}};

  const Answer answer = solve(system, {.linear_solver = LinearSolver::Paths});

  ASSERT_TRUE(answer.report.outcome.ok());
  double weight = 0.0, whole = g * std::accumulate(system.masses.begin() + 1, system.masses.end(), 0.0);
  for (std::size_t k = rods.pairs.size(); k-- > 0;) {
    weight += g * system.masses[k + 1];
    EXPECT_NEAR(answer.lambda[k], -weight, 1e-13 * whole) << "rod " << k;
  }
  for (const double w : answer.w) EXPECT_NEAR(w, 0.0, 1e-12 * g);
}

/// Makes a chain with lengths that move, an offset, a support that moves, and different forces at the points.
System make_random_driven_chain(std::mt19937* random) {
  System system = make_random_chain(500, Ends::First, 1e1, random);
  Rods& all = std::get<Rods>(system.constraints[0]);
  Rods breathing{"breathing", {}, {}, {}}, across{"across", {}, {}, {}};
  breathing.length.functions = {ScalarFunction::formula("1+0.1*sin(3*t)")};
  std::vector<std::array<Index, 2>> plain;
  for (std::size_t k = 0; k < all.pairs.size(); ++k) {
    if (k % 7 == 2) {
      breathing.pairs.push_back(all.pairs[k]);
    } else if (k % 11 == 3) {
      across.pairs.push_back(all.pairs[k]);
      across.offsets.push_back({0.5, -1.0, 0.25});
    } else {
      plain.push_back(all.pairs[k]);
    }
  }
  all.pairs = plain;
  system.constraints = {breathing, all, across};
  system.supports[0].displacement = VectorFunction(ScalarFunction::formula("0.3*t^2"), 0.0, 0.1);
  system.forces.push_back(Drag{"", {}, 0.2, 0.1});
  auto& points = std::get<Drag>(system.forces.back()).points;
  for (Index i = 0; i < 500; i += 3) points.push_back(i);
  return system;
}

TEST(LinearSolvers, PathsTakeMovingLengthsOffsetsAndForces) {
  std::mt19937 random(8);
  for (int repetition = 0; repetition < 3; ++repetition) {
    const System system = make_random_driven_chain(&random);

    const Answer general = solve(system, {.linear_solver = LinearSolver::General}, 0.4),
                 paths = solve(system, {.linear_solver = LinearSolver::Paths}, 0.4);

    ASSERT_TRUE(paths.report.outcome.ok()) << paths.report.outcome.what;
    EXPECT_LE(relative_difference(paths.w, general.w), 1e-12);
    EXPECT_LE(relative_difference(paths.lambda, general.lambda), 1e-12);
    EXPECT_LE(relative_difference(paths.eta, general.eta), 1e-12);
  }
}

TEST(LinearSolvers, PathsSideBySideAgreeWithTheGeneralSolver) {
  std::mt19937 random(9);
  System system;
  Rods rods;
  for (int p = 0; p < 200; ++p) {
    const System one = make_random_chain(2 + static_cast<std::size_t>(p) % 37, Ends::Free, 1e2, &random);
    const auto first = static_cast<Index>(system.masses.size());
    system.positions.insert(system.positions.end(), one.positions.begin(), one.positions.end());
    system.velocities.insert(system.velocities.end(), one.velocities.begin(), one.velocities.end());
    system.masses.insert(system.masses.end(), one.masses.begin(), one.masses.end());
    for (const auto& [i, j] : std::get<Rods>(one.constraints[0]).pairs) rods.pairs.push_back({first + i, first + j});
  }
  system.constraints = {rods};

  const Answer general = solve(system, {.linear_solver = LinearSolver::General}),
               paths = solve(system, {.linear_solver = LinearSolver::Paths});

  EXPECT_LE(relative_difference(paths.w, general.w), 1e-12);
  EXPECT_LE(relative_difference(paths.lambda, general.lambda), 1e-12);
}

TEST(LinearSolvers, FreePointsBesidePathsFall) {
  std::mt19937 random(12);
  System system = make_random_chain(7, Ends::Free, 1e1, &random);
  for (int k = 0; k < 3; ++k) {
    system.positions.insert(system.positions.begin(), {5.0, 1.0 * k, 0.0});
    system.velocities.insert(system.velocities.begin(), {1.0, 0.0, 0.0});
    system.masses.insert(system.masses.begin(), 2.0);
  }
  for (auto& [i, j] : std::get<Rods>(system.constraints[0]).pairs) {
    i += 3;
    j += 3;
  }

  const Answer general = solve(system, {.linear_solver = LinearSolver::General}),
               paths = solve(system, {.linear_solver = LinearSolver::Paths});

  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(paths.w[3 * i + 2], -9.81);
  EXPECT_LE(relative_difference(paths.w, general.w), 1e-12);
}

TEST(LinearSolvers, ThreadsChangeNoBit) {
  std::mt19937 random(10);
  for (const Ends ends : {Ends::Free, Ends::Both})
    expect_the_same_bits_with_threads(make_random_chain(20011, ends, 1e1, &random), LinearSolver::Paths);
}

/// Makes two supports with a path between them whose middle is `bend` out of the straight line.
System make_taut_path(double bend) {
  System system;
  Rods rods;
  for (Index i = 0; i < 6; ++i) {
    system.positions.insert(system.positions.end(), {0.3 * i, 0.0, i == 2 ? bend : 0.0});
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  system.masses.assign(6, 0.5);
  system.velocities.assign(18, 0.0);
  system.supports = {{"", {0, 5}, VectorFunction(0.0, 0.0, 0.0)}};
  system.constraints = {rods};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}

TEST(LinearSolvers, TautPathIsLeftToTheGeneralSolver) {
  const System taut = make_taut_path(0.0), bent = make_taut_path(0.1);
  Dynamics dynamics(taut, {.linear_solver = LinearSolver::Paths});
  std::vector<double> w(18), lambda(5);

  const SolveReport report = dynamics.solve({.time = 0.0, .positions = taut.positions, .velocities = taut.velocities},
                                            {.accelerations = w, .multipliers = lambda});
  const RankReport rank = dynamics.rank(state_of(taut));
  const Answer general = solve(taut, {.linear_solver = LinearSolver::General});

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  EXPECT_EQ(rank.rank, 4u);
  EXPECT_EQ(rank.dependences.size(), 1u);
  EXPECT_EQ(w, general.w);
  EXPECT_EQ(lambda, general.lambda);

  // Where the rank is full the solver of paths answers again.
  ASSERT_TRUE(dynamics
                  .solve({.time = 0.0, .positions = bent.positions, .velocities = bent.velocities},
                         {.accelerations = w, .multipliers = lambda})
                  .outcome.ok());
  EXPECT_EQ(dynamics.rank(state_of(bent)).rank, 5u);
  EXPECT_LE(relative_difference(w, solve(bent, {.linear_solver = LinearSolver::General}).w), 1e-12);
}

TEST(LinearSolvers, NearlyTautPathIsAsGoodAsWithTheGeneralSolver) {
  for (const double bend : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    const System system = make_taut_path(bend);

    const Answer general = solve(system, {.linear_solver = LinearSolver::General}),
                 paths = solve(system, {.linear_solver = LinearSolver::Paths});

    ASSERT_TRUE(paths.report.outcome.ok() && general.report.outcome.ok());
    EXPECT_LE(paths.report.residual, 1e-14);
    EXPECT_LE(relative_difference(paths.w, general.w), 1e-14 / (bend * bend));
  }
}

TEST(LinearSolvers, PathsStepAsTheGeneralSolverDoes) {
  std::mt19937 random(11);
  const System system = make_random_chain(40, Ends::First, 1e1, &random);
  for (const Method method : {Method::Rattle, Method::Dop853, Method::Taylor}) {
    MotionOptions motion;
    motion.method = method;
    motion.start = StartMode::Project;
    if (method == Method::Rattle) motion.step = 1e-3;
    motion.rtol = motion.atol = 1e-10;
    Simulation general(system, motion, {.linear_solver = LinearSolver::General}),
        paths(system, motion, {.linear_solver = LinearSolver::Paths});

    ASSERT_TRUE(general.advance_to(0.05).ok() && paths.advance_to(0.05).ok());

    const std::vector<double> r(paths.positions().begin(), paths.positions().end());
    EXPECT_LE(relative_difference(r, {general.positions().begin(), general.positions().end()}), 1e-10);
  }
}

TEST(LinearSolvers, WrongNumbersAreToldAsWithTheGeneralSolver) {
  System system = make_taut_path(0.1);
  system.velocities[7] = std::numeric_limits<double>::infinity();
  for (const LinearSolver solver : {LinearSolver::General, LinearSolver::Paths}) {
    Dynamics dynamics(make_taut_path(0.1), {.linear_solver = solver});
    std::vector<double> w(18);
    EXPECT_EQ(
        dynamics
            .solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w})
            .outcome.status,
        Status::NotFinite);
    // One rod has length 0 and thus no direction.
    std::vector<double> positions = make_taut_path(0.1).positions;
    std::copy_n(positions.begin() + 6, 3, positions.begin() + 9);
    EXPECT_EQ(dynamics.solve({.time = 0.0, .positions = positions}, {.accelerations = w}).outcome.status,
              Status::NotFinite);
  }
}

TEST(LinearSolvers, ASolverThatDoesNotServeIsRefused) {
  System tree = make_taut_path(0.1);
  std::get<Rods>(tree.constraints[0]).pairs[4] = {2, 5};
  const auto message = [](const System& system, SolverOptions options) -> std::string {
    try {
      (void)Dynamics(system, options);
    } catch (const InputError& error) {
      return error.where() + ": " + error.what();
    }
    return "";
  };

  EXPECT_NE(message(tree, {.linear_solver = LinearSolver::Paths}).find("/solver/linear_solver"), std::string::npos);
  EXPECT_EQ(message(tree, {}), "");
  EXPECT_NE(
      message(make_taut_path(0.1), {.linear_solver = LinearSolver::Paths, .ordering = Ordering::Amd}).find("ordering"),
      std::string::npos);
  EXPECT_EQ(Dynamics(make_taut_path(0.1), {.ordering = Ordering::Amd}).plan().linear_solver(), "general");
  EXPECT_EQ(Dynamics(make_taut_path(0.1)).plan().linear_solver(), "general");  // a few rows
  EXPECT_EQ(Dynamics(make_taut_path(0.1), {.linear_solver = LinearSolver::Paths}).plan().linear_solver(), "paths");
}

}  // namespace
}  // namespace tanor
