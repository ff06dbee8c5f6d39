/// Andrews' squeezing mechanism as 14 points, with its spring as one energy, has the published angles at t = 0.03 s.

#include "andrews.hpp"

#include <gtest/gtest.h>

#include "cases/interfaces.hpp"
#include "measures.hpp"

namespace tanor::cases {
namespace {

TEST(Andrews, TwoPointsHaveTheMassTheCentreAndTheInertiaOfEachBody) {
  for (const andrews::Body& body : andrews::bodies(andrews::end)) {
    const double at_joint = body.mass_at_joint(), at_opposite = body.mass - at_joint;
    const andrews::Place opposite = body.opposite(), from_centre = body.joint - body.centre,
                         behind = opposite - body.centre;
    const andrews::Place centre = (at_joint / body.mass) * body.joint + (at_opposite / body.mass) * opposite;

    EXPECT_GT(at_joint, 0.0);
    EXPECT_GT(at_opposite, 0.0);
    EXPECT_NEAR(centre.x, body.centre.x, 1e-16);
    EXPECT_NEAR(centre.y, body.centre.y, 1e-16);
    EXPECT_NEAR(at_joint * dot(from_centre, from_centre) + at_opposite * dot(behind, behind), body.inertia,
                1e-14 * body.inertia);
  }
}

/// The required accuracy is 1e-9 m. The published angles have 16 digits, of which beta ~ 16 rad loses two.
constexpr double wanted = 1e-11;

class AndrewsByMethod : public testing::TestWithParam<MotionOptions> {};

TEST_P(AndrewsByMethod, ComesToThePublishedPlaces) {
  Simulation simulation(andrews::make_system(), GetParam());

  ASSERT_TRUE(simulation.advance_to(andrews::end_time).ok());

  // radau5, of order 5, stops at the required digits.
  EXPECT_LT(largest_difference(simulation.positions(), andrews::positions(andrews::end)),
            GetParam().method == Method::Radau5 ? 1e-9 : wanted);
  const EnergyReport& energy = simulation.report().energy;
  // The moment does the work of the whole angle that the crank has turned, with all turns.
  const double work = andrews::moment * (andrews::end[0] - andrews::start[0]);
  EXPECT_NEAR(energy.work_of_forces, work, 1e-8 * work);
  EXPECT_NEAR(energy.now - energy.start, work, 1e-8 * work);
}

INSTANTIATE_TEST_SUITE_P(Methods, AndrewsByMethod,
                         testing::Values(MotionOptions{.method = Method::Taylor, .rtol = 1e-13, .atol = 1e-15},
                                         MotionOptions{.method = Method::Dop853, .rtol = 1e-13, .atol = 1e-15},
                                         MotionOptions{.method = Method::Radau5, .rtol = 1e-10, .atol = 1e-12}),
                         [](const auto& instance) { return std::string(name_of(instance.param.method)); });

/// The same motion is described by other points, which are joints that bodies share and a second point of each body.
TEST(Andrews, ComesToThePublishedPlacesAsElevenPoints) {
  Simulation simulation(andrews::make_joint_system(), {.method = Method::Taylor, .rtol = 1e-13, .atol = 1e-15});

  ASSERT_TRUE(simulation.advance_to(andrews::end_time).ok());

  const std::vector<double> wanted_places = andrews::positions(andrews::end);
  const std::array<std::size_t, 4> point_of_body{0, 2, 6, 10};  // of crank, f, g, h
  for (std::size_t joint = 0; joint < 4; ++joint) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(simulation.positions()[3 * joint + axis], wanted_places[3 * point_of_body[joint] + axis], wanted);
  }
}

/// The same motion is described by one coordinate, the angle of the crank.
TEST(Andrews, ComesToThePublishedPlacesInTheAngleOfTheCrank) {
  System system = andrews::make_points();
  system.coordinates = {andrews::make_coordinates()};
  Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-13, .atol = 1e-15});

  ASSERT_TRUE(simulation.advance_to(andrews::end_time).ok());

  EXPECT_LT(largest_difference(simulation.positions(), andrews::positions(andrews::end)), wanted);
}

#ifdef TANOR_PROGRAM
TEST(Andrews, TheExampleComesToThePublishedPlaces) {
  const Folder folder;
  run_program("run " TANOR_SOURCE_DIR "/examples/andrews.json --quiet --out " + (folder / "out").string());
  const std::vector<double> found = flatten(read_json(folder / "out/summary.json").at("final").at("positions"));

  EXPECT_LT(largest_difference(std::span<const double>(found), andrews::positions(andrews::end)), wanted);
}
#endif

}  // namespace
}  // namespace tanor::cases
