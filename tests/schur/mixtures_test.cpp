/// Islands that no special solver serves have sparse factors of their own beside the islands of special solvers. The
/// answers are compared with those of the general solver for all.

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include <tanor/user_kernel.hpp>

#include "beside.hpp"
#include "random_systems.hpp"
#include "schur/answers.hpp"

namespace tanor {
namespace {

using Pairs = std::vector<std::array<Index, 2>>;

/// Makes copies of `num_points` points with these rods, each at positions of its own.
System copies_of(int count, Index num_points, const Pairs& rods, AnyNumbers* any) {
  System system;
  Rods group;
  for (int copy = 0; copy < count; ++copy) {
    const auto first = static_cast<Index>(system.masses.size());
    for (Index k = 0; k < num_points; ++k) add_point({(*any)(), (*any)(), (*any)()}, any, &system);
    for (const auto& [i, j] : rods) group.pairs.push_back({first + i, first + j});
  }
  system.constraints = {group};
  return system;
}

Pairs path_rods(Index num_rods) {
  Pairs rods;
  for (Index k = 0; k < num_rods; ++k) rods.push_back({k, k + 1});
  return rods;
}

System clusters(int count, AnyNumbers* any) {
  return copies_of(count, 11, path_rods(10), any);
}

/// Makes a net: it stays a net where the points of a plane grid move by up to a third of a rod.
System net(Index columns, Index rows, AnyNumbers* any) {
  System system;
  Rods rods;
  for (Index y = 0; y < rows; ++y) {
    for (Index x = 0; x < columns; ++x) {
      const Index i = add_point({x + 0.3 * (*any)(), y + 0.3 * (*any)(), 0.3 * (*any)()}, any, &system);
      if (x > 0) rods.pairs.push_back({i - 1, i});
      if (y > 0) rods.pairs.push_back({i - columns, i});
    }
  }
  system.constraints = {rods};
  return system;
}

/// Makes tetrahedra, each of which shares a corner with the next one.
System tetrahedra_in_a_row(int count, AnyNumbers* any) {
  System system;
  Rods rods;
  Index corner = add_point({0.0, 0.0, 0.0}, any, &system);
  for (int k = 0; k < count; ++k) {
    Index points[4] = {corner};
    for (Index m = 1; m < 4; ++m)
      points[m] = add_point({k + 0.3 * m, m == 2 ? 0.8 : 0.1 * (*any)(), m == 3 ? 0.8 : 0.1 * (*any)()}, any, &system);
    for (Index m = 0; m < 4; ++m) {
      for (Index n = 0; n < m; ++n) rods.pairs.push_back({points[n], points[m]});
    }
    corner = points[1];
  }
  system.constraints = {rods};
  return system;
}

/// Makes a system with angles, pulleys, guides of points that rods join, sums, a user's own constraint, and a length
/// and a
/// support that move.
System of_every_other_kind(AnyNumbers* any) {
  System system = copies_of(3, 7, path_rods(6), any);
  system.constraints.emplace_back(Angles{"angles", {{0, 1, 2}, {3, 4, 5}}, {}});
  system.constraints.emplace_back(Pulleys{"pulley", {{7, 13}}, {0.0, 0.0, 5.0}, {1.0, 0.0, 5.0}, {}, 1.5});
  system.constraints.emplace_back(
      Circles{"hoop", {8}, Vector3{0.1, 0.2, 0.3}, VectorFunction{0.0, ScalarFunction::formula("0.1*t"), 1.0}, {}});
  system.constraints.emplace_back(Linears{"sum", {{9, 11}}, {{1.0, 0.2, 0.3}, {0.3, -1.0, 0.1}}, {}});
  const auto on_saddle = [](const auto& x, const auto& t) {
    return x[2] - (1.0 + 0.1 * sin(t)) * x[0] * x[1] + x[3] * x[4];
  };
  system.constraints.emplace_back(
      UserConstraints{"saddle", {{14, 15}, {16, 17}}, make_constraint_kernel<2>(on_saddle, /*thread_safe=*/false)});
  system.constraints.emplace_back(Rods{"breathing", {{18, 20}}, ScalarFunction::formula("1.1 + 0.2*sin(2*t)"), {}});
  system.supports.push_back({"shaken", {19}, {ScalarFunction::formula("0.1*sin(3*t)"), 0.0, 0.0}});
  return system;
}

/// Makes points on guides of their own.
System beads(int count, AnyNumbers* any) {
  System system;
  add_beads(count, any, &system);
  return system;
}

const Force gravity = Gravity{"", {0.1, 0.0, -9.81}};

/// Returns the rods of a star: arms of so many rods each, from one point.
std::vector<std::array<Index, 2>> star(int arms, int length) {
  std::vector<std::array<Index, 2>> pairs;
  for (Index arm = 0; arm < arms; ++arm) {
    for (Index k = 0; k < length; ++k) pairs.push_back({k == 0 ? 0 : arm * length + k, arm * length + k + 1});
  }
  return pairs;
}

/// Makes islands of all special solvers with the others between them.
System mixture(AnyNumbers* any) {
  System system = beads(7, any);
  put_beside(net(4, 5, any), &system);
  put_beside(clusters(30, any), &system);
  put_beside(of_every_other_kind(any), &system);
  put_beside(copies_of(1, 61, path_rods(60), any), &system);
  put_beside(tetrahedra_in_a_row(4, any), &system);
  put_beside(copies_of(1, 41, star(8, 5), any), &system);
  return system;
}

/// Adds forces that differ from point to point.
void add_forces(System* system) {
  system->forces.push_back(Drag{"", {0, 20, 40, 60, 80}, 0.3, 0.1});
  system->forces.push_back(ConstantForce{"", {22, 25, 30, 200}, {ScalarFunction::formula("sin(t)"), 1.0, 0.0}});
}

bool has_part_of(const std::string& solver, const std::string& part) {
  return ("+" + solver + "+").find("+" + part + "+") != std::string::npos;
}

TEST(Mixtures, SolveShortIslandsByTheirOwnLinearSolvers) {
  AnyNumbers any(21);
  int refinements = 0;
  for (const bool is_uniform : {true, false}) {
    for (int k = 0; k < 10; ++k) {
      System system = mixture(&any);
      if (is_uniform) system.forces = {gravity};
      if (!is_uniform) add_forces(&system);
      SCOPED_TRACE("system " + std::to_string(k) + (is_uniform ? ", gravity alone" : ""));
      Dynamics chosen(system);
      EXPECT_EQ(chosen.plan().linear_solver(), "closed_form+batches+paths+trees+general");

      const Answer general = solve(system, {.linear_solver = LinearSolver::General}, 0.3),
                   mixed = solve(&chosen, system, 0.3);

      ASSERT_TRUE(mixed.report.outcome.ok()) << mixed.report.outcome.what;
      EXPECT_LE(relative_difference(mixed.w, general.w), 1e-12);
      EXPECT_LE(relative_difference(mixed.lambda, general.lambda), 1e-12);
      EXPECT_LE(relative_difference(mixed.eta, general.eta), 1e-12);
      refinements += mixed.report.refinements - general.report.refinements;
    }
  }
  EXPECT_LE(refinements, 4);
}

TEST(Mixtures, AgreeWithTheGeneralSolverOnAnyConstraints) {
  int num_mixtures = 0;
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    AnyNumbers any(seed);
    System system = clusters(20, &any);
    for (std::uint32_t k = 0; k < 3; ++k) {
      RandomSystem random = make_random_system(3 + (5 * seed + 7 * k) % 12, 3 * seed + k);
      random.system.velocities = random.velocities;
      put_beside(random.system, &system);
      put_beside(clusters(3, &any), &system);
    }
    SCOPED_TRACE("seed " + std::to_string(seed));
    Dynamics chosen(system);
    num_mixtures += has_part_of(chosen.plan().linear_solver(), "general") ? 1 : 0;

    const Answer general = solve(system, {.linear_solver = LinearSolver::General}, 0.7),
                 mixed = solve(&chosen, system, 0.7);

    ASSERT_TRUE(mixed.report.outcome.ok()) << mixed.report.outcome.what;
    const double rounding = 1e-15 / std::min(general.report.reciprocal_condition, 1e-3);
    EXPECT_LE(relative_difference(mixed.w, general.w), rounding);
    EXPECT_LE(relative_difference(mixed.eta, general.eta), rounding);
  }
  EXPECT_GE(num_mixtures, 30);
}

TEST(Mixtures, GiveTheSameBitsForAnyNumberOfThreads) {
  AnyNumbers any(22);
  System system = clusters(800, &any);
  put_beside(net(40, 40, &any), &system);
  put_beside(clusters(800, &any), &system);
  put_beside(net(20, 20, &any), &system);
  system.forces = {gravity};
  const Answer one = solve(system, {.threads = 1});

  for (const int threads : {2, 3, 8}) {
    const Answer several = solve(system, {.threads = threads});
    EXPECT_EQ(one.w, several.w);
    EXPECT_EQ(one.lambda, several.lambda);
  }
}

/// A rod is given twice.
TEST(Mixtures, LeaveSingularIslandsToTheGeneralSolverWhichNamesTheRow) {
  AnyNumbers any(23);
  System system = net(5, 5, &any);
  auto& rods = std::get<Rods>(system.constraints[0]);
  rods.pairs.push_back({rods.pairs[7][1], rods.pairs[7][0]});
  put_beside(clusters(30, &any), &system);
  Dynamics general(system, {.linear_solver = LinearSolver::General}), mixed(system);
  EXPECT_EQ(mixed.plan().linear_solver(), "batches+general");

  const Answer wanted = solve(&general, system), found = solve(&mixed, system);

  ASSERT_TRUE(found.report.outcome.ok()) << found.report.outcome.what;
  EXPECT_LE(relative_difference(found.w, wanted.w), 1e-12);
  EXPECT_LE(relative_difference(found.eta, wanted.eta), 1e-12);
  const RankReport report = mixed.rank(state_of(system)), reference = general.rank(state_of(system));
  EXPECT_EQ(report.rank, mixed.num_equations() - 1);
  ASSERT_EQ(report.dependences.size(), 1u);
  ASSERT_EQ(reference.dependences.size(), 1u);
  EXPECT_EQ(report.dependences[0].what, reference.dependences[0].what);
}

TEST(Mixtures, TellWrongNumbersAsTheGeneralSolverDoes) {
  AnyNumbers any(24);
  System system = net(5, 5, &any);
  put_beside(clusters(30, &any), &system);
  for (const std::size_t wrong : {7, 7 + 3 * 25}) {  // in the net, in a cluster
    std::vector<double> velocities = system.velocities, w(system.positions.size());
    velocities[wrong] = std::numeric_limits<double>::infinity();
    Dynamics mixed(system);
    EXPECT_EQ(mixed.solve({.time = 0.0, .positions = system.positions, .velocities = velocities}, {.accelerations = w})
                  .outcome.status,
              Status::NotFinite);
    EXPECT_TRUE(
        mixed.solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w})
            .outcome.ok());
  }
}

/// K of sums is constant, so that their factors are kept while those of rods are not, and the next answer is as good.
TEST(Mixtures, KeepFactorsOfConstantGradients) {
  AnyNumbers any(25);
  System system = clusters(10, &any);
  System sums = copies_of(1, 20, {}, &any);
  sums.constraints = {};
  for (Index k = 0; k + 1 < 20; ++k)
    sums.constraints.emplace_back(Linears{"", {{k, k + 1}}, {{1.0, 0.3, any()}, {0.2, -1.0, 0.4}}, {}});
  put_beside(sums, &system);
  Dynamics mixed(system);
  EXPECT_EQ(mixed.plan().linear_solver(), "batches+general");
  for (int k = 0; k < 3; ++k) {
    const Answer general = solve(system, {.linear_solver = LinearSolver::General}), found = solve(&mixed, system);
    ASSERT_TRUE(found.report.outcome.ok());
    EXPECT_LE(relative_difference(found.w, general.w), 1e-12);
    for (double& x : system.positions) x += 0.1 * any();
    for (double& x : system.velocities) x += any();
  }
}

/// Returns the plan of a net beside `count` clusters.
PlanSummary plan_of_net(Index size, int count) {
  AnyNumbers any(26);
  System system = net(size, size, &any);
  put_beside(clusters(count, &any), &system);
  return Dynamics(system).plan();
}

TEST(Mixtures, AreTakenUnlessTheRestIsMuchMore) {
  const PlanSummary plan = plan_of_net(10, 30);

  EXPECT_EQ(plan.linear_solver(), "batches+general");
  EXPECT_EQ(plan.linear_solver_reason,
            "30 islands of rods have 1 structure; 1 island of 180 rows is left to sparse factors");
  EXPECT_NE(plan.ordering(), "natural");
  EXPECT_EQ(plan_of_net(10, 5).linear_solver(), "general");   // 180 rows beside 50
  EXPECT_EQ(plan_of_net(30, 60).linear_solver(), "general");  // 1740 rows beside 600, whose factor has much fill
  EXPECT_EQ(plan_of_net(30, 180).linear_solver(), "batches+general");
}

TEST(Mixtures, AreNotMadeForAForcedSolver) {
  AnyNumbers any(26);
  System system = net(10, 10, &any);
  put_beside(clusters(30, &any), &system);

  EXPECT_THROW(Dynamics(system, {.linear_solver = LinearSolver::Paths}), InputError);
  EXPECT_EQ(Dynamics(system, {.linear_solver = LinearSolver::General}).plan().linear_solver(), "general");
}

// ---- motion ----

/// Makes a consistent system of nets, tetrahedra, breathing rods and a shaken support beside clusters, paths and beads.
System moving_mixture(bool is_uniform) {
  AnyNumbers any(27);
  System system = net(4, 5, &any);
  put_beside(clusters(20, &any), &system);
  put_beside(tetrahedra_in_a_row(4, &any), &system);
  put_beside(copies_of(1, 31, path_rods(30), &any), &system);
  put_beside(beads(5, &any), &system);
  System hung = net(3, 4, &any);
  hung.supports.push_back({"shaken", {0}, {ScalarFunction::formula("0.1*sin(3*t)^2"), 0.0, 0.0}});
  put_beside(hung, &system);
  system.forces = {gravity};
  if (!is_uniform) add_forces(&system);
  return system;
}

struct PlaceAndMotion {
  std::vector<double> r, v;

  explicit PlaceAndMotion(const Simulation& simulation)
      : r(simulation.positions().begin(), simulation.positions().end()),
        v(simulation.velocities().begin(), simulation.velocities().end()) {}
};

class MovingMixtures : public testing::TestWithParam<Method> {
 protected:
  static MotionOptions options() {
    MotionOptions result{.method = GetParam(), .rtol = 1e-10, .atol = 1e-10, .start = StartMode::Project};
    if (GetParam() == Method::Rattle) result.step = 1e-3;
    return result;
  }
};

TEST_P(MovingMixtures, MoveAsWithTheGeneralSolver) {
  for (const bool is_uniform : {true, false}) {
    const System system = moving_mixture(is_uniform);
    Simulation general(system, options(), {.linear_solver = LinearSolver::General}), mixed(system, options());
    EXPECT_EQ(mixed.plan().linear_solver(), "closed_form+batches+paths+general");

    const Outcome outcome = mixed.advance_to(0.05);

    ASSERT_TRUE(outcome.ok()) << outcome.what;
    ASSERT_TRUE(general.advance_to(0.05).ok());
    EXPECT_LE(mixed.report().violation.position, 1e-12);
    EXPECT_LE(mixed.report().violation.velocity, 1e-12);
    EXPECT_LE(relative_difference(PlaceAndMotion(mixed).r, PlaceAndMotion(general).r), 1e-9);
    EXPECT_LE(relative_difference(PlaceAndMotion(mixed).v, PlaceAndMotion(general).v), 1e-8);
  }
}

TEST_P(MovingMixtures, GoOnFromASnapshot) {
  const System system = moving_mixture(false);
  Simulation whole(system, options()), first(system, options()), second(system, options());
  ASSERT_TRUE(whole.advance_to(0.02).ok());
  ASSERT_TRUE(first.advance_to(0.02).ok());
  second.restore(first.save());

  ASSERT_TRUE(whole.advance_to(0.04).ok());
  ASSERT_TRUE(second.advance_to(0.04).ok());

  // The start of the next iterations of these methods is not in the snapshot.
  const bool iterates = GetParam() == Method::Rattle || GetParam() == Method::Radau5;
  const double rounding = iterates ? 1e-10 : 0.0;
  EXPECT_LE(relative_difference(PlaceAndMotion(second).r, PlaceAndMotion(whole).r), rounding);
  EXPECT_LE(relative_difference(PlaceAndMotion(second).v, PlaceAndMotion(whole).v), rounding);
}

INSTANTIATE_TEST_SUITE_P(Methods, MovingMixtures,
                         testing::Values(Method::Rattle, Method::Dop853, Method::Taylor, Method::Radau5),
                         [](const auto& instance) { return std::string(name_of(instance.param)); });

}  // namespace
}  // namespace tanor
