/// The certificate of systems with constraints to one side finds gaps below 0 and forces that pull the wrong way.

#include <gtest/gtest.h>

#include "certificate/certified.hpp"

namespace tanor {
namespace {

constexpr const char* sides = "s xi >= 0, s lambda >= 0, xi lambda = 0";

/// A bead of 1 kg above a floor.
System make_bead(double height) {
  System system;
  system.positions = {0.3, 0.0, height};
  system.velocities = {0.2, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Planes{.name = "floor", .points = {0}, .normal = Vector3{0, 0, 1}, .side = OneSide::AtLeast}};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}

TEST(OneSidedCertificate, FindsAnOpenRowBelowItsFloor) {
  Case solved(make_bead(0.5));
  ASSERT_TRUE(solved.forms.work.constraints.open.have(0));
  EXPECT_TRUE(solved.certify().passed()) << solved.certify().line();
  for (const double height : {1e-12, 0.0, -1e-12}) {  // of a length of 0.3 m
    solved.r[2] = height;
    EXPECT_TRUE(solved.certify().passed()) << height;
  }
  for (const double height : {-1e-6, -0.1}) {
    solved.r[2] = height;
    const Certificate certificate = solved.certify();
    EXPECT_TRUE(fails(certificate, sides)) << height;
    EXPECT_EQ(failed(certificate), sides) << "everything else is right";
  }
}

/// A bead on the floor, of which one says that it hangs above or is held down.
TEST(OneSidedCertificate, FindsAClosedRowThatOpensOrPulls) {
  Case solved(make_bead(0.0));
  ASSERT_FALSE(solved.forms.work.constraints.open.have(0));
  EXPECT_TRUE(solved.certify().passed()) << solved.certify().line();
  Case above = Case(make_bead(0.0));
  above.r[2] = 1e-3;
  EXPECT_TRUE(fails(above.certify(), sides));
  std::get<Gravity>(solved.told_system().forces[0]).acceleration = {0.0, 0.0, 9.81};
  solved.lambda[0] = -solved.lambda[0];
  solved.eta[2] = -solved.eta[2];
  EXPECT_TRUE(fails(solved.certify(), sides)) << "it pulls with what would hold it down";
}

/// Nobody looks at what an open row would have to do: its plane may be anywhere below.
TEST(OneSidedCertificate, OpenRowsTakeNoPartInTheEquations) {
  Case solved(make_bead(0.5));
  for (const double floor : {-0.2, 0.0, 0.4}) {
    std::get<Planes>(solved.told_system().constraints[0]).offset = floor;
    EXPECT_TRUE(solved.certify().passed()) << floor << solved.certify().line();
  }
  const std::vector<char> all(1, 0);
  solved.forms.work.constraints.open.set(solved.forms.work.constraints, all);
  EXPECT_FALSE(solved.certify().passed()) << "a closed row 0.1 m above its floor";
}

}  // namespace
}  // namespace tanor
