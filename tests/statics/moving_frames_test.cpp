/// Rest in a frame that turns or accelerates has closed forms, and agrees with the dense dynamics in the frame at rest.
/// What is not steady in any such frame is refused by name.

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>
#include <tanor/user_kernel.hpp>

#include "dense.hpp"
#include "reference.hpp"

namespace tanor {
namespace {

using Eigen::MatrixXd, Eigen::Vector3d, Eigen::VectorXd;

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
  expect_refusal(tipped, "weight changes with time in the frame which turns with [0, 0, 5] rad/s");

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

/// These functions of time are constant.
TEST(UnsteadyTime, IsNotSeenWhereNothingMoves) {
  System system = make_pendulum();
  system.supports[0].displacement = {ScalarFunction::formula("0.2+0*t"), 0.0, 0.0};
  system.forces.push_back(ConstantForce{"push", {1}, {ScalarFunction::formula("3+0*t"), 0.0, 0.0}});
  system.forces.push_back(FormulaForce{"wind", {1}, formula_force({"-x", "0", "0"})});

  EXPECT_EQ(answer(system), "found");
}

// ---- random scenes -----------------------------------------------------------------------------------------------

/// A steady motion x -> axis point + R(spin t) (x - axis point) + velocity t + acceleration t^2/2, with the velocity
/// and the acceleration along the axis if it turns.
struct Motion {
  Vector3d axis, point, velocity, acceleration;
  double spin;

  /// Returns one component of what carries x along; without shifts for directions.
  ScalarFunction component(const Vector3d& x, int i, bool is_direction) const {
    const Vector3d arm = is_direction ? x : Vector3d(x - point), along = axis.dot(arm) * axis, out = arm - along,
                   side = axis.cross(out);
    const double still = along[i] + (is_direction ? 0.0 : point[i]), c = out[i], s = side[i], w = spin,
                 v = is_direction ? 0.0 : velocity[i], a = is_direction ? 0.0 : acceleration[i];
    return ScalarFunction::custom(
        [=](const auto& t) { return still + c * cos(w * t) + s * sin(w * t) + v * t + 0.5 * a * t * t; });
  }
  VectorFunction place(const Vector3d& x) const {
    return {component(x, 0, false), component(x, 1, false), component(x, 2, false)};
  }
  VectorFunction direction(const Vector3d& x) const {
    return {component(x, 0, true), component(x, 1, true), component(x, 2, true)};
  }
  VectorFunction displacement(const Vector3d& x) const {
    VectorFunction result = place(x);
    for (int i = 0; i < 3; ++i) {
      const ScalarFunction moved = result.components[static_cast<std::size_t>(i)];
      result.components[static_cast<std::size_t>(i)] =
          ScalarFunction::custom(std::function<Jet<2>(const Jet<2>&)>([moved, x0 = x[i]](const Jet<2>& t) {
            Jet<2> value = moved(t.value());
            value.c[0] -= x0;
            return value;
          }));
    }
    return result;
  }
};

/// Draws beads on guides, pendulums and springs that all turn or accelerate together.
class RandomFrame {
 public:
  explicit RandomFrame(unsigned seed) : random_(seed) {
    motion.axis = vector().normalized();
    motion.point = vector();
    motion.spin = draw(0.0, 1.0) < 0.75 ? draw(0.3, 3.0) : 0.0;
    motion.velocity = motion.acceleration = Vector3d::Zero();
    if (draw(0.0, 1.0) < 0.5) motion.velocity = motion.spin > 0.0 ? Vector3d(vector()[0] * motion.axis) : vector();
    if (draw(0.0, 1.0) < 0.5)
      motion.acceleration = motion.spin > 0.0 ? Vector3d(2.0 * vector()[0] * motion.axis) : vector();
    at = draw(0.0, 2.0);
    const Vector3d weight = motion.spin > 0.0 ? Vector3d(10.0 * motion.axis) : Vector3d(5.0 * vector());
    system.add_gravity({weight[0], weight[1], weight[2]});
    const int beads = 1 + static_cast<int>(draw(0.0, 3.0));
    for (int k = 0; k < beads; ++k) add_bead();
  }

  Motion motion;
  System system;
  double at = 0.0;

 private:
  double draw(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vector3d vector() { return {draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0)}; }
  Index add(const Vector3d& x) {
    system.positions.insert(system.positions.end(), {x[0], x[1], x[2]});
    system.masses.push_back(draw(0.5, 2.0));
    return static_cast<Index>(system.masses.size() - 1);
  }
  Index add_support() {
    const Vector3d x = motion.point + 1.5 * vector();
    const Index point = add(x);
    system.supports.push_back({"", {point}, motion.displacement(x)});
    return point;
  }
  void add_spring(Index i, Index j) {
    Springs springs{.pairs = {{i, j}}, .stiffness = draw(60.0, 200.0)};
    springs.rest_length.constants = {draw(0.2, 1.0)};
    system.forces.push_back(springs);
  }
  void add_bead() {
    const Vector3d centre = motion.point + 1.5 * vector(), normal = vector();
    const Index bead = add(centre + 0.8 * vector());
    switch (static_cast<int>(draw(0.0, 5.0))) {
      case 0:
        system.constraints.push_back(Circles{
            .points = {bead}, .center = motion.place(centre), .normal = motion.direction(normal), .radius = 0.8});
        return;
      case 1:
        system.constraints.push_back(Spheres{.points = {bead}, .center = motion.place(centre), .radius = 0.8});
        return;
      case 2:
        system.constraints.push_back(
            Lines{.points = {bead}, .origin = motion.place(centre), .direction = motion.direction(normal)});
        break;
      case 3: {
        Rods rods{.pairs = {{add_support(), bead}}, .length = 0.9};
        if (draw(0.0, 1.0) < 0.5) rods.pairs.push_back({bead, add(centre + vector())});
        system.constraints.push_back(rods);
        return;
      }
      default:
        break;
    }
    for (int k = 0; k < 3; ++k) add_spring(add_support(), bead);
  }

  std::mt19937 random_;
};

/// Accelerations beside the frame at the time t0, dense: w(r, v) - a - 2 Omega x v_rel, where a is that of the frame.
struct DenseFrame {
  const RandomFrame& scene;

  Vector3d spin() const { return scene.motion.spin * scene.motion.axis; }
  Vector3d place_velocity(const Vector3d& x) const {
    return spin().cross(x - axis_point()) + scene.motion.velocity + scene.at * scene.motion.acceleration;
  }
  Vector3d axis_point() const { return scene.motion.point; }
  Vector3d place_acceleration(const Vector3d& x) const {
    return spin().cross(spin().cross(x - axis_point())) + scene.motion.acceleration;
  }
  /// `r` and `relative` are [3n].
  VectorXd relative_acceleration(const std::vector<double>& r, const VectorXd& relative) const {
    std::vector<double> v(r.size());
    for (Index i = 0; i < static_cast<Index>(r.size() / 3); ++i) {
      const Vector3d own = place_velocity(reference::point(r, i)) + relative.segment<3>(3 * i);
      std::copy_n(own.data(), 3, v.data() + 3 * i);
    }
    const reference::Mechanics mechanics = reference::make_mechanics(scene.system, scene.at, r, v);
    VectorXd w = reference::solve_kkt(mechanics).w;
    for (Eigen::Index k = 0; k < w.size(); k += 3) {
      const auto point = static_cast<Index>(mechanics.coordinates[static_cast<std::size_t>(k)] / 3);
      w.segment<3>(k) -=
          place_acceleration(reference::point(r, point)) + 2.0 * spin().cross(Vector3d(relative.segment<3>(3 * point)));
    }
    return w;
  }
};

/// Returns the largest misfit of (lambda^2 + B lambda + A) s = 0 over all modes, with A and B by differences of the
/// dense accelerations along the moves Z that the constraints allow.
double misfit_of_modes(const DenseFrame& dense, const std::vector<double>& r, const Modes& found) {
  const std::vector<double> at_rest(r.size(), 0.0);
  const reference::Mechanics mechanics = reference::make_mechanics(dense.scene.system, dense.scene.at, r, at_rest);
  const VectorXd root = mechanics.M.cwiseSqrt();
  const MatrixXd scaled = root.cwiseInverse().asDiagonal() * mechanics.K;
  const MatrixXd basis = reference::orthonormal_basis(scaled).rightCols(root.size() - mechanics.K.cols());
  const MatrixXd Z = root.cwiseInverse().asDiagonal() * basis;
  const auto differentiate = [&](const auto& evaluate) {
    constexpr double h = 1e-3;
    return VectorXd((8.0 * (evaluate(h) - evaluate(-h)) - (evaluate(2 * h) - evaluate(-2 * h))) / (12.0 * h));
  };
  MatrixXd A(Z.cols(), Z.cols()), B(Z.cols(), Z.cols());
  for (Eigen::Index j = 0; j < Z.cols(); ++j) {
    VectorXd move = VectorXd::Zero(static_cast<Eigen::Index>(r.size()));
    for (Eigen::Index k = 0; k < Z.rows(); ++k) move[mechanics.coordinates[static_cast<std::size_t>(k)]] = Z(k, j);
    const auto project = [&](const VectorXd& w) { return VectorXd(-Z.transpose() * mechanics.M.cwiseProduct(w)); };
    A.col(j) = differentiate([&](double h) {
      std::vector<double> moved = r;
      for (std::size_t i = 0; i < r.size(); ++i) moved[i] += h * move[static_cast<Eigen::Index>(i)];
      return project(dense.relative_acceleration(moved, VectorXd::Zero(move.size())));
    });
    B.col(j) = differentiate([&](double h) { return project(dense.relative_acceleration(r, h * move)); });
  }
  double worst = 0.0;
  for (std::size_t k = 0; k < found.count(); ++k) {
    const bool has_rates = !found.decay.empty();
    const std::complex<double> lambda = has_rates               ? std::complex<double>(-found.decay[k], found.omega[k])
                                        : found.omega[k] >= 0.0 ? std::complex<double>(0.0, found.omega[k])
                                                                : std::complex<double>(-found.omega[k], 0.0);
    Eigen::VectorXcd q(Z.rows());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const auto at = k * r.size() + static_cast<std::size_t>(mechanics.coordinates[static_cast<std::size_t>(i)]);
      q[i] = {found.shapes[at], has_rates ? found.shapes_imaginary[at] : 0.0};
    }
    const Eigen::VectorXcd s = Z.transpose() * mechanics.M.cwiseProduct(q.real()) +
                               std::complex<double>(0.0, 1.0) * (Z.transpose() * mechanics.M.cwiseProduct(q.imag()));
    const Eigen::VectorXcd rest = lambda * lambda * s + lambda * (B * s) + A * s;
    worst = std::max(worst, rest.norm() / (1.0 + A.norm()));
  }
  return worst;
}

/// The frame's accelerations at rest are those that the dense equations of motion have at the positions and velocities
/// found, and the vibrations are theirs too.
TEST(RandomFrames, RestAndVibrateAsTheDenseDynamicsSays) {
  constexpr int scenes = 300;
  int found_of = 0, stable = 0, with_rates = 0;
  for (unsigned seed = 0; seed < scenes; ++seed) {
    const RandomFrame scene(seed + 1);
    const EquilibriumResult found =
        find_equilibrium(scene.system, {.accept = AcceptedEquilibria::Any, .at = scene.at, .solver = {.threads = 1}});
    if (!found.outcome.ok()) {
      EXPECT_FALSE(found.outcome.what.empty());
      continue;
    }
    ++found_of;
    const DenseFrame dense{scene};
    const std::vector<double>& r = found.positions;
    for (Index i = 0; i < static_cast<Index>(r.size() / 3); ++i)
      EXPECT_LT((reference::point(found.velocities, i) - dense.place_velocity(reference::point(r, i))).norm(), 1e-8)
          << seed;
    const VectorXd nothing = VectorXd::Zero(static_cast<Eigen::Index>(r.size()));
    EXPECT_LT(dense.relative_acceleration(r, nothing).norm(), 1e-8) << seed;

    const Modes swing =
        modes(scene.system, r, {.count = ModesOptions::all, .time = scene.at, .solver = {.threads = 1}});
    ASSERT_TRUE(swing.outcome.ok()) << seed << ": " << swing.outcome.what;
    EXPECT_LT(misfit_of_modes(dense, r, swing), 1e-8) << seed;
    EXPECT_EQ(swing.unstable_directions, found.stability.unstable_directions) << seed;
    stable += found.stability.status == Stability::Stable ? 1 : 0;
    with_rates += swing.decay.empty() ? 0 : 1;
  }
  EXPECT_GT(found_of, scenes * 9 / 10);
  EXPECT_GT(stable, scenes / 2);
  EXPECT_GT(with_rates, scenes / 5);
}

}  // namespace
}  // namespace tanor
