/// The tests check the words of enumerations, and the names of the version before.

#include <set>

#include <gtest/gtest.h>
#include <tanor/direct_problem.hpp>
#include <tanor/statics_names.hpp>
#include <tanor/tanor.hpp>

namespace tanor {
namespace {

template <class Enum>
class EnumNames : public testing::Test {};
using AllEnumerations = testing::Types<Status, Ordering, Form, FrictionMethod, LinearSolver, Factorization, Uniqueness,
                                       StartMode, Stabilisation, Event::Direction, PairLaw, Coulomb::Reaction, BondLaw,
                                       BendingLaw, TorsionLaw, EquilibriumMethod, Stability, AcceptedEquilibria>;
TYPED_TEST_SUITE(EnumNames, AllEnumerations);

TYPED_TEST(EnumNames, EachValueHasItsOwnWordAndEachWordItsValue) {
  std::set<std::string_view> words;
  int number = 0;
  for (const auto& [value, word] : enum_names<TypeParam>) {
    EXPECT_EQ(static_cast<int>(value), number++) << word;
    EXPECT_TRUE(words.insert(word).second) << word;
    EXPECT_EQ(name_of(value), word);
    EXPECT_EQ(value_of<TypeParam>(word), value);
    EXPECT_EQ(word.find_first_not_of("abcdefghijklmnopqrstuvwxyz_"), std::string_view::npos) << word;
  }
  EXPECT_FALSE(value_of<TypeParam>("no such word").has_value());
  EXPECT_EQ(name_of(static_cast<TypeParam>(99)), "?");
}

TEST(EnumNamesOfLists, AreJoined) {
  EXPECT_EQ(names_of(std::vector{LinearSolver::Batches, LinearSolver::General}), "batches+general");
  EXPECT_EQ(names_of(std::vector<Ordering>{}), "");
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"

TEST(OldNames, StillCompileAndWork) {
  EXPECT_EQ(Way::Bundles, LinearSolver::Batches);
  EXPECT_EQ(method_name(Method::Rk4), "rk4");
  EXPECT_EQ(friction_method_name(FrictionMethod::FixedPoint), "fixed_point");
  EXPECT_EQ(uniqueness_name(Uniqueness::Several), "several");

  System system;
  const Point anchor = system.add_support({0.0, 0.0, 0.0}), bob = system.add_point({.position = {1.0, 0.0, 0.0}});
  system.add_rods().join(anchor, bob);
  system.add_gravity({0.0, 0.0, -9.81});
  std::vector<double> r = system.positions, v(6), w(6), lambda(1), eta(6), w_new(6);
  Dynamics dynamics(system);
  EXPECT_TRUE(dynamics.start(0.0, r, v, StartMode::Check).outcome.ok());
  EXPECT_TRUE(dynamics.project_positions(0.0, r).outcome.ok());
  EXPECT_TRUE(dynamics.project_velocities(0.0, r, v).outcome.ok());
  EXPECT_TRUE(dynamics.solve(0.0, r, v, w, lambda, eta).outcome.ok());
  EXPECT_TRUE(dynamics.solve({.time = 0.0, .positions = r, .velocities = v}, {.accelerations = w_new}).outcome.ok());
  EXPECT_EQ(w, w_new);
  EXPECT_NEAR(w[5], -9.81, 1e-14);
  EXPECT_EQ(dynamics.solution(0.0, r, v).accelerations, w);
  r[3] = 1.5;
  EXPECT_NEAR(dynamics.position_violation(0.0, r), 0.5, 1e-14);
  v[3] = 2.0;
  EXPECT_GT(dynamics.velocity_violation(0.0, r, v), 0.0);
  r[3] = 1.0, v[3] = 0.0;

  Simulation simulation(system), other(system);
  EXPECT_TRUE(simulation.advance(0.1).ok());
  other.restore(simulation.snapshot());
  EXPECT_EQ(other.time(), 0.1);
  EXPECT_TRUE(DirectProblem(system).evaluate(0.0, {r, v, w}).outcome.ok());
}

#pragma GCC diagnostic pop

}  // namespace
}  // namespace tanor
