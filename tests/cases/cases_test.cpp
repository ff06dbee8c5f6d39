#include <algorithm>
#include <cmath>
#include <iterator>
#include <ostream>
#include <span>
#include <tuple>

#include <gtest/gtest.h>
#include <tanor/dynamics.hpp>

#include "cases/interfaces.hpp"
#include "cases/reference_motion.hpp"
#include "cases/scenes.hpp"

namespace tanor::cases {
namespace {

struct NamedInterface {
  std::string name;
  Interface find_answer;
};

std::ostream& operator<<(std::ostream& out, const NamedInterface& interface) {
  return out << interface.name;
}

std::vector<NamedInterface> list_interfaces() {
  return {{"library", through_library},
#ifdef TANOR_PROGRAM
          {"program", through_program}
#endif
  };
}

// ---- convergence ---------------------------------------------------------------------------------------------------

/// The options, and those that halve the steps. For dopri5, of order 5, the tolerances are divided by 32.
struct MethodUnderTest {
  std::string name;
  MotionOptions coarse, fine;
  double least_order, largest_order;
};

std::ostream& operator<<(std::ostream& out, const MethodUnderTest& method) {
  return out << method.name;
}

std::vector<MethodUnderTest> list_methods() {
  const auto fixed = [](Method method, double step) { return MotionOptions{.method = method, .step = step}; };
  const auto adaptive = [](double rtol) {
    return MotionOptions{.method = Method::Dopri5, .rtol = rtol, .atol = 1e-2 * rtol};
  };
  return {{"rk4", fixed(Method::Rk4, 1.0 / 400), fixed(Method::Rk4, 1.0 / 800), 3.6, 4.6},
          {"rattle", fixed(Method::Rattle, 1.0 / 2000), fixed(Method::Rattle, 1.0 / 4000), 1.9, 2.1},
          {"dopri5", adaptive(1e-8), adaptive(1e-8 / 32), 4.0, 6.5}};
}

class ConvergenceTest : public testing::TestWithParam<std::tuple<NamedInterface, CaseScene, MethodUnderTest>> {};

TEST_P(ConvergenceTest, HalfTheStepDividesTheErrorAsTheOrderSays) {
  const auto& [interface, scene, method] = GetParam();
  const ReferenceMotion reference(scene);
  const System system = scene.build(reference.start());

  for (const Instant& instant : reference.instants()) {
    const double coarse = reference.error(interface.find_answer(scene.name, system, method.coarse, instant.t), instant);
    const double fine = reference.error(interface.find_answer(scene.name, system, method.fine, instant.t), instant);

    const double order = std::log2(coarse / fine);
    EXPECT_GE(order, method.least_order) << "t = " << instant.t << ", errors " << coarse << " and " << fine;
    EXPECT_LE(order, method.largest_order) << "t = " << instant.t << ", errors " << coarse << " and " << fine;
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, ConvergenceTest,
                         testing::Combine(testing::ValuesIn(list_interfaces()), testing::ValuesIn(moving_cases()),
                                          testing::ValuesIn(list_methods())),
                         [](const auto& instance) {
                           return std::get<0>(instance.param).name + "_" + std::get<1>(instance.param).name + "_" +
                                  std::get<2>(instance.param).name;
                         });

// ---- digits --------------------------------------------------------------------------------------------------------

class AnswerTest : public testing::TestWithParam<std::tuple<NamedInterface, CaseScene>> {
 protected:
  static Answer find_answer(double t_end) {
    const auto& [interface, scene] = GetParam();
    const MotionOptions options{.method = Method::Dopri5, .rtol = 1e-12, .atol = 1e-14};
    return interface.find_answer(scene.name, scene.build(ReferenceMotion(scene).start()), options, t_end);
  }
};

template <class Wanted>
auto list_answers(const Wanted& is_wanted) {
  std::vector<CaseScene> scenes;
  std::copy_if(moving_cases().begin(), moving_cases().end(), std::back_inserter(scenes), is_wanted);
  return testing::Combine(testing::ValuesIn(list_interfaces()), testing::ValuesIn(scenes));
}

std::string name_answer(const testing::TestParamInfo<std::tuple<NamedInterface, CaseScene>>& answer) {
  return std::get<0>(answer.param).name + "_" + std::get<1>(answer.param).name;
}

class DigitsTest : public AnswerTest {};

TEST_P(DigitsTest, MotionReactionsAndMultipliersHaveTenDigits) {
  const ReferenceMotion reference(std::get<1>(GetParam()));

  for (const Instant& instant : reference.instants()) {
    const Answer answer = find_answer(instant.t);

    EXPECT_EQ(answer.t, instant.t);
    EXPECT_LT(reference.error(answer, instant), 1e-10) << "t = " << instant.t;
    EXPECT_LE(answer.position_violation, 1e-12);
    EXPECT_LE(answer.velocity_violation, 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, DigitsTest, list_answers([](const CaseScene&) { return true; }), name_answer);

/// The car axis is stiff. Its 826 steps follow the springs, and the tolerance is met all the same.
TEST(Dop853Test, EveryCaseHasElevenDigits) {
  const MotionOptions options{.method = Method::Dop853, .rtol = 1e-12, .atol = 1e-14};
  for (const CaseScene& scene : moving_cases()) {
    const ReferenceMotion reference(scene);
    for (const Instant& instant : reference.instants()) {
      const Answer answer = through_library("", scene.build(reference.start()), options, instant.t);
      EXPECT_LT(reference.error(answer, instant), 1e-11) << scene.name << ", t = " << instant.t;
    }
  }
}

/// In case 16 a string of beads under tension swings in its first mode with a small and a large amplitude. The
/// positions are compared after a quarter and after the whole of the period of the small amplitude (whose digits the
/// case rounds).
TEST(Dop853Test, WavesOfAChainUnderTensionHaveElevenDigits) {
  const nlohmann::json file = read_case("16_wave_chain");
  const double period = 2.0 * 3.14159265358979323846 / number(file.at("omega_j").at(0));
  for (const char* amplitude : {"nonlinear_A=1e-3", "nonlinear_A=0.1"}) {
    const auto vectors = [&](std::size_t k, const char* key) {
      return make_spatial(numbers(file.at(amplitude).at(k).at(key)), 2);
    };
    const std::vector<double> start = vectors(0, "r");
    System system = make_hanging_chain({0.0, start, vectors(0, "v"), {}, {}, {}}, 1.0, {0, 0, 0}, 1.0);
    const auto last = static_cast<Index>(start.size() / 3);
    system.constraints.push_back(Planes{"slider", {last}, Vector3{0, 1, 0}, 0.0});
    system.forces = {ConstantForce{"tension", {last}, VectorFunction(Vector3{10, 0, 0})}};
    for (const auto& [k, t] : {std::pair{1U, 0.25 * period}, std::pair{2U, period}}) {
      Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-13, .atol = 1e-15});

      ASSERT_TRUE(simulation.advance_to(t).ok());

      EXPECT_LT(largest_difference(simulation.positions().subspan(3), vectors(k, "r")), 1e-11) << amplitude;
      EXPECT_LT(largest_difference(simulation.velocities().subspan(3), vectors(k, "v")), 1e-11) << amplitude;
    }
  }
}

class EnergyTest : public AnswerTest {};

/// E(t) - E(0) is the work of supports and moving constraints.
TEST_P(EnergyTest, EnergyAndWorkAreThoseOfTheCase) {
  const ReferenceMotion reference(std::get<1>(GetParam()));
  const Instant& end = reference.instants().back();

  const Answer answer = find_answer(end.t);

  const double scale = std::max({1.0, std::abs(*end.energy), std::abs(*reference.start().energy)});
  EXPECT_NEAR(answer.energy, *end.energy, 1e-9 * scale);
  EXPECT_NEAR(answer.energy_start, *reference.start().energy, 1e-12 * scale);
  EXPECT_NEAR(answer.work_of_supports, *end.energy - *reference.start().energy, 1e-9 * scale);
}

INSTANTIATE_TEST_SUITE_P(Cases, EnergyTest, list_answers([](const CaseScene& scene) {
                           return read_trajectory(scene.reference).front().energy.has_value();
                         }),
                         name_answer);

class SupportTest : public AnswerTest {};

/// Rods between masses cancel in the sum of K lambda, so that the support at the origin carries the negative sum over
/// the masses.
TEST_P(SupportTest, TheSupportCarriesTheReactionsOfTheMasses) {
  const CaseScene& scene = std::get<1>(GetParam());
  const Instant end = read_trajectory(scene.reference).back();

  const Answer answer = find_answer(end.t);

  std::vector<double> carried(3, 0.0);
  const std::vector<double> reactions = scene.reactions(end);
  for (std::size_t i = 0; i < reactions.size(); ++i) carried[i % 3] -= reactions[i];
  EXPECT_LT(largest_difference(std::span(answer.support_forces).first(3), carried), 1e-9 * largest(carried));
  EXPECT_EQ(largest(std::span(answer.support_forces).subspan(3)), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Cases, SupportTest,
                         list_answers([](const CaseScene& scene) { return scene.num_supports == 1; }), name_answer);

// ---- single claims -------------------------------------------------------------------------------------------------

class InterfaceTest : public testing::TestWithParam<NamedInterface> {};

/// This is the required accuracy for `tanor run … --method dopri5 --rtol 1e-10 --atol 1e-12`.
TEST_P(InterfaceTest, ChainOf10IsWithin1e8AtOneSecond) {
  const MotionOptions options{.method = Method::Dopri5, .rtol = 1e-10, .atol = 1e-12};
  const std::vector<Instant> trajectory = read_trajectory("08_chain10");
  const Instant& end = trajectory.back();

  const Answer answer = GetParam().find_answer("08_chain10", make_chain_of_10(trajectory.front()), options, end.t);

  ASSERT_EQ(end.t, 1.0);
  EXPECT_LT(largest_difference(std::span(answer.positions).subspan(3), end.r), 1e-8);
  EXPECT_LT(largest_difference(std::span(answer.velocities).subspan(3), end.v), 1e-8);
  EXPECT_LE(answer.position_violation, 1e-12);
  EXPECT_LE(answer.velocity_violation, 1e-12);
}

TEST_P(InterfaceTest, ChainBetweenSupportsStaysAtRest) {
  const System system = make_catenary();
  const MotionOptions options{.method = Method::Dopri5, .rtol = 1e-10, .atol = 1e-12};

  const Answer answer = GetParam().find_answer("06_catenary_N10", system, options, 1.0);

  EXPECT_LT(largest_difference(answer.positions, system.positions), 1e-11);
  EXPECT_LT(largest(answer.velocities), 1e-10);
}

TEST_P(InterfaceTest, MotionInAPlaneStaysInIt) {
  for (const char* name : {"07_chain2", "07_chain2_in_plane"}) {
    const Instant start = read_trajectory("07_chain2").front();
    const bool held = std::string(name) == "07_chain2_in_plane";
    const System system = held ? make_double_pendulum_in_plane(start) : make_double_pendulum(start);

    const Answer answer = GetParam().find_answer(name, system, {.method = Method::Rk4, .step = 1e-3}, 1.0);

    for (std::size_t i = 2; i < answer.positions.size(); i += 3) EXPECT_EQ(answer.positions[i], 0.0) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, InterfaceTest, testing::ValuesIn(list_interfaces()),
                         [](const auto& instance) { return instance.param.name; });

TEST(CatenaryTest, LibraryFindsRestAndTwelveDigitsOfTheTensions) {
  Dynamics dynamics(make_catenary());
  const System& system = dynamics.system();
  std::vector<double> w(33), lambda(10);

  ASSERT_TRUE(dynamics
                  .solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                         {.accelerations = w, .multipliers = lambda})
                  .outcome.ok());

  expect_rest_with_tensions(w, lambda);
}

#ifdef TANOR_PROGRAM
TEST(CatenaryTest, ProgramFindsRestAndTwelveDigitsOfTheTensions) {
  const Folder folder;

  run_program("solve " + scene_file("06_catenary_N10") + " --out " + (folder / "solution.json").string());

  const nlohmann::json solution = read_json(folder / "solution.json");
  expect_rest_with_tensions(flatten(solution.at("accelerations")),
                            solution.at("multipliers").get<std::vector<double>>());
}
#endif

/// With both masses hanging straight down, a = g (m2 - m1)/(m1 + m2) and T = 2 m1 m2 g/(m1 + m2).
TEST(AtwoodTest, StraightRopesGiveTheSchoolBookAnswer) {
  const nlohmann::json straight = read_case("05_atwood_swinging").at("vertical_case");
  Dynamics dynamics(make_swinging_atwood({0.0, {-1, -1.5, 0, 1, -1.5, 0}, std::vector<double>(6, 0.0), {}, {}, {}}));
  const System& system = dynamics.system();
  std::vector<double> w(6), lambda(1);

  ASSERT_TRUE(dynamics
                  .solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                         {.accelerations = w, .multipliers = lambda})
                  .outcome.ok());

  EXPECT_NEAR(-w[4], number(straight.at("acc(m2 down)")), 1e-14);
  EXPECT_NEAR(w[1], number(straight.at("acc(m2 down)")), 1e-14);
  EXPECT_NEAR(-lambda[0], number(straight.at("tension")), 1e-13);
}

/// At one instant the rotating hoop has the same accelerations, multipliers and reactions as a ball and a plane and as
/// two formulas.
TEST(RotatingHoopTest, FormulasGiveTheAnswerOfTheBuiltInKinds) {
  const std::vector<Instant> trajectory = read_trajectory("03_rotating_hoop");
  Dynamics built_in(make_rotating_hoop(trajectory.front())),
      formulas(make_rotating_hoop_by_formulas(trajectory.front()));
  const auto solve = [](Dynamics* dynamics, const Instant& instant) {
    std::vector<double> w(3), lambda(2), eta(3);
    EXPECT_TRUE(dynamics
                    ->solve({.time = instant.t, .positions = instant.r, .velocities = instant.v},
                            {.accelerations = w, .multipliers = lambda, .reactions = eta})
                    .outcome.ok());
    w.insert(w.end(), lambda.begin(), lambda.end());
    w.insert(w.end(), eta.begin(), eta.end());
    return w;
  };

  for (const Instant& instant : trajectory) {
    const std::vector<double> one = solve(&built_in, instant), other = solve(&formulas, instant);

    EXPECT_LT(largest_difference(one, other), 1e-12 * largest(one)) << "t = " << instant.t;
    EXPECT_LT(largest_difference(std::span(other).first(3), instant.w), 1e-12 * largest(instant.w));
    EXPECT_LT(largest_difference(std::span(other).subspan(3, 2), instant.lambda), 1e-12 * largest(one));
  }
}

}  // namespace
}  // namespace tanor::cases
