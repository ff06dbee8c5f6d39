/// \file Nothing that acts goes unseen between the ends of a step.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include <tanor/tanor.hpp>

#include "methods.hpp"
#include "motion/unseen_scenes.hpp"

namespace tanor {
namespace {

using namespace unseen_scenes;

// ---- the examples, with published digits ----

TEST(Unseen, ForceThatMovesABlockAndLetsItGoIsSeen) {
  const std::string text = "3*sin(10*t)";
  const Force of_time = ConstantForce{.points = {0}, .force = along_x(ScalarFunction::formula(text))};
  const Force of_state_and_time = FormulaForce{.points = {0}, .kernel = formula_force({text, "0", "0"})};
  for (const Method method : {Method::Auto, Method::Dopri5, Method::Dop853}) {
    for (const Force& force : {of_time, of_state_and_time}) {
      System system = make_block(0.2, {});
      system.forces.push_back(force);
      Simulation simulation(system, {.method = method});

      ASSERT_TRUE(simulation.advance_to(20.0).ok()) << simulation.outcome().what;

      EXPECT_NEAR(simulation.positions()[0], 0.0103858, 1e-7) << name_of(method);
      EXPECT_EQ(simulation.report().events, 127u) << name_of(method);
    }
  }
}

/// Returns x of a block that a force f pushes along a rail while N = -a cos(w t + p) holds it, by short steps of its
/// own.
double slide(double f, double mu, double a, double w, double p, double t_end) {
  constexpr int steps = 4000000;
  const double h = t_end / steps;
  double x = 0.0, v = 0.0;
  for (int k = 0; k < steps; ++k) {
    const double friction = mu * std::abs(a * std::cos(w * (k + 0.5) * h + p));
    const double before = v;
    v = std::max(0.0, v + h * (f - friction));
    x += 0.5 * h * (before + v);
  }
  return x;
}

TEST(Unseen, WindowsInWhichTheNormalForceVanishesAreNotJumped) {
  std::mt19937_64 random(7);
  const auto draw = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  for (int k = 0; k < 8; ++k) {
    const double a = draw(5.0, 20.0), w = draw(0.3, 3.0), p = draw(0.0, 6.0), mu = 0.2;
    const double f = mu * a * std::pow(10.0, draw(-3.0, -0.5));
    const std::string normal = std::to_string(-a) + "*cos(" + std::to_string(w) + "*t+" + std::to_string(p) + ")";
    const double right =
        slide(f, mu, std::stod(std::to_string(a)), std::stod(std::to_string(w)), std::stod(std::to_string(p)), 20.0);
    for (const Method method : {Method::Auto, Method::Dopri5, Method::Dop853}) {
      System system = make_block(mu, {});
      system.forces = {ConstantForce{.points = {0}, .force = {f, 0.0, ScalarFunction::formula(normal)}}};
      Simulation simulation(system, {.method = method});

      ASSERT_TRUE(simulation.advance_to(20.0).ok()) << simulation.outcome().what;

      EXPECT_NEAR(simulation.positions()[0], right, 1e-4 * right + 1e-10)
          << name_of(method) << ", f = " << f << ", N = " << normal;
    }
  }
}

TEST(Unseen, PulseThatMovesABlockAtRestIsSeen) {
  for (const Method method : {Method::Auto, Method::Dopri5}) {
    System system = make_block(0.2, {});
    const ForceKernel pulse = formula_force({"4*exp(-((t-5)/0.5)^2)", "0", "0"});
    system.forces.push_back(FormulaForce{.points = {0}, .kernel = pulse});
    Simulation simulation(system, {.method = method});

    ASSERT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;

    EXPECT_NEAR(simulation.positions()[0], 0.886431, 1e-6) << name_of(method);
  }
}

TEST(Unseen, BeltThatOvertakesABlockIsSeen) {
  for (const Method method : {Method::Auto, Method::Dopri5}) {
    System system = make_block(0.1, along_x(ScalarFunction::formula("6*exp(-((t-1.3)/0.2)^2)")));
    system.velocities = {5.0, 0.0, 0.0};
    Simulation simulation(system, {.method = method});

    ASSERT_TRUE(simulation.advance_to(3.0).ok()) << simulation.outcome().what;

    EXPECT_NEAR(simulation.velocities()[0], 2.5152, 1e-4) << name_of(method);
  }
}

TEST(Unseen, PulseOnAFreePointIsSeen) {
  const Unseen pulse(Shape::Pulse, 100.0, 5.3, 0.5);
  for (const Method method : {Method::Auto, Method::Dopri5, Method::Dop853, Method::Radau5}) {
    System system = make_free_point();
    system.forces = {ConstantForce{.points = {0}, .force = along_x(formula_of(pulse))}};
    Simulation simulation(system, {.method = method});

    ASSERT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;

    EXPECT_NEAR(simulation.velocities()[0], pulse.integral(10.0), 1e-6) << name_of(method);
    EXPECT_NEAR(simulation.positions()[0], pulse.second_integral(10.0), 1e-5) << name_of(method);
  }
}

// ---- energies and forces of several points that depend on time ----

/// Returns where two points of 1 and 2 kg are that g(t) draws towards each other along x: U = (x2 - x1) c g(t), c = 1.
std::array<double, 2> expect_meeting(const Unseen& g, double t) {
  return {g.second_integral(t), 3.0 - 0.5 * g.second_integral(t)};
}
System make_pair() {
  System system;
  system.positions = {0.0, 0.0, 0.0, 3.0, 0.0, 0.0};
  system.masses = {1.0, 2.0};
  return system;
}

TEST(Unseen, PulseOfAnEnergyAndOfAForceOnTwoPointsIsSeen) {
  for (const Shape shape : {Shape::Pulse, Shape::Triangle, Shape::Window}) {
    const Unseen g(shape, 20.0, 5.3, 0.01);
    for (const Method method : with_auto(list_adaptive_methods())) {
      for (const bool is_energy : {true, false}) {
        System system = make_pair();
        if (is_energy) {
          system.forces = {
              Potential{.name = "drawn",
                        .points = {{0, 1}},
                        .kernel = formula_potential("c*(x2 - x1)*" + g.text(), 2, {}, std::vector<std::string>{"c"}),
                        .constants = {{1.0}}}};
        } else {
          const std::vector<std::string> texts{g.text(), "0", "0", "-" + g.text(), "0", "0"};
          system.forces = {FormulaForce{.points = {}, .kernel = formula_tuple_force(texts), .tuples = {{0, 1}}}};
        }
        Simulation simulation(system, {.method = method});

        ASSERT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;

        const auto [first, second] = expect_meeting(g, 10.0);
        EXPECT_NEAR(simulation.positions()[0], first, 1e-6) << name_of(method) << g.text() << is_energy;
        EXPECT_NEAR(simulation.positions()[3], second, 1e-6) << name_of(method) << g.text() << is_energy;
        if (!is_energy || shape != Shape::Pulse) continue;
        // The energy is E = T + U, and the explicit change of U in time is the work of the energies.
        const double drift = simulation.report().energy.drift_relative();
        EXPECT_LT(std::abs(drift), 1e-5) << name_of(method) << g.text();
      }
    }
  }
}

/// Every tuple has a constant of its own and holds a support.
TEST(Unseen, PulsesOfAnEnergyWithConstantsAndSupportsAreSeen) {
  for (const Method method : {Method::Auto, Method::Dopri5}) {
    System system;
    std::vector<std::vector<Index>> tuples;
    std::vector<double> heights, centers;
    std::vector<Unseen> all;
    for (Index k = 0; k < 11; ++k) {
      system.positions.insert(system.positions.end(), {0.0, 1.0 * k, 0.0, 1.0, 1.0 * k, 0.0});
      system.masses.insert(system.masses.end(), {1.0, 1.0});
      tuples.push_back({2 * k, 2 * k + 1});
      heights.push_back(1.0 + k);
      centers.push_back(0.7 + 0.9 * k);
      all.emplace_back(Shape::Pulse, heights.back(), centers.back(), 0.003);
    }
    Support support{.points = {}};
    for (Index k = 0; k < 11; ++k) support.points.push_back(2 * k);
    system.supports = {support};
    system.forces = {Potential{
        .points = tuples,
        .kernel = formula_potential("-h*exp(-((t - c)/0.003)^2)*(x2 - x1)", 2, {}, std::vector<std::string>{"h", "c"}),
        .constants = {heights, centers}}};
    Simulation simulation(system, {.method = method});

    ASSERT_TRUE(simulation.advance_to(11.0).ok()) << simulation.outcome().what;

    for (std::size_t k = 0; k < 11; ++k)
      EXPECT_NEAR(simulation.positions()[6 * k + 3], 1.0 + all[k].second_integral(11.0), 1e-7) << name_of(method) << k;
  }
}

/// A fast point falls through a narrow well in space and has its old speed behind it.
TEST(Unseen, AWellOfAnEnergyIsNotJumped) {
  for (const Method method : {Method::Auto, Method::Taylor, Method::Dop853}) {
    System system = make_free_point();
    system.velocities = {1.0, 0.0, 0.0};
    system.forces = {Potential{.points = {{0}}, .kernel = formula_potential("-3*exp(-((x1 - 5)/0.01)^2)", 1)}};
    Simulation simulation(system, {.method = method});

    ASSERT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;

    // The time that is won is the integral of 1 - 1/sqrt(1 + 6 exp(-u^2)) over the well, 0.01 m long, by its values.
    double won = 0.0;
    for (int k = -4000; k < 4000; ++k) {
      const double u = (k + 0.5) * 0.002;
      won += 0.01 * 0.002 * (1.0 - 1.0 / std::sqrt(1.0 + 6.0 * std::exp(-u * u)));
    }
    EXPECT_NEAR(simulation.velocities()[0], 1.0, 1e-6) << name_of(method);
    EXPECT_NEAR(simulation.positions()[0], 10.0 + won, 1e-6) << name_of(method);
  }
}

/// The friction of a block takes in a pulse of an energy as it does one of a force.
TEST(Unseen, APulseOfAnEnergyMovesABlockAtRest) {
  for (const Method method : {Method::Auto, Method::Dopri5}) {
    System system = make_block(0.2, {});
    system.forces.push_back(Potential{.points = {{0}}, .kernel = formula_potential("-4*exp(-((t-5)/0.5)^2)*x1", 1)});
    Simulation simulation(system, {.method = method});

    ASSERT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;

    EXPECT_NEAR(simulation.positions()[0], 0.886431, 1e-6) << name_of(method);
  }
}

TEST(Unseen, FixedStepsTellWhichEnergyTheyPassedOver) {
  const Unseen pulse(Shape::Pulse, 10.0, 5.37, 0.001);
  System system = make_free_point();
  system.forces = {Potential{.name = "kick", .points = {{0}}, .kernel = formula_potential("-x1*" + pulse.text(), 1)}};
  Simulation simulation(system, {.method = Method::Rk4, .step = 0.1});

  ASSERT_TRUE(simulation.advance_to(10.0).ok());

  EXPECT_NE(simulation.report().accuracy_warning.find("kick"), std::string::npos);
}

/// A pendulum whose support is pushed agrees with a run whose steps are far shorter than the push.
TEST(Unseen, PushOfASupportIsSeen) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 0.0, 0.0, -1.0};
  system.masses = {1.0, 1.0};
  const Unseen push(Shape::Pulse, 0.2, 5.0, 0.4);
  system.supports = {{.points = {0}, .displacement = along_x(formula_of(push))}};
  system.constraints = {Rods{.pairs = {{0, 1}}}};
  system.forces = {Gravity{.acceleration = {0.0, 0.0, -9.81}}};
  Simulation fine(system, {.method = Method::Dop853, .max_step = 0.02, .rtol = 1e-12, .atol = 1e-13});
  ASSERT_TRUE(fine.advance_to(10.0).ok());

  for (const Method method : {Method::Auto, Method::Dopri5, Method::Dop853, Method::Radau5}) {
    Simulation simulation(system, {.method = method});

    ASSERT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;

    EXPECT_GT(std::abs(simulation.positions()[3]), 0.01);
    EXPECT_NEAR(simulation.positions()[3], fine.positions()[3], 1e-6) << name_of(method);
  }
}

// ---- max_step ----

TEST(Unseen, NoStepIsLongerThanMaxStep) {
  for (const Method method : {Method::Auto, Method::Dop853, Method::Radau5, Method::Rk4, Method::Rattle}) {
    MotionOptions options{.method = method, .max_step = 0.0625};
    if (has_fixed_steps(method)) options.step = 1.0;
    Simulation simulation(make_free_point(), options);
    double longest = 0.0;

    ASSERT_TRUE(simulation
                    .advance_to(2.0,
                                [&](const MotionReport& report) {
                                  longest = std::max(longest, report.last_step);
                                  return true;
                                })
                    .ok());

    EXPECT_LE(longest, 0.0625 * (1.0 + 1e-12)) << name_of(method);
    EXPECT_NEAR(static_cast<double>(simulation.report().steps), 32.0, 1.0) << name_of(method);
  }
}

TEST(Unseen, AMaxStepThatIsNoLengthOfTimeIsRefused) {
  for (const double wrong : {-1.0, std::nan(""), HUGE_VAL}) {
    try {
      Simulation simulation(make_free_point(), {.max_step = wrong});
      ADD_FAILURE() << wrong << " was taken";
    } catch (const InputError& error) {
      EXPECT_EQ(error.where(), "/motion/max_step");
    }
  }
}

/// No bound of a black box of state and time is known, so that the user gives one.
TEST(Unseen, MaxStepFindsAPulseOfABlackBox) {
  const Unseen pulse(Shape::Pulse, 10.0, 5.3, 0.1);
  System system = make_free_point();
  const ForceKernel black_box = make_force_kernel([pulse](const auto& r, const auto&, double t) {
    auto f = r;
    for (auto& component : f) component = pulse.value(t);
    return f;
  });
  system.forces = {FormulaForce{.points = {0}, .kernel = black_box}};
  Simulation simulation(system, {.max_step = 0.1});

  ASSERT_TRUE(simulation.advance_to(10.0).ok());

  EXPECT_NEAR(simulation.velocities()[0], pulse.integral(10.0), 1e-7);
}

// ---- fixed steps ----

TEST(Unseen, FixedStepsTellWhatTheyPassedOver) {
  for (const Method method : {Method::Rk4, Method::Rattle, Method::GeneralizedAlpha}) {
    for (const double width : {0.001, 2.0}) {
      System system = make_free_point();
      const Unseen pulse(Shape::Pulse, 10.0, 5.37, width);
      system.forces = {ConstantForce{.name = "wind", .points = {0}, .force = along_x(formula_of(pulse))}};
      Simulation simulation(system, {.method = method, .step = 0.1});

      ASSERT_TRUE(simulation.advance_to(10.0).ok());

      const bool is_warned = simulation.report().accuracy_warning.find("wind") != std::string::npos;
      EXPECT_EQ(is_warned, width < 0.1) << name_of(method) << " " << simulation.report().accuracy_warning;
    }
  }
}

// ---- snapshots ----

TEST(Unseen, ARestoredRunGoesOnBitByBit) {
  for (const Method method : list_explicit_adaptive_methods()) {
    System system = make_free_point();
    const ScalarFunction f = ScalarFunction::formula("4*exp(-((t-5)/0.05)^2) + sin(t)");
    system.forces = {ConstantForce{.points = {0}, .force = along_x(f)}};
    Simulation all(system, {.method = method}), first(system, {.method = method});
    ASSERT_TRUE(all.advance_to(3.0).ok());
    ASSERT_TRUE(all.advance_to(10.0).ok());
    ASSERT_TRUE(first.advance_to(3.0).ok());
    Simulation second(system, {.method = method}, {}, 1.0);

    second.restore(first.save());
    ASSERT_TRUE(second.advance_to(10.0).ok());

    EXPECT_EQ(second.positions()[0], all.positions()[0]) << name_of(method);
    EXPECT_EQ(second.velocities()[0], all.velocities()[0]) << name_of(method);
    EXPECT_EQ(second.report().steps, all.report().steps) << name_of(method);
  }
}

}  // namespace
}  // namespace tanor
