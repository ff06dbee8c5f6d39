/// The program reads its own frames for ParaView back.

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include <tanor/error.hpp>

#include "report/compression.hpp"
#include "report/reading.hpp"
#include "report/shown_parts.hpp"
#include "report/stored_motion.hpp"
#include "report/trajectory.hpp"
#include "report/vtp_frame.hpp"

namespace tanor::report {
namespace {

/// Makes a support, two beads on rods and a bead that no rod holds; the second rod ends at an image.
System make_system() {
  System system;
  system.positions = {0, 0, 0, 0.1, 0, 0, 0.9, 0, 0, 0, 1, 0};
  system.velocities.resize(12);
  system.masses = {1, 1, 1, 1};
  system.supports = {{.points = {0}}};
  system.constraints = {Rods{.name = "rods", .pairs = {{0, 1}, {1, 2}}, .offsets = {{0, 0, 0}, {-1, 0, 0}}}};
  return system;
}

/// Rows that follow cubic polynomials, which Hermite's interpolation reproduces exactly.
struct Rows {
  std::vector<double> positions, velocities, accelerations, tensions{0, 0}, forces, friction;
  Frame frame(std::size_t number, double t) {
    positions.clear();
    velocities.clear();
    forces.clear();
    for (int k = 0; k < 12; ++k) {
      positions.push_back(k + t - k * t * t + 0.3 * t * t * t);
      velocities.push_back(1 - 2 * k * t + 0.9 * t * t);
      forces.push_back(k < 3 ? k + t : 0.0);
    }
    friction.assign(12, -0.5 * t);
    accelerations = velocities;
    tensions = {1 + t, -2 * t};
    return {.number = number,
            .time = t,
            .positions = positions,
            .velocities = velocities,
            .accelerations = accelerations,
            .tensions = tensions,
            .guide_forces = forces,
            .friction_forces = friction,
            .guides = {{"sphere", "a <ball> & \"more\"", {0, 0, t, 1}}, {"plane", "", {0, 0, 1, -0.5}}},
            .gravity = {0, 0, -9.81}};
  }
};

void write_motion(const Folder& folder, const ShownParts& shown, bool is_compressed = false) {
  VtpTrajectory trajectory(folder.path(), &shown, is_compressed);
  Rows rows;
  for (std::size_t k = 0; k < 5; ++k) trajectory.write(rows.frame(k, 0.25 * static_cast<double>(k)));
}

TEST(StoredFrameTest, ReadsBackWhatWasWritten) {
  const ShownParts shown = choose_parts(make_system(), {});
  for (const bool is_compressed : {false, true}) {
    if (is_compressed && !has_compression()) continue;
    const Folder folder;
    Rows rows;
    const Frame written = rows.frame(0, 0.1 + 0.2);
    write_vtp(folder / "f.vtp", shown, written, is_compressed);
    const StoredFrame frame = read_vtp(folder / "f.vtp");

    EXPECT_EQ(frame.time, 0.1 + 0.2);
    EXPECT_EQ(std::vector(frame.positions.begin(), frame.positions.begin() + 12), rows.positions);
    EXPECT_EQ(frame.positions.size(), 15u) << "the image follows";
    EXPECT_EQ(frame.positions[12], rows.positions[6] - 1.0);
    EXPECT_EQ(std::vector(frame.velocities.begin(), frame.velocities.begin() + 12), rows.velocities);
    EXPECT_EQ(std::vector(frame.guide_forces.begin(), frame.guide_forces.begin() + 12), rows.forces);
    EXPECT_EQ(std::vector(frame.friction_forces.begin(), frame.friction_forces.begin() + 12), rows.friction);
    EXPECT_EQ(frame.is_support, (std::vector<bool>{true, false, false, false, false}));
    EXPECT_EQ(frame.rods, (std::vector<std::array<std::int32_t, 2>>{{0, 1}, {1, 4}}));
    EXPECT_EQ(frame.tensions, rows.tensions);
    ASSERT_EQ(frame.guides.size(), 2u);
    EXPECT_EQ(frame.guides[0].kind, "sphere");
    EXPECT_EQ(frame.guides[0].name, "a <ball> & \"more\"");
    EXPECT_EQ(frame.guides[0].numbers, (std::vector<double>{0, 0, 0.1 + 0.2, 1}));
    EXPECT_EQ(frame.gravity, (Vector3{0, 0, -9.81}));
  }
}

TEST(StoredFrameTest, DamagedFilesAreRefusedByName) {
  const ShownParts shown = choose_parts(make_system(), {});
  std::mt19937 random(5);
  for (const bool is_compressed : {false, true}) {
    if (is_compressed && !has_compression()) continue;
    const Folder folder;
    Rows rows;
    write_vtp(folder / "f.vtp", shown, rows.frame(0, 0.5), is_compressed);
    const std::string whole = read_text(folder / "f.vtp");
    for (int k = 0; k < 300; ++k) {
      write_text(folder / "cut.vtp", whole.substr(0, random() % whole.size()));
      try {
        read_vtp(folder / "cut.vtp");
        ADD_FAILURE() << "a file that is cut was read";
      } catch (const InputError& error) {
        EXPECT_NE(error.where().find("cut.vtp"), std::string::npos);
      }
      // A file with any byte changed is refused, or read as other numbers.
      std::string changed = whole;
      changed[random() % changed.size()] = static_cast<char>(random());
      write_text(folder / "changed.vtp", changed);
      try {
        const StoredFrame frame = read_vtp(folder / "changed.vtp");
        for (const auto& [i, j] : frame.rods) EXPECT_LT(static_cast<std::size_t>(std::max(i, j)), frame.num_points());
        EXPECT_EQ(frame.positions.size(), 3 * frame.num_points());
      } catch (const InputError&) {
      }
    }
  }
}

TEST(StoredMotionTest, BetweenFramesPositionsAreCubicAndForcesLinear) {
  const ShownParts shown = choose_parts(make_system(), {});
  const Folder folder;
  write_motion(folder, shown);
  const StoredMotion motion(folder.path());
  EXPECT_EQ(motion.begin(), 0.0);
  EXPECT_EQ(motion.end(), 1.0);
  Rows rows;
  for (const double t : {0.1, 0.3, 0.7, 0.99}) {
    const StoredMotion::Instant instant = motion.at(t);
    rows.frame(0, t);
    EXPECT_LT(instant.before, t);
    EXPECT_GT(instant.after, t);
    EXPECT_EQ(instant.frame.time, t);
    for (std::size_t k = 0; k < 12; ++k) {
      EXPECT_NEAR(instant.frame.positions[k], rows.positions[k], 1e-14);
      EXPECT_NEAR(instant.frame.guide_forces[k], rows.forces[k], 1e-14);
      EXPECT_NEAR(instant.frame.friction_forces[k], rows.friction[k], 1e-14);
    }
    EXPECT_NEAR(instant.frame.tensions[1], rows.tensions[1], 1e-15);
    EXPECT_NEAR(instant.frame.guides[0].numbers[2], t, 1e-15);
  }
}

TEST(StoredMotionTest, AFrameIsShownAsItIs) {
  const ShownParts shown = choose_parts(make_system(), {});
  const Folder folder;
  write_motion(folder, shown);
  const StoredMotion motion(folder.path());
  Rows rows;
  for (const double t : {0.0, 0.25, 0.75, 1.0}) {
    const StoredMotion::Instant instant = motion.at(t + 1e-12);
    rows.frame(0, t);
    EXPECT_EQ(instant.before, t);
    EXPECT_EQ(instant.after, t);
    EXPECT_EQ(std::vector(instant.frame.positions.begin(), instant.frame.positions.begin() + 12), rows.positions);
  }
}

TEST(StoredMotionTest, TheExtentIsThatOfAllFrames) {
  const ShownParts shown = choose_parts(make_system(), {});
  const Folder folder;
  write_motion(folder, shown);
  const MotionExtent extent = StoredMotion(folder.path()).measure();
  EXPECT_EQ(extent.tensions.least, -2.0);
  EXPECT_EQ(extent.tensions.most, 2.0);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_LE(extent.least[axis], static_cast<double>(axis));
  EXPECT_FALSE(extent.tips.empty());
  EXPECT_EQ(extent.least[0], -1.0) << "of a ball that guides";
  EXPECT_EQ(StoredMotion(folder.path()).measure(false).least[0], 0.0);
  // No place of any frame lies beyond the outline in one of its directions.
  double farthest = -HUGE_VAL;
  for (const Vector3& place : extent.outline) farthest = std::max(farthest, place[0]);
  EXPECT_EQ(farthest, extent.most[0]);
}

TEST(MotionExtentTest, RoundingsCountNeitherAsForcesNorAsPushes) {
  StoredFrame frame;
  frame.is_support.resize(100);
  frame.positions.resize(300);
  frame.guide_forces.resize(300, 1e-14);
  frame.guide_forces[4] = -5.0;
  frame.rods.assign(100, {0, 1});
  frame.tensions.assign(100, -1e-13);
  frame.tensions[0] = 3.0;
  StoredFrame hung = frame;  // of whose supports nothing is known
  hung.guide_forces[4] = NAN;
  EXPECT_EQ(measure_motion({hung}).largest_force, 0.0);
  const MotionExtent extent = measure_motion({frame});
  EXPECT_EQ(extent.largest_force, 5.0);
  EXPECT_EQ(*std::ranges::min_element(extent.tips), *std::ranges::max_element(extent.tips)) << "of one arrow alone";
  EXPECT_EQ(extent.tensions.least, 0.0);
  EXPECT_EQ(extent.tensions.most, 3.0);
}

TEST(StoredMotionTest, TheColoursOfAPageAreThoseOfThePictures) {
  const ShownParts shown = choose_parts(make_system(), {});
  const Folder folder;
  write_motion(folder, shown);
  const auto measure_with = [&](const std::string& summary) {
    write_text(folder / "summary.json", summary);
    return StoredMotion(folder.path()).measure().tensions;
  };
  EXPECT_EQ(measure_with(R"({"tension_colours": [-170, 0]})").least, -170.0);
  EXPECT_EQ(measure_with(R"({"tension_colours": [-170, 0]})").most, 0.0);
  for (const std::string other : {"{}", "", "[1, 2]", R"({"tension_colours": [1, 2]})", R"({"tension_colours": [0]})",
                                  R"({"tension_colours": ["a", null]})"})
    EXPECT_EQ(measure_with(other).most, 2.0) << other;
  // The page of a run that goes on is newer than any summary.
  write_text(folder / "report.html", R"(<p>{"run":{},"colours":{"tensions":[-2.5,7.0],"pulled":[]}}</p>)");
  EXPECT_EQ(measure_with(R"({"tension_colours": [-170, 0]})").least, -2.5);
  EXPECT_EQ(measure_with("").most, 7.0);
}

TEST(TensionScaleTest, EndsAtNearlyAllTensionsRoundedUpToTwoDigits) {
  const auto choose = [](std::vector<double> tensions) {
    const TensionScale scale = choose_tension_scale(std::move(tensions));
    return std::pair(scale.least, scale.most);
  };
  EXPECT_EQ(choose({}), std::pair(0.0, 0.0));
  EXPECT_EQ(choose({0.0, 0.0}), std::pair(0.0, 0.0));
  EXPECT_EQ(choose({4.62, 1.0, std::nan("")}), std::pair(0.0, 4.7)) << "one of two is more than 0.01";
  EXPECT_EQ(choose({-4.62}), std::pair(-4.7, 0.0));
  EXPECT_EQ(choose({4.62, -1.0}), std::pair(-4.7, 4.7));
  EXPECT_EQ(choose({static_cast<double>(0.1f)}), std::pair(0.0, 0.1)) << "as in double precision";
  std::vector<double> many(100, 169.2);
  many[50] = 1e6;
  EXPECT_EQ(choose(many), std::pair(0.0, 170.0));
  many.clear();
  for (int k = 1; k <= 100; ++k) many.push_back(k);
  EXPECT_EQ(choose(many), std::pair(0.0, 99.0)) << "one of a hundred is beyond";
}

TEST(StoredFrameTest, NumbersThatNoMotionHasAreRefused) {
  const ShownParts shown = choose_parts(make_system(), {});
  const Folder folder;
  for (const double odd : {1e200, -HUGE_VAL, std::nan("")}) {
    for (std::vector<double> Rows::*part : {&Rows::positions, &Rows::velocities}) {
      Rows rows;
      const Frame frame = rows.frame(0, 0.5);
      (rows.*part)[4] = odd;
      write_vtp(folder / "f.vtp", shown, frame);
      EXPECT_THROW(read_vtp(folder / "f.vtp"), InputError) << odd;
    }
  }
}

TEST(StoredMotionTest, VelocitiesThatLeadTooFarAreRefused) {
  const ShownParts shown = choose_parts(make_system(), {});
  const Folder folder;
  Rows rows;
  write_vtp(folder / "f.vtp", shown, rows.frame(0, 0.5));
  write_text(folder / "trajectory.pvd",
             R"(<DataSet timestep="0" file="f.vtp"/><DataSet timestep="1e300" file="f.vtp"/>)");
  EXPECT_THROW(StoredMotion(folder.path()).at(1e299), InputError);
}

TEST(StoredMotionTest, NamesOfTwoLinesAreRefused) {
  const Folder folder;
  write_text(folder / "trajectory.pvd", "<DataSet timestep=\"0\" file=\"a\nb.vtp\"/>");
  EXPECT_THROW(StoredMotion(folder.path()), InputError);
}

TEST(StoredMotionTest, FoldersWithoutFramesAreRefused) {
  const Folder folder;
  EXPECT_THROW(StoredMotion(folder / "missing"), InputError);
  EXPECT_THROW(StoredMotion(folder.path()), InputError);
  write_text(folder / "trajectory.pvd", "<VTKFile><Collection></Collection></VTKFile>");
  EXPECT_THROW(StoredMotion(folder.path()), InputError);
  write_text(folder / "trajectory.pvd", "<DataSet timestep=\"1\" file=\"a\"/><DataSet timestep=\"0\" file=\"b\"/>");
  EXPECT_THROW(StoredMotion(folder.path()), InputError);
}

/// A crank that turns about (-1, 0, 0) is let go at 0.57 s, and the second of its rods breaks at 0.33 s; so are a table
/// and a rope. Frames come every eighth of a second, and what is drawn between them changes at those instants.
TEST(StoredMotionTest, WhatBrokeOrWasLetGoIsNoLongerThereFromItsInstantOn) {
  System system;
  system.positions = {0, 0, 0, 0, 0, -1, 0, 0, -2, 3, 0, 0, 5, 0, 0, 6, 0, -2, 8, 0, -1};
  system.masses.assign(7, 1.0);
  const auto turn = [](double part) { return std::vector{std::cos(part) - 1.0, 0.0, std::sin(part)}; };
  system.supports = {
      {"crank", {0}, VectorFunction(ScalarFunction::formula("cos(t)-1"), 0.0, ScalarFunction::formula("sin(t)"))},
      {"wall", {3}}};
  system.constraints = {Rods{.name = "rods", .pairs = {{0, 1}, {1, 2}}}, Planes{"table", {4}, Vector3{0, 0, 1}, 0.0},
                        Pulleys{"winch", {{5, 6}}, Vector3{6, 0, 0}, Vector3{8, 0, 0}}};
  system.forces = {Gravity{"", {0, 0, -9.81}}};
  Simulation simulation(system, {.method = Method::Dopri5, .start = StartMode::Project});
  simulation.add_event({.when = "t > 0.33", .action = EventAction::Break, .of = "rods[1]"});
  simulation.add_event({.when = "t > 0.33", .action = EventAction::Break, .of = "winch"});
  simulation.add_event({.when = "t > 0.57", .action = EventAction::Release, .of = "crank"});
  simulation.add_event({.when = "t > 0.57", .action = EventAction::Release, .of = "table"});
  const Folder folder;
  TrajectoryOptions options;
  options.formats.files = {scene::TrajectoryFormat::Vtp};
  Trajectory trajectory(folder.path(), system, options);
  for (int k = 0; k <= 8; ++k) {
    ASSERT_TRUE(k == 0 || simulation.advance_to(0.125 * k).ok());
    trajectory.write_frame(simulation);
  }
  ASSERT_EQ(simulation.passages().size(), 4u);

  const StoredMotion motion(folder.path());
  using Ends = std::vector<std::array<std::int32_t, 2>>;
  for (const double t : {0.0, 0.25, 0.3, 0.32, 0.34, 0.375, 0.5, 0.56, 0.58, 0.625, 1.0}) {
    const StoredFrame frame = motion.at(t).frame;
    EXPECT_EQ(frame.rods, t < 0.33 ? (Ends{{0, 1}, {1, 2}}) : (Ends{{0, 1}})) << t;
    ASSERT_EQ(frame.tensions.size(), frame.rods.size()) << t;
    for (const double tension : frame.tensions) EXPECT_TRUE(std::isfinite(tension)) << t;
    EXPECT_EQ(frame.is_support, (std::vector<bool>{t < 0.57, false, false, true, false, false, false})) << t;
    std::vector<std::string> guides;
    for (const Guide& guide : frame.guides) guides.push_back(guide.kind);
    EXPECT_EQ(guides, t < 0.33   ? (std::vector<std::string>{"plane", "tie"})
                      : t < 0.57 ? (std::vector<std::string>{"plane"})
                                 : (std::vector<std::string>{}))
        << t;
  }
  EXPECT_FALSE(read_vtp(folder / "trajectory/frame_000008.vtp").is_support[0]) << "other programs read the file alone";
  const MotionExtent extent = motion.measure();
  ASSERT_EQ(extent.supports.size(), 2u);
  ASSERT_EQ(extent.supports[0].places.size(), 5u) << "its path ends where it is let go";
  for (int k = 0; k < 5; ++k) EXPECT_NEAR(extent.supports[0].places[k][0], turn(0.125 * k)[0], 1e-12);
  ASSERT_TRUE(extent.supports[0].pivot);
  EXPECT_NEAR((*extent.supports[0].pivot)[0], -1.0, 1e-9);
  EXPECT_EQ(extent.supports[1].places.size(), 1u);
}

TEST(PivotTest, OnlyPlacesOnACircleHaveOne) {
  const auto along = [](const auto& place) {
    std::vector<Vector3> places;
    for (int k = 0; k < 9; ++k) places.push_back(place(0.3 * k));
    return places;
  };
  const auto circle = along([](double u) {
    return Vector3{5 + 2 * std::cos(u), 1 + 1.2 * std::sin(u), -1.6 * std::sin(u)};
  });
  const std::optional<Vector3> pivot = find_pivot(circle, 3.0);
  ASSERT_TRUE(pivot);
  EXPECT_NEAR((*pivot)[0], 5.0, 1e-12);
  EXPECT_NEAR((*pivot)[1], 1.0, 1e-12);
  EXPECT_NEAR((*pivot)[2], 0.0, 1e-12);
  EXPECT_FALSE(find_pivot(circle, 1.9)) << "too large to draw";
  EXPECT_FALSE(find_pivot(std::span(circle).first(4), 3.0));
  EXPECT_FALSE(find_pivot(along([](double u) { return Vector3{u, 2 * u, 0}; }), 1e9));
  EXPECT_FALSE(find_pivot(along([](double u) { return Vector3{u, u * u, 0}; }), 1e9));
  EXPECT_FALSE(find_pivot(along([](double u) { return Vector3{std::cos(u), std::sin(u), 0.1 * u}; }), 1e9));
  EXPECT_FALSE(find_pivot(along([](double u) { return Vector3{std::cos(u), 0.9 * std::sin(u), 0}; }), 1e9));
}

/// Its coil stands out of the plane in which its ends move, and pictures look at that plane.
TEST(MotionExtentTest, ASpringLeavesAMotionInItsPlane) {
  StoredFrame frame;
  frame.positions = {0, 0, 0, 1, 0, 2};
  frame.is_support = {false, false};
  frame.guides = {{"spring", "coil[0]", {0, 0, 1}}};
  EXPECT_GT(std::abs(find_course(frame.guides[0], frame.positions)[1][1]), 0.05);
  const MotionExtent extent = measure_motion({frame});
  EXPECT_EQ(extent.least, (Vector3{0, 0, 0}));
  EXPECT_EQ(extent.most, (Vector3{1, 0, 2}));
}

/// A frame has the cell of a sample that is periodic in all directions, and a picture has room for all of it.
TEST(MotionExtentTest, ACellIsSeenAsAWhole) {
  System system;
  system.positions = {0.2, 0.2, 0.2, 0.7, 0.7, 0.7};
  system.masses = {1.0, 1.0};
  const ShownParts shown = choose_parts(system, {});
  EXPECT_TRUE(list_guides(system, shown, {}, 0.0, 0.0).empty());
  system.cell = Cell{.xx = 2.0, .yy = 1.0, .zz = 1.0, .xy = 0.5, .origin = {-1, 0, 0}};
  StoredFrame frame;
  frame.positions = system.positions;
  frame.is_support = {false, false};
  frame.guides = list_guides(system, shown, {}, 0.0, 0.0);
  ASSERT_EQ(frame.guides.size(), 1u);
  const std::vector<Vector3> ends = find_edges(frame.guides[0]);
  EXPECT_EQ(ends.size(), 24u);
  EXPECT_EQ(ends.front(), (Vector3{-1, 0, 0}));
  EXPECT_EQ(ends.back(), (Vector3{1.5, 1, 1}));
  for (std::size_t k = 0; k < ends.size(); k += 2) EXPECT_NE(ends[k], ends[k + 1]);

  const MotionExtent extent = measure_motion({frame});
  EXPECT_EQ(extent.least, (Vector3{-1, 0, 0}));
  EXPECT_EQ(extent.most, (Vector3{1.5, 1, 1}));
  frame.guides[0].numbers = {-100, 0, 0, 200, 0, 0, 0, 200, 0, 0, 0, 200};
  EXPECT_EQ(measure_motion({frame}).least[0], 0.2) << "a motion in a small part of it fills the picture";
}

}  // namespace
}  // namespace tanor::report
