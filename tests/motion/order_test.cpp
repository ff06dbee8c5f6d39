/// Methods show their order when steps of equal length are halved, on motions that are known in closed form.

#include <cmath>
#include <functional>
#include <initializer_list>
#include <numbers>
#include <ostream>
#include <vector>

#include <gtest/gtest.h>

#include "dynamics/forms.hpp"
#include "motion/elliptic.hpp"
#include "motion/scheme.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

using std::numbers::pi;

/// A motion that is known, with the distance of a state from the truth at t.
struct KnownMotion {
  std::string name;
  std::function<System()> build;
  std::function<double(double t, const std::vector<double>& x)> measure_error;
};

/// Makes a pendulum of 0.1 m that is released horizontally.
KnownMotion make_pendulum() {
  return {"pendulum", [] { return scenes::make_pendulum(); },
          [](double t, const std::vector<double>& x) {
            const double angle = elliptic::swing(0.5 * pi, std::sqrt(9.81 / 0.1), t).angle;
            return std::hypot(x[3] - 0.1 * std::sin(angle), x[5] + 0.1 * std::cos(angle));
          }};
}

/// Makes a bead on a hoop of radius 1 that turns about its vertical diameter with omega = 3, without gravity. Twice the
/// polar angle swings about pi, theta'' = omega^2 sin(theta) cos(theta).
KnownMotion make_hoop() {
  static constexpr double omega = 3.0, start = 0.3;
  const auto build = [] {
    System system;
    scenes::add_point({std::sin(start), 0, std::cos(start)}, &system);
    system.velocities = {0, omega * std::sin(start), 0};
    const VectorFunction normal = {ScalarFunction::formula("-sin(3*t)"), ScalarFunction::formula("cos(3*t)"), 0.0};
    system.constraints = {Circles{"hoop", {0}, Vector3{0, 0, 0}, normal, 1.0}};
    return system;
  };
  return {"hoop", build, [](double t, const std::vector<double>& x) {
            const double theta = 0.5 * (pi + elliptic::swing(2.0 * start - pi, omega, t).angle);
            return std::hypot(x[0] - std::sin(theta) * std::cos(omega * t),
                              x[1] - std::sin(theta) * std::sin(omega * t), x[2] - std::cos(theta));
          }};
}

/// Makes a spherical pendulum of length 2, pushed sideways at its lowest point, z1. Its height is
///
///   z = z1 + (z2 - z1) sn^2(sqrt(g (z3 - z1)/(2 l^2)) t),  z'^2 l^2 = 2 (e - g z)(l^2 - z^2) - c^2
KnownMotion make_spherical_pendulum() {
  static constexpr double l = 2.0, g = 9.81, z1 = -1.6, rho = 1.2, speed = 5.0;
  const auto build = [] {
    System system;
    scenes::add_point({rho, 0, z1}, &system);
    system.velocities = {0, speed, 0};
    system.constraints = {Spheres{"sphere", {0}, Vector3{0, 0, 0}, l}};
    system.forces = {scenes::gravity};
    return system;
  };
  return {"spherical pendulum", build, [](double t, const std::vector<double>& x) {
            // The cubic (2 g z - 2 e)(z^2 - l^2) - c^2 without its root z1 is 2 g (z^2 + p z + q).
            const double e = 0.5 * speed * speed + g * z1;
            const double p = z1 - e / g, q = p * z1 - l * l, root = std::sqrt(0.25 * p * p - q);
            const double z2 = -0.5 * p - root, z3 = -0.5 * p + root;
            const double k = std::sqrt((z2 - z1) / (z3 - z1));
            const double sn = elliptic::evaluate(std::sqrt(g * (z3 - z1) / (2.0 * l * l)) * t, k).sn;
            return std::abs(x[2] - (z1 + (z2 - z1) * sn * sn));
          }};
}

/// Makes a bead on an inclined line that a spring draws to the origin, in air. From rest at s = 1 it moves by
/// s'' = -k/m s - c/m s'.
KnownMotion make_damped_bead() {
  static constexpr double stiffness = 0.1, drag = 0.02;
  const auto build = [] {
    System system;
    scenes::add_point({0.6, 0, 0.8}, &system);
    scenes::add_point({0, 0, 0}, &system);
    system.supports = {{"origin", {1}, {}}};
    system.constraints = {Lines{"line", {0}, Vector3{0, 0, 0}, Vector3{3, 0, 4}}};
    system.forces = {Springs{"spring", {{0, 1}}, stiffness, 0.0, 0.0}, Drag{"air", {0}, drag, 0.0}};
    return system;
  };
  return {"damped bead", build, [](double t, const std::vector<double>& x) {
            const double decay = 0.5 * drag / scenes::mass;
            const double frequency = std::sqrt(stiffness / scenes::mass - decay * decay);
            const double s =
                std::exp(-decay * t) * (std::cos(frequency * t) + decay / frequency * std::sin(frequency * t));
            return std::hypot(x[0] - 0.6 * s, x[1], x[2] - 0.8 * s);
          }};
}

/// Returns the largest error on the way to t_end in steps of equal length.
double run(const KnownMotion& motion, Method method, double t_end, int steps) {
  Forms forms(motion.build(), {});
  EquationsOfMotion& form = *forms.main;
  const std::unique_ptr<Scheme> scheme =
      make_scheme(method, MotionOptions{.method = method, .rtol = 1.0, .atol = 1.0}, form);
  State state;
  for (std::vector<double>* array : {&state.x, &state.v, &state.a}) array->resize(form.size());
  const std::vector<double> r = forms.model.system.positions, v = forms.model.system.velocities;
  std::vector<double> inner_r(r.size()), inner_v(v.size()), outer(r.size());
  forms.model.numbering.gather_points(r, inner_r);
  forms.model.numbering.gather_points(v, inner_v);
  Outcome found = form.set_state(0.0, inner_r.data(), inner_v.data(), state.x.data(), state.v.data());
  if (found.ok()) found = form.linearise(0.0, state.x.data());
  if (found.ok()) found = form.accelerations(state.at(), {Gradients::Keep}, state.output());
  State next = state;
  double worst = 0.0;
  for (int k = 1; found.ok() && k <= steps; ++k) {
    next.t = t_end * k / steps;
    found = scheme->step(state, next.t - state.t, &next).outcome;
    std::swap(state, next);
    forms.model.numbering.scatter_points(state.x, outer);
    worst = std::max(worst, motion.measure_error(state.t, outer));
  }
  EXPECT_TRUE(found.ok()) << found.what;
  return worst;
}

struct Order {
  Method method;
  double order;
  int steps;

  friend std::ostream& operator<<(std::ostream& out, const Order& one) { return out << name_of(one.method); }
};

class OrderTest : public testing::TestWithParam<Order> {};

void expect_order(const KnownMotion& motion, const Order& scheme, double t_end, int steps, double above) {
  const double coarse = run(motion, scheme.method, t_end, steps), fine = run(motion, scheme.method, t_end, 2 * steps);

  const double found = std::log2(coarse / fine);
  const int of_table = traits_of(scheme.method).order;  // 0 if it is as the tolerance asks
  EXPECT_EQ(scheme.order, of_table > 0 ? of_table : scheme.order);
  EXPECT_GT(found, scheme.order - 0.15) << motion.name << ": " << coarse << ", " << fine;
  EXPECT_LT(found, scheme.order + above) << motion.name << ": " << coarse << ", " << fine;
}

TEST_P(OrderTest, ErrorFallsByTheOrderOfTheMethod) {
  for (const auto& [motion, t_end] : std::initializer_list<std::pair<KnownMotion, double>>{
           {make_pendulum(), 1.0}, {make_hoop(), 2.0}, {make_spherical_pendulum(), 5.0}, {make_damped_bead(), 20.0}})
    expect_order(motion, GetParam(), t_end, GetParam().steps, 0.15);
}

INSTANTIATE_TEST_SUITE_P(Methods, OrderTest,
                         testing::Values(Order{Method::Rk4, 4, 800}, Order{Method::Dopri5, 5, 200},
                                         Order{Method::Rattle, 2, 2000}, Order{Method::Rattle4, 4, 200},
                                         Order{Method::Rattle6, 6, 80}, Order{Method::Taylor, 5, 100}),
                         [](const auto& instance) { return std::string(name_of(instance.param.method)); });

/// The leading term of dop853 is small. In long steps and in long motions the next term, of order 9 (its energy drifts
/// with that order), hides it, and in short steps rounding does. Steps between them show it in each motion.
TEST(OrderOfDop853, ErrorFallsByTheOrderOfTheMethod) {
  const Order dop853{Method::Dop853, 8, 0};
  expect_order(make_damped_bead(), dop853, 20.0, 20, 0.15);
  expect_order(make_hoop(), dop853, 1.5, 16, 0.15);
  expect_order(make_pendulum(), dop853, 0.25, 10, 0.3);
  expect_order(make_spherical_pendulum(), dop853, 5.0, 56, 0.3);
}

}  // namespace
}  // namespace tanor
