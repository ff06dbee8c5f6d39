/// The tangent form, r = r(q, t) and H q_ddot = A'(f - M psi), agrees with motions that are known, with the normal
/// form, and with the paper's formulas in dense matrices.

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tanor/motion.hpp>

#include "dense.hpp"
#include "dynamics/forms.hpp"
#include "random_coordinates.hpp"

namespace tanor {
using namespace detail;
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using reference::vector;

/// A system solved in one form at (t, r, v).
struct AnswerOfForm {
  Dynamics dynamics;
  std::vector<double> w, lambda, eta;
  SolveReport report;

  AnswerOfForm(const System& system, Form form, double t, const std::vector<double>& r, const std::vector<double>& v)
      : dynamics(system, {.form = form}), w(r.size()), lambda(dynamics.num_equations()), eta(r.size()) {
    report = dynamics.solve({.time = t, .positions = r, .velocities = v},
                            {.accelerations = w, .multipliers = lambda, .reactions = eta});
  }
};

/// Adds the forces that make the points run as they do, f = M w - n, with some forces n = K mu that do no work along T.
/// Returns n on all points, with 0 at supports.
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

  const AnswerOfForm answer(random.system, Form::Tangent, t, r, v);

  RC_ASSERT(answer.report.outcome.ok());
  const double scale = 1.0 + vector(wanted).norm() + n.norm();
  RC_ASSERT((vector(answer.w) - vector(wanted)).norm() <= 1e-11 * scale);
  RC_ASSERT((moving_part(random.system, answer.eta) - n).norm() <= 1e-11 * scale);
}

RC_GTEST_PROP(TangentForm, AccelerationsAreSecondDifferencesOfTheMotion, ()) {
  // Difference of order 8: sum over k of c_k (r(t + k h) - 2 r(t) + r(t - k h))/h^2
  constexpr double t = 0.7, h = 0.02, c[] = {8.0 / 5.0, -1.0 / 5.0, 8.0 / 315.0, -1.0 / 560.0};
  RandomCoordinates random = any_coordinates();
  (void)add_driving_forces(&random, t);
  const std::vector<double> r = random.derivative(t, 0), v = random.derivative(t, 1);
  VectorXd difference = VectorXd::Zero(static_cast<Eigen::Index>(r.size()));
  for (int k = 1; k <= 4; ++k) {
    const std::vector<double> after = random.derivative(t + k * h, 0), before = random.derivative(t - k * h, 0);
    difference += c[k - 1] / (h * h) * (vector(after) - 2.0 * vector(r) + vector(before));
  }

  const AnswerOfForm answer(random.system, Form::Tangent, t, r, v);

  RC_ASSERT(answer.report.outcome.ok());
  RC_ASSERT((vector(answer.w) - difference).norm() <= 1e-6 * (1.0 + difference.norm()));
}

// ---- the paper's formulas, dense ---------------------------------------------------------------------------------

RC_GTEST_PROP(TangentForm, AnswersAreThoseOfEquations20And22And24And30, ()) {
  const RandomCoordinates random = any_coordinates();
  const double t = 0.7;
  Forms forms(random.system, {.form = Form::Tangent});
  const Model& model = forms.model;
  const auto size = static_cast<Eigen::Index>(3 * model.num_points()),
             moving = static_cast<Eigen::Index>(3 * model.num_moving());
  const auto s = static_cast<Eigen::Index>(forms.work.coordinates.num_coordinates());
  VectorXd r(size), v(size), w(size), eta(size), q(s), q_dot(s), q_ddot(s);
  const auto gather = [&](int k, VectorXd* inner) {
    model.numbering.gather_points(random.derivative(t, k), {inner->data(), static_cast<std::size_t>(size)});
  };
  gather(0, &r);
  gather(1, &v);
  RC_ASSERT(forms.tangent->set_state(t, r.data(), v.data(), q.data(), q_dot.data()).ok());
  const Kinematics at{t, q.data(), q_dot.data()};
  Reactions found;
  RC_ASSERT(forms.tangent->accelerations(at, {.exact = true}, {q_ddot.data(), nullptr, nullptr, &found}).ok());
  forms.tangent->write_points(at, q_ddot.data(), found, r.data(), v.data(), w.data());
  forms.tangent->write_reactions(at, found, eta.data());

  MatrixXd A = MatrixXd::Zero(size, s);
  for (Eigen::Index j = 0; j < s; ++j) {
    const VectorXd e = VectorXd::Unit(s, j);
    forms.work.coordinates.apply(model.parallel, forms.tangent->dynamics().blocks().data(), e.data(), A.col(j).data());
  }
  A = A.topRows(moving).eval();
  const VectorXd psi = vector(forms.tangent->dynamics().psi()).head(moving), f = vector(forms.work.f).head(moving);
  VectorXd M(moving);
  for (Eigen::Index c = 0; c < moving; ++c) M[c] = model.mass[static_cast<std::size_t>(c / 3)];
  const MatrixXd H = A.transpose() * M.asDiagonal() * A, G = A.transpose() * A;
  const VectorXd w_N = psi - A * reference::solve_definite(G, A.transpose() * psi);              // (22)
  const VectorXd w_q = reference::solve_definite(H, A.transpose() * (f - M.cwiseProduct(w_N)));  // (30)
  const VectorXd w_T = A * w_q;                                                                  // (20)
  const VectorXd rest = M.cwiseProduct(w_N) - f;
  const VectorXd eta_24 = rest - M.cwiseProduct(A * reference::solve_definite(H, A.transpose() * rest));  // (24)
  const double scale = 1.0 + w.norm() + f.norm() + psi.norm();
  RC_ASSERT((w.head(moving) - w_T - w_N).norm() <= 1e-11 * scale);
  RC_ASSERT((eta.head(moving) - eta_24).norm() <= 1e-11 * scale);
  // q_ddot = w^(q) - G^-1 A'psi
  RC_ASSERT((A * (q_ddot - w_q + reference::solve_definite(G, A.transpose() * psi))).norm() <= 1e-11 * scale);
}

// ---- both forms --------------------------------------------------------------------------------------------------

/// Rounding may be the same in both forms, since beads of one plane often agree to the last bit.
RC_GTEST_PROP(TangentForm, AgreesWithTheNormalFormTo1e11, ()) {
  const RandomCoordinates random = any_coordinates();
  RC_PRE(num_equations(random.system) > 0u);
  const double t = 0.7;
  const std::vector<double> r = random.derivative(t, 0), v = random.derivative(t, 1);

  const AnswerOfForm both(random.system, Form::Both, t, r, v);
  const AnswerOfForm tangent(random.system, Form::Tangent, t, r, v), normal(random.system, Form::Normal, t, r, v);

  RC_ASSERT(both.report.outcome.ok());
  RC_ASSERT(both.report.forms_disagreement <= 1e-11);
  RC_ASSERT(tangent.report.outcome.ok());
  RC_ASSERT(normal.report.outcome.ok());
  const VectorXd w = moving_part(random.system, normal.w);
  const double size = std::max(w.lpNorm<Eigen::Infinity>(), 9.81);
  RC_ASSERT((moving_part(random.system, tangent.w) - w).lpNorm<Eigen::Infinity>() <= 1e-11 * size);
}

/// A bead runs with 1 m/s on a circle of 1 m. By the constraint alone the circle widens by 1e-6 m/s^2.
TEST(TangentForm, ADisagreementOfTheFormsIsMeasured) {
  const double widening = 1e-6;
  System system;
  system.positions = {1.0, 0.0, 0.0};
  system.velocities = {0.0, 1.0, 0.0};
  system.masses = {2.0};
  system.coordinates = {CircleCoordinates{"hoop", {0}, Vector3{}, Vector3{0.0, 0.0, 1.0}, 1.0}};
  system.constraints = {
      Circles{"hoop", {0}, Vector3{}, Vector3{0.0, 0.0, 1.0}, ScalarFunction::formula("1 + 5e-7*t^2")}};

  const AnswerOfForm both(system, Form::Both, 0.0, system.positions, system.velocities);

  ASSERT_TRUE(both.report.outcome.ok()) << both.report.outcome.what;
  EXPECT_NEAR(both.report.forms_disagreement, widening, 2.0 * widening * widening);
}

RC_GTEST_PROP(TangentForm, CoordinatesAndConstraintsThatSayTheSameAreAccepted, ()) {
  const RandomCoordinates random = any_coordinates();
  std::vector<double> r = random.system.positions, v = random.system.velocities;
  for (const Form form : {Form::Auto, Form::Tangent}) {
    Dynamics dynamics(random.system, {.form = form});

    const StartReport report = dynamics.start({.time = 0.0, .positions = r, .velocities = v}, StartMode::Check);

    RC_ASSERT(report.outcome.ok());
    RC_ASSERT(report.relative <= 1e-12);
  }
}

RC_GTEST_PROP(TangentForm, StateOfTheMotionIsAdmissibleAndStays, ()) {
  RandomCoordinates random = any_coordinates();
  Simulation simulation(random.system, {.method = Method::Rk4, .step = 0.01}, {.form = Form::Tangent});
  Dynamics other(random.system, {.form = Form::Tangent});

  const Outcome outcome = simulation.advance_to(0.2);

  RC_ASSERT(outcome.ok());
  RC_ASSERT(other.position_violation({.time = 0.2, .positions = simulation.positions()}) <= 1e-11);
  RC_ASSERT(other.velocity_violation(
                {.time = 0.2, .positions = simulation.positions(), .velocities = simulation.velocities()}) <= 1e-11);
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

  AnswerOfForm answer(system(), Form::Auto, 0.0, Hoop::place(), Hoop::velocity());

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
  AnswerOfForm answer(system(), Form::Auto, 0.0, Hoop::place(), Hoop::velocity());
  std::vector<double> q(1), q_dot(1), q_ddot(1);

  (void)answer.dynamics.solve({.time = 0.0, .positions = Hoop::place(), .velocities = Hoop::velocity()},
                              {.coordinates = q, .coordinate_rates = q_dot, .coordinate_accelerations = q_ddot});

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

// ---- going on ----------------------------------------------------------------------------------------------------

/// The given angle is half a turn from the place of the snapshot, so that the search starts at the worst possible
/// place.
TEST(SnapshotTest, MotionInCoordinatesGoesOn) {
  System system = Hoop::system(Hoop::formula());
  system.velocities = {};
  std::get<UserCoordinates>(system.coordinates[0]).q_dot = {9.0};
  const MotionOptions options{.method = Method::Rk4, .step = 1e-3};
  Simulation whole(system, options), first(system, options), second(system, options);
  ASSERT_TRUE(whole.advance_to(1.0).ok());
  ASSERT_TRUE(first.advance_to(0.4).ok());

  second.restore(first.save());

  ASSERT_TRUE(second.advance_to(1.0).ok());
  EXPECT_LE((vector(second.positions()) - vector(whole.positions())).norm(), 1e-11);
}

}  // namespace
}  // namespace tanor
