/// Events of drawn functions, whose passages are known.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "methods.hpp"
#include "motion/by_method.hpp"
#include "motion/elliptic.hpp"
#include "motion/method_options.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

using std::numbers::pi;
using Points = std::span<const double>;

constexpr double gravity = 9.81, rise = 12.0, t_end = 3.0;  // m/s^2, m/s, s

/// Returns a bead at x = t, z = rise t - gravity t^2/2.
System make_throw() {
  System system;
  system.add_point({.position = {0, 0, 0}, .velocity = {1, 0, rise}, .mass = 1.0});
  system.forces = {Gravity{"gravity", {0, 0, -gravity}}};
  return system;
}

struct EventDraw {
  Event event;
  std::vector<double> times;  // s, of its passages
};

class Draws {
 public:
  explicit Draws(unsigned seed) : random_(seed) {}

  EventDraw draw() {
    EventDraw result;
    switch (random_() % 4) {
      case 0:
        result = draw_polynomial();
        break;
      case 1:
        result = draw_sine();
        break;
      case 2:
        result = draw_level();
        break;
      default:
        result = draw_curve();
        break;
    }
    std::erase_if(result.times, [](double t) { return !(t > 0.0 && t < t_end); });
    std::sort(result.times.begin(), result.times.end());
    return result;
  }

 private:
  double part() { return std::uniform_real_distribution<double>(0.0, 1.0)(random_); }

  /// A product of x - x_k.
  EventDraw draw_polynomial() {
    std::vector<double> roots(1 + random_() % 7);
    for (double& root : roots) root = -1.0 + 5.0 * part();
    return {{"polynomial",
             [roots](double, Points r, Points) {
               double product = 1.0;
               for (const double root : roots) product *= r[0] - root;
               return product;
             }},
            roots};
  }

  /// c + sin(w x + p), with up to 13 turns.
  EventDraw draw_sine() {
    const double w = 27.0 * part(), p = 2.0 * pi * part(), c = 1.96 * part() - 0.98;
    EventDraw result{{"sine", [=](double, Points r, Points) { return c + std::sin(w * r[0] + p); }}, {}};
    for (int turn = -1; turn < 20; ++turn)
      for (const double angle : {std::asin(-c), pi - std::asin(-c)})
        result.times.push_back((angle + 2.0 * pi * turn - p) / w);
    return result;
  }

  /// A level by 1e-1 … 1e-11 of a metre below the top of the throw, or above it.
  EventDraw draw_level() {
    const double below = std::pow(10.0, -1.0 - 10.0 * part()) * (part() < 0.5 ? -1.0 : 1.0);
    const double top = rise / gravity, apart = below > 0.0 ? std::sqrt(2.0 * below / gravity) : 0.0;
    const double level = 0.5 * rise * top - below;
    EventDraw result{{"level", [=](double, Points r, Points) { return r[2] - level; }}, {}};
    if (below > 0.0) result.times = {top - apart, top + apart};
    return result;
  }

  /// The distance from an oblique line, by a velocity and a time as well.
  EventDraw draw_curve() {
    const double first = 4.0 * part() - 0.5, second = 4.0 * part() - 0.5, size = std::exp(10.0 * part() - 5.0);
    return {{"curve",
             [=](double t, Points, Points v) {
               // v_z = rise - gravity t
               const double now = (rise - v[2]) / gravity;
               return size * (now - first) * (t - second);
             }},
            {first, second}};
  }

  std::mt19937 random_;
};

class EventDraws : public testing::TestWithParam<Method> {
 protected:
  MotionOptions options() const { return with(GetParam(), 0.25); }
};

TEST_P(EventDraws, HaveAllPassagesOfAThousandFunctionsAndNoneTwice) {
  Draws draws(static_cast<unsigned>(GetParam()));
  Simulation simulation(make_throw(), options());
  std::vector<EventDraw> all;
  for (int k = 0; k < 1000; ++k) {
    all.push_back(draws.draw());
    simulation.add_event(all.back().event);
  }

  ASSERT_TRUE(simulation.advance_to(t_end).ok()) << simulation.outcome().what;

  std::vector<std::vector<double>> found(all.size());
  for (const Passage& passage : simulation.passages()) found[passage.event].push_back(passage.time);
  for (std::size_t k = 0; k < all.size(); ++k) {
    SCOPED_TRACE(all[k].event.name + " " + std::to_string(k));
    ASSERT_EQ(found[k].size(), all[k].times.size());
    // Two roots of a polynomial that nearly coincide are known less well.
    for (std::size_t i = 0; i < found[k].size(); ++i) EXPECT_NEAR(found[k][i], all[k].times[i], 1e-7);
  }
  EXPECT_EQ(simulation.report().events_may_be_missed, "");
}

/// sin(3 x) vanishes nine times in 10 s.
TEST_P(EventDraws, AStoppingSineEndsAtItsFirstRoot) {
  System system;
  system.add_point({.position = {0, 0, 0}, .velocity = {1, 0, 0}, .mass = 1.0});
  const Event sine{"sine", [](double, Points r, Points) { return std::sin(3.0 * r[0]); }};
  Event stops = sine;
  stops.stops = true;
  Simulation all(system, options()), first(system, options());
  all.add_event(sine);
  first.add_event(stops);

  ASSERT_TRUE(all.advance_to(10.0).ok());
  ASSERT_EQ(all.passages().size(), 9U);
  for (std::size_t k = 0; k < 9; ++k) {
    EXPECT_NEAR(all.passages()[k].time, static_cast<double>(k + 1) * pi / 3.0, 1e-9);
    ASSERT_TRUE(first.advance_to(10.0).ok());
    EXPECT_NEAR(first.time(), static_cast<double>(k + 1) * pi / 3.0, 1e-9);
    EXPECT_EQ(first.passages().size(), k + 1);
  }
  ASSERT_TRUE(first.advance_to(10.0).ok());
  EXPECT_EQ(first.time(), 10.0);
  EXPECT_EQ(first.passages().size(), 9U);
}

/// A root at t_end counts there, and not again afterwards. One where the motion begins does not count.
TEST_P(EventDraws, ARootAtTheEndCountsOnceAndOneAtTheBeginningDoesNot) {
  System system;
  system.add_point({.position = {0, 0, 0}, .velocity = {1, 0, 0}, .mass = 1.0});
  for (const double root : {1.0, 1.1, pi / 3.0}) {
    Simulation simulation(system, options());
    simulation.add_event({"level", [=](double, Points r, Points) { return r[0] - root; }});
    simulation.add_event({"sine", [=](double, Points r, Points) { return std::sin(pi / root * r[0]); }});

    for (int k = 1; k <= 3; ++k) {
      ASSERT_TRUE(simulation.advance_to(k * root).ok());
      ASSERT_EQ(simulation.passages().size(), static_cast<std::size_t>(k + 1)) << root;
      EXPECT_NEAR(simulation.passages().back().time, k * root, 1e-12);
      EXPECT_EQ(simulation.passages().back().event, 1U);
    }
    ASSERT_TRUE(simulation.advance_to(3.5 * root).ok());
    EXPECT_EQ(simulation.passages().size(), 4U);
  }
}

/// A root where an advance ends, and another one right before it or right behind it, or behind the beginning.
TEST_P(EventDraws, TwoRootsBesideAnEndAreBothFound) {
  System system;
  system.add_point({.position = {0, 0, 0}, .velocity = {1, 0, 0}, .mass = 1.0});
  for (const double apart : {1e-2, 1e-4, 1e-5, 3e-6}) {
    for (const double size : {1.0, -3.0}) {
      Simulation simulation(system, options());
      std::vector<std::vector<double>> roots;
      const auto add = [&](double first, double second) {
        simulation.add_event({"times", [=](double t, Points, Points) { return size * (t - first) * (t - second); }});
        simulation.add_event(
            {"places", [=](double, Points r, Points) { return size * (r[0] - first) * (r[0] - second); }});
        roots.insert(roots.end(), 2, {first, second});
      };
      add(1.0, 1.0 + apart);
      add(1.0 - apart, 1.0);
      add(0.0, apart);

      for (const double t : {1.0, 2.0}) ASSERT_TRUE(simulation.advance_to(t).ok());

      std::vector<std::vector<double>> found(roots.size());
      for (const Passage& passage : simulation.passages()) found[passage.event].push_back(passage.time);
      for (std::size_t k = 0; k < roots.size(); ++k) {
        SCOPED_TRACE(std::to_string(k) + ", apart " + std::to_string(apart));
        if (roots[k][0] == 0.0) roots[k].erase(roots[k].begin());  // where the motion begins
        ASSERT_EQ(found[k].size(), roots[k].size());
        for (std::size_t i = 0; i < found[k].size(); ++i) EXPECT_NEAR(found[k][i], roots[k][i], 1e-3 * apart);
      }
    }
  }
}

TEST_P(EventDraws, TwoEventsAtOneTimeAreBothReportedWhereOneStops) {
  const auto through = [](double x0, double factor) {
    return [=](double, Points r, Points) { return factor * (r[0] - x0); };
  };
  Simulation simulation(make_throw(), options());
  simulation.add_event({"first", through(1.3, 1.0), {}, true});
  simulation.add_event({"second", through(1.3, -7.0)});

  ASSERT_TRUE(simulation.advance_to(t_end).ok());
  EXPECT_NEAR(simulation.time(), 1.3, 1e-9);
  EXPECT_EQ(simulation.passages().size(), 2U);
  for (const Passage& passage : simulation.passages()) EXPECT_EQ(passage.time, simulation.time());

  ASSERT_TRUE(simulation.advance_to(t_end).ok());
  EXPECT_EQ(simulation.time(), t_end);
  EXPECT_EQ(simulation.passages().size(), 2U);
}

/// Restored bytes hold no events. The passages behind them are found again, those before them stay.
TEST_P(EventDraws, AreFoundAgainAfterRestoring) {
  Simulation simulation(make_throw(), options());
  simulation.add_event({"sine", [](double, Points r, Points) { return std::sin(pi * r[0]); }, {}, true});
  ASSERT_TRUE(simulation.advance_to(t_end).ok());
  const std::vector<std::byte> at_first = simulation.save();
  ASSERT_TRUE(simulation.advance_to(2.5).ok());
  ASSERT_EQ(simulation.passages().size(), 2U);

  simulation.restore(at_first);
  EXPECT_EQ(simulation.passages().size(), 1U);
  ASSERT_TRUE(simulation.advance_to(2.5).ok());

  EXPECT_EQ(simulation.passages().size(), 2U);
  EXPECT_NEAR(simulation.time(), 2.0, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Methods, EventDraws,
                         testing::Values(Method::Taylor, Method::Dop853, Method::Dopri5, Method::Radau5, Method::Rk4,
                                         Method::Rattle, Method::Rattle4, Method::Rattle6, Method::GeneralizedAlpha),
                         name_method);

/// The pendulum turns 17 times in 34 quarters of its period, and passes a level 1e-6 m below its turn twice each time.
TEST(EventDraws, ALevelRightBelowTheTurnsOfAPendulumIsPassedTwiceAtEach) {
  const double quarter = elliptic::quarter_period(0.5 * pi, std::sqrt(9.81 / scenes::spacing));
  for (const Method method : {Method::Taylor, Method::Dop853, Method::Radau5}) {
    Simulation simulation(scenes::make_pendulum(), {.method = method, .rtol = 1e-12, .atol = 1e-14});
    simulation.add_event({"right", [](double, Points r, Points) { return r[3] - (0.1 - 1e-6); }});
    simulation.add_event({"left", [](double, Points r, Points) { return r[3] + (0.1 - 1e-6); }});

    ASSERT_TRUE(simulation.advance_to(35.0 * quarter).ok());

    // The pendulum begins on the right, where it passes the level once.
    ASSERT_EQ(simulation.passages().size(), 35U) << name_of(method);
    for (std::size_t k = 1; k < 35; k += 2) {
      const double turn = (static_cast<double>(k) + 1.0) * quarter;
      EXPECT_NEAR(0.5 * (simulation.passages()[k].time + simulation.passages()[k + 1].time), turn, 1e-7);
    }
  }
}

/// A bead between springs, x_k = A_k sin(w_k t + p_k), and a polynomial of degree two of its place.
struct Swing {
  std::array<double, 3> size, rate, phase;
  std::array<double, 7> factor;

  double value(const std::array<double, 3>& r) const {
    return factor[0] + factor[1] * r[0] + factor[2] * r[1] + factor[3] * r[2] + factor[4] * r[0] * r[1] +
           factor[5] * r[1] * r[2] + factor[6] * r[0] * r[0];
  }
  double at(double t) const {
    std::array<double, 3> r{};
    for (std::size_t k = 0; k < 3; ++k) r[k] = size[k] * std::sin(rate[k] * t + phase[k]);
    return value(r);
  }
  /// Returns the passages until `end`, by samples so dense that the value hardly bends between two. `is_clear` becomes
  /// false if it turns so near to 0 that rounding decides.
  std::vector<double> find_passages(double end, bool* is_clear) const {
    constexpr int samples = 20000;
    const double step = end / samples;
    std::vector<double> times;
    for (int i = 0; i < samples; ++i) {
      double low = i * step, high = low + step;
      const double before = at(low - step), first = at(low), last = at(high);
      const bool turns = std::abs(first) <= std::abs(before) && std::abs(first) <= std::abs(last);
      if (turns && before * last > 0.0 && std::abs(first) < 1e-6) *is_clear = false;
      if (first * last > 0.0) continue;
      for (int k = 0; k < 60; ++k) (at(0.5 * (low + high)) * first > 0.0 ? low : high) = 0.5 * (low + high);
      times.push_back(high);
    }
    return times;
  }
};

TEST(EventDraws, OfThreeHundredBeadsBetweenSpringsAreThoseOfADenseProgram) {
  std::mt19937_64 random(7);
  const auto draw = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  const std::vector<Method> methods = with_auto(list_adaptive_methods());
  constexpr double end = 5.0;
  std::size_t compared = 0;
  for (std::size_t scene = 0; scene < 300; ++scene) {
    Swing swing{};
    for (double& factor : swing.factor) factor = draw(-1.0, 1.0);
    System system;
    std::array<std::string, 3> force;
    PointStart point{.position = {}, .velocity = {}, .mass = 1.0};
    for (std::size_t k = 0; k < 3; ++k) {
      swing.size[k] = draw(0.3, 1.5);
      swing.rate[k] = draw(0.5, 6.0);
      swing.phase[k] = draw(0.0, 2.0 * pi);
      point.position[k] = swing.size[k] * std::sin(swing.phase[k]);
      point.velocity[k] = swing.size[k] * swing.rate[k] * std::cos(swing.phase[k]);
      char text[64];
      std::snprintf(text, sizeof text, "-(%.17g)*%c", swing.rate[k] * swing.rate[k], "xyz"[k]);
      force[k] = text;
    }
    system.add_point(point);
    system.forces = {FormulaForce{.points = {0}, .kernel = formula_force(force)}};
    bool is_clear = true;
    const std::vector<double> right = swing.find_passages(end, &is_clear);
    const Method method = methods[scene % methods.size()];
    Simulation simulation(system, {.method = method, .rtol = 1e-11, .atol = 1e-13});
    simulation.add_event({"level", [&](double, Points r, Points) { return swing.value({r[0], r[1], r[2]}); }});

    ASSERT_TRUE(simulation.advance_to(end).ok()) << simulation.outcome().what;

    if (!is_clear) continue;
    ++compared;
    SCOPED_TRACE("scene " + std::to_string(scene) + ", " + std::string(name_of(method)));
    ASSERT_EQ(simulation.passages().size(), right.size());
    for (std::size_t k = 0; k < right.size(); ++k) {
      const double slope = std::abs(swing.at(right[k] + 1e-6) - swing.at(right[k] - 1e-6)) / 2e-6;
      EXPECT_NEAR(simulation.passages()[k].time, right[k], 1e-8 * std::max(1.0, 1.0 / slope));
    }
  }
  EXPECT_GT(compared, 290U);
}

/// A sign that changes at a pole is no passage, of any order down to a cube root; one that jumps through 0 is.
/// Kinks near 0, near pairs of roots, and sines faster than the first samples are apart.
TEST_P(EventDraws, NarrowDipsAndFastSinesOfAFreeBeadHaveTheirPassages) {
  System bead;
  bead.add_point({.position = {0, 0, 0}, .velocity = {1, 0, 0}, .mass = 1.0});
  const auto count = [&](const std::function<double(double)>& g) {
    Simulation simulation(bead, options());
    simulation.add_event({.value = [&](double, Points r, Points) { return g(r[0]); }});
    EXPECT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;
    return simulation.passages().size();
  };
  for (int k = 0; k < 50; ++k) {
    const double c = 2.0137 + 0.12 * k;
    EXPECT_EQ(count([c](double x) { return std::hypot(x - c, 0.005) - 0.01; }), 2u) << c;
    std::size_t roots = 0;
    for (int turn = -2; turn < 3; ++turn)
      for (const double x : {c - 0.05 + 2.0 * pi * turn, c + 0.05 + 2.0 * pi * turn}) roots += x > 0.0 && x < 10.0;
    EXPECT_EQ(count([c](double x) { return std::cos(x - c) - std::cos(0.05); }), roots) << c;
  }
  EXPECT_EQ(count([](double x) { return std::sin(200.0 * pi * x + 0.5); }), 2000u);
  // A kink within a thousandth of the end, and a function that grows by sixty orders behind its roots.
  for (const double apart : {5e-3, 1e-4, 1e-6})
    EXPECT_EQ(count([&](double x) { return std::abs(x - 10.0 + apart) - 0.6 * apart; }), 2u) << apart;
  EXPECT_EQ(count([](double x) { return std::expm1(20.0 * (x - 3.0137)) * (x - 3.0147); }), 2u);
}

TEST_P(EventDraws, APoleIsNoPassageAndAJumpIs) {
  std::mt19937_64 random(3);
  const auto draw = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  Simulation simulation(make_throw(), options());
  std::vector<double> roots;
  for (int k = 0; k < 100; ++k) {
    const double root = draw(0.1, 2.9), pole = draw(0.1, 2.9), other = draw(0.1, 2.9);
    const std::array orders{1.0, 3.0, 1.0 / 3.0};
    const double order = orders[static_cast<std::size_t>(k) % orders.size()];
    roots.push_back(root);
    simulation.add_event({"fraction", [=](double, Points r, Points) {
                            const auto power = [=](double x) { return std::copysign(std::pow(std::abs(x), order), x); };
                            return (r[0] - root) / (power(r[0] - pole) * power(r[0] - other));
                          }});
  }
  for (int k = 0; k < 100; ++k) {
    roots.push_back(draw(0.1, 2.9));
    simulation.add_event(
        {"step", [root = roots.back()](double, Points r, Points) { return r[0] < root ? -1.0 : 1.0; }});
  }

  ASSERT_TRUE(simulation.advance_to(t_end).ok()) << simulation.outcome().what;

  std::vector<std::vector<double>> found(roots.size());
  for (const Passage& passage : simulation.passages()) found[passage.event].push_back(passage.time);
  for (std::size_t k = 0; k < roots.size(); ++k) {
    ASSERT_EQ(found[k].size(), 1U) << k;
    EXPECT_NEAR(found[k][0], roots[k], 1e-9) << k;
  }
}

TEST(EventDraws, ALevelAtTheTopIsInDoubt) {
  const double top = 0.5 * rise * rise / gravity;
  Simulation simulation(make_throw());
  simulation.add_event({"top", [=](double, Points r, Points) { return r[2] - top; }});

  ASSERT_TRUE(simulation.advance_to(t_end).ok());

  EXPECT_NE(simulation.report().events_may_be_missed.find("event \"top\" may pass 0 unseen near t = 1.2"),
            std::string::npos)
      << simulation.report().events_may_be_missed;
}

TEST(EventDraws, NoiseIsInDoubt) {
  Simulation simulation(make_throw());
  simulation.add_event({"", [=](double, Points r, Points) { return std::sin(1e13 * r[0] * r[0]); }});

  ASSERT_TRUE(simulation.advance_to(0.1).ok());

  EXPECT_NE(simulation.report().events_may_be_missed.find("event 0"), std::string::npos);
}

}  // namespace
}  // namespace tanor
