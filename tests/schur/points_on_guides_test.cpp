/// Points on guides of their own are solved in closed form and compared with the general solver.

#include <gtest/gtest.h>

#include "schur/answers.hpp"

namespace tanor {
namespace {

System points_in_space(int count, AnyNumbers* any) {
  System system;
  for (int k = 0; k < count; ++k) add_point({2.0 + (*any)(), (*any)(), (*any)()}, any, &system);
  system.forces = {Gravity{"", {0.1, 0.0, -9.81}}};
  return system;
}

std::vector<Index> all_points(const System& system) {
  std::vector<Index> points(system.masses.size());
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = static_cast<Index>(i);
  return points;
}

/// Returns the value with "0.3*sin(2*t)" and so on added if it moves, or the constant value.
ScalarFunction number(double value, bool moves) {
  return moves ? ScalarFunction::formula(std::to_string(value) + " + 0.3*sin(2*t) + 0.1*t^2") : ScalarFunction(value);
}
VectorFunction vector(const Vector3& value, bool moves) {
  return {number(value[0], moves), number(value[1], moves), number(value[2], moves)};
}

/// Returns a guide of any kind that passes through these points.
Constraint any_guide(const std::vector<Index>& points, bool moves, int kind, AnyNumbers* any) {
  const Vector3 place{(*any)(), (*any)(), (*any)()};
  const Vector3 direction{1.0 + 0.5 * (*any)(), (*any)(), (*any)()};
  switch (kind) {
    case 0:
      return Planes{"", points, vector(direction, moves), Parameter{}};
    case 1:
      return Spheres{"", points, vector(place, moves), Parameter{}};
    case 2:
      return Lines{"", points, vector(place, moves), vector(direction, moves)};
    default:
      return Circles{"", points, vector(place, moves), vector(direction, moves), Parameter{}};
  }
}

int rows_of(int kind) {
  return kind < 2 ? 1 : 2;
}

void expect_guides_agree(const System& system, double t) {
  const Answer general = solve(system, {.linear_solver = LinearSolver::General}, t),
               points = solve(system, {.linear_solver = LinearSolver::ClosedForm}, t);
  ASSERT_TRUE(general.report.outcome.ok()) << general.report.outcome.what;
  ASSERT_TRUE(points.report.outcome.ok()) << points.report.outcome.what;
  EXPECT_LE(points.report.refinements, general.report.refinements + 1);
  // Guides of one point may be nearly parallel, which costs accuracy.
  const double accuracy = rounding / std::sqrt(general.report.reciprocal_condition);
  EXPECT_LE(relative_difference(points.w, general.w), accuracy);
  EXPECT_LE(relative_difference(points.lambda, general.lambda), accuracy);
  EXPECT_LE(relative_difference(points.eta, general.eta), accuracy);
}

TEST(PointsOnGuides, AgreeWithTheGeneralSolverOnOneGuide) {
  AnyNumbers any(21);
  for (const bool moves : {false, true}) {
    for (int kind = 0; kind < 4; ++kind) {
      for (const int count : {1, 7, 8, 9, 64, 65, 200}) {
        SCOPED_TRACE("kind " + std::to_string(kind) + (moves ? ", moving, " : ", ") + std::to_string(count) +
                     " points");
        System system = points_in_space(count, &any);
        system.constraints = {any_guide(all_points(system), moves, kind, &any)};
        expect_guides_agree(system, moves ? 0.4 : 0.0);
      }
    }
  }
}

TEST(PointsOnGuides, AgreeWithTheGeneralSolverOnAnyGuidesOfUpToThreeRows) {
  AnyNumbers any(22);
  for (int k = 0; k < 40; ++k) {
    SCOPED_TRACE("system " + std::to_string(k));
    System system = points_in_space(60, &any);
    system.forces.emplace_back(Drag{"", {3, 4, 5, 17}, 0.2, 0.1});
    // Guides belong to one point or are shared by some, and those of a point come in any order.
    for (Index point = 0; point < 60;) {
      const Index end = std::min<Index>(60, point + 1 + any.up_to(9));
      std::vector<Index> points;
      for (; point < end; ++point) points.push_back(point);
      for (int rows = system.constraints.empty() ? 1 : any.up_to(3); rows > 0;) {
        const int kind = rows == 1 ? any.up_to(1) : any.up_to(3);
        system.constraints.push_back(any_guide(points, k % 3 == 0 && any.up_to(3) == 0, kind, &any));
        rows -= rows_of(kind);
      }
    }
    expect_guides_agree(system, 0.0);
  }
}

TEST(PointsOnGuides, GiveTheSameBitsForAnyNumberOfThreads) {
  AnyNumbers any(23);
  System system = points_in_space(20'011, &any);
  system.constraints = {any_guide(all_points(system), false, 3, &any)};
  const Answer one = solve(system, {.linear_solver = LinearSolver::ClosedForm, .threads = 1});
  for (const int threads : {2, 3, 8}) {
    const Answer several = solve(system, {.linear_solver = LinearSolver::ClosedForm, .threads = threads});
    EXPECT_EQ(one.w, several.w);
    EXPECT_EQ(one.lambda, several.lambda);
  }
}

TEST(PointsOnGuides, LeaveASingularPointToTheGeneralSolverWhichNamesTheRow) {
  AnyNumbers any(24);
  System system = points_in_space(30, &any);
  std::fill(system.velocities.begin(), system.velocities.end(), 0.0);
  system.constraints = {Planes{"floor", all_points(system), Vector3{0.0, 0.0, 1.0}, Parameter{}},
                        Planes{"again", {17}, Vector3{0.0, 0.0, 2.0}, Parameter{}}};
  Dynamics general(system, {.linear_solver = LinearSolver::General}),
      points(system, {.linear_solver = LinearSolver::ClosedForm});

  const Answer wanted = solve(&general, system), found = solve(&points, system);

  ASSERT_TRUE(found.report.outcome.ok()) << found.report.outcome.what;
  EXPECT_LE(relative_difference(found.w, wanted.w), rounding);
  ASSERT_EQ(points.rank(state_of(system)).dependences.size(), 1u);
  EXPECT_EQ(points.rank(state_of(system)).dependences[0].what, general.rank(state_of(system)).dependences[0].what);
}

TEST(PointsOnGuides, ServeWhereNoConstraintJoinsPoints) {
  AnyNumbers any(25);
  System system = points_in_space(10, &any);
  system.constraints = {any_guide(all_points(system), false, 1, &any)};
  EXPECT_EQ(Dynamics(system).plan().linear_solver(), "closed_form");

  system.constraints.emplace_back(Rods{"rods", {{3, 4}}, {}, {}});
  EXPECT_NE(Dynamics(system).plan().linear_solver(), "closed_form");
  EXPECT_THROW(Dynamics(system, {.linear_solver = LinearSolver::ClosedForm}), InputError);
}

}  // namespace
}  // namespace tanor
