/// \file Guides with corners where no motion goes on, or none that is told by the guide.

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/tanor.hpp>

#include "errors.hpp"
#include "methods.hpp"
#include "motion/corner_scenes.hpp"

namespace tanor {
namespace {

std::string refusal_of(System system, Method method, double t_end = 1.5) {
  Simulation simulation(std::move(system), corner_options(method));
  const Outcome outcome = simulation.advance_to(t_end);
  return outcome.ok() ? "none" : outcome.what;
}

TEST(Corners, WhereABeadStandsAreRefusedByName) {
  for (const std::string equation : {"z1-abs(x1)", "z1+abs(x1)"}) {
    for (const Method method : list_all_methods()) {
      System system = make_bead_on_v(equation);
      system.positions = {0.0, 0.0, 0.0};
      const std::string refusal = refusal_of(system, method);
      EXPECT_NE(refusal.find("corner of abs(x1) in wire"), std::string::npos) << name_of(method) << ": " << refusal;
    }
  }
}

/// No answer holds for a bead that stands in a corner, with which nothing says on which side it is.
TEST(Corners, WhereABeadStandsHaveNeitherAccelerationsNorRestNorModes) {
  for (const std::string equation : {"z1-abs(x1)", "z1+abs(x1)", "z1-sqrt(x1*x1)"}) {
    System system = make_bead_on_v(equation);
    system.positions = {0.0, 0.0, 0.0};
    Dynamics dynamics(system);
    const Outcome outcome = dynamics.solution({.time = 0.0, .positions = system.positions}).outcome;
    EXPECT_NE(outcome.what.find("corner of abs(x1) in wire"), std::string::npos) << equation << outcome.what;
    EXPECT_FALSE(dynamics.certify({.time = 0.0, .positions = system.positions}).passed());
    EXPECT_NE(error_of([&] { (void)modes(system, system.positions); }).find("corner of abs(x1) in wire"),
              std::string::npos);
  }
  for (const double x : {0.0, 0.5}) {
    System system = make_bead_on_v();
    system.positions = {x, 0.0, x};
    const Outcome outcome = find_equilibrium(system).outcome;
    EXPECT_NE(outcome.what.find("come to rest in the corner of abs(x1) in wire"), std::string::npos) << outcome.what;
  }
}

/// The corner of a comparison is not known, but the certificate tells that the motion does not follow its branch.
TEST(Corners, OfComparisonsAreNotCertifiedWhereABeadStands) {
  System system = make_bead_on_v();
  system.constraints[1] = UserConstraints{
      .name = "wire", .tuples = {{0}}, .kernel = make_constraint_kernel<1>([](const auto& r, const auto&) {
                                         return r[2] - (r[0] < 0.0 ? -r[0] : r[0]);
                                       })};
  system.positions = {0.0, 0.0, 0.0};
  const Certificate certificate = Dynamics(system).certify({.time = 0.0, .positions = system.positions});
  EXPECT_NE(certificate.line().find("path along the constraints"), std::string::npos) << certificate.line();
  system.positions = {1e-7, 0.0, 1e-7};
  system.velocities = {-1.0, 0.0, -1.0};
  const Certificate beside =
      Dynamics(system).certify({.time = 0.0, .positions = system.positions, .velocities = system.velocities});
  EXPECT_TRUE(beside.passed()) << beside.line();
}

TEST(Corners, WhereTwoEdgesMeetAreRefusedByName) {
  for (const Method method : list_all_methods()) {
    System system = make_bead_on_v("z1-abs(x1)-abs(y1)");  // slides down to the tip between two edges
    system.constraints.erase(system.constraints.begin());
    system.positions = {1.0, 1.0, 2.0};
    const std::string refusal = refusal_of(system, method);
    EXPECT_NE(refusal.find("corner of abs"), std::string::npos) << name_of(method) << ": " << refusal;
  }
}

/// |x| = |z| is two lines that cross. Rounded, they go over into each other or not, as the one root is rounded more
/// than the other.
TEST(Corners, WhereTwoWiresCrossAreRefusedByName) {
  for (const Method method : list_all_methods()) {
    const std::string refusal = refusal_of(make_bead_on_v("abs(x1)-abs(z1)"), method);
    EXPECT_NE(refusal.find("depends on their order"), std::string::npos) << name_of(method) << ": " << refusal;
  }
}

/// In the plane y = x both edges are the same place of one wire, which goes on in any order.
TEST(Corners, OfTwoEdgesThatAWireMeetsAtOnceAreTurned) {
  for (const Method method : with_auto(list_adaptive_methods())) {
    System system = make_bead_on_v("z1-abs(x1)-abs(y1)");
    system.constraints[0] = Planes{.name = "sheet", .points = {0}, .normal = Vector3{1.0, -1.0, 0.0}, .offset = 0.0};
    system.positions = {1.0, 1.0, 2.0};
    Simulation simulation(system, corner_options(method));
    // Along x = y the wire rises by 2, so that a_x = -10 2/(1 + 1 + 4), and x returns to rest at -1.
    const double quarter = std::sqrt(2.0 / (20.0 / 6.0));

    ASSERT_TRUE(simulation.advance_to(2.0 * quarter).ok()) << name_of(method) << ": " << simulation.outcome().what;

    EXPECT_NEAR(simulation.positions()[0], -1.0, 1e-9) << name_of(method);
    EXPECT_NEAR(simulation.velocities()[0], 0.0, 1e-9) << name_of(method);
  }
}

/// An angle jumps at its cut alone, and a formula that does not jump there has no corner.
TEST(Corners, OfAnglesAreAtTheirCutsAlone) {
  for (const Method method : with_auto(list_adaptive_methods())) {
    for (const double y : {1.0, -1.0}) {  // a swing on a circle whose lowest point is beside the cut or opposite to it
      System system;
      system.positions = {0.0, y, 0.0};
      system.velocities = {1.0, 0.0, 0.0};
      system.masses = {1.0};
      system.constraints = {
          Planes{.name = "sheet", .points = {0}, .normal = Vector3{0.0, 0.0, 1.0}, .offset = 0.0},
          UserConstraints{.name = "ring",
                          .tuples = {{0}},
                          .kernel = formula_constraint("x1*cos(atan2(y1,x1))+y1*sin(atan2(y1,x1))-1", 1)}};
      Simulation simulation(system, corner_options(method));
      ASSERT_TRUE(simulation.advance_to(7.0).ok()) << name_of(method) << ": " << simulation.outcome().what;
      EXPECT_NEAR(simulation.positions()[0], std::sin(7.0), 1e-8) << name_of(method);
    }
    System jumps = make_bead_on_v("z1-0.1*atan2(y1,x1)");
    jumps.constraints[0] =
        UserConstraints{.name = "ring", .tuples = {{0}}, .kernel = formula_constraint("x1^2+y1^2-1", 1)};
    jumps.positions = {-0.8, 0.6, 0.1 * std::atan2(0.6, -0.8)};
    jumps.velocities = {-1.2, -1.6, 0.2};
    const std::string refusal = refusal_of(jumps, method);
    EXPECT_NE(refusal.find("the corner of atan2 in wire"), std::string::npos) << name_of(method) << ": " << refusal;
  }
}

/// The normal force grows without bound towards x = 0, so that no step is short enough.
TEST(Corners, WithCurvaturesWithoutBoundAreRefusedByName) {
  for (const Method method : list_all_methods()) {
    for (const char* equation : {"z1-abs(x1)^1.5", "z1-abs(x1)^1.2"}) {
      const std::string refusal = refusal_of(make_bead_on_v(equation), method);
      EXPECT_NE(refusal.find("corner of abs(x1) in wire"), std::string::npos)
          << equation << ", " << name_of(method) << ": " << refusal;
    }
  }
}

/// Where only a comparison or a number without end tells of a corner, no scheme may go through it.
TEST(Corners, OfComparisonsAreNotPassedByAnyAdaptiveMethod) {
  for (const Method method : with_auto(list_adaptive_methods())) {
    System system = make_bead_on_v();
    system.constraints[1] = UserConstraints{
        .name = "wire", .tuples = {{0}}, .kernel = make_constraint_kernel<1>([](const auto& r, const auto&) {
                                           return r[2] - (r[0] < 0.0 ? -r[0] : r[0]);
                                         })};
    MotionOptions options = corner_options(method);
    options.start = StartMode::Project;
    try {
      Simulation simulation(system, options);
      if (!simulation.advance_to(1.5).ok()) continue;
      EXPECT_NEAR(simulation.positions()[0], x_of_bead(1.5), 1e-6) << name_of(method);
    } catch (const InputError& error) {  // no series without an expression
      EXPECT_EQ(method, Method::Taylor) << error.what();
    }
  }
}

TEST(Corners, WithAJumpOfTheGuideAreRefusedByName) {
  for (const Method method : list_all_methods()) {
    System system = make_bead_on_v("z1-x1-0.1*x1/abs(x1)");
    system.positions = {1.0, 0.0, 1.1};
    const std::string refusal = refusal_of(system, method);
    EXPECT_NE(refusal.find("corner of abs(x1) in wire"), std::string::npos) << name_of(method) << ": " << refusal;
  }
}

TEST(Corners, ThatAreCuspsAreRefusedByName) {
  for (const char* cusp : {"z1-sqrt(abs(x1))", "z1-abs(x1)^0.5", "z1-(x1*x1)^0.25", "z1-(x1^2)^(1/3)"}) {
    for (const Method method : list_all_methods()) {
      const std::string refusal = refusal_of(make_bead_on_v(cusp), method);
      EXPECT_NE(refusal.find("corner of abs(x1) in wire"), std::string::npos)
          << cusp << ", " << name_of(method) << ": " << refusal;
    }
  }
}

TEST(Corners, InTimeThatAreCuspsAreRefusedByName) {
  for (const char* offset : {"0.6+0.4*((t-0.5)^2)^(1/3)-0.2", "0.6+0.4*sqrt(abs(t-0.5))"}) {
    for (const Method method : list_all_methods()) {
      MotionOptions options = corner_options(method);
      options.start = StartMode::Project;
      if (has_fixed_steps(method)) options.step = 3.1e-3;
      Simulation simulation(make_plane_with_corner(offset), options);
      const Outcome outcome = simulation.advance_to(1.0);
      EXPECT_FALSE(outcome.ok()) << offset << ", " << name_of(method);
      EXPECT_NE(outcome.what.find("the corner of a function of time"), std::string::npos)
          << offset << ", " << name_of(method) << ": " << outcome.what;
    }
  }
}

/// A bead that comes to rest exactly on a ridge: rounding would tell whether it goes on or back.
TEST(Corners, ThatAreReachedWithoutSpeedAreRefusedByName) {
  for (const double more : {0.0, 1e-13, -1e-13}) {
    for (const Method method : list_all_methods()) {
      System system = make_bead_on_v("z1+abs(x1)");
      const double speed = std::sqrt(10.0) * (1.0 + more);
      system.positions = {1.0, 0.0, -1.0};
      system.velocities = {-speed, 0.0, speed};
      const std::string refusal = refusal_of(system, method);
      EXPECT_NE(refusal.find("corner of abs(x1) in wire"), std::string::npos)
          << more << ", " << name_of(method) << ": " << refusal;
    }
  }
}

/// A root that is no square has no tangent where it vanishes, as the tip of a cone; beside it there is no corner.
TEST(Corners, AtTheTipOfAConeAreRefusedByName) {
  for (const Method method : list_all_methods()) {
    for (const char* cone : {"z1-sqrt(x1^2+y1^2)", "z1-sqrt(x1*x1+0)"}) {
      const std::string refusal = refusal_of(make_bead_on_v(cone), method);
      EXPECT_NE(refusal.find("the corner of sqrt in wire"), std::string::npos)
          << cone << ", " << name_of(method) << ": " << refusal;
    }
  }
  for (const Method method : with_auto(list_adaptive_methods())) {
    Simulation simulation(make_bead_on_v("z1-sqrt(x1^2+0.01)+sqrt(1.01)-1"), corner_options(method));
    EXPECT_TRUE(simulation.advance_to(1.0).ok()) << name_of(method) << ": " << simulation.outcome().what;
  }
}

/// The gradient of z = max(0, x)^2 does not jump.
TEST(Corners, AreNoneWhereTheGradientIsContinuous) {
  for (const Method method : with_auto(list_adaptive_methods())) {
    System system = make_bead_on_v("z1-max(0,x1)^2");
    system.velocities = {-1.0, 0.0, -2.0};
    Simulation simulation(system, corner_options(method));
    ASSERT_TRUE(simulation.advance_to(1.0).ok()) << name_of(method) << ": " << simulation.outcome().what;
    EXPECT_NEAR(simulation.velocities()[0], -5.0, 1e-9) << name_of(method);  // v^2 = 1 + 4 + 2 g

    system.positions = {0.0, 0.0, 0.0};  // at rest where both branches meet
    system.velocities = {0.0, 0.0, 0.0};
    Simulation still(system, corner_options(method));
    ASSERT_TRUE(still.advance_to(1.0).ok()) << name_of(method) << ": " << still.outcome().what;
    EXPECT_NEAR(still.positions()[0], 0.0, 1e-12) << name_of(method);
  }
}

}  // namespace
}  // namespace tanor
