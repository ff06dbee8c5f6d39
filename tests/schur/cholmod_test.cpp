/// CHOLMOD alone, which shares nothing with the other solvers but the matrix, finds what they find.

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "scenes.hpp"
#include "schur/answers.hpp"

namespace tanor {
namespace {

std::vector<std::pair<std::string, System>> list_systems() {
  return {{"chain", scenes::make_chain(300)},
          {"ring", scenes::make_ring(100)},
          {"clusters", scenes::make_clusters(30)},
          {"beads", scenes::make_beads(30)},
          {"rough beads", scenes::make_rough_beads(10)},
          {"breathing chain", scenes::make_breathing_chain(40)},
          {"small net", scenes::make_net(6, 5)},
          {"net", scenes::make_net(60, 60)},
          {"net of unequal masses", scenes::make_hung_net(40, true)},
          {"curtain", scenes::make_curtain(20, 20)},
          {"lattice", scenes::make_lattice(9)}};
}

TEST(Cholmod, AgreesWithTheChosenSolver) {
  for (const auto& [name, system] : list_systems()) {
    SCOPED_TRACE(name);
    const Answer chosen = solve(system, {}), reference = solve(system, {.linear_solver = LinearSolver::Cholmod});
    ASSERT_TRUE(reference.report.outcome.ok()) << reference.report.outcome.what;
    EXPECT_LE(relative_difference(chosen.w, reference.w), rounding);
    EXPECT_LE(relative_difference(chosen.lambda, reference.lambda), rounding);
    EXPECT_LE(relative_difference(chosen.eta, reference.eta), rounding);
    EXPECT_EQ(Dynamics(system, {.linear_solver = LinearSolver::Cholmod}).plan().linear_solver(), "cholmod");
  }
}

TEST(Cholmod, SolvesInCoordinates) {
  const System system = scenes::make_coordinates();
  const Answer chosen = solve(system, {.form = Form::Tangent}),
               reference = solve(system, {.form = Form::Tangent, .linear_solver = LinearSolver::Cholmod});
  ASSERT_TRUE(reference.report.outcome.ok()) << reference.report.outcome.what;
  EXPECT_LE(relative_difference(chosen.w, reference.w), rounding);
}

TEST(Cholmod, LeavesDependentRowsToTheRank) {
  const System system = make_stretched_ring();
  const Answer chosen = solve(system, {}), reference = solve(system, {.linear_solver = LinearSolver::Cholmod});
  EXPECT_EQ(reference.report.outcome.status, chosen.report.outcome.status) << reference.report.outcome.what;
  EXPECT_LE(relative_difference(chosen.w, reference.w), rounding);
}

}  // namespace
}  // namespace tanor
