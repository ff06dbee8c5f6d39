/// A start at which rows contradict each other to first order alone is bent, and others are refused as before.

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/dynamics.hpp>
#include <tanor/equilibrium.hpp>

namespace tanor {
namespace {

/// Makes a straight chain of `count` rods over a gap along x, longer than the gap by `excess` of it.
System make_chain(int count, double gap, double excess, const Vector3& weight) {
  System system;
  Rods rods{.name = "links"};
  rods.length.constants = {(1.0 + excess) * gap / count};
  for (int i = 0; i <= count; ++i) {
    system.positions.insert(system.positions.end(), {gap * i / count, 0.0, 0.0});
    system.masses.push_back(0.1);
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  system.supports = {{"walls", {0, count}, {}}};
  system.constraints = {rods};
  if (weight != Vector3{}) system.add_gravity(weight);
  return system;
}

StartReport project(const System& system, std::vector<double>* r) {
  Dynamics dynamics(system);
  *r = system.positions;
  std::vector<double> v(r->size(), 0.0);
  StartReport report = dynamics.start({.time = 0.0, .positions = *r, .velocities = v}, StartMode::Project);
  EXPECT_TRUE(!report.outcome.ok() || dynamics.position_violation({.time = 0.0, .positions = *r}) <= 1e-12);
  return report;
}

TEST(BentStart, TwoRodsLongerThanTheirGapHangInATriangle) {
  const System system = make_chain(2, 0.2, 0.05, {0.0, 0.0, -9.81});
  std::vector<double> r;

  const StartReport report = project(system, &r);

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  EXPECT_NEAR(r[3], 0.1, 1e-6);
  EXPECT_NEAR(r[4], 0.0, 1e-12) << "it bends the way it falls, and would not swing";
  EXPECT_NEAR(r[5], -std::sqrt(0.105 * 0.105 - 0.01), 1e-9);
}

/// The rods of everybody's first cable are longer than their gap. It does not begin as a zigzag that falls and cracks.
TEST(BentStart, ACableHangsNearlyAsAtRest) {
  const System system = make_chain(20, 2.0, 0.05, {0.0, 0.0, -9.81});
  const EquilibriumResult rest = find_equilibrium(system);
  ASSERT_TRUE(rest.outcome.ok()) << rest.outcome.what;
  std::vector<double> r;

  ASSERT_TRUE(project(system, &r).outcome.ok());

  for (std::size_t i = 0; i < r.size(); ++i) EXPECT_NEAR(r[i], rest.positions[i], 2e-3) << i;
}

TEST(BentStart, CablesOfAnyLengthBendWithAndWithoutWeight) {
  for (const int count : {2, 3, 5, 20, 200}) {
    for (const double excess : {1e-6, 0.01, 0.05, 0.5}) {
      for (const Vector3& weight : {Vector3{0.0, 0.0, -9.81}, Vector3{}, Vector3{9.81, 0.0, 0.0}}) {
        std::vector<double> r;

        const StartReport report = project(make_chain(count, 2.0, excess, weight), &r);

        EXPECT_TRUE(report.outcome.ok()) << count << " rods, excess " << excess << ", weight " << weight[0] << " "
                                         << weight[2] << ": " << report.outcome.what;
      }
    }
  }
}

/// All points stay in a plane that holds them, and every start is the same.
TEST(BentStart, KeepsOtherConstraintsAndIsTheSameEachTime) {
  System system = make_chain(6, 1.2, 0.1, {0.0, 0.0, -9.81});
  system.constraints.push_back(Planes{"flat", {1, 2, 3, 4, 5}, Vector3{0.0, 0.0, 1.0}, 0.0});
  std::vector<double> r, again;

  const StartReport report = project(system, &r);
  (void)project(system, &again);

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  for (std::size_t i = 2; i < r.size(); i += 3) EXPECT_NEAR(r[i], 0.0, 1e-13);
  EXPECT_EQ(r, again);
}

TEST(BentStart, DoesNotHelpAChainThatIsTooShort) {
  std::vector<double> r;

  const StartReport report = project(make_chain(20, 2.0, -0.05, {0.0, 0.0, -9.81}), &r);

  EXPECT_EQ(report.outcome.status, Status::Contradictory);
  EXPECT_NE(report.outcome.what.find("contradicts"), std::string::npos) << report.outcome.what;
}

/// The longer one of rods of 0.5 m and 0.05 m cannot fit over 0.2 m. The shorter one ends at most 0.25 m away.
TEST(BentStart, NamesARodThatIsTooLongForItsPlace) {
  System system = make_chain(2, 0.2, 0.0, {});
  std::get<Rods>(system.constraints[0]).length.constants = {0.5, 0.05};
  for (const double aside : {0.0, 0.03}) {
    system.positions[4] = aside;
    std::vector<double> r;

    const StartReport report = project(system, &r);

    EXPECT_EQ(report.outcome.status, Status::Contradictory);
    EXPECT_EQ(report.outcome.what,
              "links[0] is 0.5 long at t = 0, but links[1] and the supports let its ends be 0.25 apart at most");
  }
}

/// A triangle of rods of 1, 1 and 2.5 m has no place in which they meet.
TEST(BentStart, NamesARodThatIsLongerThanTheWayAlongOthers) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.8, 0.0};
  system.masses = {1.0, 1.0, 1.0};
  system.constraints = {Rods{"triangle", {{0, 1}, {1, 2}, {2, 0}}, Parameter(std::vector<double>{2.5, 1.0, 1.0}), {}}};
  std::vector<double> r;

  const StartReport report = project(system, &r);

  EXPECT_EQ(report.outcome.status, Status::Contradictory);
  EXPECT_EQ(report.outcome.what,
            "triangle[0] is 2.5 long at t = 0, but triangle[1] and triangle[2] let its ends be 2 apart at most");
}

}  // namespace
}  // namespace tanor
