/// \file Guides with corners: on one that is rounded ever more sharply the velocity turns into the other branch.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <tanor/tanor.hpp>

#include "errors.hpp"
#include "methods.hpp"
#include "motion/corner_program.hpp"
#include "motion/corner_scenes.hpp"

namespace tanor {
namespace {

TEST(Corners, TurnTheVelocityOfABeadIntoTheOtherBranch) {
  EXPECT_NEAR(x_of_bead(1.5), -0.861833, 1e-6);
  for (const std::string equation :
       {"z1-abs(x1)", "z1-max(x1,-x1)", "z1+min(x1,-x1)", "z1-sqrt(x1^2)", "z1-sqrt(x1*x1)", "z1-0.5*abs(2*x1)",
        "abs(x1)-z1", "z1-(x1^2)^0.5", "z1-(x1*(-x1)*-1)^0.5", "z1-sqrt(sqrt(x1^4))", "z1-(9*x1^4)^0.25/sqrt(3)",
        "z1-x1*sin(atan2(x1,0))", "z1-x1*2/pi*atan2(x1,0)", "z1-exp(0.5*log(x1^2))"}) {
    for (const Method method : list_all_methods()) {
      Simulation simulation(make_bead_on_v(equation), corner_options(method));

      const Outcome outcome = simulation.advance_to(1.5);

      ASSERT_TRUE(outcome.ok()) << equation << ", " << name_of(method) << ": " << outcome.what;
      EXPECT_NEAR(simulation.positions()[0], x_of_bead(1.5), allowed(method)) << equation << ", " << name_of(method);
      EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), allowed(method)) << name_of(method);
      EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
      EXPECT_EQ(simulation.report().events, 1u) << name_of(method);
    }
  }
}

/// The derivatives of a callable's root may be missing, or wrong, exactly in the corner.
TEST(Corners, OfRootsInCallablesAreTurnedAsWell) {
  for (const Method method : with_auto(list_adaptive_methods())) {
    for (const bool has_coordinates : {false, true}) {
      if (has_coordinates && method != Method::Dop853 && method != Method::Dopri5) continue;
      System system = make_bead_on_v();
      if (has_coordinates) {
        system.constraints.clear();
        system.coordinates = {UserCoordinates{.name = "slide",
                                              .tuples = {{0}},
                                              .kernel = make_coordinate_kernel<1, 1>([](const auto& q, const auto&) {
                                                using std::sqrt;
                                                return std::array{q[0], 0.0 * q[0], sqrt((q[0] + 0.0) * (q[0] + 0.0))};
                                              }),
                                              .q = {1.0}}};
      } else {
        system.constraints[1] = UserConstraints{
            .name = "wire", .tuples = {{0}}, .kernel = make_constraint_kernel<1>([](const auto& r, const auto&) {
                                               using std::sqrt;
                                               return r[2] - sqrt((r[0] + 0.0) * (r[0] + 0.0));
                                             })};
      }
      Simulation simulation(system, corner_options(method));
      ASSERT_TRUE(simulation.advance_to(1.5).ok()) << name_of(method) << ": " << simulation.outcome().what;
      EXPECT_NEAR(simulation.positions()[0], x_of_bead(1.5), 1e-9) << name_of(method) << has_coordinates;
    }
  }
}

/// Both numbers are the same on one side.
TEST(Corners, OfMaximaThatAreEqualOnOneSideAreTurnedAsWell) {
  for (const Method method : with_auto(list_adaptive_methods())) {
    Simulation simulation(make_bead_on_v("z1-max(abs(x1),x1)"), corner_options(method));
    ASSERT_TRUE(simulation.advance_to(1.5).ok()) << name_of(method) << ": " << simulation.outcome().what;
    EXPECT_NEAR(simulation.positions()[0], x_of_bead(1.5), 1e-9) << name_of(method);
  }
}

/// A certificate looks at places around the state, which must not lie beyond the corner.
TEST(Corners, AreNoMatterToCertificatesRightBesideThem) {
  for (const bool has_coordinates : {false, true}) {
    System system = make_bead_on_v();
    if (has_coordinates) {
      system.constraints.clear();
      system.coordinates = {UserCoordinates{
          .name = "slide",
          .tuples = {{0}},
          .kernel = formula_coordinates(std::vector<std::string>{"a"}, std::vector<std::string>{"a", "0", "abs(a)"}),
          .q = {1.0}}};
    }
    const double met = std::sqrt(0.4);
    for (const double t :
         {met - 1e-2, met - 1e-4, met - 1e-6, met - 1e-9, met + 1e-9, met + 1e-6, met + 1e-4, met + 1e-2}) {
      Simulation simulation(system, corner_options(Method::Dop853));
      ASSERT_TRUE(simulation.advance_to(t).ok()) << simulation.outcome().what;
      EXPECT_TRUE(simulation.certify().passed()) << t - met << ": " << simulation.certify().line();
    }
  }
}

TEST(Corners, ArePassedManyTimesAtTheSameHeight) {
  for (const Method method : with_auto(list_adaptive_methods())) {
    Simulation simulation(make_bead_on_v(), corner_options(method));
    for (const double t : {0.5, 2.0, 5.0, 11.3, 20.0}) {
      ASSERT_TRUE(simulation.advance_to(t).ok()) << name_of(method) << ": " << simulation.outcome().what;
      EXPECT_NEAR(simulation.positions()[0], x_of_bead(t), 1e-8) << name_of(method) << " at " << t;
    }
    EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-9) << name_of(method);
  }
}

/// The corner is met at 0.632455… s, and an advance may end there or right beside it.
TEST(Corners, MayBeMetWhereAnAdvanceEnds) {
  const double met = std::sqrt(0.4);
  for (const Method method : list_all_methods()) {
    for (const double at : {met, std::nextafter(met, 0.0), std::nextafter(met, 1.0), met - 1e-12, met + 1e-12}) {
      Simulation simulation(make_bead_on_v(), corner_options(method));
      ASSERT_TRUE(simulation.advance_to(at).ok()) << name_of(method) << ": " << simulation.outcome().what;
      EXPECT_NEAR(std::hypot(simulation.velocities()[0], simulation.velocities()[2]), std::sqrt(20.0), allowed(method));
      EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();

      ASSERT_TRUE(simulation.advance_to(1.5).ok()) << name_of(method) << ": " << simulation.outcome().what;
      // An end right beside the corner leaves tiny steps, and radau5 divides the rounding of positions by their length.
      const double off = method == Method::Radau5 ? 1e-7 : allowed(method);
      EXPECT_NEAR(simulation.positions()[0], x_of_bead(1.5), off) << name_of(method);
    }
  }
}

TEST(Corners, TurnAMotionThatBeginsThere) {
  for (const Method method : list_all_methods()) {
    System system = make_bead_on_v();
    system.positions = {0.0, 0.0, 0.0};
    system.velocities = {-std::sqrt(10.0), 0.0, -std::sqrt(10.0)};  // along the right branch, beyond its end
    Simulation simulation(system, corner_options(method));

    ASSERT_TRUE(simulation.advance_to(0.3).ok()) << name_of(method) << ": " << simulation.outcome().what;

    const double since = std::sqrt(0.4) - 0.3;
    EXPECT_NEAR(simulation.positions()[0], -(1.0 - 2.5 * since * since), allowed(method)) << name_of(method);
  }
}

TEST(Corners, ChooseTheBranchThatAStartLeadsTo) {
  for (const StartMode mode : {StartMode::Check, StartMode::Project}) {
    System system = make_bead_on_v();
    system.positions = {0.0, 0.0, 0.0};
    system.velocities = {-std::sqrt(10.0), 0.0, std::sqrt(10.0)};  // up the left branch
    Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-12, .atol = 1e-12, .start = mode});

    ASSERT_TRUE(simulation.advance_to(0.3).ok()) << simulation.outcome().what;

    const double since = std::sqrt(0.4) - 0.3;
    EXPECT_NEAR(simulation.positions()[0], -(1.0 - 2.5 * since * since), 1e-9);
  }
}

TEST(Corners, AreNoMatterToABeadThatTurnsBackBefore) {
  for (const Method method : list_all_methods()) {
    System system = make_bead_on_v("z1+abs(x1)");  // a roof
    system.positions = {1.0, 0.0, -1.0};
    const double speed = std::sqrt(10.0) - 1e-3;  // along each axis; sqrt(10) would lead to its ridge
    system.velocities = {-speed, 0.0, speed};
    Simulation simulation(system, corner_options(method));

    ASSERT_TRUE(simulation.advance_to(1.0).ok()) << name_of(method) << ": " << simulation.outcome().what;

    EXPECT_NEAR(simulation.positions()[0], 1.0 - speed + 2.5, allowed(method)) << name_of(method);
  }
}

TEST(Corners, OfCoordinatesKeepTheEnergyAsWell) {
  for (const auto& [x, z] : std::vector<std::pair<std::string, std::string>>{{"a", "abs(a)"},
                                                                             {"2*a", "2*abs(a)"},
                                                                             {"max(a,2*a)", "abs(max(a,2*a))"},
                                                                             {"min(a,3*a)", "sqrt(min(a,3*a)^2)"},
                                                                             {"a", "sqrt(a*a)"},
                                                                             {"a", "(4*a^2)^0.5/2"}}) {
    for (const Method method : list_all_methods()) {
      if (method == Method::Rattle) continue;
      System system;
      system.positions = {1.0, 0.0, 1.0};
      system.velocities = {0.0, 0.0, 0.0};
      system.masses = {1.0};
      const double start = x == "2*a" || x == "max(a,2*a)" ? 0.5 : 1.0;
      system.coordinates = {UserCoordinates{
          .name = "slide",
          .tuples = {{0}},
          .kernel = formula_coordinates(std::vector<std::string>{"a"}, std::vector<std::string>{x, "0", z}),
          .q = {start}}};
      system.forces = {Gravity{"", {0.0, 0.0, -10.0}}};
      std::string refusal;
      try {
        Simulation simulation(system, corner_options(method));
        const Outcome outcome = simulation.advance_to(1.5);
        ASSERT_TRUE(outcome.ok()) << x << ", " << name_of(method) << ": " << outcome.what;
        EXPECT_NEAR(simulation.positions()[0], x_of_bead(1.5), allowed(method)) << x << ", " << name_of(method);
        EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), allowed(method)) << name_of(method);
        EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
      } catch (const InputError& error) {  // methods that have no coordinates say so
        refusal = error.what();
        EXPECT_FALSE(refusal.empty());
      }
    }
  }
}

/// Two beads on a rod, one of them on the rounded wire z = sqrt(x^2 + w^2) in a plane. The distance to the motion on
/// the sharp wire falls in proportion to w.
TEST(Corners, AreTheLimitOfRoundedOnes) {
  const auto run = [](const std::string& equation) {
    System system = make_bead_on_v(equation);
    system.positions = {0.6, 0.0, 0.6, 0.6, 0.3, 1.0};
    system.velocities.assign(6, 0.0);
    system.masses = {1.0, 0.7};
    system.constraints.emplace_back(Rods{.name = "rod", .pairs = {{0, 1}}, .length = {}, .offsets = {}});
    Simulation simulation(system,
                          {.method = Method::Dopri5, .rtol = 1e-11, .atol = 1e-11, .start = StartMode::Project});
    EXPECT_TRUE(simulation.advance_to(0.8).ok()) << simulation.outcome().what;
    return std::vector<double>(simulation.positions().begin(), simulation.positions().end());
  };
  const std::vector<double> sharp = run("z1-abs(x1)");
  EXPECT_LT(sharp[0], 0.0);
  double last = 1.0;
  for (const std::string width : {"1e-3", "1e-4", "1e-5"}) {
    const std::vector<double> rounded = run("z1-sqrt(x1^2+" + width + "^2)");
    double distance = 0.0;
    for (std::size_t i = 0; i < sharp.size(); ++i) distance = std::max(distance, std::abs(sharp[i] - rounded[i]));
    EXPECT_LT(distance, 0.3 * last) << width;
    last = distance;
  }
  EXPECT_LT(last, 1e-4);
}

// ---- corners in time ----

TEST(Corners, InTimeMoveThePlaneAtOnce) {
  using namespace corner_program;
  DenseMotion truth;
  truth.masses = Vector::Ones(6);
  truth.guides = {{1, Vector3d(1.0, 0.0, 1.0), 0.4, {{0.4, Vector3d::Zero(), 0.5}}}};
  truth.rods = {{0, 1, 0.6, {}}};
  const System given = make_plane_with_corner("0.6+0.4*abs(t-0.5)-0.2");
  truth.r = Eigen::Map<const Vector>(given.positions.data(), 6);
  truth.v = Eigen::Map<const Vector>(given.velocities.data(), 6);
  truth.advance(1.0, 1e-3);
  ASSERT_EQ(truth.corners, 1u);
  for (const std::string offset :
       {"0.6+0.4*abs(t-0.5)-0.2", "0.4+0.4*abs(0.5-t)", "0.4+0.4*max(t-0.5,0.5-t)", "0.4-min(0.4*(t-0.5),0.2-0.4*t)",
        "0.4+0.4*sqrt((t-0.5)^2)", "0.4+0.4*sqrt((t-0.5)*(t-0.5))", "0.4+0.4*((0.5-t)^2)^0.5"}) {
    for (const Method method : list_all_methods()) {
      MotionOptions options = corner_options(method);
      options.start = StartMode::Project;
      Simulation simulation(make_plane_with_corner(offset), options);

      const Outcome outcome = simulation.advance_to(1.0);

      ASSERT_TRUE(outcome.ok()) << offset << ", " << name_of(method) << ": " << outcome.what;
      for (Eigen::Index i = 0; i < 6; ++i) {
        const double r = simulation.positions()[static_cast<std::size_t>(i)];
        EXPECT_NEAR(r, truth.r[i], allowed(method)) << offset << ", " << name_of(method);
      }
      EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
      EXPECT_TRUE(simulation.report().accuracy_warning.empty()) << simulation.report().accuracy_warning;
      EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), allowed(method)) << name_of(method);
      EXPECT_EQ(simulation.report().events, 1u) << name_of(method);
      EXPECT_NEAR(simulation.report().last_event, 0.5, 1e-12);
    }
  }
}

/// A point on a rod of 1 m whose support, or whose length, begins to move at once.
TEST(Corners, InTimeOfSupportsAndLengthsPushAtOnce) {
  for (const Method method : list_all_methods()) {
    for (const bool moves_support : {true, false}) {
      System system;
      system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0};
      system.velocities.assign(6, 0.0);
      system.masses = {1.0, 1.0};
      const ScalarFunction pull = ScalarFunction::formula("max(0, 0.3*(t-0.25))");
      system.supports = {Support{.points = {0}}};
      if (moves_support) system.supports[0].displacement = VectorFunction(pull, 0.0, 0.0);
      Rods rods{.name = "rod", .pairs = {{0, 1}}, .length = 1.0, .offsets = {}};
      if (!moves_support) rods.length = ScalarFunction::formula("1+max(0, 0.3*(t-0.25))");
      system.constraints = {rods};
      Simulation simulation(system, corner_options(method));

      ASSERT_TRUE(simulation.advance_to(1.0).ok()) << name_of(method) << ": " << simulation.outcome().what;

      EXPECT_NEAR(simulation.positions()[3], 1.0 + 0.3 * 0.75, 1e-10) << name_of(method);
      EXPECT_NEAR(simulation.velocities()[3], 0.3, 1e-10) << name_of(method);
      EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-9) << name_of(method);
    }
  }
}

}  // namespace
}  // namespace tanor
