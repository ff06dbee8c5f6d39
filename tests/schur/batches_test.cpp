/// Islands of equal topology lie side by side in lanes and are compared with the general solver.

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "schur/answers.hpp"

namespace tanor {
namespace {

using Pairs = std::vector<std::array<Index, 2>>;

/// Points 0 … num_points - 1 that rods join to one island, supports among them.
struct Shape {
  Index num_points;
  Pairs rods;
  std::vector<Index> supports;
};

/// Returns a tree with up to `extra` more rods, which are fewer than a rigid body would need, so that none depends on
/// others.
Shape any_shape(AnyNumbers* any, int most_points = 9) {
  Shape shape{static_cast<Index>(2 + any->up_to(most_points - 2)), {}, {}};
  std::set<std::array<Index, 2>> rods;
  for (Index k = 1; k < shape.num_points; ++k) rods.insert({any->up_to(k - 1), k});
  const int extra = any->up_to(std::max(0, 2 * (shape.num_points - 3)));
  for (int k = 0; k < extra; ++k) {
    const Index i = any->up_to(shape.num_points - 1), j = any->up_to(shape.num_points - 1);
    if (i != j) rods.insert({std::min(i, j), std::max(i, j)});
  }
  shape.rods.assign(rods.begin(), rods.end());
  // One point may be held; then every rod still has a point that moves.
  if (any->up_to(1) == 0) shape.supports = {any->up_to(shape.num_points - 1)};
  return shape;
}

/// Adds an island of this shape with positions, masses and velocities of its own.
void add_island(const Shape& shape, AnyNumbers* any, System* system, Pairs* rods) {
  const auto first = static_cast<Index>(system->masses.size());
  for (Index k = 0; k < shape.num_points; ++k) add_point({(*any)(), (*any)(), (*any)()}, any, system);
  for (const auto& [i, j] : shape.rods) rods->push_back({first + i, first + j});
  for (const Index support : shape.supports) {
    const Index point = first + support;
    system->supports.push_back({"", {point}, VectorFunction(0.0, 0.0, 0.0)});
    std::fill_n(system->velocities.begin() + 3 * point, 3, 0.0);
  }
}

/// Returns the same system with its points and rods in random order and direction.
System shuffled(const System& given, Pairs rods, AnyNumbers* any) {
  System system = given;
  std::vector<Index> place(given.masses.size());
  std::iota(place.begin(), place.end(), 0);
  std::shuffle(place.begin(), place.end(), any->generator());
  for (std::size_t i = 0; i < place.size(); ++i) {
    const auto to = static_cast<std::size_t>(place[i]);
    system.masses[to] = given.masses[i];
    for (std::size_t c = 0; c < 3; ++c) {
      system.positions[3 * to + c] = given.positions[3 * i + c];
      system.velocities[3 * to + c] = given.velocities[3 * i + c];
    }
  }
  for (Support& support : system.supports) support.points[0] = place[static_cast<std::size_t>(support.points[0])];
  for (auto& [i, j] : rods) {
    i = place[static_cast<std::size_t>(i)];
    j = place[static_cast<std::size_t>(j)];
    if (any->up_to(1) == 0) std::swap(i, j);
  }
  std::shuffle(rods.begin(), rods.end(), any->generator());
  system.constraints = {Rods{"rods", rods, {}, {}}};
  return system;
}

/// Returns `counts` islands of each of as many shapes.
System any_bundles(const std::vector<int>& counts, AnyNumbers* any) {
  System system;
  Pairs rods;
  for (const int count : counts) {
    const Shape shape = any_shape(any);
    for (int k = 0; k < count; ++k) add_island(shape, any, &system, &rods);
  }
  system.forces = {Gravity{"", {0.1, 0.0, -9.81}}};
  return shuffled(system, rods, any);
}

System copies_of(const Shape& shape, int count, AnyNumbers* any) {
  System system;
  Pairs rods;
  for (int k = 0; k < count; ++k) add_island(shape, any, &system, &rods);
  system.constraints = {Rods{"rods", rods, {}, {}}};
  return system;
}

const Shape triangle{3, {{0, 1}, {1, 2}, {2, 0}}, {}};
const Shape tetrahedron{4, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}, {}};

Shape path_shape(Index num_rods) {
  Shape shape{num_rods + 1, {}, {}};
  for (Index k = 0; k < num_rods; ++k) shape.rods.push_back({k, k + 1});
  return shape;
}
Shape ring(Index num_rods) {
  Shape shape = path_shape(num_rods - 1);
  shape.rods.push_back({num_rods - 1, 0});
  return shape;
}

void expect_agreement(const System& system, const SolverOptions& options = {.linear_solver = LinearSolver::Batches},
                      double t = 0.0) {
  const Answer general = solve(system, {.linear_solver = LinearSolver::General}, t),
               bundles = solve(system, options, t);
  ASSERT_TRUE(general.report.outcome.ok()) << general.report.outcome.what;
  ASSERT_TRUE(bundles.report.outcome.ok()) << bundles.report.outcome.what;
  EXPECT_LE(bundles.report.refinements, general.report.refinements + 1);
  EXPECT_LE(relative_difference(bundles.w, general.w), rounding);
  EXPECT_LE(relative_difference(bundles.lambda, general.lambda), rounding);
  EXPECT_LE(relative_difference(bundles.eta, general.eta), rounding);
}

TEST(Batches, AgreeWithTheGeneralSolverOnAnyTopologies) {
  AnyNumbers any(11);
  for (int k = 0; k < 60; ++k) {
    // Some lanes are left over, alone and beside full ones.
    std::vector<int> counts;
    for (int shape = any.up_to(3); shape >= 0; --shape) counts.push_back(1 + any.up_to(20));
    SCOPED_TRACE("system " + std::to_string(k));
    expect_agreement(any_bundles(counts, &any));
  }
}

TEST(Batches, AgreeWithTheGeneralSolverOnClustersRingsTrianglesAndTetrahedra) {
  AnyNumbers any(12);
  for (const Shape& shape : {path_shape(1), path_shape(10), path_shape(99), ring(6), ring(12), triangle, tetrahedron}) {
    for (const int count : {1, 7, 8, 9, 24}) {
      SCOPED_TRACE(std::to_string(count) + " islands of " + std::to_string(shape.rods.size()) + " rods");
      expect_agreement(copies_of(shape, count, &any));
    }
  }
}

/// Makes rings of five with one support each; some rods have offsets, others have lengths that change with time.
System breathing_rings(AnyNumbers* any) {
  System system;
  Pairs rods;
  Shape shape = ring(5);
  shape.supports = {2};
  for (int k = 0; k < 13; ++k) add_island(shape, any, &system, &rods);
  system = shuffled(system, rods, any);
  auto& first = std::get<Rods>(system.constraints[0]);
  Rods second{"breathing", {first.pairs.begin() + 30, first.pairs.end()}, {}, {}};
  first.pairs.resize(30);
  for (std::size_t k = 0; k < 30; ++k) first.offsets.push_back({0.1 * (*any)(), 0.1 * (*any)(), 0.1 * (*any)()});
  for (const auto& [i, j] : second.pairs) {
    double square = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double d =
          system.positions[3 * static_cast<std::size_t>(j) + c] - system.positions[3 * static_cast<std::size_t>(i) + c];
      square += d * d;
    }
    second.length.functions.push_back(ScalarFunction::formula(std::to_string(std::sqrt(square)) + " + 0.1*sin(2*t)"));
  }
  system.constraints.emplace_back(second);
  for (Support& support : system.supports)
    support.displacement = {ScalarFunction::formula("0.2*t^2"), 0.0, ScalarFunction::formula("0.1*sin(t)")};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}, Drag{"", {0, 1, 2, 3}, 0.3, 0.1}};
  return system;
}

TEST(Batches, KnowLengthsThatMoveOffsetsSupportsThatMoveAndForces) {
  AnyNumbers any(13);
  expect_agreement(breathing_rings(&any), {.linear_solver = LinearSolver::Batches}, 0.3);
}

/// Expects the motion with the solver that the plan chooses to be that with the general one.
void expect_the_same_motion(const System& system, const std::string& solver) {
  for (const Method method : {Method::Rattle, Method::Dop853}) {
    std::vector<double> positions[2], velocities[2];
    for (const std::size_t k : {0, 1}) {
      const MotionOptions options{.method = method, .step = 1e-3, .start = StartMode::Project};
      Simulation simulation(system, options, {.linear_solver = k == 0 ? LinearSolver::General : LinearSolver::Auto});
      EXPECT_EQ(simulation.plan().linear_solver(), k == 0 ? "general" : solver);
      const Outcome outcome = simulation.advance_to(0.05);
      ASSERT_TRUE(outcome.ok()) << outcome.what;
      EXPECT_LE(simulation.report().violation.position, 1e-12);
      EXPECT_LE(simulation.report().violation.velocity, 1e-12);
      positions[k].assign(simulation.positions().begin(), simulation.positions().end());
      velocities[k].assign(simulation.velocities().begin(), simulation.velocities().end());
    }
    EXPECT_LE(relative_difference(positions[1], positions[0]), 1e-10);
    EXPECT_LE(relative_difference(velocities[1], velocities[0]), 1e-10);
  }
}

TEST(Batches, MoveAsWithTheGeneralSolver) {
  AnyNumbers any(17);
  expect_the_same_motion(copies_of(path_shape(10), 20, &any), "batches");
  expect_the_same_motion(breathing_rings(&any), "batches");
}

TEST(Batches, GiveTheSameBitsForAnyNumberOfThreads) {
  AnyNumbers any(14);
  System system = copies_of(path_shape(10), 3003, &any);
  const Answer one = solve(system, {.linear_solver = LinearSolver::Batches, .threads = 1});
  for (const int threads : {2, 3, 8}) {
    const Answer several = solve(system, {.linear_solver = LinearSolver::Batches, .threads = threads});
    EXPECT_EQ(one.w, several.w);
    EXPECT_EQ(one.lambda, several.lambda);
  }
}

TEST(Batches, LeaveSingularIslandsToTheGeneralSolverWhichNamesTheRow) {
  AnyNumbers any(15);
  System flat = copies_of(triangle, 20, &any);
  for (std::size_t c = 0; c < 3; ++c) {  // its corner 2 on the line through the others
    double* const x = flat.positions.data() + 3 * 3 * 11 + c;
    x[6] = 0.3 * x[0] + 0.7 * x[3];
  }
  std::fill(flat.velocities.begin(), flat.velocities.end(), 0.0);
  Shape twice = path_shape(4);
  twice.rods.push_back({2, 1});
  const System doubled = copies_of(twice, 20, &any);

  for (const System& system : {flat, doubled}) {
    Dynamics general(system, {.linear_solver = LinearSolver::General}),
        bundles(system, {.linear_solver = LinearSolver::Batches});
    const Answer wanted = solve(&general, system), found = solve(&bundles, system);
    ASSERT_TRUE(found.report.outcome.ok()) << found.report.outcome.what;
    EXPECT_LE(relative_difference(found.w, wanted.w), rounding);
    EXPECT_LE(relative_difference(found.eta, wanted.eta), rounding);
    const RankReport report = bundles.rank(state_of(system)), reference = general.rank(state_of(system));
    EXPECT_LT(report.rank, bundles.num_equations());
    EXPECT_EQ(report.rank, reference.rank);
    ASSERT_EQ(report.dependences.size(), reference.dependences.size());
    for (std::size_t k = 0; k < report.dependences.size(); ++k)
      EXPECT_EQ(report.dependences[k].what, reference.dependences[k].what);
  }
}

/// Makes beads on planes and wires, clusters, triangles, and two paths of different lengths.
System islands_of_every_kind(AnyNumbers* any) {
  System system;
  Pairs rods;
  for (int k = 0; k < 9; ++k) {
    for (const Shape& shape : {path_shape(3), triangle, path_shape(10)}) add_island(shape, any, &system, &rods);
  }
  for (const Index num_rods : {150, 37}) add_island(path_shape(num_rods), any, &system, &rods);
  system = shuffled(system, rods, any);
  add_beads(11, any, &system);
  system.forces = {Gravity{"", {0.1, 0.0, -9.81}}};
  return system;
}

TEST(MixedSolvers, GiveEachIslandItsOwnSolver) {
  AnyNumbers any(18);
  const System system = islands_of_every_kind(&any);
  EXPECT_EQ(Dynamics(system).plan().linear_solver(), "closed_form+batches+paths");
  expect_agreement(system, {});
  expect_the_same_motion(system, "closed_form+batches+paths");
}

TEST(Batches, ServeWhereManyIslandsAreAlikeUnlessForced) {
  AnyNumbers any(16);
  const System rings = copies_of(ring(6), 100, &any), few = copies_of(ring(6), 2, &any);
  System mixed = rings;
  mixed.constraints.emplace_back(Planes{"", {0}, Vector3{0.0, 0.0, 1.0}, mixed.positions[2]});

  EXPECT_EQ(Dynamics(rings).plan().linear_solver(), "batches");
  EXPECT_EQ(Dynamics(few).plan().linear_solver(), "paths");
  EXPECT_EQ(Dynamics(few, {.linear_solver = LinearSolver::Batches}).plan().linear_solver(), "batches");
  EXPECT_EQ(Dynamics(copies_of(path_shape(99), 16, &any)).plan().linear_solver(), "batches");
  EXPECT_EQ(Dynamics(copies_of(path_shape(99), 12, &any)).plan().linear_solver(),
            "paths");  // a quarter of the lanes would lie idle
  EXPECT_EQ(Dynamics(copies_of(ring(99), 12, &any)).plan().linear_solver(), "batches");
  EXPECT_EQ(Dynamics(mixed).plan().linear_solver(), "batches+general");
  EXPECT_THROW(Dynamics(mixed, {.linear_solver = LinearSolver::Batches}), InputError);
}

}  // namespace
}  // namespace tanor
