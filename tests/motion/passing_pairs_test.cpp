/// Steps must not jump over beads that meet and part between two evaluations. Random scenes are compared with closed
/// forms and with runs that cannot jump.

#include "motion/passing.hpp"

namespace tanor::passing {
namespace {

class PassingPairsByMethod : public testing::TestWithParam<Method> {};
// The sample has the adaptive methods without series.
INSTANTIATE_TEST_SUITE_P(, PassingPairsByMethod,
                         testing::Values(Method::Auto, Method::Dop853, Method::Dopri5, Method::Radau5),
                         [](const auto& of) { return std::string(name_of(of.param)); });

System make_two_beads(double gap) {
  System system;
  system.positions = {0, 0, 0, gap, 0.1, 0};
  system.velocities = {1, 0, 0, 0, 0, 0};
  system.masses = {1, 1};
  system.forces = {PairForces{}};
  return system;
}

/// Returns where a longer flight ends. Everything happens later by the same time, and nothing else changes.
State shift(State state, double gap, double more) {
  for (std::size_t i = 0; i < 6; ++i) state.r[i] += more * state.v[i];
  state.r[0] += gap;
  state.r[3] += gap;
  return state;
}

TEST_P(PassingPairsByMethod, TwoBeadsMeetHoweverFarTheyAre) {
  Simulation exact(make_two_beads(2.0), {.method = Method::Rattle6, .step = 2.5e-4}, {.threads = 1});
  ASSERT_TRUE(exact.advance_to(4.0).ok());
  ASSERT_LT(exact.velocities()[0], 0.1) << "they have met";

  for (double gap = 2.0; gap <= 60.0; gap += 1.0) {
    Simulation simulation(make_two_beads(gap), {.method = GetParam(), .rtol = rtol, .atol = atol}, {.threads = 1});
    ASSERT_TRUE(simulation.advance_to(2.0 * gap).ok()) << gap;

    // The beads meet later by gap - 2, and farther by gap - 2, and fly on for the rest.
    const State right = shift(state_of(exact), gap - 2.0, gap - 2.0);
    EXPECT_LT(over_tolerance(simulation.velocities(), right.v), 100.0) << gap;
    EXPECT_LT(over_tolerance(simulation.positions(), right.r), 100.0 * gap) << gap;
    EXPECT_TRUE(simulation.report().accuracy_warning.empty()) << gap;
  }
}

/// Runs without a jump, since steps end after every twentieth of the time in which beads pass each other.
State run_in_pieces(const System& system, double t_end, double piece) {
  Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-12, .atol = 1e-14}, {.threads = 1});
  const int pieces = static_cast<int>(std::ceil(t_end / piece));
  for (int k = 1; k <= pieces; ++k) {
    const Outcome outcome = simulation.advance_to(t_end * k / pieces);
    EXPECT_TRUE(outcome.ok()) << outcome.what;
  }
  return state_of(simulation);
}

struct Gas {
  System system;
  double t_end = 0.0, piece = 0.0;
  std::string what;
};

/// Draws pairs of beads of size 1, each of which meets once: two free ones, one at rest on a support, one that a
/// support carries along, or a dumbbell that spins; in space or in a periodic box.
Gas draw_gas(Random& random) {
  constexpr std::array names{"free", "obstacle", "carried", "dumbbell"};
  Gas gas;
  System& system = gas.system;
  const double speed = random.log_uniform(0.5, 2.0), length = 1.0 / random.log_uniform(1e-3, 1.0);
  gas.t_end = (length + 3.0) / speed;
  gas.piece = 0.1 / speed;
  PairForces pairs;
  pairs.exclude_rods = true;
  pairs.law = std::array{PairLaw::Wca, PairLaw::Lj, PairLaw::Log}[static_cast<std::size_t>(random.below(3))];
  if (pairs.law == PairLaw::Lj) pairs.cutoff = random.uniform(1.2, 3.0);
  if (pairs.law == PairLaw::Lj) pairs.epsilon = 0.1;
  if (pairs.law == PairLaw::Log) pairs.strength = 0.02 * speed * speed;
  gas.what = std::string(kind_name(Force{pairs})) + " law " + std::to_string(static_cast<int>(pairs.law)) +
             ", length " + std::to_string(length);
  const bool has_box = pairs.law != PairLaw::Log && random.below(4) == 0;
  if (has_box) pairs.box = {std::max(8.0, 0.3 * length), std::max(8.0, 0.3 * length), 0.0};
  if (has_box) gas.what += ", box";
  const int num_pairs = 1 + random.below(2);
  for (int k = 0; k < num_pairs; ++k) {
    const int kind = random.below(names.size());
    gas.what += std::string(", ") + names[static_cast<std::size_t>(kind)];
    const Vector3 d = random.direction();
    const double away = 40.0 * k, reach = 1.5 + length * random.uniform(0.1, 0.8), offset = random.uniform(0.1, 0.9);
    // A bead flies along d past the target, at the distance `offset`.
    const Vector3 e = std::abs(d[2]) < 0.9 ? Vector3{-d[1], d[0], 0.0} : Vector3{0.0, -d[2], d[1]};
    const double scale = offset / std::hypot(e[0], e[1], e[2]);
    Vector3 from;
    for (std::size_t c = 0; c < 3; ++c) from[c] = -reach * d[c] + scale * e[c];
    const Index target = add_point({0, 0, away}, &system);
    const auto t = static_cast<std::size_t>(target);
    const Index bead = add_point({from[0], from[1], from[2] + away}, &system);
    for (std::size_t c = 0; c < 3; ++c) system.velocities[3 * static_cast<std::size_t>(bead) + c] = speed * d[c];
    if (kind == 1) system.supports.push_back({"", {target}, {}});
    if (kind == 2) {
      const std::string back = number(-0.5 * speed) + "*t*";
      system.supports.push_back(
          {"",
           {target},
           {ScalarFunction::formula(back + number(d[0])), ScalarFunction::formula(back + number(d[1])),
            ScalarFunction::formula(back + number(d[2]))}});
    }
    if (kind == 3) {
      const Index other = add_point({0.0, 1.0, away}, &system);
      const double spin = speed * random.log_uniform(0.01, 1.0);
      system.velocities[3 * t] = spin;
      system.velocities[3 * static_cast<std::size_t>(other)] = -spin;
      system.constraints.push_back(Rods{"rod" + std::to_string(k), {{target, other}}, 1.0, {}});
    }
  }
  std::fill(system.masses.begin(), system.masses.end(), 1.0);
  system.forces = {pairs};
  return gas;
}

TEST_P(PassingPairsByMethod, BeadsOfAThinGasMeet) {
  Random random(11), noise(12);
  Tally tally;
  for (int draw = num_draws(120); draw-- > 0;) {
    const Gas gas = draw_gas(random);
    const State right = run_in_pieces(gas.system, gas.t_end, gas.piece);
    // Ten tolerances are added at the start, to see how they grow.
    System moved = gas.system;
    for (std::size_t i = 0; i < moved.velocities.size(); ++i)
      moved.velocities[i] += 10.0 * noise.uniform(-1.0, 1.0) * (atol + rtol * std::abs(moved.velocities[i]));
    MotionOptions options{.method = Method::Dop853, .rtol = 1e-12, .atol = 1e-14, .start = StartMode::Project};
    Simulation other(moved, options, {.threads = 1});
    for (int k = 1; k <= 1000; ++k) ASSERT_TRUE(other.advance_to(gas.t_end * k / 1000).ok());
    const double growth =
        0.1 * std::max(over_tolerance(other.positions(), right.r), over_tolerance(other.velocities(), right.v));

    const std::string what = std::to_string(draw) + ": " + gas.what;
    const double each = std::max(growth, 1.0), allowed = 100.0 * each;
    const Verdict verdict = compare(gas.system, GetParam(), gas.t_end, right);
    if (!verdict.told.empty() || verdict.error <= allowed) {
      tally.add(verdict, allowed, what);
      continue;
    }
    // Dumbbells that spin for long make thousands of steps, each of which may err by a tolerance in the same sense.
    // Such an error falls with the tolerance, and that of a jump does not.
    EXPECT_LE(verdict.error, each * static_cast<double>(verdict.steps)) << what;
    tally.add(compare(gas.system, GetParam(), gas.t_end, right, 0.1), 0.2 * verdict.error, what);
  }
  tally.expect_good();
}

/// Makes beads at random places of a wide grid with random velocities.
System make_gas_of_sixty() {
  Random random(5);
  System system;
  for (int i = 0; i < 60; ++i) {
    const double x = i % 4, y = i / 4 % 4, z = i / 16;
    add_point({12 * x + random.uniform(0, 10), 12 * y + random.uniform(0, 10), 12 * z + random.uniform(0, 10)},
              &system);
  }
  for (double& v : system.velocities) v = random.uniform(-1, 1);
  std::fill(system.masses.begin(), system.masses.end(), 1.0);
  system.forces = {PairForces{.box = {48, 48, 48}}};
  return system;
}

State run(const System& system, double tolerance, double t_end) {
  Simulation simulation(system, {.method = Method::Dop853, .rtol = tolerance, .atol = tolerance}, {.threads = 1});
  EXPECT_TRUE(simulation.advance_to(t_end).ok());
  return state_of(simulation);
}

TEST(PassingTest, AGasOfSixtyBeadsIsTheSameAtEachTolerance) {
  constexpr double t_end = 60.0, move = 1e-10;
  const System gas = make_gas_of_sixty();
  System moved = gas;
  for (std::size_t i = 0; i < moved.positions.size(); ++i) moved.positions[i] += i % 2 == 0 ? move : -move;
  const State right = run(gas, 1e-12, t_end);
  const double growth = largest_difference(run(moved, 1e-12, t_end).r, right.r) / move;
  ASSERT_LT(growth, 1e6) << "the motion is known";

  for (const double tolerance : {1e-9, 1e-10, 1e-11}) {
    const double size = 48.0;  // the size of the box, to which relative tolerances belong
    EXPECT_LT(largest_difference(run(gas, tolerance, t_end).r, right.r), 100 * tolerance * size * growth) << tolerance;
  }
}

/// The search between evaluations depends on nothing that a snapshot does not hold.
TEST(PassingTest, ARunThatGoesOnFromASnapshotMeetsTheSameBeads) {
  const System gas = make_gas_of_sixty();
  const MotionOptions options{.method = Method::Dopri5, .rtol = 1e-7, .atol = 1e-9};
  Simulation whole(gas, options, {.threads = 1}), again(gas, options, {.threads = 1});
  ASSERT_TRUE(whole.advance_to(30.0).ok());
  const std::vector<std::byte> saved = whole.save();
  const std::size_t rejected = whole.report().rejected;
  ASSERT_TRUE(whole.advance_to(60.0).ok());

  again.restore(saved);
  ASSERT_TRUE(again.advance_to(60.0).ok());

  EXPECT_EQ(state_of(again).r, state_of(whole).r);
  EXPECT_EQ(again.report().rejected, whole.report().rejected);
  EXPECT_GT(whole.report().rejected, rejected);
}

/// Fixed steps stay as they were asked for, and the report says where they jump.
TEST(PassingTest, FixedStepsThatJumpAreWarnedOf) {
  Random random(3);
  System well;
  add_point({0, 0, 0}, &well);
  well.velocities = {1, 0, 0};
  well.forces = {FormulaForce{"well", {0}, formula_force({"-5*(x - 5.3)*exp(-100*(x - 5.3)^2)", "0", "0"})}};
  for (const Method method : {Method::Rk4, Method::Rattle, Method::Rattle4, Method::GeneralizedAlpha}) {
    for (const System& system : {make_two_beads(7.3), well}) {
      Simulation jumps(system, {.method = method, .step = 4.0}, {.threads = 1});
      Simulation sees(system, {.method = method, .step = 0.002}, {.threads = 1});
      ASSERT_TRUE(jumps.advance_to(12.0).ok());
      ASSERT_TRUE(sees.advance_to(12.0).ok());

      EXPECT_FALSE(jumps.report().accuracy_warning.empty()) << name_of(method);
      EXPECT_EQ(sees.report().accuracy_warning, "") << name_of(method);
    }
  }
}

}  // namespace
}  // namespace tanor::passing
