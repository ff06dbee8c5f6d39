/// Rest in a frame that turns or accelerates has closed forms, and agrees with the dense dynamics in the frame at rest.
/// What is not steady in any such frame is refused by name.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>
#include <tanor/user_kernel.hpp>

namespace tanor {
namespace {

constexpr double gravity = 10.0;

/// Makes a bead on a hoop of 1 m that turns with `spin` about the vertical through its centre.
System make_hoop(double spin, const Vector3& start) {
  System system;
  system.positions = {start[0], start[1], start[2]};
  system.masses = {1.7};
  Circles hoop{.name = "hoop", .points = {0}, .center = Vector3{}, .normal = {}, .radius = 1.0};
  const Constants constants{{"w", spin}};
  hoop.normal = {ScalarFunction::formula("-sin(w*t)", constants), ScalarFunction::formula("cos(w*t)", constants), 0.0};
  system.constraints = {hoop};
  system.add_gravity({0.0, 0.0, -gravity});
  return system;
}

/// Returns the message of a refusal, or how the equilibrium is.
std::string answer(const System& system, const EquilibriumOptions& options = {}) {
  try {
    const EquilibriumResult found = find_equilibrium(system, options);
    return found.outcome.ok() ? "found" : found.outcome.what;
  } catch (const InputError& error) {
    return std::string(error.what());
  }
}

void expect_refusal(const System& system, const std::string& part) {
  const std::string said = answer(system);
  EXPECT_NE(said.find(part), std::string::npos) << said;
  EXPECT_NE(said.find("freeze"), std::string::npos) << said;
  EXPECT_THROW((void)modes(system, system.positions), InputError) << said;
}

// ---- closed forms ------------------------------------------------------------------------------------------------

/// omega^2 - g/R = 15.
TEST(RotatingHoop, BottomIsUnstable) {
  const System hoop = make_hoop(5.0, {0.0, 0.0, -1.0});

  const EquilibriumResult found =
      find_equilibrium(hoop, {.method = EquilibriumMethod::Newton, .accept = AcceptedEquilibria::Any});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.stability.status, Stability::Unstable);
  EXPECT_EQ(found.stability.unstable_directions, 1u);
  EXPECT_NEAR(found.stability.lowest_omega2, -15.0, 1e-10);
  const Modes growing = modes(hoop, hoop.positions);
  ASSERT_TRUE(growing.outcome.ok()) << growing.outcome.what;
  EXPECT_NEAR(growing.omega[0], -std::sqrt(15.0), 1e-10);
  EXPECT_TRUE(growing.decay.empty());
}

/// cos(theta) = g/(omega^2 R), and omega^2 sin(theta)^2 is the squared frequency about it.
TEST(RotatingHoop, BeadRestsWhereCentrifugalForceBalancesWeight) {
  for (const double at : {0.0, 0.7}) {
    System hoop = make_hoop(5.0, {0.0, 0.0, -1.0});

    const EquilibriumResult found = find_equilibrium(hoop, {.at = at});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable);
    EXPECT_NEAR(found.positions[2], -0.4, 1e-10);
    EXPECT_NEAR(found.stability.lowest_omega2, 25.0 * 0.84, 1e-8);
    // v = Omega x r
    EXPECT_NEAR(found.velocities[0], -5.0 * found.positions[1], 1e-10);
    EXPECT_NEAR(found.velocities[1], 5.0 * found.positions[0], 1e-10);
    const Modes swing = modes(hoop, found.positions, {.time = at});
    ASSERT_TRUE(swing.outcome.ok()) << swing.outcome.what;
    EXPECT_NEAR(swing.omega[0], std::sqrt(25.0 * 0.84), 1e-9);
  }
}

TEST(RotatingHoop, IsFrozenWhereThatIsAskedFor) {
  const System hoop = make_hoop(5.0, {0.3, 0.0, -std::sqrt(0.91)});

  const EquilibriumResult found = find_equilibrium(hoop, {.freeze_time = true});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_NEAR(found.positions[2], -1.0, 1e-10);
  EXPECT_EQ(found.left_out, std::vector<std::string>{"hoop (normal): the motion is frozen at t = 0"});
}

/// A pendulum in a lift that accelerates sideways hangs along g - a.
TEST(AcceleratingSupport, PendulumHangsAlongTheEffectiveGravity) {
  System lift;
  lift.positions = {0.0, 0.0, 0.0, 0.0, 0.0, -2.0};
  lift.masses = {1.0, 3.0};
  lift.supports = {{"lift", {0}, {ScalarFunction::formula("3*t^2+2*t"), 0.0, ScalarFunction::formula("-t^2")}}};
  lift.constraints = {Rods{"rod", {{0, 1}}}};
  lift.add_gravity({0.0, 0.0, -gravity});

  const EquilibriumResult found = find_equilibrium(lift);

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  const double felt = std::hypot(6.0, gravity - 2.0);
  EXPECT_NEAR(found.positions[3], -2.0 * 6.0 / felt, 1e-10);
  EXPECT_NEAR(found.positions[5], -2.0 * (gravity - 2.0) / felt, 1e-10);
  EXPECT_NEAR(found.velocities[3], 2.0, 1e-10);
  const Modes swing = modes(lift, found.positions);
  ASSERT_EQ(swing.count(), 2u);
  for (const double omega : swing.omega) EXPECT_NEAR(omega, std::sqrt(felt / 2.0), 1e-9);
}

TEST(EvenMotion, IsRestAsAnyOther) {
  System cart;
  cart.positions = {0.0, 0.0, 0.0, 0.3, 0.0, -1.0};
  cart.masses = {1.0, 1.0};
  cart.supports = {{"cart", {0}, {ScalarFunction::formula("7*t"), 0.0, 0.0}}};
  cart.constraints = {Rods{"rod", {{0, 1}}, 1.0}};
  cart.add_gravity({0.0, 0.0, -gravity});

  const EquilibriumResult found = find_equilibrium(cart, {.at = 3.0});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_NEAR(found.positions[3], 21.0, 1e-9);
  EXPECT_NEAR(found.positions[5], -1.0, 1e-10);
  EXPECT_NEAR(found.stability.lowest_omega2, gravity, 1e-8);
}

/// A mass on equal springs to a turning support at the axis: in the frame that turns the circular motions of
/// omega_0 = sqrt(k/m) have the frequencies omega_0 - Omega and omega_0 + Omega, and beyond omega_0 the energy falls.
TEST(TurningSprings, HaveTheFrequenciesOfTheFrame) {
  for (const double spin : {1.0, 6.0}) {
    System table;
    const Constants constants{{"w", spin}};
    table.positions = {1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0};
    table.masses.assign(5, 2.0);
    const auto turn = [&](const char* x, const char* y) {
      return VectorFunction(ScalarFunction::formula(x, constants), ScalarFunction::formula(y, constants), 0.0);
    };
    table.supports = {{"", {0}, turn("cos(w*t)-1", "sin(w*t)")},
                      {"", {2}, turn("1-cos(w*t)", "-sin(w*t)")},
                      {"", {3}, turn("-sin(w*t)", "cos(w*t)-1")},
                      {"", {4}, turn("sin(w*t)", "1-cos(w*t)")}};
    Springs springs{.name = "springs", .pairs = {{0, 1}, {1, 2}, {1, 3}, {1, 4}}, .stiffness = 8.0};
    springs.rest_length.constants = {0.0};
    table.forces = {springs};  // omega_0^2 = 32/2
    const double omega_0 = 4.0;

    const EquilibriumResult found =
        find_equilibrium(table, {.method = EquilibriumMethod::Newton, .accept = AcceptedEquilibria::Any});
    const Modes swing = modes(table, table.positions, {.count = ModesOptions::all});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.status, spin < omega_0 ? Stability::Stable : Stability::Marginal);
    EXPECT_EQ(found.stability.unstable_directions, 0u);
    EXPECT_NEAR(found.stability.lowest_omega2, omega_0 * omega_0 - spin * spin, 1e-9);
    ASSERT_TRUE(swing.outcome.ok()) << swing.outcome.what;
    std::vector<double> wanted{std::abs(omega_0 - spin), omega_0, omega_0 + spin};
    std::ranges::sort(wanted);
    ASSERT_EQ(swing.count(), 3u);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(swing.omega[k], wanted[k], 1e-9) << spin;
      EXPECT_EQ(swing.decay[k], 0.0);
    }
  }
}

/// A bead with a spring on a wire that turns leaves at Omega^2 = k/m.
TEST(TurningWire, BeadIsStableUpToTheFrequencyOfItsSpring) {
  for (const double spin : {2.9, 3.1}) {
    System wire;
    const Constants constants{{"w", spin}};
    wire.positions = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    wire.masses = {1.0, 2.0};
    wire.supports = {{"axis", {0}, {}}};
    Lines line{.name = "wire", .points = {1}, .origin = Vector3{}, .direction = {}};
    line.direction = {ScalarFunction::formula("cos(w*t)", constants), ScalarFunction::formula("sin(w*t)", constants),
                      0.0};
    wire.constraints = {line};
    wire.forces = {Potential{
        .name = "spring", .points = {{1, 0}}, .kernel = formula_potential("9*((x1-x2)^2+(y1-y2)^2+(z1-z2)^2)", 2)}};
    wire.add_gravity({0.0, 0.0, -gravity});

    const EquilibriumResult found = find_equilibrium(wire, {.accept = AcceptedEquilibria::Any});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.status, spin < 3.0 ? Stability::Stable : Stability::Unstable);
    EXPECT_NEAR(found.stability.lowest_omega2, 9.0 - spin * spin, 1e-9);
  }
}

/// In a lift that falls freely nothing has weight: its rounding is none, at whatever time.
TEST(FallingLift, HasNoWeight) {
  for (const double at : {0.0, 0.7, 300.0}) {
    System lift;
    lift.positions = {0.0, 0.0, 0.0, 0.3, 0.0, -1.0};
    lift.masses = {1.0, 3.0};
    lift.supports = {{"lift", {0}, {ScalarFunction::formula("0.3*t"), 0.0, ScalarFunction::formula("-4.905*t^2")}}};
    lift.constraints = {Rods{"rod", {{0, 1}}, std::sqrt(1.09)}};
    lift.add_gravity({0.0, 0.0, -9.81});
    lift.positions[3] += 0.3 * at;
    lift.positions[5] -= 4.905 * at * at;

    const EquilibriumResult found = find_equilibrium(lift, {.at = at});
    const Modes swing = modes(lift, lift.positions, {.count = ModesOptions::all, .time = at});

    EXPECT_EQ(found.stability.status, Stability::Marginal) << at << ": " << found.outcome.what;
    EXPECT_EQ(found.stability.zero_modes, 2u) << at;
    EXPECT_EQ(swing.zero_modes, 2u) << at;
    EXPECT_EQ(swing.unstable_directions, 0u) << at;
  }
}

/// k(x - R) = m Omega^2 x in the frame of a well that turns about the origin.
TEST(TurningWell, HoldsABeadFartherOut) {
  for (const double at : {0.0, 1.3}) {
    System system;
    system.positions = {std::cos(2.0 * at), std::sin(2.0 * at), 0.1};
    system.masses = {1.0};
    system.forces = {
        Potential{"well",
                  {{0}},
                  formula_potential("20*(x1*cos(2*t)+y1*sin(2*t)-1)^2+40*(y1*cos(2*t)-x1*sin(2*t))^2+30*z1^2", 1)}};

    const EquilibriumResult found = find_equilibrium(system, {.at = at});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable);
    EXPECT_NEAR(found.positions[0], 40.0 / 36.0 * std::cos(2.0 * at), 1e-10);
    EXPECT_NEAR(found.positions[1], 40.0 / 36.0 * std::sin(2.0 * at), 1e-10);
    EXPECT_NEAR(found.stability.lowest_omega2, 36.0, 1e-8);
  }
}

// ---- refusals ----------------------------------------------------------------------------------------------------

/// Makes a pendulum, to which each of these tests adds what depends on time.
System make_pendulum() {
  System system;
  system.positions = {0.0, 0.0, 0.0, 0.3, 0.0, -1.0};
  system.masses = {1.0, 1.0};
  system.supports = {{"hand", {0}, {}}};
  system.constraints = {Rods{"rope", {{0, 1}}}};
  system.add_gravity({0.0, 0.0, -gravity});
  return system;
}

TEST(UnsteadyTime, IsRefusedByName) {
  System rope = make_pendulum();
  std::get<Rods>(rope.constraints[0]).length = ScalarFunction::formula("1+0.1*t");
  expect_refusal(rope, "rope (length)");

  System hand = make_pendulum();
  hand.supports[0].displacement = {ScalarFunction::formula("0.1*sin(3*t)"), 0.0, 0.0};
  expect_refusal(hand, "hand (motion)");

  System floor = make_pendulum();
  floor.constraints.push_back(Planes{"wall", {1}, Vector3{0.0, 1.0, 0.0}, ScalarFunction::formula("0.1*sin(t)")});
  expect_refusal(floor, "wall (offset)");

  System tilted = make_pendulum();
  tilted.constraints.push_back(Planes{"wall", {1}, {ScalarFunction::formula("sin(t)"), 1.0, 0.0}, 0.0});
  expect_refusal(tilted, "wall (normal)");

  System sum = make_pendulum();
  sum.constraints.push_back(Linears{"sum", {{1}}, {{0.0, 1.0, 0.0}}, ScalarFunction::formula("exp(-t)")});
  expect_refusal(sum, "sum (value)");

  System formula = make_pendulum();
  formula.constraints.push_back(UserConstraints{"track", {{1}}, formula_constraint("y1-0.1*sin(t)*x1", 1)});
  expect_refusal(formula, "track (formula)");

  System push = make_pendulum();
  push.forces.push_back(ConstantForce{"push", {1}, {ScalarFunction::formula("cos(2*t)"), 0.0, 0.0}});
  expect_refusal(push, "push (force)");

  System well = make_pendulum();
  well.forces.push_back(Potential{"well", {{1}}, formula_potential("(x1-sin(t))^2", 1), {}});
  expect_refusal(well, "well");

  System wind = make_pendulum();
  wind.forces.push_back(FormulaForce{"wind", {1}, formula_force({"cos(t)", "0", "0"})});
  expect_refusal(wind, "wind");

  System ball = make_pendulum();
  ball.constraints = {Spheres{"ball", {1}, {ScalarFunction::formula("t^3"), 0.0, 0.0}, 1.0}};
  expect_refusal(ball, "ball (center)");

  System line = make_pendulum();
  line.constraints = {Lines{"slide", {1}, {0.3, ScalarFunction::formula("sin(t)"), 0.0}, Vector3{0.0, 0.0, 1.0}}};
  line.forces.push_back(Springs{.name = "spring", .pairs = {{0, 1}}, .stiffness = 9.0});
  expect_refusal(line, "slide (origin)");

  System table = make_pendulum();
  table.supports[0].displacement = {ScalarFunction::table({0, 1, 2, 3, 4, 5}, {0, 0.1, 0.3, 0.2, 0, 0}), 0.0, 0.0};
  expect_refusal(table, "hand (motion)");
}

TEST(UnsteadyTime, IsRefusedWhereTheFrameTurnsAndSomethingElseDoesNot) {
  System tipped = make_hoop(5.0, {0.0, 0.0, -1.0});
  tipped.forces = {Gravity{"weight", {0.0, 1.0, -gravity}}};
  expect_refusal(tipped, "weight changes with time in the frame which turns with [0, 0, 5]");

  System faster = make_hoop(5.0, {0.0, 0.0, -1.0});
  faster.constraints.push_back(std::get<Circles>(make_hoop(5.1, {0.0, 0.0, -1.0}).constraints[0]));
  std::get<Circles>(faster.constraints[1]).name = "faster";
  expect_refusal(faster, "faster (normal)");

  System quicker = make_hoop(5.0, {0.0, 0.0, -1.0});
  auto& hoop = std::get<Circles>(quicker.constraints[0]);
  hoop.normal = {ScalarFunction::formula("-sin(t^2)"), ScalarFunction::formula("cos(t^2)"), 0.0};
  expect_refusal(quicker, "hoop (normal)");

  System air = make_hoop(5.0, {0.0, 0.0, -1.0});
  air.forces.push_back(Drag{.name = "air", .points = {0}, .linear = 0.1});
  expect_refusal(air, "air acts on what moves");

  System tied = make_hoop(5.0, {0.0, 0.0, -1.0});
  tied.positions.insert(tied.positions.end(), {2.0, 0.0, 0.0});
  tied.masses.push_back(1.0);
  tied.supports = {{"post", {1}, {}}};
  tied.forces.push_back(Springs{.name = "spring", .pairs = {{0, 1}}, .stiffness = 1.0});
  expect_refusal(tied, "hoop (normal)");
}

/// Nothing of these is to be seen at the instants that anybody would look at.
TEST(UnsteadyTime, IsRefusedHoweverShortOrLateOrSmallItIs) {
  const auto along_x = [](const char* text) { return VectorFunction(ScalarFunction::formula(text), 0.0, 0.0); };
  System push = make_pendulum();
  push.forces.push_back(ConstantForce{"push", {1}, along_x("max(0,sin(t)-0.9)")});
  expect_refusal(push, "push (force)");

  for (const char* text : {"0.1*max(0,0.5-abs(t-3))", "0.1*exp(-(t-40)^2)", "1e-30*t^3", "1e-12*sin(t)"}) {
    System hand = make_pendulum();
    hand.supports[0].displacement = along_x(text);
    expect_refusal(hand, "hand (motion)");
  }

  System rope = make_pendulum();
  std::get<Rods>(rope.constraints[0]).length = ScalarFunction::formula("1+5*exp(-(t-40)^2)");
  expect_refusal(rope, "rope (length)");

  for (const std::string angle : {"5*t+max(0,t-10)^2", "5*t+1e-7*t^3", "5*t+1e-9*sin(t)"}) {
    System system = make_hoop(5.0, {0.0, 0.0, -1.0});
    auto& hoop = std::get<Circles>(system.constraints[0]);
    hoop.normal = {ScalarFunction::formula("-sin(" + angle + ")"), ScalarFunction::formula("cos(" + angle + ")"), 0.0};
    expect_refusal(system, "hoop (normal)");
  }

  System nearly = make_hoop(5.0, {0.0, 0.0, -1.0});
  nearly.constraints.push_back(std::get<Circles>(make_hoop(5.0 + 1e-7, {0.0, 0.0, -1.0}).constraints[0]));
  std::get<Circles>(nearly.constraints[1]).name = "faster";
  expect_refusal(nearly, "faster (normal)");

  System table = make_pendulum();
  table.supports[0].displacement = {
      ScalarFunction::table({0, 1, 2, 3, 4, 100, 101, 102, 103}, {0, 0, 0, 0, 0, 0, 1e-6, 0, 0}), 0.0, 0.0};
  expect_refusal(table, "hand (motion)");

  for (const char* text : {"max(0,sin(t)-0.9)", "exp(-(t-40)^2)", "max(0,x-100)*cos(t)", "exp(-(x-50)^2)*t",
                           "x*(1+cos(t))*1e-12", "-vx*cos(t)"}) {
    System wind = make_pendulum();
    wind.forces.push_back(FormulaForce{"wind", {1}, formula_force({text, "0", "0"})});
    expect_refusal(wind, "wind (formula)");
  }
  for (const char* text : {"x1*max(0,sin(t)-0.9)", "max(0,x1-100)^2*t", "(x1-exp(-(t-40)^2))^2"}) {
    System well = make_pendulum();
    well.forces.push_back(Potential{"well", {{1}}, formula_potential(text, 1), {}});
    expect_refusal(well, "well (formula)");
  }
  System track = make_pendulum();
  track.constraints.push_back(UserConstraints{"track", {{1}}, formula_constraint("y1-max(0,x1-9)*sin(t)", 1)});
  expect_refusal(track, "track (formula)");
}

/// A function whose operations are not known could be looked at by its numbers alone, which is not enough.
TEST(UnsteadyTime, IsSuspectedOfWhatIsNotKnown) {
  System hand = make_pendulum();
  hand.supports[0].displacement = {
      ScalarFunction::custom(std::function<Jet<2>(const Jet<2>&)>([](const Jet<2>& t) { return 7.0 * t; })), 0.0, 0.0};
  expect_refusal(hand, "hand (motion)");
  hand.supports[0].displacement = {ScalarFunction::custom([](const auto& t) { return 7.0 * t; }), 0.0, 0.0};
  EXPECT_EQ(answer(hand), "found");

  System wind = make_pendulum();
  ForceKernel kernel = make_force_kernel([]<class T>(const std::array<T, 3>& r, const std::array<T, 3>&, double) {
    return std::array<T, 3>{-r[0], T(0.0), T(0.0)};
  });
  wind.forces.push_back(FormulaForce{"wind", {1}, kernel});
  expect_refusal(wind, "wind is not known to stand still");
  kernel.depends_on_time = false;
  wind.forces.back() = FormulaForce{"wind", {1}, kernel};
  EXPECT_EQ(answer(wind), "found");
}

/// All of this goes along with a frame, whatever the formula looks like.
TEST(SteadyTime, IsSeenThroughItsFormula) {
  System cart = make_pendulum();
  cart.supports[0].displacement = {ScalarFunction::table({-1, 0, 1, 4, 5, 7, 11}, {-2, 0, 2, 8, 10, 14, 22}), 0.0, 0.0};
  cart.forces.push_back(
      Potential{"well", {{1}}, formula_potential("9*(sqrt((x1-2*t)^2+y1^2+1)-1)+m*z1", 1, {{"m", 1.0}})});
  EXPECT_EQ(answer(cart), "found");
  System well = make_pendulum();
  well.forces.push_back(Potential{"well", {{1}}, formula_potential("(x1-0.1)^2+sin(t)", 1), {}});
  EXPECT_EQ(answer(well), "found");

  // A force that pushes outwards, and a track that is a hoop by its equation.
  System hoop = make_hoop(5.0, {0.0, 0.0, -1.0});
  hoop.forces.push_back(
      FormulaForce{"out", {0}, formula_force({"0.1*x/(x^2+y^2+1)^1.5", "0.1*y/(x^2+y^2+1)^1.5", "0"})});
  hoop.constraints = {Spheres{"ball", {0}, Vector3{}, 1.0},
                      UserConstraints{"plane", {{0}}, formula_constraint("x1*sin(5*t)-y1*cos(5*t)", 1)}};
  const EquilibriumResult bottom =
      find_equilibrium(hoop, {.method = EquilibriumMethod::Newton, .accept = AcceptedEquilibria::Any});
  ASSERT_TRUE(bottom.outcome.ok()) << bottom.outcome.what;
  EXPECT_NEAR(bottom.stability.lowest_omega2, -15.0 - 0.1 / 1.7, 1e-9);

  // sin(5 t) and cos(5 t) by half the angle, and a power that is multiplied by 0
  System twice = make_hoop(5.0, {0.0, 0.0, -1.0});
  std::get<Circles>(twice.constraints[0]).normal = {ScalarFunction::formula("-2*sin(2.5*t)*cos(2.5*t)"),
                                                    ScalarFunction::formula("1-2*sin(2.5*t)^2"),
                                                    ScalarFunction::formula("0*t^9")};
  EXPECT_EQ(answer(twice), "found");

  System lift = make_pendulum();
  lift.supports[0].displacement = {0.0, 0.0, ScalarFunction::formula("2*(t-1)*(t+1)-t^2")};
  EXPECT_EQ(answer(lift), "found");
}

/// These functions of time are constant.
TEST(UnsteadyTime, IsNotSeenWhereNothingMoves) {
  System system = make_pendulum();
  system.supports[0].displacement = {ScalarFunction::formula("0.2+0*t"), 0.0, 0.0};
  system.forces.push_back(ConstantForce{"push", {1}, {ScalarFunction::formula("3+0*t"), 0.0, 0.0}});
  system.forces.push_back(FormulaForce{"wind", {1}, formula_force({"-x", "0", "0"})});
  system.forces.push_back(
      ConstantForce{"pull", {1}, {ScalarFunction::table({0, 0.1, 0.3, 0.7}, {0.3, 0.3, 0.3, 0.3}), 0.0, 0.0}});

  EXPECT_EQ(answer(system), "found");
}

}  // namespace
}  // namespace tanor
