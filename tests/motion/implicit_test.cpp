#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "dynamics/forms.hpp"
#include "motion/radau_coefficients.hpp"
#include "motion/scheme.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

/// A system that is advanced in steps of one length, whatever a scheme thinks of its errors.
class Walk {
 public:
  Walk(System system, const MotionOptions& options) : forms_(std::move(system), SolverOptions{}) {
    const Model& model = forms_.model;
    EquationsOfMotion& form = *forms_.main;
    std::vector<double> r(3 * model.num_points()), v(r);
    model.numbering.gather_points(model.system.positions, r);
    model.numbering.gather_points(model.system.velocities, v);
    EXPECT_TRUE(forms_.start(0.0, r.data(), v.data(), StartMode::Check).outcome.ok());
    for (std::vector<double>* array : {&now_.x, &now_.v, &now_.a}) array->resize(form.size());
    EXPECT_TRUE(form.set_state(0.0, r.data(), v.data(), now_.x.data(), now_.v.data()).ok());
    EXPECT_TRUE(form.linearise(0.0, now_.x.data()).ok());
    EXPECT_TRUE(form.accelerations(now_.at(), {Gradients::Keep}, now_.output()).ok());
    next_ = now_;
    scheme_ = make_scheme(options.method, options, form);
  }

  void go(double t_end, int steps) {
    for (int k = 1; k <= steps; ++k) {
      next_.t = t_end * k / steps;
      const StepResult result = scheme_->step(now_, next_.t - now_.t, &next_);
      ASSERT_TRUE(result.outcome.ok()) << result.outcome.what;
      ASSERT_LE(result.position_violation, 1e-12);
      std::swap(now_, next_);
    }
  }

  std::vector<double> positions() const { return in_users_order(now_.x); }
  std::vector<double> velocities() const { return in_users_order(now_.v); }
  const Power& work() const { return now_.work; }
  const Counters& counters() const { return forms_.work.counters; }

 private:
  std::vector<double> in_users_order(const std::vector<double>& inner) const {
    std::vector<double> user(inner.size());
    forms_.model.numbering.scatter_points(inner, user);
    return user;
  }

  Forms forms_;
  State now_, next_;
  std::unique_ptr<Scheme> scheme_;
};

using scenes::g;
constexpr double l = scenes::spacing;

MotionOptions exactly(Method method) {
  return {.method = method, .rtol = 1e-12, .atol = 1e-14};
}

// ---- the method's numbers ----

TEST(RadauCoefficientsTest, CollocationIsExactForCubicsAndQuadratureForFourthPowers) {
  const RadauCoefficients radau = radau_coefficients();
  for (int power = 1; power <= 3; ++power) {
    for (std::size_t i = 0; i < 3; ++i) {
      double sum = 0.0;
      for (std::size_t j = 0; j < 3; ++j) sum += radau.a[i][j] * std::pow(radau.c[j], power - 1);
      EXPECT_NEAR(sum, std::pow(radau.c[i], power) / power, 1e-15);
    }
  }
  double fifth = 0.0;
  for (std::size_t j = 0; j < 3; ++j) fifth += radau.a[2][j] * std::pow(radau.c[j], 4);
  EXPECT_NEAR(fifth, 0.2, 1e-15);
}

TEST(RadauCoefficientsTest, TransformationSplitsTheInverseIntoOneRealAndOneComplexNumber) {
  const RadauCoefficients radau = radau_coefficients();
  EXPECT_NEAR(radau.gamma, 3.637834252744496, 1e-14);  // Hairer & Wanner's radau5.f
  EXPECT_NEAR(radau.alpha_beta.real(), 2.681082873627752, 1e-14);
  EXPECT_NEAR(radau.alpha_beta.imag(), 3.050430199247411, 1e-14);
  const double alpha = radau.alpha_beta.real(), beta = radau.alpha_beta.imag();
  const RadauCoefficients::Matrix wanted{{{radau.gamma, 0, 0}, {0, alpha, -beta}, {0, beta, alpha}}};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      double sum = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t m = 0; m < 3; ++m) sum += radau.t_inverse[i][k] * radau.a_inverse[k][m] * radau.t[m][j];
      }
      EXPECT_NEAR(sum, wanted[i][j], 1e-13) << i << j;
    }
  }
}

// ---- order on closed forms ----

struct OrderWanted {
  Method method;
  double order;
  int steps;
};
class ImplicitOrderTest : public ::testing::TestWithParam<OrderWanted> {};
INSTANTIATE_TEST_SUITE_P(Methods, ImplicitOrderTest,
                         ::testing::Values(OrderWanted{Method::Radau5, 5.0, 16},
                                           OrderWanted{Method::GeneralizedAlpha, 2.0, 64}),
                         [](const auto& at) { return std::string(name_of(at.param.method)); });

/// A quarter of the period, sqrt(l/g) K(sin 45 degrees), leads from the horizontal to the lowest place.
TEST_P(ImplicitOrderTest, PendulumConvergesAtTheOrderOfTheMethod) {
  const auto [method, order, steps] = GetParam();
  const double quarter = std::sqrt(l / g) * std::comp_ellint_1(std::sqrt(0.5));
  double before = 0.0;
  for (const int n : {steps, 2 * steps, 4 * steps}) {
    Walk walk(scenes::make_pendulum(), exactly(method));
    walk.go(quarter, n);
    const double error = std::hypot(walk.velocities()[3] + std::sqrt(2.0 * g * l), walk.velocities()[5]);
    if (n > steps) {
      EXPECT_NEAR(std::log2(before / error), order, 0.15) << n;
    }
    before = error;
  }
  EXPECT_LT(before, method == Method::Radau5 ? 3e-10 : 1e-3);
}

/// A bead on a spring without rest length moves by x'' = -omega^2 x.
TEST_P(ImplicitOrderTest, OscillatorConvergesAtTheOrderOfTheMethod) {
  const auto [method, order, steps] = GetParam();
  const double omega = 5.0;
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({0, 0.01, -0.12}, &system);
  system.supports = {{"ceiling", {0}, {}}};
  system.forces = {Springs{"spring", {{0, 1}}, scenes::mass * omega * omega, 0.0, 0.0}};
  double before = 0.0;
  for (const int n : {steps, 2 * steps, 4 * steps}) {
    Walk walk(system, exactly(method));
    walk.go(1.0, n);
    const double error = std::abs(walk.positions()[5] + 0.12 * std::cos(omega));
    if (n > steps) {
      EXPECT_NEAR(std::log2(before / error), order, 0.15) << n;
    }
    before = error;
  }
}

/// A bead on a damped spring moves by z'' = -2 delta z' - omega^2 z. The work of the spring is the energy lost.
TEST_P(ImplicitOrderTest, DampedSpringAndItsWorkConvergeAtTheOrderOfTheMethod) {
  const auto [method, order, steps] = GetParam();
  const double omega = 8.0, delta = 1.5, fast = std::sqrt(omega * omega - delta * delta), m = scenes::mass;
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({0, 0, -0.12}, &system);
  system.supports = {{"ceiling", {0}, {}}};
  system.forces = {Springs{"spring", {{0, 1}}, m * omega * omega, 2.0 * delta * m, 0.1}};
  double before = 0.0, work_before = 0.0;
  for (const int n : {steps, 2 * steps, 4 * steps}) {
    Walk walk(system, exactly(method));
    walk.go(1.0, n);
    const double decay = 0.02 * std::exp(-delta);
    const double stretch = decay * (std::cos(fast) + delta / fast * std::sin(fast));
    const double speed = -decay * omega * omega / fast * std::sin(fast);
    const double lost = 0.5 * m * (speed * speed + omega * omega * (stretch * stretch - 0.02 * 0.02));
    const double error = std::abs(walk.positions()[5] + 0.1 + stretch),
                 work_error = std::abs(walk.work().forces - lost);
    if (n > steps) {
      EXPECT_NEAR(std::log2(before / error), order, 0.15) << n;
      EXPECT_NEAR(std::log2(work_before / work_error), order, 0.2) << n;
    }
    before = error;
    work_before = work_error;
  }
}

// ---- stiff springs ----

/// Makes four points in a row that fall from the horizontal, with rods outside and a rod or a spring in the middle.
System make_coupled_chain(double stiffness) {
  System system = scenes::make_chain(3);
  if (stiffness > 0.0) {
    std::get<Rods>(system.constraints[0]).pairs = {{0, 1}, {2, 3}};
    system.forces.push_back(Springs{"stiff", {{1, 2}}, stiffness, 0.0, {}});
  }
  return system;
}

const std::vector<double>& slow_motion() {
  static const std::vector<double> positions = [] {
    Simulation rigid(make_coupled_chain(0.0), {.method = Method::Dopri5, .rtol = 1e-12, .atol = 1e-13});
    EXPECT_TRUE(rigid.advance_to(0.5).ok());
    return std::vector<double>(rigid.positions().begin(), rigid.positions().end());
  }();
  return positions;
}

/// Returns the longest stable step of rk4, 2.83/omega with omega = sqrt(2 k/m).
double explicit_limit(double stiffness) {
  return 2.83 / std::sqrt(2.0 * stiffness / scenes::mass);
}

TEST(StiffSpringTest, RadauFollowsTheSlowMotionAHundredTimesBeyondTheExplicitLimit) {
  for (const double stiffness : {1e8, 1e10}) {
    Walk walk(make_coupled_chain(stiffness), {.method = Method::Radau5, .rtol = 1e-9, .atol = 1e-11});
    const int steps = 78;
    ASSERT_GT(0.5 / steps, 100.0 * explicit_limit(stiffness));
    walk.go(0.5, steps);
    // The spring gives way by F/k, F some N: 5.9/k m at the tip.
    EXPECT_LT(largest_difference(walk.positions(), slow_motion()), 1.2e-7 + 6.0 / stiffness);
  }
}

TEST(StiffSpringTest, GeneralizedAlphaConvergesToTheSlowMotionAtOrderTwo) {
  const double stiffness = 1e8;
  double before = 0.0;
  for (const int steps : {80, 160, 320}) {
    Walk walk(make_coupled_chain(stiffness), {.method = Method::GeneralizedAlpha, .rtol = 1e-9, .atol = 1e-11});
    walk.go(0.5, steps);
    const double error = largest_difference(walk.positions(), slow_motion());
    if (steps > 80) {
      EXPECT_NEAR(std::log2(before / error), 2.0, 0.15);
    }
    before = error;
  }
  EXPECT_LT(before, 5e-5);
}

TEST(StiffSpringTest, AnExplicitMethodFailsAtTheSameStep) {
  Simulation simulation(make_coupled_chain(1e8), {.method = Method::Rk4, .step = 0.5 / 80});
  const bool is_right =
      simulation.advance_to(0.5).ok() && largest_difference(simulation.positions(), slow_motion()) < 1e-2;
  EXPECT_FALSE(is_right);
}

/// However stiff the spring is, the slow motion differs from that with a rod by a number over k. The tolerance is kept
/// at the same cost.
TEST(StiffSpringTest, AdaptiveStepsDoNotSeeTheStiffness) {
  std::size_t evaluations = 0;
  for (const double stiffness : {1e6, 1e8, 1e10}) {
    Simulation simulation(make_coupled_chain(stiffness), {.method = Method::Radau5, .rtol = 1e-8, .atol = 1e-10});
    ASSERT_TRUE(simulation.advance_to(0.5).ok());
    const double error = largest_difference(simulation.positions(), slow_motion());
    EXPECT_NEAR(error * stiffness, 5.9, 0.1);
    if (evaluations > 0) {
      EXPECT_LT(simulation.report().counters.evaluations, 1.5 * static_cast<double>(evaluations));
    }
    evaluations = simulation.report().counters.evaluations;
    EXPECT_LT(simulation.report().violation.position, 1e-12);
    EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-8);
  }
}

/// A chain with a stiff spring swings a little, and the matrix of the first step serves all steps.
TEST(NewtonTest, OneFactorIsKeptWhileItConverges) {
  System system = make_coupled_chain(1e6);
  // The chain hangs, with a push that turns it by 0.01 rad.
  system.positions = {0, 0, 0, 0, 0, -0.1, 0, 0, -0.2, 0, 0, -0.3};
  system.velocities = {0, 0, 0, 0.001, 0, 0, 0.002, 0, 0, 0.003, 0, 0};
  for (const Method method : list_methods_that(&MethodTraits::is_implicit)) {
    Walk walk(system, {.method = method, .rtol = 1e-8, .atol = 1e-10});
    const std::size_t before = walk.counters().factorizations;
    const int steps = 50;
    walk.go(0.25, steps);
    // A step takes one factor of S. Newton's matrix takes one real factor and, in radau5, a complex one for all steps.
    EXPECT_EQ(walk.counters().factorizations - before - steps, method == Method::Radau5 ? 2u : 1u) << name_of(method);
  }
}

/// Where rtol is below rounding the absolute tolerance holds. Newton's iteration then goes on to that, whatever rtol
/// would say, and the motion is that of an rtol that still counts.
TEST(NewtonTest, TolerancesBelowRoundingCostNoDigits) {
  for (const System& system : {scenes::make_pendulum(), scenes::make_shaken_chain(3)}) {
    Simulation reference(system, {.method = Method::Taylor, .rtol = 1e-14, .atol = 1e-15});
    Simulation usual(system, {.method = Method::Radau5, .rtol = 1e-11});
    ASSERT_TRUE(reference.advance_to(0.2).ok());
    ASSERT_TRUE(usual.advance_to(0.2).ok());
    for (const double rtol : {1e-13, 1e-16, 1e-30}) {
      Simulation simulation(system, {.method = Method::Radau5, .rtol = rtol});

      ASSERT_TRUE(simulation.advance_to(0.2).ok()) << rtol << ": " << simulation.outcome().what;

      EXPECT_LE(largest_difference(simulation.positions(), reference.positions()), 1e-12) << rtol;
      EXPECT_LE(simulation.report().steps + simulation.report().rejected, usual.report().steps * 3 / 2 + 20) << rtol;
    }
  }
}

/// A rod is duplicated, so that K has lost a rank. Newton's matrix has a factor all the same.
TEST(NewtonTest, DependentConstraintsChangeNothing) {
  System single = make_coupled_chain(1e6), twice = single;
  std::get<Rods>(twice.constraints[0]).pairs.push_back({0, 1});
  Simulation a(single, {.method = Method::Radau5}), b(twice, {.method = Method::Radau5});
  ASSERT_TRUE(a.advance_to(0.2).ok());
  ASSERT_TRUE(b.advance_to(0.2).ok()) << b.outcome().what;
  EXPECT_LT(largest_difference(a.positions(), b.positions()), 1e-8);
}

/// The force is a stiff formula: y'' = -k y + k cos t along one axis, whose slow solution is k/(k - 1) cos t.
TEST(StiffFormulaTest, NewtonsMatrixHasTheDerivativesOfTheFormula) {
  System system;
  scenes::add_point({0, 1.0 / (1.0 - 1e-9), 0}, &system);
  system.masses[0] = 1.0;
  system.forces = {FormulaForce{"well", {0}, formula_force({"0", "1e9*(cos(t) - y)", "0"})}};
  Simulation simulation(system, {.method = Method::Radau5, .rtol = 1e-8, .atol = 1e-10});
  ASSERT_TRUE(simulation.advance_to(2.0).ok());
  EXPECT_NEAR(simulation.positions()[1], std::cos(2.0) / (1.0 - 1e-9), 1e-8);
  EXPECT_LT(simulation.report().steps, 1000u);  // explicit steps are stable from sqrt(1e9) 2/3.3 = 19,000 on
}

// ---- what is refused, and what `auto` does ----

TEST(ImplicitInputTest, SpectralRadiusLiesBetween0And1) {
  EXPECT_THROW(
      Simulation(scenes::make_pendulum(), {.method = Method::GeneralizedAlpha, .step = 0.01, .spectral_radius = 1.5}),
      InputError);
}

TEST(ImplicitInputTest, FrictionIsRefusedByName) {
  System system = scenes::make_pendulum();
  system.constraints.push_back(Planes{.name = "floor", .points = {1}, .normal = {0.0, 1.0, 0.0}});
  system.friction = {Coulomb{.name = "rust", .at = {"floor"}, .coefficient = 0.3}};
  try {
    Simulation simulation(system, {.method = Method::Radau5});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.where(), "/motion/method");
    EXPECT_NE(std::string(error.what()).find("radau5 does not know friction (rust)"), std::string::npos)
        << error.what();
  }
}

TEST(AutoTest, StiffSpringsAreSteppedImplicitly) {
  EXPECT_EQ(Simulation(make_coupled_chain(1e8), {.step = 1e-3}).report().method, Method::GeneralizedAlpha);
  EXPECT_NE(Simulation(make_coupled_chain(1e8), {.step = 1e-5}).report().method, Method::GeneralizedAlpha);
  EXPECT_EQ(Simulation(make_coupled_chain(1e10)).report().method, Method::Radau5);
  EXPECT_NE(Simulation(make_coupled_chain(1e4)).report().method, Method::Radau5);
}

}  // namespace
}  // namespace tanor
