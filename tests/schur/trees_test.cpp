/// Trees of rods are compared with the general solver.

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "schur/answers.hpp"
#include "schur/solver_at_place.hpp"

namespace tanor {
namespace {

struct Growth {
  int num_points = 0, supports = 0;
  int most_back = 1 << 30;  ///< a point joins one of so many before it
  bool with_springs = false, moves_in_time = false;
};

/// Makes a tree that grows at random: rods join new points to points that are already there, some leaves and inner
/// points are held, and points and rods are given in any order and direction.
System make_tree(const Growth& shape, AnyNumbers* any) {
  const auto count = static_cast<std::size_t>(shape.num_points);
  std::vector<Index> place(count);
  std::iota(place.begin(), place.end(), 0);
  std::shuffle(place.begin(), place.end(), any->generator());
  System system;
  std::vector<Vector3> at(count);
  std::vector<std::array<Index, 2>> pairs;
  const auto join = [&](Index i, Index j) {
    i = place[static_cast<std::size_t>(i)];
    j = place[static_cast<std::size_t>(j)];
    pairs.push_back(any->up_to(1) == 0 ? std::array{i, j} : std::array{j, i});
  };
  for (Index k = 0; k < shape.num_points; ++k) {
    (void)add_point({0.0, 0.0, 0.0}, any, &system);
    if (k == 0) continue;
    Index before = std::max(0, k - shape.most_back) + any->up_to(std::min(k, shape.most_back) - 1);
    if (shape.supports == 2 && before == 0 && k + 1 == shape.num_points) before = 1;  // no rod joins supports alone
    for (std::size_t c = 0; c < 3; ++c)
      at[static_cast<std::size_t>(k)][c] = at[static_cast<std::size_t>(before)][c] + (*any)() + (c == 0 ? 0.3 : 0.0);
    join(before, k);
  }
  for (std::size_t k = 0; k < count; ++k)
    std::copy(at[k].begin(), at[k].end(), system.positions.begin() + 3 * place[k]);
  std::shuffle(pairs.begin(), pairs.end(), any->generator());
  Rods rods{"rods", pairs, {}, {}};
  if (shape.moves_in_time) {
    Rods one{"one", {rods.pairs.back()}, {}, {}};
    rods.pairs.pop_back();
    one.length = ScalarFunction::formula("2 + 0.3*sin(t)");
    system.constraints = {rods, one};
  } else {
    system.constraints = {rods};
  }
  for (int k = 0; k < shape.supports; ++k) {
    const Index point = place[static_cast<std::size_t>(k * (shape.num_points - 1) / std::max(1, shape.supports - 1))];
    system.supports.push_back({"", {point}, VectorFunction(0.0, 0.0, 0.0)});
    std::fill_n(system.velocities.begin() + 3 * point, 3, 0.0);
  }
  system.forces = {Gravity{"", {0.1, 0.0, -9.81}}};
  if (shape.with_springs) {
    Springs springs{"", {}, 10.0, 0.5, 0.3};
    for (Index k = 0; k + 3 < shape.num_points; k += 3) springs.pairs.push_back({k, k + 3});
    system.forces.push_back(springs);
  }
  return system;
}

/// Expects agreement with the general solver and returns the number of refinements that the trees took.
int expect_trees_agree(const System& system, double tolerance) {
  const Answer general = solve(system, {.linear_solver = LinearSolver::General}, 0.2),
               trees = solve(system, {.linear_solver = LinearSolver::Trees}, 0.2);
  EXPECT_TRUE(general.report.outcome.ok()) << general.report.outcome.what;
  EXPECT_TRUE(trees.report.outcome.ok()) << trees.report.outcome.what;
  EXPECT_LE(trees.report.residual, rounding);
  EXPECT_LE(relative_difference(trees.w, general.w), tolerance);
  EXPECT_LE(relative_difference(trees.lambda, general.lambda), tolerance);
  EXPECT_LE(relative_difference(trees.eta, general.eta), tolerance);
  return trees.report.refinements;
}

TEST(Trees, AgreeWithTheGeneralSolver) {
  AnyNumbers any(3);
  int refined = 0, solved = 0;
  for (const int num_points : {3, 4, 7, 30, 300, 2000}) {
    for (const int supports : {0, 1, 2}) {
      for (const int most_back : {1, 3, 1 << 30}) {
        SCOPED_TRACE(testing::Message() << num_points << " points, " << supports << " supports, back " << most_back);
        const bool extra = num_points % 2 == 0;
        ++solved;
        refined += expect_trees_agree(make_tree({num_points, supports, most_back, extra, extra}, &any), rounding);
      }
    }
  }
  EXPECT_LT(4 * refined, solved);  // badly conditioned ones alone: else wrong numbers were mended
}

/// Puts copies of a system of rods side by side, each with masses and velocities of its own.
System repeat(const System& one, int copies, AnyNumbers* any) {
  System system = one;
  for (int copy = 1; copy < copies; ++copy) {
    const auto shift = static_cast<Index>(system.masses.size());
    for (std::size_t i = 0; i < one.masses.size(); ++i)
      (void)add_point({one.positions[3 * i] + copy, one.positions[3 * i + 1], one.positions[3 * i + 2]}, any, &system);
    for (const auto& [i, j] : std::get<Rods>(one.constraints[0]).pairs)
      std::get<Rods>(system.constraints[0]).pairs.push_back({shift + i, shift + j});
  }
  return system;
}

TEST(Trees, AgreeSideBySideAndGiveTheSameBitsOnTwoThreads) {
  AnyNumbers any(5);
  const System system = repeat(make_tree({40, 1}, &any), 400, &any);
  (void)expect_trees_agree(system, rounding);
  const Answer a = solve(system, {.linear_solver = LinearSolver::Trees, .threads = 1}),
               b = solve(system, {.linear_solver = LinearSolver::Trees, .threads = 2});
  EXPECT_EQ(a.w, b.w);
  EXPECT_EQ(a.lambda, b.lambda);
}

TEST(Trees, MoveAsWithTheGeneralSolver) {
  AnyNumbers any(6);
  const System system = make_tree({60, 1, 3}, &any);
  MotionOptions motion{.method = Method::Dop853, .rtol = 1e-10, .atol = 1e-12, .start = StartMode::Project};
  Simulation trees(system, motion, {.linear_solver = LinearSolver::Trees}),
      general(system, motion, {.linear_solver = LinearSolver::General, .reuse = false});
  for (Simulation* each : {&trees, &general}) ASSERT_TRUE(each->advance_to(0.1).ok());
  const auto as_vector = [](std::span<const double> x) { return std::vector(x.begin(), x.end()); };
  EXPECT_LE(relative_difference(as_vector(trees.positions()), as_vector(general.positions())), 1e-9);
  EXPECT_LE(trees.report().violation.position, 1e-12);
}

// ---- equal branches ----

/// Makes a backbone of rods on whose points equal trees hang, which a list of parents describes. With extras some of
/// their rods have shifts of images and a length that changes with time.
System make_comb(int teeth, const std::vector<int>& parents, bool with_extras, AnyNumbers* any) {
  std::vector<std::array<Index, 2>> pairs;
  Index count = 0;
  std::vector<Index> backbone;
  for (int tooth = 0; tooth < teeth; ++tooth) {
    backbone.push_back(count++);
    if (tooth > 0) pairs.push_back({backbone[backbone.size() - 2], backbone.back()});
    const Index first = count;
    for (const int parent : parents) {
      pairs.push_back({parent < 0 ? backbone.back() : first + parent, count});
      ++count;
    }
  }
  std::vector<Index> place(static_cast<std::size_t>(count));
  std::iota(place.begin(), place.end(), 0);
  std::shuffle(place.begin(), place.end(), any->generator());
  for (auto& [i, j] : pairs) {
    i = place[static_cast<std::size_t>(i)];
    j = place[static_cast<std::size_t>(j)];
    if (any->up_to(1) == 0) std::swap(i, j);
  }
  std::shuffle(pairs.begin(), pairs.end(), any->generator());
  System system;
  for (Index k = 0; k < count; ++k) (void)add_point({5.0 * (*any)(), 5.0 * (*any)(), 5.0 * (*any)()}, any, &system);
  Rods rods{"rods", pairs, {}, {}};
  if (with_extras) {
    Rods one{"one", {rods.pairs.back()}, {}, {}};
    rods.pairs.pop_back();
    // The rod has its initial length at t = 0.3.
    const auto& [i, j] = one.pairs[0];
    const double length = norm(load(system.positions.data(), j) - load(system.positions.data(), i));
    one.length = ScalarFunction::formula(std::to_string(length) + " + 0.3*sin(t - 0.3)");
    for (std::size_t k = 0; k < rods.pairs.size(); ++k)
      rods.offsets.push_back(k % 5 == 0 ? Vector3{1.0, -2.0, 0.5} : Vector3{});
    system.constraints = {rods, one};
    Springs springs{"", {}, 10.0, 0.5, 0.3};
    for (Index k = 0; k + 3 < count; k += 3) springs.pairs.push_back({k, k + 3});
    system.forces = {springs};
  } else {
    system.constraints = {rods};
    system.forces = {Gravity{"", {0.1, 0.0, -9.81}}};
  }
  return system;
}

/// Returns the parents of a tree of which each point has two branches, `depth` rods long.
std::vector<int> binary_tree(int depth) {
  std::vector<int> parents{-1};
  for (int k = 1; k < (1 << depth) - 1; ++k) parents.push_back((k - 1) / 2);
  return parents;
}

TEST(Trees, AgreeWithTheGeneralSolverOnEqualBranches) {
  AnyNumbers any(8);
  int refined = 0, solved = 0;
  const std::vector<int> tail{-1, 0, 1}, fork{-1, 0, 0, 2}, lopsided{-1, 0, 1, 0, 3, 3, 5, 5, 5};
  for (const std::vector<int>& parents : {tail, fork, lopsided, binary_tree(3), binary_tree(6), binary_tree(8)}) {
    for (const int teeth : {1, 8, 13, 40}) {
      for (const bool with_extras : {false, true}) {
        SCOPED_TRACE(testing::Message() << parents.size() << " rods a tooth, " << teeth << " teeth");
        if (teeth * parents.size() < 8) continue;
        ++solved;
        refined += expect_trees_agree(make_comb(teeth, parents, with_extras, &any), rounding);
      }
    }
  }
  EXPECT_LT(4 * refined, solved);  // badly conditioned ones alone: else wrong numbers were mended
}

/// Returns the system with these points held by supports, one each.
System with_held(System system, const std::vector<Index>& points) {
  for (const Index point : points) {
    system.supports.push_back({"", {point}, VectorFunction(0.0, 0.0, 0.0)});
    std::fill_n(system.velocities.begin() + 3 * point, 3, 0.0);
  }
  return system;
}

TEST(Trees, AgreeWithTheGeneralSolverOnBranchesHeldBySupports) {
  AnyNumbers any(9);
  (void)expect_trees_agree(with_held(make_comb(30, binary_tree(4), false, &any), {3, 100, 200}), rounding);
}

TEST(Trees, ThreadsGiveTheSameBitsInLanes) {
  AnyNumbers any(10);
  expect_the_same_bits_with_threads(make_comb(300, binary_tree(6), true, &any), LinearSolver::Trees);
}

/// Twelve teeth fill a batch and a half, so that trees share batches with others. Threads take whole groves of them.
TEST(Trees, ManyTreesAgreeAndGiveTheSameBitsOnAnyThreads) {
  AnyNumbers any(16);
  const System system = repeat(make_comb(12, binary_tree(3), false, &any), 600, &any);
  (void)expect_trees_agree(system, rounding);
  expect_the_same_bits_with_threads(system, LinearSolver::Trees);

  const MotionOptions motion{.method = Method::Rattle, .step = 1e-3, .start = StartMode::Project};
  const auto as_vector = [](std::span<const double> x) { return std::vector(x.begin(), x.end()); };
  Simulation general(system, motion, {.linear_solver = LinearSolver::General, .reuse = false});
  ASSERT_TRUE(general.advance_to(0.003).ok());
  std::vector<double> on_one_thread;
  for (const int threads : {1, 2, 7}) {
    Simulation trees(system, motion, {.linear_solver = LinearSolver::Trees, .threads = threads});
    ASSERT_TRUE(trees.advance_to(0.003).ok());
    EXPECT_LE(relative_difference(as_vector(trees.velocities()), as_vector(general.velocities())), 1e-10);
    EXPECT_LE(trees.report().violation.position, 1e-12);
    if (on_one_thread.empty()) on_one_thread = as_vector(trees.velocities());
    EXPECT_EQ(as_vector(trees.velocities()), on_one_thread) << threads;
  }
}

/// The backbone with many teeth is more than a thread's share, and the small trees beside it are not.
TEST(Trees, ALargeTreeBesideSmallOnesGivesTheSameBitsOnAnyThreads) {
  AnyNumbers any(17);
  System system = repeat(make_comb(12, binary_tree(3), false, &any), 60, &any);
  const System large = make_comb(120, binary_tree(6), false, &any);
  const auto shift = static_cast<Index>(system.masses.size());
  for (std::size_t i = 0; i < large.masses.size(); ++i)
    (void)add_point({large.positions[3 * i], large.positions[3 * i + 1], large.positions[3 * i + 2]}, &any, &system);
  for (const auto& [i, j] : std::get<Rods>(large.constraints[0]).pairs)
    std::get<Rods>(system.constraints[0]).pairs.push_back({shift + i, shift + j});
  (void)expect_trees_agree(system, rounding);
  expect_the_same_bits_with_threads(system, LinearSolver::Trees);
}

TEST(Trees, MoveAsWithTheGeneralSolverOnEqualBranches) {
  AnyNumbers any(11);
  const System system = make_comb(9, binary_tree(3), false, &any);
  MotionOptions motion{.method = Method::Dop853, .rtol = 1e-10, .atol = 1e-12, .start = StartMode::Project};
  Simulation trees(system, motion, {.linear_solver = LinearSolver::Trees}),
      general(system, motion, {.linear_solver = LinearSolver::General, .reuse = false});
  for (Simulation* each : {&trees, &general}) ASSERT_TRUE(each->advance_to(0.1).ok());
  const auto as_vector = [](std::span<const double> x) { return std::vector(x.begin(), x.end()); };
  EXPECT_LE(relative_difference(as_vector(trees.positions()), as_vector(general.positions())), 1e-9);
  EXPECT_LE(trees.report().violation.position, 1e-12);
}

/// Steps of RATTLE project positions and velocities of branches in lanes and of what they hang on.
TEST(Trees, ProjectionsOfRattleAreThoseOfTheGeneralSolver) {
  AnyNumbers any(12);
  for (const bool is_held : {false, true}) {
    System system = make_comb(20, binary_tree(4), false, &any);
    if (is_held) system = with_held(std::move(system), {3});
    const MotionOptions motion{.method = Method::Rattle, .step = 1e-3, .start = StartMode::Project};
    Simulation trees(system, motion, {.linear_solver = LinearSolver::Trees}),
        general(system, motion, {.linear_solver = LinearSolver::General, .reuse = false}),
        on_threads(system, motion, {.linear_solver = LinearSolver::Trees, .threads = 3});
    for (Simulation* each : {&trees, &general, &on_threads}) ASSERT_TRUE(each->advance_to(0.02).ok());
    const auto as_vector = [](std::span<const double> x) { return std::vector(x.begin(), x.end()); };
    EXPECT_LE(relative_difference(as_vector(trees.positions()), as_vector(general.positions())), 1e-11);
    EXPECT_LE(relative_difference(as_vector(trees.velocities()), as_vector(general.velocities())), 1e-10);
    EXPECT_EQ(as_vector(trees.velocities()), as_vector(on_threads.velocities()));
    EXPECT_LE(trees.report().violation.position, 1e-12);
    EXPECT_LE(trees.report().violation.velocity, 1e-12);
  }
}

/// There are branches in lanes and trunks, trunks alone, and trees in which supports hold leaves, roots of branches and
/// points inside of them.
TEST(Trees, AreProjectedAlongTheirGradients) {
  AnyNumbers any(14);
  const System held = with_held(make_comb(20, binary_tree(4), false, &any), {3, 100, 200});
  const std::vector<int> lopsided{-1, 0, 1, 0, 3, 3, 5, 5, 5};
  for (const System& system : {make_comb(13, lopsided, false, &any), make_comb(40, binary_tree(5), false, &any), held,
                               make_tree({60, 1, 3}, &any), make_tree({300, 2, 1 << 30}, &any)})
    expect_projections_along_gradients(system, LinearSolver::Trees);
}

/// The shifts of images are a part of the violation, and lengths that move are read at each projection.
TEST(Trees, AreProjectedAlongTheirGradientsWithShiftsAndMovingLengths) {
  AnyNumbers any(15);
  System system = make_comb(13, binary_tree(4), true, &any);
  system.forces = {};
  expect_projections_along_gradients(system, LinearSolver::Trees);
  system.constraints.pop_back();  // the rod whose length moves
  expect_projections_along_gradients(system, LinearSolver::Trees);
}

/// A backbone with one rod at each point has only one piece at a time.
TEST(Trees, AreTakenUnlessMostLanesStayEmpty) {
  AnyNumbers any(12);
  const PlanSummary comb = Dynamics(make_comb(16, binary_tree(6), false, &any)).plan();
  EXPECT_EQ(comb.linear_solver(), "trees");
  EXPECT_NE(comb.linear_solver_reason.find("% of the lanes"), std::string::npos) << comb.linear_solver_reason;
  EXPECT_EQ(Dynamics(make_tree({500, 0}, &any)).plan().linear_solver(), "trees");
  EXPECT_EQ(Dynamics(make_comb(400, {-1}, false, &any)).plan().linear_solver(), "general");
}

TEST(Trees, RingsAreLeftToTheGeneralSolver) {
  AnyNumbers any(7);
  System system = make_tree({200, 1}, &any);
  std::get<Rods>(system.constraints[0]).pairs.push_back({3, 150});
  EXPECT_THROW((void)Dynamics(system, {.linear_solver = LinearSolver::Trees}), InputError);
  EXPECT_TRUE(Dynamics(system).plan().linear_solver().ends_with("general"));
}

}  // namespace
}  // namespace tanor
