#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tanor/tanor.hpp>

#include "base/parallel.hpp"
#include "methods.hpp"
#include "motion/rough_guides.hpp"

/// \file Three beads on rough lines, joined by springs, stop and leave many times. They are compared with a reference
/// in long double: m s_ddot = F.e - mu_k |F - (F.e) e| sign(s_dot), classical Runge-Kutta steps, events by bisection.
namespace tanor {
using namespace detail;
namespace {

using Real = long double;
using Triple = std::array<Real, 3>;

constexpr std::array<Triple, 3> origins{{{0.0L, 0.0L, 0.0L}, {1.0L, 0.25L, 0.0L}, {2.0L, -0.125L, 0.5L}}};
constexpr std::array<Triple, 3> directions{{{0.6L, 0.8L, 0.0L}, {0.0L, 0.6L, 0.8L}, {0.8L, 0.0L, -0.6L}}};
constexpr std::array<Real, 3> masses{0.5L, 0.75L, 1.25L}, starts{1.5L, -2.0L, 0.5L};
constexpr Real mu_k = 0.25L, mu_s = 0.3125L, stiffness = 30.0L, rest = 0.875L;
constexpr Triple gravity{0.0L, 0.0L, -1.5L};
constexpr double t_end = 2.0;

System make_beads() {
  System system;
  Coulomb rough{.name = "", .at = {}, .coefficient = static_cast<double>(mu_k)};
  rough.static_coefficient = static_cast<double>(mu_s);
  const auto vector = [](const Triple& a) {
    return Vector3{static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])};
  };
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      system.positions.push_back(static_cast<double>(origins[i][c]));
      system.velocities.push_back(static_cast<double>(starts[i] * directions[i][c]));
    }
    system.masses.push_back(static_cast<double>(masses[i]));
    rough.at.push_back("line" + std::to_string(i));
    system.constraints.push_back(
        Lines{rough.at.back(), {static_cast<Index>(i)}, vector(origins[i]), vector(directions[i])});
  }
  system.forces = {Gravity{"", vector(gravity)},
                   Springs{"", {{0, 1}, {1, 2}}, static_cast<double>(stiffness), 0.0, static_cast<double>(rest)}};
  system.friction = {rough};
  return system;
}

class Reference {
 public:
  Reference() {
    for (std::size_t i = 0; i < 3; ++i) x_[3 + i] = starts[i], modes_[i] = starts[i] > 0.0L ? 1 : -1;
    advance();
  }
  std::vector<double> events;
  double place(std::size_t i) const { return static_cast<double>(x_[i]); }
  double speed(std::size_t i) const { return static_cast<double>(x_[3 + i]); }

 private:
  using State = std::array<Real, 6>;
  State x_{};
  std::array<int, 3> modes_{};  // 0 if it sticks

  struct Parts {
    Real along, across;
  };
  static std::array<Parts, 3> forces(const State& x) {
    std::array<Triple, 3> r{}, f{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        r[i][c] = origins[i][c] + x[i] * directions[i][c];
        f[i][c] = masses[i] * gravity[c];
      }
    }
    for (std::size_t i = 0; i < 2; ++i) {
      Triple d{};
      Real length = 0.0L;
      for (std::size_t c = 0; c < 3; ++c) d[c] = r[i + 1][c] - r[i][c], length += d[c] * d[c];
      length = std::sqrt(length);
      for (std::size_t c = 0; c < 3; ++c) {
        f[i][c] += stiffness * (length - rest) * d[c] / length;
        f[i + 1][c] -= stiffness * (length - rest) * d[c] / length;
      }
    }
    std::array<Parts, 3> result{};
    for (std::size_t i = 0; i < 3; ++i) {
      Real along = 0.0L, square = 0.0L;
      for (std::size_t c = 0; c < 3; ++c) along += f[i][c] * directions[i][c];
      for (std::size_t c = 0; c < 3; ++c) square += std::pow(f[i][c] - along * directions[i][c], 2);
      result[i] = {along, std::sqrt(square)};
    }
    return result;
  }
  State slope(const State& x) const {
    const auto f = forces(x);
    State d{};
    for (std::size_t i = 0; i < 3; ++i) {
      if (modes_[i] == 0) continue;
      d[i] = x[3 + i];
      d[3 + i] = (f[i].along - mu_k * f[i].across * static_cast<Real>(modes_[i])) / masses[i];
    }
    return d;
  }
  State step(const State& x, Real h) const {
    const auto at = [&](const State& k, Real s) {
      State y = x;
      for (std::size_t i = 0; i < 6; ++i) y[i] += s * k[i];
      return y;
    };
    const State a = slope(x), b = slope(at(a, h / 2)), c = slope(at(b, h / 2)), d = slope(at(c, h));
    State y = x;
    for (std::size_t i = 0; i < 6; ++i) y[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
    return y;
  }
  /// Returns a number that is positive as long as the mode of bead i lasts.
  Real lasts(const State& x, std::size_t i) const {
    if (modes_[i] != 0) return x[3 + i] * static_cast<Real>(modes_[i]);
    const Parts f = forces(x)[i];
    return mu_s * f.across - std::abs(f.along);
  }
  void advance() {
    const Real h = 2e-4L;
    Real t = 0.0L;
    while (t < t_end) {
      const Real full = std::min(h, t_end - t);
      State next = step(x_, full);
      std::size_t first = 3;
      Real taken = full;
      for (std::size_t i = 0; i < 3; ++i) {
        if (lasts(next, i) >= 0.0L || lasts(x_, i) < 0.0L) continue;
        const Real at = find_root([&](Real s) { return lasts(step(x_, s), i); }, 0.0L, full);
        if (first == 3 || at < taken) first = i, taken = at;
      }
      if (first < 3) next = step(x_, taken);
      x_ = next;
      t += taken;
      if (first == 3) continue;
      events.push_back(static_cast<double>(t));
      const Parts f = forces(x_)[first];
      const bool holds = modes_[first] != 0 && std::abs(f.along) <= mu_s * f.across;
      modes_[first] = holds ? 0 : f.along > 0.0L ? 1 : -1;
      x_[3 + first] = 0.0L;
      if (!holds) x_[3 + first] = 1e-30L * static_cast<Real>(modes_[first]);
    }
  }
};

const Reference& reference() {
  static const Reference result;
  return result;
}

double error_of_places(const Simulation& simulation) {
  double worst = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double wanted =
          static_cast<double>(origins[i][c]) + reference().place(i) * static_cast<double>(directions[i][c]);
      worst = larger(worst, std::abs(simulation.positions()[3 * i + c] - wanted));
    }
  }
  return worst;
}

TEST(RoughSprings, EventsAreThoseOfTheReferenceToTenDigits) {
  ASSERT_GE(reference().events.size(), 5u);
  Simulation simulation(make_beads(), {.rtol = 1e-11, .atol = 1e-13});
  const std::vector<double> events = advance_and_list_events(&simulation, t_end);
  ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
  ASSERT_EQ(events.size(), reference().events.size());
  for (std::size_t e = 0; e < events.size(); ++e) EXPECT_NEAR(events[e], reference().events[e], 1e-9) << "event " << e;
  EXPECT_LE(error_of_places(simulation), 1e-9);
  EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-9);
  EXPECT_LT(simulation.report().energy.work_of_friction, 0.0);
}

TEST(RoughSprings, HalfTheStepDividesTheErrorAsTheOrderSays) {
  for (const auto& [method, step, least, largest] :
       {std::tuple{Method::Rk4, 0.005, 3.3, 4.8}, {Method::Rattle, 0.002, 1.7, 2.3}}) {
    std::array<double, 2> errors{};
    for (const int k : {0, 1}) {
      Simulation simulation(make_beads(), {.method = method, .step = k == 0 ? step : 0.5 * step});
      ASSERT_TRUE(simulation.advance_to(t_end).ok()) << simulation.outcome().what;
      EXPECT_EQ(simulation.report().events, reference().events.size());
      errors[static_cast<std::size_t>(k)] = error_of_places(simulation);
    }
    const double order = std::log2(errors[0] / errors[1]);
    EXPECT_GE(order, least) << name_of(method) << " errors " << errors[0] << " and " << errors[1];
    EXPECT_LE(order, largest) << name_of(method) << " errors " << errors[0] << " and " << errors[1];
  }
}

TEST(RoughSprings, ARestoredMotionGoesOnBitByBit) {
  for (const Method method : sampled_methods) {
    MotionOptions options{.method = method, .rtol = 1e-9, .atol = 1e-11};
    if (has_fixed_steps(method)) options.step = 0.002;
    Simulation whole(make_beads(), options), other(make_beads(), options);
    for (const double t : {0.3, 0.7, 1.1, 1.5}) {
      if (whole.time() < t) {
        ASSERT_TRUE(whole.advance_to(t).ok());
      }
      other.restore(whole.save());
      ASSERT_TRUE(whole.advance_to(t + 0.3).ok());
      ASSERT_TRUE(other.advance_to(t + 0.3).ok());
      for (std::size_t i = 0; i < 9; ++i) {
        if (method == Method::Rattle) {
          EXPECT_NEAR(other.positions()[i], whole.positions()[i], 1e-12);
        } else {
          EXPECT_EQ(other.positions()[i], whole.positions()[i]) << name_of(method) << " t = " << t;
          EXPECT_EQ(other.velocities()[i], whole.velocities()[i]) << name_of(method) << " t = " << t;
        }
      }
      EXPECT_EQ(other.report().events, whole.report().events);
    }
  }
}

}  // namespace
}  // namespace tanor
