/// Motions that end where a part of a rope, a leg of an angle or a rod has length 0.

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "base/vec3.hpp"
#include "motion/by_method.hpp"
#include "motion/method_options.hpp"

namespace tanor {
using namespace detail;
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// Two points on a rope over two wheels: |r_0 - a| + ratio |r_1 - b| stays the same.
struct Rope {
  std::array<Vec3, 2> wheels, r, v;
  std::array<double, 2> masses;
  double ratio;
  Vec3 gravity;

  std::array<double, 2> pulls() const { return {1.0, ratio}; }

  System make_system() const {
    System system;
    for (std::size_t i = 0; i < 2; ++i)
      system.add_point({.position = {r[i].x, r[i].y, r[i].z}, .velocity = {v[i].x, v[i].y, v[i].z}, .mass = masses[i]});
    Pulleys rope{.name = "rope", .pairs = {{0, 1}}};
    rope.a = {wheels[0].x, wheels[0].y, wheels[0].z};
    rope.b = {wheels[1].x, wheels[1].y, wheels[1].z};
    rope.ratio = ratio;
    system.constraints = {rope};
    system.forces = {Gravity{"gravity", {gravity.x, gravity.y, gravity.z}}};
    return system;
  }

  /// Returns the accelerations g - T ratio_i u_i/m_i, where the tension T keeps the second derivative of the length 0:
  ///
  ///   T sum ratio_i^2/m_i = sum ratio_i (u_i'g + (v_i^2 - (u_i'v_i)^2)/l_i)
  std::array<Vec3, 2> accelerations(const std::array<Vec3, 2>& at, const std::array<Vec3, 2>& velocities) const {
    double load = 0.0, flexibility = 0.0;
    std::array<Vec3, 2> u;
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3 d = at[i] - wheels[i];
      u[i] = 1.0 / norm(d) * d;
      const double along = dot(u[i], velocities[i]);
      load += pulls()[i] * (dot(u[i], gravity) + (squared(velocities[i]) - along * along) / norm(d));
      flexibility += pulls()[i] * pulls()[i] / masses[i];
    }
    std::array<Vec3, 2> a;
    for (std::size_t i = 0; i < 2; ++i) a[i] = gravity - load / flexibility * pulls()[i] / masses[i] * u[i];
    return a;
  }

  /// Steps by the classical Runge-Kutta method. Returns the shortest part on the way, m.
  double integrate(double t_end, int steps) {
    const double h = t_end / steps;
    double shortest = never;
    for (int step = 0; step < steps; ++step) {
      std::array<std::array<Vec3, 2>, 4> dr, dv;
      std::array<Vec3, 2> at = r, velocities = v;
      for (std::size_t stage = 0; stage < 4; ++stage) {
        dr[stage] = velocities;
        dv[stage] = accelerations(at, velocities);
        const double next = stage < 2 ? 0.5 * h : h;
        for (std::size_t i = 0; i < 2; ++i) {
          at[i] = r[i] + next * dr[stage][i];
          velocities[i] = v[i] + next * dv[stage][i];
        }
      }
      for (std::size_t i = 0; i < 2; ++i) {
        r[i] = r[i] + h / 6.0 * (dr[0][i] + 2.0 * dr[1][i] + 2.0 * dr[2][i] + dr[3][i]);
        v[i] = v[i] + h / 6.0 * (dv[0][i] + 2.0 * dv[1][i] + 2.0 * dv[2][i] + dv[3][i]);
        shortest = std::min(shortest, norm(r[i] - wheels[i]));
      }
    }
    return shortest;
  }
};

class Draws {
 public:
  explicit Draws(unsigned seed) : random_(seed) {}

  double between(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random_); }
  Vec3 direction() {
    const Vec3 d{between(-1, 1), between(-1, 1), between(-1, 1)};
    return norm(d) > 0.1 ? 1.0 / norm(d) * d : direction();
  }
  /// Points that hang from their wheels and swing if `swing` is not 0, m/s.
  Rope draw(double swing) {
    Rope rope;
    const Vec3 down = direction();
    rope.gravity = between(1.0, 10.0) * down;
    rope.ratio = between(0.5, 2.0) * (between(0.0, 1.0) < 0.2 ? -1.0 : 1.0);
    const double speed = between(-1.5, 1.5);
    for (std::size_t i = 0; i < 2; ++i) {
      rope.wheels[i] = between(0.0, 2.0) * direction();
      rope.masses[i] = between(0.5, 3.0);
      rope.r[i] = rope.wheels[i] + between(0.3, 2.0) * down;
      rope.v[i] = (i == 0 ? -rope.ratio * speed : speed) * down;
      const Vec3 aside = cross(down, direction());
      rope.v[i] = rope.v[i] + swing * aside;
    }
    return rope;
  }

 private:
  std::mt19937 random_;
};

/// Returns the first time at which l + v t + a t^2/2 is 0, s.
double first_zero(double l, double v, double a) {
  double first = never;
  const double root = std::sqrt(v * v - 2.0 * a * l);
  if (std::isnan(root)) return never;
  for (const double sign : {-1.0, 1.0}) {
    // The form without cancellation, 2 l/(-v +- root).
    const double t = 2.0 * l / (-v + sign * root);
    if (t > 0.0) first = std::min(first, t);
  }
  return first;
}

constexpr double t_end = 1.5;

class VanishingArmsTest : public testing::TestWithParam<Method> {
 protected:
  MotionOptions options() const { return with(GetParam(), 0.01); }
};

TEST_P(VanishingArmsTest, EndTheMotionWhereAWeightReachesItsWheel) {
  Rope rope{{Vec3{0, 0, 0}, Vec3{1, 0, 0}}, {Vec3{0, 0, -1}, Vec3{1, 0, -1}}, {}, {1.0, 2.0}, 1.0, {0, 0, -9.81}};
  Simulation simulation(rope.make_system(), options());

  const Outcome outcome = simulation.advance_to(t_end);

  // Atwood's machine: a = g (m_1 - m_0)/(m_0 + m_1) = 3.27 m/s^2.
  EXPECT_FALSE(outcome.ok());
  EXPECT_NE(outcome.what.find("rope[0]: the part from a to point 0 has run out at t = 0.7821"), std::string::npos)
      << outcome.what;
  EXPECT_NEAR(simulation.time(), std::sqrt(2.0 / 3.27), 1e-8);
  EXPECT_NEAR(simulation.positions()[2], 0.0, 1e-8);
  EXPECT_FALSE(simulation.advance_to(t_end).ok());
  EXPECT_NEAR(simulation.time(), std::sqrt(2.0 / 3.27), 1e-8);
}

/// One of these makes the instant hard to find.
enum class Hanging { Usual, NoForce, LittleForce, NearItsEnd };

/// Weights that hang straight move evenly accelerated: m_1 l_1'' = m_1 g - ratio T and l_0'' = -ratio l_1'' give
/// l_1'' = g (m_1 - ratio m_0)/(m_1 + ratio^2 m_0).
struct HangingRope {
  Rope rope;
  std::array<double, 2> l, speeds, a, ends;
  double end;

  HangingRope(Rope drawn, Hanging hanging, Draws* draws) : rope(std::move(drawn)) {
    const Vec3 down = 1.0 / norm(rope.gravity) * rope.gravity;
    if (hanging == Hanging::NoForce) rope.gravity = {};
    if (hanging == Hanging::LittleForce) rope.gravity = std::pow(10.0, draws->between(-12.0, -3.0)) * down;
    if (hanging == Hanging::NearItsEnd) rope.r[0] = rope.wheels[0] + std::pow(10.0, draws->between(-7.0, -3.0)) * down;
    const double a1 = dot(rope.gravity, down) * (rope.masses[1] - rope.ratio * rope.masses[0]) /
                      (rope.masses[1] + rope.ratio * rope.ratio * rope.masses[0]);
    a = {-rope.ratio * a1, a1};
    for (std::size_t i = 0; i < 2; ++i) {
      l[i] = norm(rope.r[i] - rope.wheels[i]);
      speeds[i] = dot(rope.v[i], down);
      ends[i] = first_zero(l[i], speeds[i], a[i]);
    }
    end = std::min(ends[0], ends[1]);
  }
  /// Returns the rounding of the instant, s: that of places, over the speed there.
  double rounding() const {
    const std::size_t i = ends[0] < ends[1] ? 0 : 1;
    return 5e-9 / std::min(1.0, std::abs(speeds[i] + a[i] * end));
  }
};

class DrawnRopes : public VanishingArmsTest {
 protected:
  /// Rounding is more than 1e-12 to the iterations of radau5.
  MotionOptions options() const {
    MotionOptions options = VanishingArmsTest::options();
    if (GetParam() == Method::Radau5) options.rtol = options.atol = 1e-11;
    return options;
  }
  void expect_end(const HangingRope& hanging, double advance_to) const {
    SCOPED_TRACE(testing::Message() << "ends at " << hanging.end << ", advanced to " << advance_to);
    Simulation simulation(hanging.rope.make_system(), options());

    const Outcome outcome = simulation.advance_to(advance_to);

    ASSERT_EQ(outcome.ok(), hanging.end > advance_to) << outcome.what;
    if (!outcome.ok()) {
      EXPECT_NEAR(simulation.time(), hanging.end, hanging.rounding());
      EXPECT_NE(outcome.what.find(hanging.ends[0] < hanging.ends[1] ? "from a to point 0" : "from b to point 1"),
                std::string::npos)
          << outcome.what;
      return;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      const double length = hanging.l[i] + advance_to * (hanging.speeds[i] + 0.5 * advance_to * hanging.a[i]);
      EXPECT_NEAR(norm(load(simulation.positions().data(), i) - hanging.rope.wheels[i]), length, 1e-8);
    }
  }
};

TEST_P(DrawnRopes, EndAtTheInstantOfTheClosedForm) {
  Draws draws(static_cast<unsigned>(GetParam()));
  int ended = 0;
  for (int draw = 0; draw < 100; ++draw) {
    const HangingRope hanging(draws.draw(0.0), static_cast<Hanging>(draw % 4), &draws);
    SCOPED_TRACE(testing::Message() << "draw " << draw);
    if (std::abs(hanging.end - t_end) < 1e-6) continue;
    expect_end(hanging, t_end);
    if (hanging.end < t_end) ++ended;
  }
  EXPECT_GT(ended, 30);
}

/// A motion that is advanced to the very instant at which it ends has ended.
TEST_P(DrawnRopes, EndAlsoWhereAnAdvanceEnds) {
  Draws draws(100 + static_cast<unsigned>(GetParam()));
  for (int draw = 0; draw < 40; ++draw) {
    const HangingRope hanging(draws.draw(0.0), static_cast<Hanging>(draw % 4), &draws);
    SCOPED_TRACE(testing::Message() << "draw " << draw);
    // Rounding of a short part turns the rope, which tells after a while.
    if (draw % 4 == 3 && hanging.end > 0.01) continue;
    if (hanging.end < t_end) expect_end(hanging, hanging.end);
  }
}

/// A right angle about a fixed corner. One leg shrinks at 1 m/s.
TEST_P(VanishingArmsTest, EndTheMotionWhereALegOfAnAngleVanishes) {
  System system;
  system.add_point({.position = {1, 0, 0}, .velocity = {-1, 0, 0}, .mass = 1.0});
  system.add_point({.position = {0, 0, 0}, .mass = 1.0});
  system.add_point({.position = {0, 1, 0}, .mass = 1.0});
  system.supports = {{"corner", {1}}};
  system.constraints = {Angles{"corner", {{0, 1, 2}}}};
  Simulation simulation(system, options());

  const Outcome outcome = simulation.advance_to(t_end);

  EXPECT_FALSE(outcome.ok());
  EXPECT_NE(outcome.what.find("corner[0]: the leg from point 1 to point 0 has run out at t = "), std::string::npos)
      << outcome.what;
  EXPECT_NEAR(simulation.time(), 1.0, 1e-8);
}

/// Two beads on a rod of the length l - b t - c t^2, which move along it or turn about each other.
struct ShrinkingRod {
  double l, b, c;
  Vec3 along, drift, turn{};
  std::array<double, 2> masses;

  double length(double t) const { return l - t * (b + t * c); }
  double end() const { return first_zero(l, -b, -2.0 * c); }
  System make_system() const {
    System system;
    for (std::size_t i = 0; i < 2; ++i) {
      const double part = (i == 0 ? -1.0 : 1.0) * masses[1 - i] / (masses[0] + masses[1]);
      const Vec3 r = part * l * along, v = drift + part * (turn - b * along);
      system.add_point({.position = {r.x, r.y, r.z}, .velocity = {v.x, v.y, v.z}, .mass = masses[i]});
    }
    const std::string text = std::to_string(l) + " - t*(" + std::to_string(b) + " + t*(" + std::to_string(c) + "))";
    system.constraints = {Rods{"shrinks", {{0, 1}}, ScalarFunction::formula(text), {}}};
    return system;
  }
};

/// The beads meet, whatever the steps. A rod whose length is negative afterwards would let them pass each other. Places
/// are known to 1e-12 of their distance from the origin, and the direction of a rod of some micrometres is lost, where
/// the projection may end the run before.
TEST_P(VanishingArmsTest, EndTheMotionWhereARodHasNoLength) {
  Draws draws(200 + static_cast<unsigned>(GetParam()));
  const auto drawn = [&](double a, double b) { return std::round(1e6 * draws.between(a, b)) / 1e6; };
  for (int draw = 0; draw < 35; ++draw) {
    SCOPED_TRACE(testing::Message() << "draw " << draw);
    const ShrinkingRod rod{.l = drawn(0.3, 2.0),
                           .b = drawn(-0.3, 1.5),
                           .c = drawn(0.1, 1.0),
                           .along = draws.direction(),
                           .drift = draws.between(0.0, 1.0) * draws.direction(),
                           .masses = {draws.between(0.5, 2.0), draws.between(0.5, 2.0)}};
    const double half = 0.5 * rod.end();
    Simulation simulation(rod.make_system(), options());

    ASSERT_TRUE(simulation.advance_to(half).ok()) << simulation.outcome().what;
    const double distance = norm(load(simulation.positions().data(), 1) - load(simulation.positions().data(), 0));
    EXPECT_NEAR(distance, rod.length(half), 1e-8);
    const Outcome outcome = simulation.advance_to(rod.end() + 1.0);

    EXPECT_FALSE(outcome.ok());
    EXPECT_NE(outcome.what.find("shrinks[0]"), std::string::npos) << outcome.what;
    EXPECT_NEAR(simulation.time(), rod.end(), 1e-4);
  }
}

/// Beads that turn about each other turn without end where their rod runs out, and no step comes there.
TEST(ShrinkingRods, AreNamedWhereTheyTurnEverFaster) {
  const ShrinkingRod rod{
      .l = 1.0, .b = 1.0, .c = 0.0, .along = {1, 0, 0}, .drift = {}, .turn = {0, 0.6, 0}, .masses = {1, 1}};
  for (const Method method : {Method::Dop853, Method::Radau5, Method::GeneralizedAlpha}) {
    Simulation simulation(rod.make_system(),
                          {.method = method, .step = has_fixed_steps(method) ? 2e-3 : 0.0, .rtol = 1e-6});

    const Outcome outcome = simulation.advance_to(1.5);

    EXPECT_FALSE(outcome.ok());
    EXPECT_NE(outcome.what.find("shrinks[0]: the rod from point 0 to point 1 has run out at t = 1"), std::string::npos)
        << outcome.what;
    EXPECT_NEAR(simulation.time(), 1.0, 1e-2);
  }
}

const auto every_method = testing::Values(Method::Taylor, Method::Dop853, Method::Dopri5, Method::Radau5, Method::Rk4,
                                          Method::Rattle, Method::Rattle4, Method::Rattle6, Method::GeneralizedAlpha);

INSTANTIATE_TEST_SUITE_P(Methods, VanishingArmsTest, every_method, name_method);

/// Fixed steps are exact here too, since the accelerations are constant.
INSTANTIATE_TEST_SUITE_P(Methods, DrawnRopes, every_method, name_method);

struct FixedSteps {
  Method method;
  int order;
};

class OrderOfFixedSteps : public testing::TestWithParam<FixedSteps> {};

/// Weights m_0 and m_1 on one rope, m_1 on a spring of stiffness k that ends at its wheel:
///
///   l_1 = e + (l_1(0) - e) cos(w t),   e = (m_1 - m_0) g/k,   w^2 = k/(m_0 + m_1),
///
/// and l_0 runs out where l_1 = l_0(0) + l_1(0).
TEST_P(OrderOfFixedSteps, IsThatOfTheInstantToo) {
  Rope rope{{Vec3{0, 0, 0}, Vec3{1, 0, 0}}, {Vec3{0, 0, -0.5}, Vec3{1, 0, -1}}, {}, {1.0, 2.0}, 1.0, {0, 0, -9.81}};
  System system = rope.make_system();
  system.add_point({.position = {1, 0, 0}, .mass = 1.0});
  system.supports = {{"wheel", {2}}};
  system.forces.emplace_back(Springs{"spring", {{1, 2}}, 5.0, 0.0, 0.0});
  const double e = 9.81 / 5.0, end = std::acos((1.5 - e) / (1.0 - e)) / std::sqrt(5.0 / 3.0);
  const auto find_error = [&](double step) {
    Simulation simulation(system, with(GetParam().method, step));
    const Outcome outcome = simulation.advance_to(t_end);
    EXPECT_NE(outcome.what.find("from a to point 0 has run out"), std::string::npos) << outcome.what;
    return std::abs(simulation.time() - end);
  };

  const double coarse = find_error(0.04), fine = find_error(0.02);

  EXPECT_LT(coarse, std::pow(0.04, GetParam().order));
  EXPECT_LT(fine, std::pow(0.5, GetParam().order - 0.7) * coarse + 1e-12) << coarse;
}

INSTANTIATE_TEST_SUITE_P(Methods, OrderOfFixedSteps,
                         testing::Values(FixedSteps{Method::Rk4, 4}, FixedSteps{Method::Rattle, 2},
                                         FixedSteps{Method::Rattle4, 4}, FixedSteps{Method::Rattle6, 6},
                                         FixedSteps{Method::GeneralizedAlpha, 2}),
                         [](const auto& steps) { return std::string(name_of(steps.param.method)); });

/// Drawn weights that swing come near their wheels at most, and the motion goes on.
TEST(SwingingWeights, PassTheirWheels) {
  Draws draws(7);
  int compared = 0;
  for (int draw = 0; draw < 60; ++draw) {
    const Rope rope = draws.draw(draws.between(0.5, 1.5));
    Rope reference = rope;
    const double shortest = reference.integrate(1.0, 4000);
    if (shortest < 0.1) continue;
    ++compared;
    Simulation simulation(rope.make_system(), with(draw % 2 == 0 ? Method::Taylor : Method::Dop853, 0.0));

    ASSERT_TRUE(simulation.advance_to(1.0).ok()) << simulation.outcome().what;

    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_LT(norm(load(simulation.positions().data(), i) - reference.r[i]), 1e-8) << draw;
  }
  EXPECT_GT(compared, 30);
}

}  // namespace
}  // namespace tanor
