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

namespace tanor {
namespace {

MotionOptions corner_options(Method method) {
  MotionOptions options{.method = method};
  if (has_fixed_steps(method))
    options.step = 2e-3;
  else
    options.rtol = options.atol = 1e-12;
  return options;
}

std::vector<Method> list_all_methods() {
  return with_auto(list_methods_that([](const MethodTraits&) { return true; }));
}

/// Returns how far a method of fixed steps may be off.
double allowed(Method method, double fixed = 1e-4) {
  return has_fixed_steps(method) ? fixed : 1e-9;
}

/// Returns a bead of 1 kg at rest on the wire z = |x| in the plane y = 0, 1 m beside its corner, under g = 10 m/s^2.
System make_bead_on_v(const std::string& equation = "z1-abs(x1)") {
  System system;
  system.positions = {1.0, 0.0, 1.0};
  system.velocities = {0.0, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Planes{.name = "sheet", .points = {0}, .normal = Vector3{0.0, 1.0, 0.0}, .offset = 0.0},
                        UserConstraints{.name = "wire", .tuples = {{0}}, .kernel = formula_constraint(equation, 1)}};
  system.forces = {Gravity{"", {0.0, 0.0, -10.0}}};
  return system;
}

/// The bead's x: from a turning point at distance 1 down to the corner, up the other side, and so on.
double x_of_bead(double t) {
  const double quarter = std::sqrt(2.0 * std::sqrt(2.0) / (10.0 / std::sqrt(2.0)));
  const double turns = std::floor(0.5 * (t / quarter + 1.0));
  const double since = t - 2.0 * quarter * turns;
  return std::cos(M_PI * turns) * (1.0 - 2.5 * since * since);
}

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

/// Returns the plane x + z = c |t - 0.5| + 0.4 with a rod to another point, as in a scene that was reported.
System make_plane_with_corner(const std::string& offset) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 0.6, 0.0, 0.0};
  system.velocities = {0.11538461538461539, 0.0, 0.0, 0.11538461538461539, 0.0, -0.5153846153846153};
  system.masses = {1.0, 1.0};
  system.constraints = {
      Planes{
          .name = "plane", .points = {1}, .normal = Vector3{1.0, 0.0, 1.0}, .offset = ScalarFunction::formula(offset)},
      Rods{.name = "rod", .pairs = {{0, 1}}, .length = 0.6, .offsets = {}}};
  system.forces = {Gravity{"", {0.0, 0.0, -10.0}}};
  return system;
}

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

// ---- what is refused ----

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
  EXPECT_NE(certificate.line().find("xi(r + s v + s^2/2 w) = 0"), std::string::npos) << certificate.line();
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
