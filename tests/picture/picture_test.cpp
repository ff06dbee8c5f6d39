/// Pictures of instants are read back by libpng: what is where, and in which colour.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>

#include "picture/decoded.hpp"
#include "picture/draw.hpp"
#include "picture/implicit_surface.hpp"
#include "picture/legend.hpp"
#include "picture/shapes.hpp"
#include "report/motion_extent.hpp"

namespace tanor::picture {
namespace {

using Colour = std::array<int, 3>;
constexpr Colour bead{120, 133, 150}, support{26, 31, 38}, force{10, 122, 92};

void expect_colour(const Decoded& picture, int x, int y, const Colour& wanted, int allowed = 6) {
  const std::uint8_t* found = picture.at(x, y);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(found[k], wanted[k], allowed) << "pixel " << x << ", " << y << ", part " << k;
}

bool is_near(const std::uint8_t* pixel, const Colour& wanted, int allowed) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(pixel[k] - wanted[k]) > allowed) return false;
  return true;
}

/// These are the bounds of what is drawn, in pixels.
struct Bounds {
  int left = 1 << 20, right = -1, top = 1 << 20, bottom = -1;
  int count = 0;
};
template <class Counts>
Bounds bound(const Decoded& picture, const Counts& counts) {
  Bounds bounds;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (!counts(x, y)) continue;
      bounds.left = std::min(bounds.left, x);
      bounds.right = std::max(bounds.right, x);
      bounds.top = std::min(bounds.top, y);
      bounds.bottom = std::max(bounds.bottom, y);
      ++bounds.count;
    }
  }
  return bounds;
}
Bounds bound_drawn(const Decoded& picture) {
  return bound(picture, [&](int x, int y) { return !picture.is_ground(x, y); });
}
Bounds bound_colour(const Decoded& picture, const Colour& colour, int allowed = 8) {
  return bound(picture, [&](int x, int y) { return is_near(picture.at(x, y), colour, allowed); });
}

/// Returns a guide with the numbers that a run writes into its frames.
report::Guide formula_guide(const std::string& equation, double t = 0.0) {
  System system;
  system.positions = {0, 0, 0};
  system.masses = {1.0};
  system.constraints = {UserConstraints{"surface", {{0}}, formula_constraint(equation, 1)}};
  return report::place_guides(system, t, t).at(0);
}

/// Makes a support at the origin and a bead at (1, 0, 0), joined by a rod.
Picture make_rod(double tension) {
  report::StoredFrame frame;
  frame.positions = {0, 0, 0, 1, 0, 0};
  frame.velocities.resize(6);
  frame.is_support = {true, false};
  frame.rods = {{0, 1}};
  frame.tensions = {tension};
  frame.gravity = {0, -9.81, 0};
  Picture picture{frame, {}, {.width = 400, .height = 300, .tension_scale = 10.0, .shows_legend = false}};
  return picture;
}

Decoded paint(Picture picture) {
  picture.extent = report::measure_motion({picture.frame});
  return decode(draw(picture).png);
}

TEST(PictureTest, ARodHasTheColourOfItsTension) {
  const auto expect_rod = [](double tension, const Colour& wanted) {
    Picture picture = make_rod(tension);
    picture.style.width = 800;
    picture.style.height = 600;
    const Decoded painted = paint(picture);
    ASSERT_EQ(painted.width, 800);
    ASSERT_EQ(painted.height, 600);
    // The axis is between two rows, a thirteenth of the radius from either: one faces the lamp and is whiter by 1.5 %.
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(0.5 * (painted.at(400, 299)[k] + painted.at(400, 300)[k]), wanted[k], 4) << k;
  };
  // This is half of the scale: in the middle between the second and the third stop of the colours.
  expect_rod(5.0, {228, 126, 45});
  expect_rod(-5.0, {77, 140, 210});
  expect_rod(0.0, {199, 199, 196});
  expect_rod(1e9, {112, 28, 8});
  expect_rod(std::nan(""), {140, 140, 140});
}

/// A rod of unknown tension is dashed, so that nobody takes it for one without tension.
TEST(PictureTest, ARodOfUnknownTensionIsDashed) {
  const auto count_gaps = [](double tension) {
    const Decoded painted = paint(make_rod(tension));
    int gaps = 0;
    for (int x = 1; x < painted.width; ++x) gaps += painted.is_ground(x, 150) && !painted.is_ground(x - 1, 150);
    return gaps;
  };
  EXPECT_EQ(count_gaps(0.0), 1);  // where the picture ends
  EXPECT_EQ(count_gaps(5.0), 1);
  EXPECT_GE(count_gaps(std::nan("")), 5);
}

TEST(PictureTest, APlaneMotionIsSeenStraightAndFillsThePicture) {
  const Decoded picture = paint(make_rod(5.0));
  const Bounds all = bound_drawn(picture);
  EXPECT_GE(all.left, 1);
  EXPECT_LE(all.right, 398);
  EXPECT_GE(all.right - all.left, 370);
  // The left end is the support and larger, with the ground beneath it, the right one the bead.
  const Bounds dark = bound_colour(picture, support, 12), light = bound_colour(picture, bead, 12),
               earth = bound_colour(picture, {173, 158, 135}, 30);
  EXPECT_NEAR(light.top + light.bottom, 299, 2) << "in the middle";
  EXPECT_GT(earth.count, 20);
  EXPECT_GT(earth.bottom, light.bottom);
  EXPECT_LT(earth.bottom, 299);
  EXPECT_LT(dark.right, 40);
  EXPECT_GT(light.left, 370);
  EXPECT_GT(dark.count, light.count);
}

TEST(PictureTest, EdgesAreSmooth) {
  // Across the edge of the rod there are pixels between its colour and the ground.
  const Decoded picture = paint(make_rod(5.0));
  Picture turned = make_rod(5.0);
  turned.frame.positions = {0, 0, 0, 1, 0.7, 0};
  const Decoded slanted = paint(turned);
  std::array<bool, 256> blues{};
  for (int y = 0; y < slanted.height; ++y) blues[slanted.at(200, y)[2]] = blues[slanted.at(201, y)[2]] = true;
  EXPECT_GT(std::count(blues.begin(), blues.end(), true), 6);
  EXPECT_EQ(picture.bytes, paint(make_rod(5.0)).bytes) << "and every run gives the same";
}

TEST(PictureTest, WhatIsInFrontHidesWhatIsBehind) {
  Picture picture = make_rod(5.0);
  picture.style.from = {{1, 0, 0}};
  expect_colour(paint(picture), 200, 150, bead);
  picture.style.from = {{-1, 0, 0}};
  expect_colour(paint(picture), 200, 150, support);
}

/// Returns the widths of all that is drawn side by side, from the left.
std::vector<int> measure_widths(const Decoded& picture) {
  std::vector<int> widths;
  bool was_drawn = false;
  for (int x = 0; x < picture.width; ++x) {
    bool is_drawn = false;
    for (int y = 0; y < picture.height; ++y) is_drawn |= !picture.is_ground(x, y);
    if (is_drawn && !was_drawn) widths.push_back(0);
    if (is_drawn) ++widths.back();
    was_drawn = is_drawn;
  }
  return widths;
}

TEST(PictureTest, PerspectiveMakesNearPointsLarger) {
  Picture picture = make_rod(5.0);
  picture.frame.positions = {-0.5, 0, 0.5, 0.5, 0, -0.5};
  picture.frame.is_support = {true, true};
  picture.style.from = {{0, 0, 1}};
  picture.style.shows_rods = false;
  picture.style.projection = Projection::Perspective;
  const std::vector<int> seen = measure_widths(paint(picture));
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_GT(seen[0], 1.3 * seen[1]);
  EXPECT_GT(seen[1], 5);
  picture.style.projection = Projection::Orthographic;
  const std::vector<int> equal = measure_widths(paint(picture));
  ASSERT_EQ(equal.size(), 2u);
  EXPECT_NEAR(equal[0], equal[1], 1);
}

TEST(PictureTest, AReactionIsAnArrowAlongItsForce) {
  Picture picture = make_rod(5.0);
  picture.frame.guide_forces = {0, 3, 0, 0, 1e-12, 0};
  const Decoded up = paint(picture);
  const Bounds arrow = bound_colour(up, force, 30);
  const Bounds dark = bound_colour(up, support, 12);
  EXPECT_GT(arrow.count, 20);
  EXPECT_LT(arrow.bottom, dark.bottom) << "upwards from the support";
  EXPECT_LT(arrow.right, 200) << "a rounding is no force";
  picture.style.shows_normal = false;
  EXPECT_EQ(bound_colour(paint(picture), force, 30).count, 0);
}

/// One of fifty frames has a force ten times as large as the others, as where a whip cracks.
TEST(PictureTest, ArrowsStayInThePictureAndACutOneHasAGap) {
  Picture picture = make_rod(5.0);
  picture.frame.guide_forces = {0, 3, 0, 0, 0, 0};
  std::vector<report::StoredFrame> frames(50, picture.frame);
  frames[7].guide_forces[1] = 30.0;
  picture.extent = report::measure_motion(frames);
  const auto measure_arrow = [&](const report::StoredFrame& frame) {
    picture.frame = frame;
    const Decoded painted = decode(draw(picture).png);
    const Bounds arrow = bound_colour(painted, force, 30);
    int empty_rows = 0;
    for (int y = arrow.top; y <= arrow.bottom; ++y)
      empty_rows +=
          bound(painted, [&](int x, int row) { return row == y && x < 100 && !painted.is_ground(x, y); }).count == 0;
    EXPECT_GT(arrow.top, 0);
    return std::pair(arrow.bottom - arrow.top, empty_rows);
  };

  const auto [usual, gap_of_usual] = measure_arrow(frames[0]);
  const auto [cut, gap_of_cut] = measure_arrow(frames[7]);

  EXPECT_EQ(gap_of_usual, 0);
  EXPECT_GT(gap_of_cut, 1);
  EXPECT_NEAR(cut, 1.5 * usual, 6);
}

TEST(PictureTest, FrictionHasArrowsOfItsOwn) {
  Picture picture = make_rod(5.0);
  picture.style.width = 1200;
  picture.style.height = 900;
  picture.frame.guide_forces = {0, 3, 0, 0, 0, 0};
  picture.frame.friction_forces = {-0.4, 0, 0, 0, 0, 0};  // shorter than the ball is thick
  constexpr Colour friction{176, 56, 140};
  const Decoded both = paint(picture);
  const Bounds arrow = bound_colour(both, friction, 40), dark = bound_colour(both, support, 12);
  EXPECT_GT(arrow.count, 5);
  EXPECT_LT(arrow.left, dark.left) << "to the left of the support";
  EXPECT_GT(bound_colour(both, force, 30).count, 20);
  picture.style.shows_tangent = false;
  EXPECT_EQ(bound_colour(paint(picture), friction, 40).count, 0);
  EXPECT_GT(bound_colour(paint(picture), force, 30).count, 20);
}

TEST(PictureTest, EveryKindOfGuideIsDrawn) {
  const std::vector<report::Guide> guides{{"plane", "", {0, 0, 1, 0}},
                                          {"sphere", "", {0.5, 0, 0, 0.4}},
                                          {"line", "", {0, 0.2, 0, 1, 0, 0}},
                                          {"circle", "", {0.5, 0, 0, 0, 0, 1, 0.4}},
                                          {"ellipsoid", "", {0.5, 0, 0, 0.4, 0.3, 0.2, 1, 0, 0, 0, 1, 0}},
                                          {"helix", "", {0.5, 0, 0, 1, 0, 0, 0.2, 0.3, 0}},
                                          formula_guide("z1-0.2*((x1-0.5)^2-y1^2)"),
                                          {"cell", "", {0, -0.5, -0.5, 1, 0, 0, 0, 1, 0, 0, 0, 1}},
                                          {"tie", "", {2, 0, 0.5, 0, 1, 0.5, 0, 0, 1}},
                                          {"spring", "", {0, 0, 1}}};
  Picture picture = make_rod(5.0);
  picture.style.from = {{0.3, 0.2, 1}};
  for (const report::Guide& guide : guides) {
    picture.frame.guides = {guide};
    picture.style.shows_guides = true;
    const Decoded with = paint(picture);
    picture.style.shows_guides = false;
    const Decoded without = paint(picture);
    const Bounds differing =
        bound(with, [&](int x, int y) { return !std::equal(with.at(x, y), with.at(x, y) + 3, without.at(x, y)); });
    EXPECT_GT(differing.count, 300) << guide.kind;
    EXPECT_GT(differing.right - differing.left, 100) << guide.kind;
  }
}

TEST(PictureTest, GuidesThatAreNowhereAreNotDrawn) {
  Picture picture = make_rod(5.0);
  const std::vector<report::Guide> nowhere{{"plane", "no normal", {0, 0, 0, 0}},
                                           {"line", "no direction", {0, 0, 0, 0, 0, 0}},
                                           {"ellipsoid", "one axis", {0.5, 0, 0, 1e-3, 1e-3, 1e-3, 1, 0, 0, 1, 0, 0}},
                                           {"helix", "no pitch", {0, 0, 0, 0, 0, 1, 1, 0, 0}},
                                           {"formula", "no steps", {0, 0}},
                                           {"formula", "half a step", {0, 0, 0, 0}},
                                           {"formula", "no such result", {0, 1, 0, 0, 0, 0}},
                                           {"formula", "no such variable", {0, 0, 0, 0, 0, 4}},
                                           {"formula", "of what comes later", {0, 0, 2, 1, 0, 1, 0, 0, 0, 0}},
                                           {"formula", "no operation", {0, 0, 99, 0, 0, 0}},
                                           {"formula", "NaN", {0, 0, NAN, NAN, NAN, NAN}},
                                           formula_guide("x1^2+y1^2+z1^2+1"),
                                           formula_guide("1/(z1-0.01)")};
  for (const report::Guide& guide : nowhere) {
    picture.frame.guides = {guide};
    picture.style.shows_guides = true;
    const Decoded with = paint(picture);
    picture.style.shows_guides = false;
    EXPECT_TRUE(with.bytes == paint(picture).bytes) << guide.kind;
  }
}

/// The corners lie on the sphere, and its area is 4 pi, to second order in the side of a cell.
TEST(ImplicitSurfaceTest, PolygonsOfASphereLieOnTheSphere) {
  const std::optional<ImplicitFunction> xi = ImplicitFunction::read(formula_guide("x1^2+y1^2+z1^2-1").numbers);
  ASSERT_TRUE(xi.has_value());
  double area = 0.0, farthest = 0.0;
  for (const SurfacePart& part : polygonise(*xi, {0.1, 0.05, -0.1}, 1.5)) {
    const auto& [a, b, c] = part.corners;
    area += 0.5 * norm(cross(b - a, c - a));
    for (const Vec3& corner : part.corners) farthest = std::max(farthest, std::abs(norm(corner) - 1.0));
  }
  EXPECT_LT(farthest, 1e-4);
  EXPECT_NEAR(area, 4.0 * std::numbers::pi, 0.05);
}

/// The formula has all operations and is read at a place and a time.
TEST(ImplicitSurfaceTest, NumbersOfTheFormulaAreItsValues) {
  const std::string formula =
      "sqrt(x1)+exp(-y1)*log(z1)-sin(t)/cos(x1)+sinh(y1)*cosh(z1)+asin(0.1*x1)+atan(y1)+atan2(y1,z1)+abs(-x1)+"
      "min(x1,y1)-max(y1,z1)+2*x1-3";
  const auto at = [](double x, double y, double z, double t) {
    return std::sqrt(x) + std::exp(-y) * std::log(z) - std::sin(t) / std::cos(x) + std::sinh(y) * std::cosh(z) +
           std::asin(0.1 * x) + std::atan(y) + std::atan2(y, z) + std::abs(-x) + std::min(x, y) - std::max(y, z) +
           2.0 * x - 3.0;
  };
  std::optional<ImplicitFunction> xi = ImplicitFunction::read(formula_guide(formula, 0.7).numbers);
  ASSERT_TRUE(xi.has_value());
  EXPECT_NEAR((*xi)({0.3, 0.8, 1.9}), at(0.3, 0.8, 1.9, 0.7), 1e-13);
}

// A formula costs as much as it is long, and there may be thousands, so that those that would take long are left out.
TEST(PictureTest, MostOfThousandsOfFormulasAreLeftOut) {
  Picture picture = make_rod(5.0);
  picture.extent = report::measure_motion({picture.frame});
  picture.frame.guides.assign(9000, formula_guide("x1^2+y1^2+z1^2+1"));
  EXPECT_GT(draw(picture).left_out, 8000u);
}

// Each surface costs all samples that it covers, and thousands of large ones cannot be seen.
TEST(PictureTest, LargeSurfacesBeyondAFewAreLeftOut) {
  Picture picture = make_rod(5.0);
  picture.extent = report::measure_motion({picture.frame});
  picture.frame.guides.assign(4, {"sphere", "", {0.5, 0, 0, 2}});
  EXPECT_EQ(draw(picture).left_out, 0u);
  picture.frame.guides.assign(9000, {"sphere", "", {0.5, 0, 0, 2}});
  EXPECT_EQ(draw(picture).left_out, 8996u);
  picture.frame.guides.assign(1000, {"sphere", "", {0.5, 0, 0, 0.01}});
  EXPECT_EQ(draw(picture).left_out, 0u) << "small ones cost little";
}

// Without a limit 8,000 curves of 6,000 parts took gigabytes.
TEST(PictureTest, ManyCurvesHaveFewParts) {
  Picture picture = make_rod(5.0);
  picture.frame.guides.assign(8000, {"helix", "", {0.5, 0, 0, 1, 0, 0, 0.2, 1e-9, 0}});
  picture.extent = report::measure_motion({picture.frame});
  const Scale scale = choose_scale(picture);
  const Camera camera(choose_eye(picture), scale.outline, 1.4 * scale.bead, {0, 0, 400, 300});
  const Shapes shapes = build_shapes(picture, scale, camera);
  EXPECT_LE(shapes.cones.size(), 250'000u);
  EXPECT_GT(shapes.left_out, 0u);
}

TEST(PictureTest, TheBarHasTheColoursAndTheTimeIsWritten) {
  Picture picture = make_rod(5.0);
  picture.style.shows_legend = true;
  const Decoded painted = paint(picture);
  const Bounds top = bound_colour(painted, {112, 28, 8}, 4), low = bound_colour(painted, {199, 199, 196}, 3);
  EXPECT_GT(top.left, 320);
  EXPECT_LT(top.top, 90);
  EXPECT_GT(low.bottom, 190);
  // There are words in the upper left corner.
  const Bounds words = bound(painted, [&](int x, int y) { return x < 100 && y < 20 && painted.at(x, y)[0] < 128; });
  EXPECT_GT(words.count, 20);
  picture.frame.time = NAN;  // at rest
  const Decoded rest = paint(picture);
  EXPECT_EQ(bound(rest, [&](int x, int y) { return x < 100 && y < 20 && rest.at(x, y)[0] < 128; }).count, 0);
  // The motion keeps away from the bar.
  EXPECT_LT(bound_colour(painted, bead, 10).right, 320);
}

TEST(PictureTest, TheBarHasNumbersAtBothEnds) {
  for (const double end : {4.7, 9.3, 0.012, 170.0, 1e-9}) {
    for (const std::vector<double>& tensions : {std::vector{end}, std::vector{-end}, std::vector{end, -end}}) {
      Picture picture = make_rod(0.0);
      picture.style = {.width = 800, .height = 600};
      picture.frame.rods.assign(tensions.size(), {0, 1});
      picture.frame.tensions = tensions;
      const Decoded painted = paint(picture);
      const Layout layout = arrange(picture, true);
      const double beside = layout.motion.left + layout.motion.width + 2.5 * layout.font;
      for (const double part : {0.16, 0.84}) {  // of the height: the ends of the bar
        const double y = layout.motion.top + part * layout.motion.height;
        const Bounds words = bound(painted, [&](int px, int py) {
          return px > beside && std::abs(py - y) < 0.6 * layout.font && painted.at(px, py)[0] < 128;
        });
        EXPECT_GT(words.count, 5) << end << " of " << tensions.size() << " at " << part;
      }
    }
  }
}

TEST(PictureTest, ALongUnitBesideTheBarIsNotCut) {
  Picture picture = make_rod(5.0);
  picture.style = {.width = 800, .height = 600};
  picture.frame.force_unit = "epsilon/sigma";
  const Decoded painted = paint(picture);
  EXPECT_EQ(bound(painted, [&](int x, int y) { return x > 796 && painted.at(x, y)[0] < 200; }).count, 0);
}

/// The path of a crank and its arm are drawn while it is held, and its ground or ball as a support, but not after.
TEST(PictureTest, ACrankHasItsPathAndItsArmWhileItIsHeld) {
  std::vector<report::StoredFrame> frames;
  for (int k = 0; k <= 24; ++k) {
    const double u = 2.0 * std::numbers::pi * k / 24.0;
    report::StoredFrame& frame = frames.emplace_back();
    frame.positions = {std::cos(u), std::sin(u), 0, 3, 0, 0};
    frame.velocities.resize(6);
    frame.is_support = {true, true};
  }
  const auto draw_with = [&](bool is_held) {
    Picture picture{frames[0], report::measure_motion(frames), {.width = 800, .height = 600, .shows_legend = false}};
    picture.style.from = {{0, 0, 1}};
    picture.frame.is_support = {is_held, is_held};
    return decode(draw(picture).png);
  };
  const auto count = [](const Decoded& painted, const Colour& colour, int allowed) {
    return bound_colour(painted, colour, allowed);
  };
  const Decoded held = draw_with(true), free = draw_with(false);
  const Bounds arm = count(held, support, 30), earth = count(held, {173, 158, 135}, 30);
  const double metre = (arm.right - arm.left) / 3.0;  // from the pivot to the other support
  EXPECT_GT(metre, 150.0);
  EXPECT_GT(arm.count, 5.0 * metre);
  EXPECT_GT(earth.count, 20);
  // The path surrounds its pivot, which is at the left end of the arm.
  const Bounds drawn = bound_drawn(held);
  EXPECT_NEAR(arm.left - drawn.left, metre, 0.1 * metre);
  EXPECT_NEAR(drawn.bottom - drawn.top, 2.0 * metre, 0.1 * metre);
  EXPECT_LT(count(free, support, 30).count, arm.count / 10) << "edges of balls alone";
  EXPECT_LT(count(free, {173, 158, 135}, 30).count, earth.count / 10) << "edges of balls alone";
  EXPECT_EQ(measure_widths(free).size(), 2u) << "two balls alone";
}

/// A cross stands before a unit that is a number of others, as in texts: not "10 48.9 fs".
TEST(PictureTest, ANumberOfAUnitIsNotReadTogetherWithIt) {
  Picture picture = make_rod(5.0);
  picture.style = {.width = 400, .height = 300};
  picture.extent = report::measure_motion({picture.frame});
  const auto draw_with = [&](const std::string& time, const std::string& unit) {
    picture.frame.time_unit = time;
    picture.frame.force_unit = unit;
    return draw(picture).png;
  };
  EXPECT_TRUE(draw_with("48.9 fs", "") == draw_with("x 48.9 fs", ""));
  EXPECT_FALSE(draw_with("fs", "") == draw_with("x fs", ""));
  picture.frame.guide_forces = {0, 0, 5, 0, 0, 0};
  picture.extent = report::measure_motion({picture.frame});
  EXPECT_FALSE(draw_with("", "2 N") == draw_with("", "3 N"));
}

TEST(PictureTest, ALargePictureShowsTheSameAsASmallOne) {
  Picture picture = make_rod(5.0);
  const Decoded small = paint(picture);
  picture.style.width = 1200;
  picture.style.height = 900;
  const Decoded large = paint(picture);
  const Bounds a = bound_drawn(small), b = bound_drawn(large);
  EXPECT_NEAR(3 * a.left, b.left, 6);
  EXPECT_NEAR(3 * a.bottom, b.bottom, 6);
}

TEST(PictureTest, AHundredThousandBeadsAreDrawn) {
  Picture picture = make_rod(0.0);
  picture.frame = {};
  constexpr int side = 46;
  for (int k = 0; k < side * side * side; ++k) {
    for (const int number : {k % side, k / side % side, k / side / side}) picture.frame.positions.push_back(number);
  }
  picture.frame.velocities.resize(picture.frame.positions.size());
  picture.frame.is_support.resize(side * side * side);
  const Decoded painted = paint(picture);
  EXPECT_GT(bound_drawn(painted).count, 20'000);
  EXPECT_LT(bound_drawn(painted).right, 399);
}

TEST(PictureTest, OnePointWithoutExtentIsDrawn) {
  Picture picture = make_rod(0.0);
  picture.frame.positions = {7, 7, 7};
  picture.frame.velocities.resize(3);
  picture.frame.is_support = {false};
  picture.frame.rods.clear();
  picture.frame.tensions.clear();
  EXPECT_GT(bound_drawn(paint(picture)).count, 50);
}

}  // namespace
}  // namespace tanor::picture
