/// All that choose what `auto` means for a system, or ask beforehand, say the same.

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "scenes.hpp"

namespace tanor {
namespace {

/// Makes a bob that hangs from a rod and a stiff spring, on a rough wall if `touches`.
System make_stiff_pendulum(bool touches) {
  System system = scenes::make_chain(2);
  std::get<Rods>(system.constraints[0]).pairs.pop_back();
  system.forces.push_back(Springs{"spring", {{1, 2}}, 1e6, 1e3, scenes::spacing});
  Planes wall{.name = "wall", .points = {}, .normal = {0, 1, 0}, .offset = 0.0};
  if (touches) wall.points = {1};
  system.constraints.push_back(wall);
  system.friction = {Coulomb{.name = "rust", .at = {"wall"}, .coefficient = 0.3}};
  return system;
}

/// A law at a group without points has no effect, so it rules out no method.
TEST(MethodChoice, FrictionWithoutContactsRulesOutNothing) {
  const System free = make_stiff_pendulum(false), rough = make_stiff_pendulum(true);
  MotionOptions options;
  options.start = StartMode::Project;
  for (const double step : {0.0, 1e-3}) {
    options.step = step;
    const Method implicit = step > 0.0 ? Method::GeneralizedAlpha : Method::Radau5;
    EXPECT_EQ(choose_method(options, Dynamics(free)).method, implicit);
    EXPECT_EQ(Simulation(free, options).report().method, implicit);
    EXPECT_TRUE(wants_whole_islands(options, free));
    const Method chosen = choose_method(options, Dynamics(rough)).method;
    EXPECT_FALSE(traits_of(chosen).is_implicit);
    EXPECT_EQ(Simulation(rough, options).report().method, chosen);
    EXPECT_FALSE(wants_whole_islands(options, rough));
  }
  options = {};
  options.method = Method::Radau5;
  EXPECT_TRUE(Simulation(free, options).outcome().ok());
  EXPECT_THROW(Simulation(rough, options), InputError);
}

TEST(MethodChoice, ImplicitMethodsWantWholeIslands) {
  const System chain = scenes::make_chain(4);
  for (const MethodTraits& each : methods()) {
    MotionOptions options;
    options.method = each.method;
    EXPECT_EQ(wants_whole_islands(options, chain), each.is_implicit) << each.name;
  }
}

}  // namespace
}  // namespace tanor
