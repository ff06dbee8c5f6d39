#include <gtest/gtest.h>

#include <vector>

#include "dynamics/forms.hpp"

namespace tanor {
using namespace detail;
namespace {

constexpr double mass = 2.0, mu = 0.3;

/// The result at one speed of a bead at (1, 0, 0) on a circle of radius 1.
struct BeadFound {
  std::vector<double> r{1.0, 0.0, 0.0}, v, a = std::vector<double>(3);
  Reactions reactions;

  BeadFound(EquationsOfMotion& form, double speed) : v{0.0, speed, 0.0} {
    EXPECT_TRUE(form.accelerations(at(), {}, {a.data(), nullptr, nullptr, &reactions}).ok());
  }
  Kinematics at() const { return {0.0, r.data(), v.data()}; }
};

TEST(Reactions, StayThoseOfTheirStateWhereOthersAreFoundLater) {
  System system;
  system.positions = {1.0, 0.0, 0.0};
  system.velocities = {0.0, 1.0, 0.0};
  system.masses = {mass};
  system.constraints = {Circles{"hoop", {0}, Vector3{}, Vector3{0.0, 0.0, 1.0}, 1.0}};
  system.friction = {Coulomb{.name = "", .at = {"hoop"}, .coefficient = mu}};
  Forms forms(system, {});
  EquationsOfMotion& form = *forms.main;
  std::vector<double> r = system.positions, v = system.velocities;
  ASSERT_TRUE(form.start(0.0, r.data(), v.data(), StartMode::Check).outcome.ok());

  const BeadFound slow(form, 1.0), fast(form, 3.0);

  std::vector<double> eta(3), tau(3);
  for (const BeadFound* found : {&slow, &fast}) {
    form.write_reactions(found->at(), found->reactions, eta.data());
    form.write_friction(found->reactions, tau.data());
    const double pull = mass * found->v[1] * found->v[1];
    EXPECT_NEAR(eta[0], -pull, 1e-13 * pull);
    EXPECT_NEAR(tau[1], -mu * pull, 1e-12 * pull);
  }
}

}  // namespace
}  // namespace tanor
