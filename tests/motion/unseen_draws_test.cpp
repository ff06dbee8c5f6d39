/// Random draws show that nothing that acts goes unseen between the ends of a step.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <sstream>
#include <string>

#include <tanor/tanor.hpp>

#include "long_tests.hpp"
#include "motion/unseen_scenes.hpp"

namespace tanor {
namespace {

using namespace unseen_scenes;

/// Draws numbers that do not depend on the distributions of the standard library.
class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  double uniform(double a, double b) { return a + (b - a) * static_cast<double>(engine_()) / 4294967296.0; }
  double log_uniform(double a, double b) { return std::exp(uniform(std::log(a), std::log(b))); }
  template <class T, std::size_t n>
  T choose(const std::array<T, n>& from) {
    return from[engine_() % n];
  }

 private:
  std::mt19937 engine_;
};

/// The result of one draw, with its error over the tolerance.
struct Result {
  std::string scene;
  double miss = 0.0;       // over atol + rtol times the largest of the motion
  double allowed = 100.0;  // more for waves, as ordinary errors of thousands of steps add up
  bool is_told = false;    // exit 3, or a warning
};

constexpr double rtol = 1e-8, atol = 1e-10;

Result compare(Simulation* simulation, double end, double x, double v, double x_size, double v_size,
               const std::string& scene, double periods) {
  const Outcome outcome = simulation->advance_to(end);
  Result result{scene, 0.0, std::max(100.0, 10.0 * periods),
                !outcome.ok() || !simulation->report().accuracy_warning.empty()};
  result.scene += ": " + outcome.what + simulation->report().accuracy_warning;
  const double of_x = std::abs(simulation->positions().end()[-3] - x) / (atol + rtol * x_size);
  const double of_v = std::abs(simulation->velocities().end()[-3] - v) / (atol + rtol * v_size);
  result.miss = std::max(of_x, of_v);
  return result;
}

/// The first draws of each scene: how long it lasts, what acts, and the method.
struct Drawn {
  unsigned seed;
  Draw draw;
  double end, width, center;
  Shape shape;
  int kind;
  Method method;
  MotionOptions options;
  double periods;
  bool has_corners;

  explicit Drawn(unsigned from)
      : seed(from),
        draw(from),
        end(draw.log_uniform(1.0, 100.0)),
        width(end * draw.log_uniform(1e-3, 1.0)),
        center(draw.uniform(0.05, 0.95) * end),
        shape(draw.choose(std::array{Shape::Pulse, Shape::Triangle, Shape::Window, Shape::Wave})),
        kind(draw.choose(std::array{0, 1, 2, 3, 4, 5, 6, 7})),
        method(choose_method()),
        options{.method = method, .rtol = rtol, .atol = atol},
        periods(shape == Shape::Wave ? end / width : 0.0),
        has_corners(shape == Shape::Triangle || shape == Shape::Window) {}

  /// Returns a method that serves friction for the scenes with it.
  Method choose_method() {
    const bool is_rough = kind == 3 || kind == 4;
    if (is_rough) return draw.choose(std::array{Method::Auto, Method::Dop853, Method::Dopri5});
    return draw.choose(std::array{Method::Auto, Method::Taylor, Method::Dop853, Method::Dopri5, Method::Radau5});
  }
  std::string describe(const std::string& what, const Unseen& g) const {
    std::ostringstream scene;
    scene.precision(17);
    scene << what << " " << g.text() << " to t = " << end << " by " << name_of(method);
    return "draw " + std::to_string(seed) + ": " + scene.str();
  }
};

/// A force acts on a free point: a formula of time, a formula of state and time, an energy or a callable.
Result push_free_point(Drawn drawn) {
  const double end = drawn.end;
  const Unseen g(drawn.shape, drawn.draw.log_uniform(0.1, 100.0), drawn.center, drawn.width);
  System system = make_free_point();
  if (drawn.kind == 0) {
    system.forces = {ConstantForce{.points = {0}, .force = along_x(formula_of(g))}};
  } else if (drawn.kind == 1 && drawn.seed % 2 == 0) {
    system.forces = {FormulaForce{.points = {0}, .kernel = formula_force({g.text(), "0", "0"})}};
  } else if (drawn.kind == 1) {
    system.forces = {Potential{.points = {{0}}, .kernel = formula_potential("-x1*" + g.text(), 1)}};
  } else {
    const ScalarFunction f = formula_of(g);
    auto callable = [f](const Jet<2>& t) { return f(t.value()); };
    system.forces = {ConstantForce{.points = {0}, .force = along_x(ScalarFunction::custom(callable))}};
    if (drawn.method == Method::Taylor) drawn.options.method = Method::Auto;
  }
  Simulation simulation(system, drawn.options);
  const double v = g.integral(end), x = g.second_integral(end);
  double speed = 0.0;
  for (int k = 1; k <= 100; ++k) speed = std::max(speed, std::abs(g.integral(end * k / 100)));
  return compare(&simulation, end, x, v, std::max(std::abs(x), speed * end), speed, drawn.describe("a force", g),
                 drawn.periods);
}

/// A force pulls a block that sticks.
Result pull_block(Drawn drawn) {
  const double end = drawn.end, width = drawn.width;
  const Unseen g(drawn.shape, drawn.draw.uniform(0.5, 3.0) * 2.0, drawn.center, width);
  System system = make_block(0.2, {});
  system.forces.push_back(ConstantForce{.points = {0}, .force = along_x(formula_of(g))});
  Simulation simulation(system, drawn.options);
  RoughBlock truth(&g, nullptr, 2.0);
  truth.advance(end, width / 4000.0);
  const double size = std::max(1e-3 * width * width, std::abs(truth.x));
  return compare(&simulation, end, truth.x, truth.v, size, width, drawn.describe("a block, pulled by", g),
                 drawn.periods);
}

/// A belt runs under a block that slides.
Result carry_block(Drawn drawn) {
  const double end = drawn.end, width = drawn.width;
  const Shape shape = drawn.shape == Shape::Window ? Shape::Pulse : drawn.shape;
  const Unseen u(shape, drawn.draw.uniform(0.5, 3.0), drawn.center, width);
  System system = make_block(0.1, along_x(formula_of(u)));
  const double speed = drawn.draw.uniform(0.0, 2.0) * end;
  system.velocities = {speed, 0.0, 0.0};
  Simulation simulation(system, drawn.options);
  RoughBlock truth(nullptr, &u, 1.0);
  truth.v = speed;
  truth.advance(end, width / 4000.0);
  std::ostringstream what;
  what.precision(17);
  what << "v = " << speed << ", a block on a belt";
  return compare(&simulation, end, truth.x, truth.v, std::max(std::abs(truth.x), end), std::max(speed, 3.0),
                 drawn.describe(what.str(), u), drawn.periods);
}

/// A support draws a point by a spring: x'' = -rate^2 (x - d).
Result move_support(Drawn drawn) {
  const double end = drawn.end, rate = drawn.draw.uniform(2.0, 20.0) / end;
  const Unseen d(drawn.has_corners ? Shape::Pulse : drawn.shape, 1.0, drawn.center, drawn.width);
  System system;
  system.positions = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  system.masses = {1.0, 1.0};
  system.supports = {{.points = {0}, .displacement = along_x(formula_of(d))}};
  system.forces = {Springs{.pairs = {{0, 1}}, .stiffness = rate * rate, .rest_length = 0.0}};
  Simulation simulation(system, drawn.options);
  const double x = integrate([&](double t) { return rate * std::sin(rate * (end - t)) * d.value(t); }, end, d);
  const double v = integrate([&](double t) { return rate * rate * std::cos(rate * (end - t)) * d.value(t); }, end, d);
  return compare(&simulation, end, x, v, 1.0, std::max(1.0, rate), drawn.describe("a support, moved by", d),
                 drawn.periods);
}

/// A point goes round on a rod, or a sphere, whose length is 1 + g, so that length^2 angle' is constant.
Result turn_on_rod(Drawn drawn) {
  const double end = drawn.end, width = drawn.width, rate = drawn.draw.uniform(2.0, 20.0) / end;
  // Higher waves would run in and out too fast to turn.
  const double height = drawn.shape == Shape::Wave ? 0.3 * width / end : 0.3;
  const Unseen g(drawn.has_corners ? Shape::Pulse : drawn.shape, height, drawn.center, width);
  const double at_start = 1.0 + g.value(0.0);
  System system;
  system.positions = {0.0, 0.0, 0.0, at_start, 0.0, 0.0};
  system.velocities = {0.0, 0.0, 0.0, g.slope(0.0), rate, 0.0};
  system.masses = {1.0, 1.0};
  system.supports = {{.points = {0}, .displacement = {}}};
  const ScalarFunction length = ScalarFunction::formula("1 + " + g.text());
  if (drawn.kind == 6)
    system.constraints = {Rods{.pairs = {{0, 1}}, .length = length}};
  else
    system.constraints = {UserConstraints{
        .tuples = {{1}}, .kernel = formula_constraint("x1^2 + y1^2 + z1^2 - (1 + " + g.text() + ")^2", 1)}};
  Simulation simulation(system, drawn.options);
  const double angle =
      integrate([&](double t) { return at_start * rate / ((1.0 + g.value(t)) * (1.0 + g.value(t))); }, end, g);
  const double at_end = 1.0 + g.value(end), turn = at_start * rate / (at_end * at_end);
  const double x = at_end * std::cos(angle);
  const double v = g.slope(end) * std::cos(angle) - at_end * turn * std::sin(angle);
  const double size = std::max(1.0, angle);
  return compare(&simulation, end, x, v, size, size * std::max(rate, height / width),
                 drawn.describe("a rod as long as 1 +", g), drawn.periods);
}

/// Runs one scene with a random shape, height and width, of which nobody warns the method.
Result draw_one(unsigned seed) {
  const Drawn drawn(seed);
  if (drawn.kind <= 2) return push_free_point(drawn);
  if (drawn.kind == 3) return pull_block(drawn);
  if (drawn.kind == 4) return carry_block(drawn);
  if (drawn.kind == 5) return move_support(drawn);
  return turn_on_rod(drawn);
}

TEST(Unseen, RandomPulsesAreSeenByEveryMethod) {
  const int count = num_draws(1000);
  double worst = 0.0;
  int told = 0, missed = 0;
  for (int k = 0; k < count; ++k) {
    const Result result = draw_one(static_cast<unsigned>(k));
    if (result.is_told) ++told;
    if (result.is_told) std::printf("told: %s\n", result.scene.c_str());
    if (!result.is_told) worst = std::max(worst, result.miss * 100.0 / result.allowed);
    if (result.is_told || result.miss <= result.allowed) continue;
    ++missed;
    ADD_FAILURE() << result.scene << ": off by " << result.miss << " tolerances";
  }
  EXPECT_EQ(missed, 0);
  EXPECT_LE(told, count / 100);
  std::printf("%d draws, %d told, worst miss %.3g tolerances\n", count, told, worst);
}

}  // namespace
}  // namespace tanor
