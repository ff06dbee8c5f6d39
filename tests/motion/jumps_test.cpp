/// \file Forces that jump where points reach a certain place: at the cutoff of pairs, and by formulas.

#include "motion/jumps.hpp"

#include <array>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <tanor/tanor.hpp>

#include "methods.hpp"

namespace tanor {
namespace {

using jumps::Numbers;
using Generator = std::mt19937_64;

double draw(Generator& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// The force of a pair by its law, positive where the points push each other away, N.
double force_of(const PairForces& law, double r) {
  if (law.law == PairLaw::Lj) {
    const double s6 = std::pow(law.sigma / r, 6);
    return 24.0 * law.epsilon * s6 * (2.0 * s6 - 1.0) / r;
  }
  if (law.law == PairLaw::Yukawa) return law.strength * std::exp(-r / law.length) / r * (1.0 / r + 1.0 / law.length);
  const double e = std::exp(-law.width * (r - law.rest_length));
  return -2.0 * law.depth * law.width * e * (1.0 - e);
}

/// Free points that pull and push each other within a cutoff. y has all positions, then all velocities.
jumps::Piecewise motion_of(const System& system) {
  const auto& law = std::get<PairForces>(system.forces[0]);
  const std::size_t n = system.masses.size();
  const auto between = [](const Numbers& y, std::size_t i, std::size_t j) {
    return std::array{y[3 * j] - y[3 * i], y[3 * j + 1] - y[3 * i + 1], y[3 * j + 2] - y[3 * i + 2]};
  };
  const auto length = [](const std::array<double, 3>& d) { return std::hypot(d[0], d[1], d[2]); };
  return {.rate =
              [=, masses = system.masses](const std::vector<bool>& is_outside, const Numbers& y) {
                Numbers rate(y.begin() + static_cast<std::ptrdiff_t>(3 * n), y.end());
                rate.resize(6 * n, 0.0);
                std::size_t pair = 0;
                for (std::size_t i = 0; i < n; ++i) {
                  for (std::size_t j = i + 1; j < n; ++j) {
                    if (is_outside[pair++]) continue;
                    const auto d = between(y, i, j);
                    const double r = length(d), f = force_of(law, r) / r;
                    for (std::size_t c = 0; c < 3; ++c) {
                      rate[3 * n + 3 * i + c] -= f * d[c] / masses[i];
                      rate[3 * n + 3 * j + c] += f * d[c] / masses[j];
                    }
                  }
                }
                return rate;
              },
          .sides =
              [=, cutoff = law.cutoff.value_or(2.5 * law.sigma)](const Numbers& y) {
                Numbers sides;
                for (std::size_t i = 0; i < n; ++i)
                  for (std::size_t j = i + 1; j < n; ++j) sides.push_back(length(between(y, i, j)) - cutoff);
                return sides;
              }};
}

Numbers start_of(const System& system) {
  Numbers y = system.positions;
  y.insert(y.end(), system.velocities.begin(), system.velocities.end());
  return y;
}

/// Returns the largest error of positions and velocities.
double largest_error(const Simulation& simulation, const Numbers& right) {
  double worst = 0.0;
  const std::size_t n = right.size() / 2;
  for (std::size_t i = 0; i < n; ++i) {
    worst = std::max(worst, std::abs(simulation.positions()[i] - right[i]));
    worst = std::max(worst, std::abs(simulation.velocities()[i] - right[n + i]));
  }
  return worst;
}

/// A motion, and how far a change of the start by 1e-11 moves its end.
struct Truth {
  Numbers end;
  double moved = 0.0;

  Truth(const jumps::Piecewise& motion, const Numbers& start, double time, double h)
      : end(jumps::follow(motion, start, time, h)) {
    Numbers beside = start;
    for (std::size_t i = 0; i < beside.size(); ++i) beside[i] += (i % 2 == 0 ? 1e-11 : -1e-11) * (1.0 + beside[i]);
    beside = jumps::follow(motion, beside, time, h);
    for (std::size_t i = 0; i < end.size(); ++i) moved = std::max(moved, std::abs(end[i] - beside[i]));
  }
  double allowed() const { return 1e-8 + 100.0 * moved; }
};

void expect_motion(const System& system, const Truth& truth, double time, Method method, const std::string& what) {
  Simulation simulation(system, {.method = method, .rtol = 1e-11, .atol = 1e-13});
  ASSERT_TRUE(simulation.advance_to(time).ok()) << what << ", " << name_of(method) << ": " << simulation.outcome().what;
  EXPECT_LT(largest_error(simulation, truth.end), truth.allowed()) << what << ", " << name_of(method);
}

// ---- pairs ----

/// Draws two or three points that fly towards each other, or begin as a bound pair that leaves its cutoff again.
System draw_pairs(Generator& random) {
  System system;
  const std::size_t n = 2 + random() % 2;
  constexpr std::array laws{PairLaw::Lj, PairLaw::Morse, PairLaw::Yukawa};
  PairForces law{.law = laws[random() % laws.size()]};
  law.cutoff = draw(random, 1.3, 3.0);
  if (law.law == PairLaw::Yukawa) law.strength = draw(random, 0.2, 2.0);
  if (law.law == PairLaw::Morse) {
    law.rest_length = draw(random, 0.8, 1.2);
    law.width = draw(random, 0.7, 2.0);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 2.0 * M_PI * static_cast<double>(i) / static_cast<double>(n), far = draw(random, 1.0, 3.0);
    const std::array<double, 3> place{far * std::cos(angle), far * std::sin(angle), draw(random, -0.3, 0.3)};
    for (std::size_t c = 0; c < 3; ++c) {
      system.positions.push_back(place[c]);
      system.velocities.push_back(-draw(random, 0.2, 0.6) * place[c] + draw(random, -0.4, 0.4));
    }
    system.masses.push_back(draw(random, 0.5, 2.0));
  }
  system.forces = {law};
  return system;
}

/// No series exist of pairs with a cutoff.
const std::array methods_of_pairs{Method::Auto, Method::Dop853, Method::Dopri5, Method::Radau5};

TEST(Jumps, OfPairsAtTheirCutoffsArePassedRight) {
  Generator random(1);
  constexpr double time = 8.0;
  for (int scene = 0; scene < 120; ++scene) {
    const System system = draw_pairs(random);
    const Truth truth(motion_of(system), start_of(system), time, 0.04);
    const Method method = methods_of_pairs[static_cast<std::size_t>(scene) % methods_of_pairs.size()];
    expect_motion(system, truth, time, method, "scene " + std::to_string(scene));
  }
}

System make_scattering(double impact) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 4.0, impact, 0.0};
  system.velocities = {0.8, 0.0, 0.0, 0.0, 0.0, 0.0};
  system.masses = {1.0, 1.0};
  system.forces = {PairForces{.law = PairLaw::Lj}};
  return system;
}

/// A pair that grazes the cutoff is within it for a short time, or not at all.
TEST(Jumps, OfPairsThatGrazeTheirCutoffsAreSeen) {
  constexpr double time = 10.0;
  for (const double depth : {1e-2, 1e-4, 1e-6, 1e-8, 1e-12, -1e-12, -1e-6}) {
    const System system = make_scattering(2.5 * (1.0 - depth));
    const Truth truth(motion_of(system), start_of(system), time, 0.01);
    for (const Method method : methods_of_pairs)
      expect_motion(system, truth, time, method, "depth " + std::to_string(depth));
  }
}

/// By default tolerances, where steps are long: the way back is as short as the way in, and as easily passed over.
TEST(Jumps, OfRandomScatteringsAreLeftAgainByDefault) {
  Generator random(3);
  constexpr std::array adaptive{Method::Dop853, Method::Dopri5, Method::Radau5};
  int compared = 0;
  for (int scene = 0; scene < 60; ++scene) {
    const double cutoff = draw(random, 1.2, 2.5), speed = 0.1 * std::pow(20.0, draw(random, 0.0, 1.0));
    const bool grazes = scene % 2 == 0;
    const double impact = cutoff * (grazes ? 1.0 - std::pow(10.0, -draw(random, 1.0, 5.0)) : draw(random, 0.0, 0.98));
    const double from = std::sqrt(cutoff * cutoff - impact * impact) + draw(random, 0.3, 1.3);
    System system;
    system.positions = {0.0, 0.0, 0.0, from, impact, 0.0};
    system.velocities = {0.0, 0.0, 0.0, -speed, 0.0, 0.0};
    system.masses = {1.0, 1.0};
    system.forces = {PairForces{.law = PairLaw::Lj, .cutoff = cutoff}};
    const double time = (2.0 * from + 2.0) / speed;
    const Numbers right = jumps::follow(motion_of(system), start_of(system), time, 0.005),
                  again = jumps::follow(motion_of(system), start_of(system), time, 0.0037);
    // The dense program passes over what is touched for less than its steps, by one step length or the other.
    const bool is_known = std::ranges::equal(right, again, [](double a, double b) { return std::abs(a - b) < 1e-6; });
    if (!is_known) continue;
    ++compared;
    for (const Method method : adaptive) {
      Simulation simulation(system, {.method = method});
      ASSERT_TRUE(simulation.advance_to(time).ok()) << "scene " << scene << ": " << simulation.outcome().what;
      for (std::size_t i = 0; i < 6; ++i)
        EXPECT_NEAR(simulation.velocities()[i], right[6 + i], 1e-3 * speed)
            << "scene " << scene << ", " << name_of(method);
    }
  }
  EXPECT_GT(compared, 54);
}

/// Two pairs reach their cutoffs at one instant, and a third one soon after.
TEST(Jumps, OfSeveralPairsAtOneInstantArePassedRight) {
  constexpr double time = 6.0;
  System system;
  system.positions = {0.0, 0.0, 0.0, 3.0, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 3.1, 0.0};
  system.velocities = {0.0, 0.0, 0.0, -0.5, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, -0.5, 0.1};
  system.masses = {1.0, 1.0, 1.0, 1.0};
  system.forces = {PairForces{.law = PairLaw::Lj}};
  const Truth truth(motion_of(system), start_of(system), time, 0.01);
  for (const Method method : methods_of_pairs) expect_motion(system, truth, time, method, "four points");
}

TEST(Jumps, OfAScatteringFromFarAwayLeaveItsVelocitiesByDefault) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 141.58695936465188, 0.9037953538973831, 0.0};
  system.velocities = {0.8337070803309019, 0.0, 0.0, 0.0, 0.0, 0.0};
  system.masses = {1.0, 1.0};
  system.forces = {PairForces{.law = PairLaw::Lj}};
  // The flight up to the cutoff is free.
  const double v = system.velocities[0], y = system.positions[4], near = std::sqrt(2.5 * 2.5 - y * y);
  const double until = (system.positions[3] - near) / v - 1.0, time = 339.6564;
  Numbers start = start_of(system);
  start[0] += v * until;
  const Numbers right = jumps::follow(motion_of(system), start, time - until, 0.02);
  Simulation simulation(system);

  ASSERT_TRUE(simulation.advance_to(time).ok()) << simulation.outcome().what;

  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(simulation.velocities()[i], right[6 + i], 1e-6);
    EXPECT_NEAR(simulation.positions()[i], right[i], 2e-4);
  }
  // By an own program of the same quadrature
  EXPECT_NEAR(simulation.velocities()[0], 0.3834963851400009, 1e-6);
  EXPECT_NEAR(simulation.velocities()[4], 0.4155167555670849, 1e-6);
}

// ---- formulas ----

/// One point under f = -k r + sum of two vectors, each with the sign of n.r - d. Some are the gradients of energies.
struct Formula {
  double stiffness = 1.0;
  std::array<std::array<double, 3>, 2> normal{}, push{};
  std::array<double, 2> offset{};

  std::string side(std::size_t k) const {
    const auto& n = normal[k];
    return "(" + std::to_string(n[0]) + "*x+" + std::to_string(n[1]) + "*y+" + std::to_string(n[2]) + "*z-" +
           std::to_string(offset[k]) + ")";
  }
  double value(std::size_t k, const Numbers& y) const {
    return normal[k][0] * y[0] + normal[k][1] * y[1] + normal[k][2] * y[2] - offset[k];
  }
};

/// Numbers that a formula holds as text with six digits.
double rounded(double x) {
  return std::stod(std::to_string(x));
}

Formula draw_formula(Generator& random) {
  Formula formula{.stiffness = rounded(draw(random, 0.5, 3.0))};
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      formula.normal[k][c] = rounded(draw(random, -1.0, 1.0));
      formula.push[k][c] = rounded(draw(random, -1.5, 1.5));
    }
    formula.offset[k] = rounded(draw(random, -0.4, 0.4));
  }
  return formula;
}

jumps::Piecewise motion_of(const Formula& formula) {
  return {.rate =
              [formula](const std::vector<bool>& is_positive, const Numbers& y) {
                Numbers rate{y[3], y[4], y[5], 0.0, 0.0, 0.0};
                for (std::size_t c = 0; c < 3; ++c) {
                  rate[3 + c] = -formula.stiffness * y[c];
                  for (std::size_t k = 0; k < 2; ++k) rate[3 + c] += (is_positive[k] ? 1.0 : -1.0) * formula.push[k][c];
                }
                return rate;
              },
          .sides =
              [formula](const Numbers& y) {
                return Numbers{formula.value(0, y), formula.value(1, y)};
              }};
}

/// Writes the sign of a side in one of the ways that formulas know.
std::string sign_of(const std::string& side, std::size_t way) {
  if (way == 0) return "(" + side + "/abs" + side + ")";
  if (way == 1) return "(abs" + side + "/" + side + ")";
  return "((max(" + side + ",0)-max(-" + side + ",0))/abs" + side + ")";
}

System make_formula(const Formula& formula, Generator& random) {
  System system;
  for (std::size_t c = 0; c < 3; ++c) {
    system.positions.push_back(draw(random, -1.0, 1.0));
    system.velocities.push_back(draw(random, -1.0, 1.0));
  }
  system.masses = {1.0};
  const std::size_t way = random() % 3;
  std::array<std::string, 3> force;
  for (std::size_t c = 0; c < 3; ++c) {
    force[c] = "-" + std::to_string(formula.stiffness) + "*" + std::string(1, "xyz"[c]);
    for (std::size_t k = 0; k < 2; ++k)
      force[c] += "+(" + std::to_string(formula.push[k][c]) + ")*" + sign_of(formula.side(k), way);
  }
  system.forces = {FormulaForce{.points = {0}, .kernel = formula_force(force)}};
  return system;
}

TEST(Jumps, OfFormulasArePassedRight) {
  Generator random(2);
  constexpr double time = 6.0;
  const std::vector<Method> methods = with_auto(list_adaptive_methods());
  for (int scene = 0; scene < 100; ++scene) {
    const Formula formula = draw_formula(random);
    const System system = make_formula(formula, random);
    const Truth truth(motion_of(formula), start_of(system), time, 0.05);
    expect_motion(system, truth, time, methods[static_cast<std::size_t>(scene) % methods.size()],
                  "scene " + std::to_string(scene));
  }
}

/// An energy with a kink has a force that jumps: |u| with the force -n sign(u).
TEST(Jumps, OfEnergiesWithKinksArePassedRight) {
  Generator random(3);
  constexpr double time = 6.0;
  const std::vector<Method> methods = with_auto(list_adaptive_methods());
  for (int scene = 0; scene < 50; ++scene) {
    Formula formula = draw_formula(random);
    System system = make_formula(formula, random);
    for (std::size_t k = 0; k < 2; ++k)
      for (std::size_t c = 0; c < 3; ++c) formula.push[k][c] = -formula.normal[k][c];
    const auto numbered = [](std::string text) {
      for (const char name : {'x', 'y', 'z'})
        for (std::size_t at = 0; (at = text.find(std::string("*") + name, at)) != std::string::npos; at += 3)
          text.insert(at + 2, "1");
      return text;
    };
    const std::string u = numbered(formula.side(0)), w = numbered(formula.side(1));
    const std::string energy =
        "0.5*" + std::to_string(formula.stiffness) + "*(x1^2+y1^2+z1^2)+abs" + u + "+max(" + w + ",-" + w + ")";
    system.forces = {Potential{.points = {{0}}, .kernel = formula_potential(energy, 1)}};
    const Truth truth(motion_of(formula), start_of(system), time, 0.05);
    expect_motion(system, truth, time, methods[static_cast<std::size_t>(scene) % methods.size()],
                  "scene " + std::to_string(scene));
  }
}

/// Makes a point on the x axis under this force.
System make_slider(const std::string& force) {
  System system;
  system.positions = {1.0, 0.0, 0.0};
  system.velocities = {0.5, 0.0, 0.0};
  system.masses = {1.0};
  system.forces = {FormulaForce{.name = "grip", .points = {0}, .kernel = formula_force({force, "0", "0"})}};
  return system;
}

/// Nothing tells how a motion goes on where a force drives it back from both sides: a slider that sticks, pulled by a
/// force or by a spring, and a bead that comes to rest in a notch, in finite time or ever sooner.
TEST(Jumps, FromWhichForcesDriveBackOnBothSidesAreNamed) {
  const auto expect_named = [](const char* force, Method method) {
    Simulation simulation(make_slider(force), {.method = method});

    const Outcome outcome = simulation.advance_to(100.0);

    EXPECT_FALSE(outcome.ok()) << force << ", " << name_of(method);
    EXPECT_NE(outcome.what.find("grip jumps without end at t = "), std::string::npos)
        << force << ", " << name_of(method) << ": " << outcome.what;
  };
  for (const char* const force : {"0.3-vx/abs(vx)", "-x-2*vx/abs(vx)", "-x/abs(x)-0.3*vx/abs(vx)"})
    for (const Method method : with_auto(list_adaptive_methods())) expect_named(force, method);
  expect_named("-x/abs(x)-3*vx", Method::Taylor);  // some thousand jumps
}

/// Right behind each stop s(t) v/|v| is small over small, where a power series is rounding alone.
TEST(Jumps, OfASenseWhoseSizeSwingsArePassedRight) {
  constexpr double time = 10.0;
  const jumps::Piecewise motion{.rate =
                                    [](const std::vector<bool>& is_positive, const Numbers& y) {
                                      const double size = std::sin(7.0 * y[2]);
                                      return Numbers{y[1], -y[0] - (is_positive[0] ? size : -size), 1.0};
                                    },
                                .sides = [](const Numbers& y) { return Numbers{y[1]}; }};
  const Numbers right = jumps::follow(motion, {1.0, 0.5, 0.0}, time, 0.02);
  for (const Method method : with_auto(list_adaptive_methods())) {
    Simulation simulation(make_slider("-x-sin(7*t)*vx/abs(vx)"), {.method = method, .rtol = 1e-10, .atol = 1e-12});

    ASSERT_TRUE(simulation.advance_to(time).ok()) << name_of(method) << ": " << simulation.outcome().what;

    EXPECT_NEAR(simulation.positions()[0], right[0], 1e-8) << name_of(method);
    EXPECT_NEAR(simulation.velocities()[0], right[1], 1e-8) << name_of(method);
  }
}

/// The period of a bead in a notch is 4 v.
TEST(Jumps, OfANotchWithoutLossesArePassedForEver) {
  System system = make_slider("-x/abs(x)");
  system.positions[0] = 0.125e-4;
  system.velocities[0] = 0.0;
  for (const Method method : with_auto(list_adaptive_methods())) {
    Simulation simulation(system, {.method = method, .rtol = 1e-11, .atol = 1e-15});

    ASSERT_TRUE(simulation.advance_to(100.0 * 0.02).ok()) << name_of(method) << ": " << simulation.outcome().what;

    EXPECT_NEAR(simulation.positions()[0], 0.125e-4, 1e-10) << name_of(method);
    EXPECT_NEAR(simulation.velocities()[0], 0.0, 1e-8) << name_of(method);
  }
}

/// A force that jumps is not rounding, though a state at the jump has it on one side only.
TEST(Jumps, AreNoRounding) {
  System system = make_scattering(1.0);
  system.positions[3] = std::sqrt(2.5 * 2.5 - 1.0);  // the motion begins at the cutoff
  const Truth truth(motion_of(system), start_of(system), 6.0, 0.01);
  for (const Method method : methods_of_pairs) {
    expect_motion(system, truth, 6.0, method, "at the cutoff");
    Simulation simulation(system, {.method = method, .rtol = 1e-11, .atol = 1e-13});
    ASSERT_TRUE(simulation.advance_to(6.0).ok());
    EXPECT_EQ(simulation.report().accuracy_warning, "") << name_of(method);
  }
}

}  // namespace
}  // namespace tanor
