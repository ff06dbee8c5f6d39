/// The tangent form: r = r(q, t), H q_ddot = A'(f - M psi). Against motions that are known, the normal form, and the
/// paper's formulas with dense matrices.

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tanor/motion.hpp>

#include "dynamics/forms.hpp"
#include "random_coordinates.hpp"

namespace tanor {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using reference::vector;

/// The system solved in one form at (t, r, v).
struct Answer {
  Dynamics dynamics;
  std::vector<double> w, lambda, eta;
  SolveReport report;

  Answer(const System& system, Form form, double t, const std::vector<double>& r, const std::vector<double>& v)
      : dynamics(system, {.form = form}), w(r.size()), lambda(dynamics.num_equations()), eta(r.size()) {
    report = dynamics.solve(t, r, v, w, lambda, eta);
  }
};

/// Adds what makes the points run as they do, f = M w - n, with some forces n = K mu that do no work along T; returns n
/// on all points, 0 at supports.
VectorXd add_driving_forces(RandomCoordinates* random, double t) {
  System& system = random->system;
  system.forces.clear();
  const std::vector<double> r = random->derivative(t, 0), v = random->derivative(t, 1), w = random->derivative(t, 2);
  const auto numbers = reference::evaluate_constraints(system, t, r, v);
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  VectorXd mu(numbers.K.cols());
  for (double& x : mu) x = normal(generator);
  VectorXd n = numbers.K * mu;
  const std::vector<char> is_support = reference::find_supports(system);
  for (std::size_t i = 0; i < system.num_points(); ++i) {
    const auto c = static_cast<Eigen::Index>(3 * i);
    if (is_support[i]) {
      n.segment<3>(c).setZero();
      continue;
    }
    Vector3 f;
    for (Eigen::Index k = 0; k < 3; ++k)
      f[static_cast<std::size_t>(k)] = system.masses[i] * w[static_cast<std::size_t>(c + k)] - n[c + k];
    system.forces.push_back(ConstantForce{"", {static_cast<Index>(i)}, f});
  }
  return n;
}

VectorXd moving_part(const System& system, const std::vector<double>& all) {
  VectorXd result = vector(all);
  const std::vector<char> is_support = reference::find_supports(system);
  for (std::size_t c = 0; c < all.size(); ++c) {
    if (is_support[c / 3]) result[static_cast<Eigen::Index>(c)] = 0.0;
  }
  return result;
}

// ---- motions that are known --------------------------------------------------------------------------------------

RC_GTEST_PROP(TangentForm, ForcesThatMakeAMotionGiveBackItsAccelerationsAndReactions, ()) {
  RandomCoordinates random = any_coordinates();
  const double t = 0.7;
  const VectorXd n = add_driving_forces(&random, t);
  const std::vector<double> r = random.derivative(t, 0), v = random.derivative(t, 1), wanted = random.derivative(t, 2);

  const Answer answer(random.system, Form::Tangent, t, r, v);

  RC_ASSERT(answer.report.outcome.ok());
  const double scale = 1.0 + vector(wanted).norm() + n.norm();
  RC_ASSERT((vector(answer.w) - vector(wanted)).norm() <= 1e-11 * scale);
  RC_ASSERT((moving_part(random.system, answer.eta) - n).norm() <= 1e-11 * scale);
}

RC_GTEST_PROP(TangentForm, AccelerationsAreSecondDifferencesOfTheMotion, ()) {
  // Order 8: sum over k of c_k (r(t + k h) - 2 r(t) + r(t - k h))/h^2
  constexpr double t = 0.7, h = 0.02, c[] = {8.0 / 5.0, -1.0 / 5.0, 8.0 / 315.0, -1.0 / 560.0};
  RandomCoordinates random = any_coordinates();
  (void)add_driving_forces(&random, t);
  const std::vector<double> r = random.derivative(t, 0), v = random.derivative(t, 1);
  VectorXd difference = VectorXd::Zero(static_cast<Eigen::Index>(r.size()));
  for (int k = 1; k <= 4; ++k) {
    const std::vector<double> after = random.derivative(t + k * h, 0), before = random.derivative(t - k * h, 0);
    difference += c[k - 1] / (h * h) * (vector(after) - 2.0 * vector(r) + vector(before));
  }

  const Answer answer(random.system, Form::Tangent, t, r, v);

  RC_ASSERT(answer.report.outcome.ok());
  RC_ASSERT((vector(answer.w) - difference).norm() <= 1e-6 * (1.0 + difference.norm()));
}

// ---- the paper's formulas, dense ---------------------------------------------------------------------------------

RC_GTEST_PROP(TangentForm, AnswersAreThoseOfEquations20And22And24And30, ()) {
  const RandomCoordinates random = any_coordinates();
  const double t = 0.7;
  Forms forms(random.system, {.form = Form::Tangent});
  forms.tangent->set_exact(true);
  const Model& model = forms.model;
  const auto size = static_cast<Eigen::Index>(3 * model.num_points()),
             moving = static_cast<Eigen::Index>(3 * model.num_moving());
  const auto s = static_cast<Eigen::Index>(model.coordinates.num_coordinates());
  VectorXd r(size), v(size), w(size), eta(size), q(s), q_dot(s), q_ddot(s);
  const auto gather = [&](int k, VectorXd* inner) {
    model.numbering.gather_points(random.derivative(t, k), {inner->data(), static_cast<std::size_t>(size)});
  };
  gather(0, &r);
  gather(1, &v);
  RC_ASSERT(forms.tangent->adopt(t, r.data(), v.data(), q.data(), q_dot.data()).ok());
  RC_ASSERT(forms.tangent->accelerations(t, q.data(), q_dot.data(), Gradients::Evaluate, q_ddot.data()).ok());
  forms.tangent->write_points(t, q.data(), q_dot.data(), q_ddot.data(), r.data(), v.data(), w.data());
  forms.tangent->reactions(eta.data());

  MatrixXd A = MatrixXd::Zero(size, s);
  for (Eigen::Index j = 0; j < s; ++j) {
    const VectorXd e = VectorXd::Unit(s, j);
    model.coordinates.apply(model.parallel, forms.tangent->blocks().data(), e.data(), A.col(j).data());
  }
  A = A.topRows(moving).eval();
  const VectorXd psi = vector(forms.tangent->psi()).head(moving), f = vector(model.f).head(moving);
  VectorXd M(moving);
  for (Eigen::Index c = 0; c < moving; ++c) M[c] = model.mass[static_cast<std::size_t>(c / 3)];
  const auto H = MatrixXd(A.transpose() * M.asDiagonal() * A).ldlt();
  const auto G = MatrixXd(A.transpose() * A).ldlt();
  const VectorXd w_N = psi - A * G.solve(A.transpose() * psi);              // (22)
  const VectorXd w_q = H.solve(A.transpose() * (f - M.cwiseProduct(w_N)));  // (30)
  const VectorXd w_T = A * w_q;                                             // (20)
  const VectorXd rest = M.cwiseProduct(w_N) - f;
  const VectorXd eta_24 = rest - M.cwiseProduct(A * H.solve(A.transpose() * rest));  // (24)
  const double scale = 1.0 + w.norm() + f.norm() + psi.norm();
  RC_ASSERT((w.head(moving) - w_T - w_N).norm() <= 1e-11 * scale);
  RC_ASSERT((eta.head(moving) - eta_24).norm() <= 1e-11 * scale);
  // q_ddot = w^(q) - G^-1 A'psi
  RC_ASSERT((A * (q_ddot - w_q + G.solve(A.transpose() * psi))).norm() <= 1e-11 * scale);
}

// ---- both forms --------------------------------------------------------------------------------------------------

RC_GTEST_PROP(TangentForm, AgreesWithTheNormalFormTo1e11, ()) {
  const RandomCoordinates random = any_coordinates();
  RC_PRE(num_equations(random.system) > 0u);
  const double t = 0.7;

  const Answer answer(random.system, Form::Both, t, random.derivative(t, 0), random.derivative(t, 1));

  RC_ASSERT(answer.report.outcome.ok());
  RC_ASSERT(answer.report.forms_disagreement <= 1e-11);
  RC_ASSERT(answer.report.forms_disagreement > 0.0 || vector(answer.w).norm() == 0.0);
}

RC_GTEST_PROP(TangentForm, CoordinatesAndConstraintsThatSayTheSameAreAccepted, ()) {
  const RandomCoordinates random = any_coordinates();
  std::vector<double> r = random.system.positions, v = random.system.velocities;
  for (const Form form : {Form::Auto, Form::Tangent}) {
    Dynamics dynamics(random.system, {.form = form});

    const StartReport report = dynamics.start(0.0, r, v, StartMode::Check);

    RC_ASSERT(report.outcome.ok());
    RC_ASSERT(report.relative <= 1e-12);
  }
}

RC_GTEST_PROP(TangentForm, StateOfTheMotionIsAdmissibleAndStays, ()) {
  RandomCoordinates random = any_coordinates();
  Simulation simulation(random.system, {.method = Method::Rk4, .step = 0.01}, {.form = Form::Tangent});
  Dynamics judge(random.system, {.form = Form::Tangent});

  const Outcome outcome = simulation.advance(0.2);

  RC_ASSERT(outcome.ok());
  RC_ASSERT(judge.position_violation(0.2, simulation.positions()) <= 1e-11);
  RC_ASSERT(judge.velocity_violation(0.2, simulation.positions(), simulation.velocities()) <= 1e-11);
}

RC_GTEST_PROP(TangentForm, ThreadsGiveTheSameBits, ()) {
  const RandomCoordinates random = any_coordinates();
  std::vector<double> ends[2];
  for (const int threads : {1, 2}) {
    Simulation simulation(random.system, {.method = Method::Rk4, .step = 0.01},
                          {.form = Form::Tangent, .threads = threads});
    RC_ASSERT(simulation.advance(0.05).ok());
    ends[threads - 1].assign(simulation.positions().begin(), simulation.positions().end());
  }
  RC_ASSERT(ends[0] == ends[1]);
}

// ---- the rotating hoop, by hand ----------------------------------------------------------------------------------
//
// A bead on a hoop of radius R that turns around the vertical with Omega: r = R (sin q cos Ot, sin q sin Ot, -cos q),
//   q_ddot = sin q (Omega^2 cos q - g/R);  w = q_ddot a + psi,  G^-1 A'psi = -Omega^2 sin q cos q: w^(q) is not q_ddot.

struct Hoop {
  static constexpr double R = 0.5, Omega = 6.0, g = 9.81, mass = 0.3, q = 0.8, q_dot = 1.7;

  static Jet<2> angle(const Jet<2>& t) { return Omega * t; }
  static std::vector<double> place() { return {R * std::sin(q), 0.0, -R * std::cos(q)}; }
  static std::vector<double> velocity() {
    return {R * q_dot * std::cos(q), R * Omega * std::sin(q), R * q_dot * std::sin(q)};
  }
  static VectorFunction normal() {
    return {ScalarFunction::custom([](const Jet<2>& t) { return -sin(angle(t)); }),
            ScalarFunction::custom([](const Jet<2>& t) { return cos(angle(t)); }), 0.0};
  }
  static System system(const Coordinates& coordinates) {
    System result;
    result.positions = place();
    result.velocities = velocity();
    result.masses = {mass};
    result.coordinates = {coordinates};
    result.forces = {Gravity{"", {0, 0, -g}}};
    return result;
  }
  static Coordinates circle() { return CircleCoordinates{"", {0}, Vector3{0, 0, 0}, normal(), R}; }
  static Coordinates formula() {
    const std::vector<std::string> names = {"q"};
    const std::vector<std::string> components = {"R*sin(q)*cos(O*t)", "R*sin(q)*sin(O*t)", "-R*cos(q)"};
    return UserCoordinates{"", {{0}}, formula_coordinates(names, components, {{"R", R}, {"O", Omega}}), {q}, {q_dot}};
  }
};

class HoopTest : public testing::TestWithParam<const char*> {
 protected:
  static System system() {
    return Hoop::system(GetParam() == std::string("formula") ? Hoop::formula() : Hoop::circle());
  }
};

TEST_P(HoopTest, AccelerationAndReactionAreThoseOfTheBook) {
  const double s = std::sin(Hoop::q), c = std::cos(Hoop::q);
  const double q_ddot = s * (Hoop::Omega * Hoop::Omega * c - Hoop::g / Hoop::R);

  Answer answer(system(), Form::Auto, 0.0, Hoop::place(), Hoop::velocity());

  ASSERT_TRUE(answer.report.outcome.ok());
  const double squares = Hoop::q_dot * Hoop::q_dot + Hoop::Omega * Hoop::Omega;
  const double wanted[3] = {Hoop::R * (q_ddot * c - squares * s), Hoop::R * 2.0 * Hoop::Omega * Hoop::q_dot * c,
                            Hoop::R * (q_ddot * s + Hoop::q_dot * Hoop::q_dot * c)};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(answer.w[k], wanted[k], 1e-13);
    EXPECT_NEAR(answer.eta[k], Hoop::mass * (wanted[k] + (k == 2 ? Hoop::g : 0.0)), 1e-13);
  }
}

TEST_P(HoopTest, CoordinatesOfTheSolveAreNotWq) {
  const double s = std::sin(Hoop::q), c = std::cos(Hoop::q);
  Answer answer(system(), Form::Auto, 0.0, Hoop::place(), Hoop::velocity());
  std::vector<double> q(1), q_dot(1), q_ddot(1);

  answer.dynamics.coordinates(q, q_dot, q_ddot);

  // The circle's angle may run the other way.
  const double sign = q_dot[0] > 0.0 ? 1.0 : -1.0;
  EXPECT_NEAR(sign * q_dot[0], Hoop::q_dot, 1e-14);
  EXPECT_NEAR(sign * q_ddot[0], s * (Hoop::Omega * Hoop::Omega * c - Hoop::g / Hoop::R), 1e-13);
  // w^(q) = a'w/R^2 with a = R (c, 0, s)
  const double wq = (c * answer.w[0] + s * answer.w[2]) / Hoop::R;
  EXPECT_NEAR(sign * q_ddot[0] - wq, Hoop::Omega * Hoop::Omega * s * c, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(TangentForm, HoopTest, testing::Values("circle", "formula"),
                         [](const auto& instance) { return std::string(instance.param); });

// ---- a spinning body ---------------------------------------------------------------------------------------------

/// Points of a body that has no symmetry, without forces, spinning with omega.
System make_spinning_body(const Vector3& omega) {
  System system;
  system.positions = {0.5, 0.1, 0, -0.4, 0.3, 0.1, 0, -0.6, 0.2, 0.1, 0.2, 0.7, -0.2, -0.1, -0.5};
  system.masses = {1.0, 0.5, 2.0, 0.7, 1.2};
  for (std::size_t i = 0; i < 15; i += 3) {
    const double* const r = &system.positions[i];
    system.velocities.insert(
        system.velocities.end(),
        {omega[1] * r[2] - omega[2] * r[1], omega[2] * r[0] - omega[0] * r[2], omega[0] * r[1] - omega[1] * r[0]});
  }
  system.coordinates = {RigidBody{"body", {0, 1, 2, 3, 4}}};
  return system;
}

Eigen::Vector3d angular_momentum(const System& system, std::span<const double> r, std::span<const double> v) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < system.num_points(); ++i) {
    sum +=
        system.masses[i] * reference::point(r, static_cast<Index>(i)).cross(reference::point(v, static_cast<Index>(i)));
  }
  return sum;
}

/// Tumbling many times over: no pole of any chart is met, and what is conserved stays.
TEST(RigidBodyTest, FreeTopKeepsEnergyMomentumAndShape) {
  const System system = make_spinning_body({0.3, 7.0, -2.0});
  Simulation simulation(system, {.rtol = 1e-13, .atol = 1e-14});
  const Eigen::Vector3d before = angular_momentum(system, simulation.positions(), simulation.velocities());

  ASSERT_TRUE(simulation.advance(10.0).ok());

  const Eigen::Vector3d after = angular_momentum(system, simulation.positions(), simulation.velocities());
  EXPECT_LE((after - before).norm(), 1e-10 * before.norm());
  EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-10);
  for (Index i = 0; i < 5; ++i) {
    for (Index j = 0; j < i; ++j) {
      const double length = (reference::point(system.positions, i) - reference::point(system.positions, j)).norm();
      EXPECT_NEAR((reference::point(simulation.positions(), i) - reference::point(simulation.positions(), j)).norm(),
                  length, 1e-14);
    }
  }
}

/// A body of revolution without forces precesses evenly: its axis turns around L with |L|/I1 (Euler).
TEST(RigidBodyTest, SymmetricTopPrecessesAsEulerSays) {
  // Four points of 1 kg on a square of half-diagonal a: I1 = I2 = 2 a^2, I3 = 4 a^2.
  constexpr double a = 0.5, I1 = 2.0 * a * a, I3 = 4.0 * a * a, spin = 5.0, wobble = 1.0;
  System system;
  system.positions = {a, 0, 0, 0, a, 0, -a, 0, 0, 0, -a, 0};
  system.masses = {1, 1, 1, 1};
  for (std::size_t i = 0; i < 12; i += 3) {
    // omega = (wobble, 0, spin)
    const double* const r = &system.positions[i];
    system.velocities.insert(system.velocities.end(), {-spin * r[1], spin * r[0] - wobble * r[2], wobble * r[1]});
  }
  system.coordinates = {RigidBody{"", {0, 1, 2, 3}}};
  Simulation simulation(system, {.rtol = 1e-13, .atol = 1e-14});
  const double t_end = 4.0;

  ASSERT_TRUE(simulation.advance(t_end).ok());

  const Eigen::Vector3d L(I1 * wobble, 0.0, I3 * spin);
  const Eigen::Vector3d axis = Eigen::AngleAxisd(L.norm() / I1 * t_end, L.normalized()) * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d found =
      (reference::point(simulation.positions(), 0) - reference::point(simulation.positions(), 2))
          .cross(reference::point(simulation.positions(), 1) - reference::point(simulation.positions(), 3))
          .normalized();
  EXPECT_LE((found - axis).norm(), 1e-10);
}

// ---- charts ------------------------------------------------------------------------------------------------------

/// A great circle over both poles of every axis: exactly known, through thousands of recentrings.
TEST(SphereTest, FreeBeadRunsOnItsGreatCircle) {
  constexpr double speed = 3.0, t_end = 40.0;
  System system;
  system.positions = {0, 0, 1};
  system.velocities = {speed, 0, 0};
  system.masses = {1};
  system.coordinates = {SphereCoordinates{"", {0}, Vector3{0, 0, 0}, 1.0}};
  Simulation simulation(system, {.method = Method::Rk4, .step = 1e-3});

  ASSERT_TRUE(simulation.advance(t_end).ok());

  EXPECT_NEAR(simulation.positions()[0], std::sin(speed * t_end), 1e-9);
  EXPECT_EQ(simulation.positions()[1], 0.0);
  EXPECT_NEAR(simulation.positions()[2], std::cos(speed * t_end), 1e-9);
  EXPECT_EQ(simulation.report().steps, 40'000u);
}

/// A plane and a circle whose normal turns through all axes, with what was chosen as helper: beads without forces agree
/// with the normal form.
TEST(TurningNormalTest, MotionIsThatOfTheNormalForm) {
  const VectorFunction normal = {ScalarFunction::formula("sin(2*t)*cos(3*t)"),
                                 ScalarFunction::formula("sin(2*t)*sin(3*t)"), ScalarFunction::formula("cos(2*t)")};
  System system;
  system.positions = {0.6, 0.2, 0, 0.5, 0, 0};
  system.masses = {1, 2};
  system.constraints = {Planes{"sheet", {0}, normal, 0.0}, Circles{"wire", {1}, Vector3{0, 0, 0}, normal, 0.5}};
  system.forces = {Gravity{"", {0, 0, -9.81}}, Springs{"", {{0, 1}}, 5.0, 0.0, 0.1}};
  System both = system;
  both.coordinates = {PlaneCoordinates{"", {0}, normal, 0.0},
                      CircleCoordinates{"", {1}, Vector3{0, 0, 0}, normal, 0.5}};
  const MotionOptions options{.rtol = 1e-12, .atol = 1e-13, .start = StartMode::Project};
  Simulation by_constraints(system, options), by_coordinates(both, options, {.form = Form::Tangent});

  for (const double t : {0.7, 1.5, 3.0}) {
    ASSERT_TRUE(by_constraints.advance(t).ok());
    ASSERT_TRUE(by_coordinates.advance(t).ok());

    EXPECT_LE((vector(by_coordinates.positions()) - vector(by_constraints.positions())).norm(), 1e-9) << "t = " << t;
    EXPECT_LE((vector(by_coordinates.reactions()) - vector(by_constraints.reactions())).norm(), 1e-7) << "t = " << t;
  }
}

// ---- choices and refusals ----------------------------------------------------------------------------------------

/// Points on a helix, each held by rods to three earlier ones: a rigid body of 3n - 6 rods.
System make_framework(std::size_t num_points, bool with_coordinates) {
  System system;
  Rods rods{"frame", {}, {}, {}};
  RigidBody body{"body", {}};
  for (std::size_t i = 0; i < num_points; ++i) {
    const double x = static_cast<double>(i);
    system.positions.insert(system.positions.end(), {0.1 * std::cos(2.0 * x), 0.1 * std::sin(2.0 * x), 0.05 * x});
    system.masses.push_back(1.0);
    for (std::size_t k = 1; k <= std::min<std::size_t>(i, 3); ++k) {
      rods.pairs.push_back({static_cast<Index>(i - k), static_cast<Index>(i)});
    }
    body.points.push_back(static_cast<Index>(i));
  }
  system.constraints = {rods};
  if (with_coordinates) system.coordinates = {body};
  return system;
}

TEST(ChoiceTest, RigidBodyOfManyPointsIsSolvedInTangentForm) {
  const Dynamics dynamics(make_framework(1000, true));

  EXPECT_EQ(dynamics.plan().form, Form::Tangent);
  EXPECT_EQ(dynamics.plan().coordinates, 6u);
  EXPECT_EQ(dynamics.plan().equations, 2994u);
  EXPECT_GE(dynamics.plan().normal_flops, 20.0 * dynamics.plan().tangent_flops / 3.0);
}

TEST(ChoiceTest, LongChainIsSolvedInNormalForm) {
  System chain;
  Rods rods{"rods", {}, 0.1, {}};
  ChainAngles angles{"", {}, 0, 0.1, {}};
  for (Index i = 0; i <= 200; ++i) {
    chain.positions.insert(chain.positions.end(), {0.1 * i, 0, 0});
    chain.masses.push_back(1.0);
    if (i == 0) continue;
    rods.pairs.push_back({i - 1, i});
    angles.points.push_back(i);
  }
  chain.supports = {{"", {0}, {}}};
  chain.constraints = {rods};
  chain.coordinates = {angles};

  EXPECT_EQ(Dynamics(chain).plan().form, Form::Normal);
  EXPECT_EQ(Dynamics(chain, {.form = Form::Tangent}).plan().form, Form::Tangent);
}

/// What an action complains about: "<where>: <what>".
template <class Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.where() + ": " + error.what();
  }
  return "no error";
}

TEST(RefusalTest, FormsThatTheSystemDoesNotHave) {
  System constraints = make_framework(4, false), coordinates = make_framework(4, true);
  coordinates.constraints.clear();

  EXPECT_EQ(error_of([&] { Dynamics(constraints, {.form = Form::Tangent}); }),
            "/solver/form: the tangent form needs coordinates; none are given");
  EXPECT_EQ(error_of([&] { Dynamics(coordinates, {.form = Form::Both}); }),
            "/solver/form: both forms need constraints too; coordinates alone are given");
  EXPECT_EQ(error_of([&] { Simulation(coordinates, {.method = Method::Rattle, .step = 1e-3}); }),
            "/motion/method: rattle projects onto constraints, the tangent form has none; rk4 and dopri5 step in "
            "coordinates");
  EXPECT_EQ(Simulation(make_framework(1000, true), {.method = Method::Rattle, .step = 1e-3}).plan().form, Form::Normal);
}

TEST(RefusalTest, ConstraintsThatTheCoordinatesBreak) {
  // A bead on a circle of radius 1, which a rod to a support at its centre allows, to another place does not.
  System system;
  system.positions = {0, 0, 0, 1, 0, 0, 0.5, 0, 0};
  system.masses = {1, 1, 1};
  system.supports = {{"", {0, 2}, {}}};
  system.coordinates = {CircleCoordinates{"", {1}, Vector3{0, 0, 0}, Vector3{0, 0, 1}, 1.0}};
  system.constraints = {Rods{"spoke", {{0, 1}}, {}, {}}};
  std::vector<double> r = system.positions, v(9, 0.0);
  for (const Form form : {Form::Auto, Form::Normal, Form::Tangent}) {
    system.constraints = {Rods{"spoke", {{0, 1}}, {}, {}}};
    EXPECT_EQ(error_of([&] { (void)Dynamics(system, {.form = form}).start(0.0, r, v, StartMode::Check); }), "no error");
    system.constraints = {Rods{"spoke", {{0, 1}}, 1.1, {}}};
    EXPECT_NE(error_of([&] {
                (void)Dynamics(system, {.form = form}).start(0.0, r, v, StartMode::Check);
              }).find("/coordinates: the places that the coordinates describe violate spoke[0]"),
              std::string::npos);
    system.constraints = {Linears{"wall", {{1}}, {{1, 1, 0}}, 1.0}};
    EXPECT_NE(error_of([&] {
                (void)Dynamics(system, {.form = form}).start(0.0, r, v, StartMode::Check);
              }).find("/coordinates: K'A is not 0: the coordinates move along the gradient of wall[0]"),
              std::string::npos);
  }
}

TEST(RefusalTest, CoordinateThatMovesNothingIsNamed) {
  System system;
  system.positions = {1, 0, 0};
  system.masses = {1};
  const std::vector<std::string> names = {"a", "b"}, components = {"cos(a)", "sin(a)", "0"};
  system.coordinates = {UserCoordinates{"wheel", {{0}}, formula_coordinates(names, components), {0.0, 0.0}, {}}};
  Dynamics dynamics(system);
  std::vector<double> w(3);

  const SolveReport report = dynamics.solve(0.0, system.positions, std::vector<double>(3, 0.0), w);

  EXPECT_EQ(report.outcome.status, Status::Singular);
  EXPECT_NE(report.outcome.what.find("coordinate wheel[1] moves no point"), std::string::npos) << report.outcome.what;
}

// ---- going on ----------------------------------------------------------------------------------------------------

/// The given angle is half a turn from where the snapshot was taken: the search starts at the worst place there is.
TEST(SnapshotTest, MotionInCoordinatesGoesOn) {
  System system = Hoop::system(Hoop::formula());
  system.velocities = {};
  std::get<UserCoordinates>(system.coordinates[0]).q_dot = {9.0};
  const MotionOptions options{.method = Method::Rk4, .step = 1e-3};
  Simulation whole(system, options), first(system, options), second(system, options);
  ASSERT_TRUE(whole.advance(1.0).ok());
  ASSERT_TRUE(first.advance(0.4).ok());

  second.restore(first.snapshot());

  ASSERT_TRUE(second.advance(1.0).ok());
  EXPECT_LE((vector(second.positions()) - vector(whole.positions())).norm(), 1e-11);
}

}  // namespace
}  // namespace tanor
