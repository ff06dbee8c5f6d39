/// Trees of rods, and trees that close a few rings, against the general solver.

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "schur/answers.hpp"

namespace tanor {
namespace {

constexpr double rounding = 1e-12;

struct Shape {
  int num_points = 0, rings = 0, supports = 0;
  int most_back = 1 << 30;  ///< a point joins one of so many before it
  bool with_springs = false, moves_in_time = false;
};

/// A tree that grows at random, rods between points that are already there, some leaves and inner points held; points
/// and rods given in any order and direction.
System make_tree(const Shape& shape, AnyNumbers* any) {
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
  for (int ring = 0; ring < shape.rings; ++ring)
    join(any->up_to(shape.num_points / 2 - 1), shape.num_points / 2 + any->up_to(shape.num_points / 2 - 1));
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

/// Returns the refinements that it took.
int expect_agreement(const System& system, double tolerance) {
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
        refined += expect_agreement(make_tree({num_points, 0, supports, most_back, extra, extra}, &any), rounding);
      }
    }
  }
  EXPECT_LT(4 * refined, solved);  // badly conditioned ones alone: else wrong numbers were mended
}

TEST(Trees, OfAFewRingsAgreeToo) {
  AnyNumbers any(4);
  int refined = 0, solved = 0;
  for (const int num_points : {8, 50, 500}) {
    for (const int rings : {1, 2, 4}) {
      for (const int supports : {0, 1, 2}) {
        SCOPED_TRACE(testing::Message() << num_points << " points, " << rings << " rings, " << supports << " supports");
        ++solved;
        refined += expect_agreement(
            make_tree({num_points, rings, supports, 2, num_points == 50, num_points == 50}, &any), rounding);
      }
    }
  }
  EXPECT_LT(4 * refined, solved);  // badly conditioned ones alone: else wrong numbers were mended
}

TEST(Trees, ManyOfThemAgreeAndThreadsGiveTheSameBits) {
  AnyNumbers any(5);
  System system = make_tree({40, 2, 1}, &any);
  // Copies side by side, each with masses and velocities of its own.
  const System one = system;
  for (int copy = 1; copy < 400; ++copy) {
    const auto shift = static_cast<Index>(system.masses.size());
    for (std::size_t i = 0; i < one.masses.size(); ++i)
      (void)add_point({one.positions[3 * i] + copy, one.positions[3 * i + 1], one.positions[3 * i + 2]}, &any, &system);
    for (const auto& [i, j] : std::get<Rods>(one.constraints[0]).pairs)
      std::get<Rods>(system.constraints[0]).pairs.push_back({shift + i, shift + j});
  }
  (void)expect_agreement(system, rounding);
  const Answer a = solve(system, {.linear_solver = LinearSolver::Trees, .threads = 1}),
               b = solve(system, {.linear_solver = LinearSolver::Trees, .threads = 2});
  EXPECT_EQ(a.w, b.w);
  EXPECT_EQ(a.lambda, b.lambda);
}

TEST(Trees, MotionIsThatOfTheGeneralSolver) {
  AnyNumbers any(6);
  const System system = make_tree({60, 2, 1, 3}, &any);
  MotionOptions motion{.method = Method::Dop853, .rtol = 1e-10, .atol = 1e-12, .start = StartMode::Project};
  Simulation trees(system, motion, {.linear_solver = LinearSolver::Trees}),
      general(system, motion, {.linear_solver = LinearSolver::General, .reuse = false});
  for (Simulation* each : {&trees, &general}) ASSERT_TRUE(each->advance_to(0.1).ok());
  const auto as_vector = [](std::span<const double> x) { return std::vector(x.begin(), x.end()); };
  EXPECT_LE(relative_difference(as_vector(trees.positions()), as_vector(general.positions())), 1e-9);
  EXPECT_LE(trees.report().position_violation, 1e-12);
}

/// A flat ring of four rods, stretched to a line: its rods depend on one another, which the general solver decides.
TEST(Trees, SingularRingsAreLeftToTheGeneralSolver) {
  const System system = make_stretched_ring();
  const Answer trees = solve(system, {.linear_solver = LinearSolver::Trees}),
               general = solve(system, {.linear_solver = LinearSolver::General});
  EXPECT_EQ(trees.report.outcome.status, general.report.outcome.status);
  EXPECT_LE(relative_difference(trees.w, general.w), rounding);
}

TEST(Trees, MoreRingsAreForTheGeneralSolver) {
  AnyNumbers any(7);
  const System system = make_tree({200, 9, 1}, &any);
  EXPECT_THROW((void)Dynamics(system, {.linear_solver = LinearSolver::Trees}), InputError);
  EXPECT_EQ(Dynamics(system).plan().linear_solver(), "general");
  EXPECT_EQ(Dynamics(make_tree({200, 3, 1}, &any)).plan().linear_solver(), "trees");
}

}  // namespace
}  // namespace tanor
