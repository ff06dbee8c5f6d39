/// Points with coordinates of their own have accelerations in closed form. The tests compare them with H q_ddot = A'(f
/// - M psi) by its factor.

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tanor/motion.hpp>

#include "base/parallel.hpp"
#include "dynamics/forms.hpp"

namespace tanor {
using namespace detail;
namespace {

enum class Field { Uniform, Springs };

/// Makes points on guides of all kinds, some of which move.
System make_points(int count, Field field, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> any;
  const auto vector = [&] { return Vector3{any(generator), any(generator), any(generator)}; };
  System system;
  Springs springs{"", {}, 10.0, 0.1, 0.5};
  for (Index i = 0; i < count; ++i) {
    const Vector3 r = vector(), center = vector();
    system.positions.insert(system.positions.end(), r.begin(), r.end());
    system.masses.push_back(0.5 + std::abs(any(generator)));
    switch (generator() % 6) {
      case 0:
        system.coordinates.push_back(FreeCoordinates{"", {i}});
        break;
      case 1:
        system.coordinates.push_back(LineCoordinates{"", {i}, center, vector()});
        break;
      case 2:
        system.coordinates.push_back(PlaneCoordinates{"", {i}, vector()});
        break;
      case 3:
        system.coordinates.push_back(CircleCoordinates{"", {i}, center, vector()});
        break;
      case 4:
        system.coordinates.push_back(
            CircleCoordinates{"", {i}, center, vector(), ScalarFunction::formula("1.2 + 0.1*sin(t)")});
        break;
      default:
        system.coordinates.push_back(SphereCoordinates{"", {i}, center});
        break;
    }
    if (i > 0) springs.pairs.push_back({i - 1, i});
  }
  for (Index c = 0; c < 3 * count; ++c) system.velocities.push_back(any(generator));
  system.forces = {Gravity{"", {0.3, 0.0, -9.81}}};
  if (field == Field::Springs) system.forces.push_back(springs);
  return system;
}

/// The tangent form solved at one state.
struct SolvedTangentForm {
  Forms forms;
  bool exactly;
  double t;
  std::vector<double> q, q_dot, q_ddot, eta;
  Reactions reactions;
  Outcome outcome;

  SolvedTangentForm(const System& system, bool is_exact, double at, int threads = 1)
      : forms(system, {.form = Form::Tangent, .threads = threads}, at), exactly(is_exact), t(at) {
    TangentForm& form = *forms.tangent;
    for (std::vector<double>* array : {&q, &q_dot, &q_ddot}) array->resize(form.size());
    std::vector<double> r(system.positions.size()), v(r.size());
    forms.model.numbering.gather_points(system.positions, r);
    forms.model.numbering.gather_points(system.velocities, v);
    (void)form.start(t, r.data(), v.data(), StartMode::Project);
    outcome = form.set_state(t, r.data(), v.data(), q.data(), q_dot.data());
    if (outcome.ok())
      outcome = form.accelerations({t, q.data(), q_dot.data()}, {.exact = exactly},
                                   {q_ddot.data(), nullptr, nullptr, &reactions});
    eta.resize(r.size());
  }
  Kinematics at() const { return {t, q.data(), q_dot.data()}; }

  Power find_power() {
    Power power;
    outcome = forms.tangent->accelerations({t, q.data(), q_dot.data()}, {.exact = exactly}, {q_ddot.data(), &power});
    return power;
  }
};

void expect_near_relative(const std::vector<double>& a, const std::vector<double>& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  double scale = 1.0, difference = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    scale = std::max(scale, std::abs(b[k]));
    difference = larger(difference, std::abs(a[k] - b[k]));
  }
  RC_ASSERT(difference <= tolerance * scale);
}

RC_GTEST_PROP(TangentPoints, ClosedFormsAgreeWithTheFactor, ()) {
  const auto seed = *rc::gen::arbitrary<std::uint32_t>();
  for (const Field field : {Field::Uniform, Field::Springs}) {
    const System system = make_points(20, field, seed);
    SolvedTangentForm quick(system, false, 0.3), thorough(system, true, 0.3);
    RC_ASSERT(quick.outcome.ok() && thorough.outcome.ok());

    expect_near_relative(quick.q_ddot, thorough.q_ddot, 1e-11);
    expect_near_relative(quick.reactions.w, thorough.reactions.w, 1e-12);
    // The part that was left out is there when it is asked for.
    quick.forms.tangent->write_reactions(quick.at(), quick.reactions, quick.eta.data());
    thorough.forms.tangent->write_reactions(thorough.at(), thorough.reactions, thorough.eta.data());
    expect_near_relative(quick.eta, thorough.eta, 1e-11);
    expect_near_relative(quick.forms.tangent->dynamics().blocks(), thorough.forms.tangent->dynamics().blocks(), 1e-13);
    expect_near_relative(quick.forms.tangent->dynamics().psi(), thorough.forms.tangent->dynamics().psi(), 1e-12);
    const Power power = quick.find_power(), wanted = thorough.find_power();
    RC_ASSERT(std::abs(power.supports - wanted.supports) <= 1e-10 * (1.0 + std::abs(wanted.supports)));
  }
}

TEST(TangentPoints, ReactionsStayThoseOfTheirStateWhereOthersAreFoundLater) {
  for (const Field field : {Field::Uniform, Field::Springs}) {
    SolvedTangentForm solved(make_points(20, field, 7), false, 0.3);
    TangentForm& form = *solved.forms.tangent;
    form.write_reactions(solved.at(), solved.reactions, solved.eta.data());
    const std::vector<double> eta = solved.eta;

    std::vector<double> faster = solved.q_dot, q_ddot(faster.size());
    for (double& rate : faster) rate *= 2.0;
    ASSERT_TRUE(form.accelerations({solved.t, solved.q.data(), faster.data()}, {}, q_ddot.data()).ok());
    form.write_reactions(solved.at(), solved.reactions, solved.eta.data());

    EXPECT_EQ(solved.eta, eta);
  }
}

TEST(TangentPoints, ThreadsGiveTheSameBits) {
  const System system = make_points(20'000, Field::Uniform, 5);
  const auto accelerations = [&](int threads) {
    SolvedTangentForm solved(system, false, 0.3, threads);
    EXPECT_TRUE(solved.outcome.ok());
    return solved.q_ddot;
  };
  EXPECT_EQ(accelerations(1), accelerations(2));
}

/// Beads on spheres, whose charts move with them, are joined by springs.
TEST(TangentPoints, ReactionsAfterStepsAreThoseOfTheState) {
  System system;
  Springs springs{"", {}, 50.0, 0.0, 0.2};
  for (Index i = 0; i < 5; ++i) {
    const double angle = 0.4 * i;
    system.positions.insert(system.positions.end(), {std::cos(angle), std::sin(angle), 0.0});
    system.velocities.insert(system.velocities.end(), {0.0, 0.0, 1.0 + 0.3 * i});
    system.masses.push_back(1.0 + 0.2 * i);
    if (i > 0) springs.pairs.push_back({i - 1, i});
  }
  system.coordinates = {SphereCoordinates{"", {0, 1, 2, 3, 4}, Vector3{0, 0, 0}}};
  system.forces = {Gravity{"", {0, 0, -9.81}}, springs};
  for (const Method method : {Method::Rk4, Method::Dop853}) {
    MotionOptions motion{.method = method, .rtol = 1e-9};
    if (method == Method::Rk4) motion.step = 1e-3;
    Simulation simulation(system, motion, {.form = Form::Tangent});
    const auto as_vector = [](std::span<const double> x) { return std::vector(x.begin(), x.end()); };
    for (const double t : {0.05, 0.1, 0.3}) {
      ASSERT_TRUE(simulation.advance_to(t).ok());
      const std::vector<double> r = as_vector(simulation.positions()), v = as_vector(simulation.velocities()),
                                eta = as_vector(simulation.reactions());

      SolvedTangentForm exactly(system, true, 0.0);
      TangentForm& form = *exactly.forms.tangent;
      ASSERT_TRUE(form.set_state(t, r.data(), v.data(), exactly.q.data(), exactly.q_dot.data()).ok());
      const Kinematics at{t, exactly.q.data(), exactly.q_dot.data()};
      ASSERT_TRUE(
          form.accelerations(at, {.exact = true}, {exactly.q_ddot.data(), nullptr, nullptr, &exactly.reactions}).ok());
      form.write_reactions(at, exactly.reactions, exactly.eta.data());
      for (std::size_t c = 0; c < eta.size(); ++c) EXPECT_NEAR(eta[c], exactly.eta[c], 1e-8) << t;
    }
    EXPECT_EQ(simulation.report().accuracy_warning, "") << name_of(method);
  }
}

/// The circle has radius R in the plane y z, so that q'' = -(g/R) sin q from the lowest place on.
TEST(TangentPoints, PendulumIsRightAtAnglesOfManyTurns) {
  constexpr double radius = 0.7, gravity = 9.81;
  System system;
  system.positions = {0.0, 0.0, -radius};
  system.masses = {2.0};
  system.coordinates = {CircleCoordinates{"", {0}, Vector3{0, 0, 0}, Vector3{1, 0, 0}, radius}};
  system.forces = {Gravity{"", {0, 0, -gravity}}};
  Forms forms(system, {.form = Form::Tangent});
  std::vector<double> r = system.positions, v(3, 0.0);
  double lowest = 0.0, rest = 0.0;
  ASSERT_TRUE(forms.tangent->set_state(0.0, r.data(), v.data(), &lowest, &rest).ok());
  for (const double turns : {0.0, 1.0, 1e3, 3e5}) {
    for (double angle = 0.1; angle < 6.0; angle += 0.7) {
      const double q = lowest + angle + turns * 2.0 * std::numbers::pi, q_dot = 1.5;
      double q_ddot = 0.0;
      ASSERT_TRUE(forms.tangent->accelerations({0.0, &q, &q_dot}, {}, &q_ddot).ok());
      const double rounding = 1e-15 * (10.0 + std::abs(q));
      EXPECT_NEAR(q_ddot, -gravity / radius * std::sin(q - lowest), gravity / radius * 2.0 * rounding) << turns;
    }
  }
}

}  // namespace
}  // namespace tanor
