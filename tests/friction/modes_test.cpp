#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tanor/tanor.hpp>

#include "long_tests.hpp"
#include "reference.hpp"
#include "rough_scenes.hpp"

/// \file All motions of beads at rest on rough lines that rods join are counted by a dense twin and by tanor. The law
/// is
/// written down here once more: the twin knows positions, masses and forces alone.
namespace tanor {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Two beads on lines in space with a rod between them and forces on both have one degree of freedom.
struct TwoBeads {
  Vector3d r[2], line[2], force[2];
  double mass[2], mu[2];

  explicit TwoBeads(unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> log_mass(-1.0, 1.0), coefficient(0.1, 0.7);
    const auto any = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
    for (int k = 0; k < 2; ++k) {
      r[k] = any();
      line[k] = any().normalized();
      force[k] = 4.0 * any();
      mass[k] = std::exp(log_mass(random));
      mu[k] = coefficient(random);
    }
  }

  System system() const {
    System result;
    for (int k = 0; k < 2; ++k) {
      for (int i = 0; i < 3; ++i) result.positions.push_back(r[k](i));
      result.masses.push_back(mass[k]);
      const std::string name = "l" + std::to_string(k);
      result.constraints.push_back(
          Lines{name, {k}, Vector3{r[k](0), r[k](1), r[k](2)}, Vector3{line[k](0), line[k](1), line[k](2)}});
      result.forces.push_back(ConstantForce{"", {k}, Vector3{force[k](0), force[k](1), force[k](2)}});
      result.friction.push_back(Coulomb{.name = "", .at = {name}, .coefficient = mu[k]});
    }
    result.velocities.assign(6, 0.0);
    result.constraints.push_back(Rods{"rod", {{0, 1}}, {}, {}});
    return result;
  }

  /// Returns the accelerations of the first bead along its line. Each bead moves by a_k = c_k u; T is the pull of the
  /// rod:
  ///
  ///   m_k c_k u = F_k.l_k + T e_k.l_k + x_k,   N_k = -(F_k + T e_k) across l_k,   |x_k| <= mu_k |N_k|
  ///
  /// so that x_k = m_k c_k u - F_k.l_k - T e_k.l_k. The unknowns are u and T, with two equations where both beads
  /// slide.
  /// For each bead rest is an interval of T; sliding to each side is a root of g(T) = 0 on a line of T.
  std::vector<double> find_all() const {
    const Vector3d e = (r[1] - r[0]).normalized();
    const double c[2] = {e.dot(line[1]), e.dot(line[0])};  // e.(c_1 l_1 - c_0 l_0) = 0 for c_0 = e.l_1, c_1 = e.l_0
    const double pull[2] = {1.0, -1.0};
    const auto limit = [&](int k, double T) {
      const Vector3d all = force[k] + T * pull[k] * e;
      return mu[k] * (all - all.dot(line[k]) * line[k]).norm();
    };
    const auto along = [&](int k, double T) { return (force[k] + T * pull[k] * e).dot(line[k]); };
    // The function returns u of bead 0 or of bead 1 that slides with the sense of `sign` at T. Both must agree and have
    // that
    // sign.
    const auto speed_up = [&](int k, double T, double sign) {
      const double sense = sign * (c[k] < 0.0 ? -1.0 : 1.0);
      return (along(k, T) - sense * limit(k, T)) / (mass[k] * c[k]);
    };
    constexpr int samples = 200000;
    std::vector<double> found;
    const auto tension = [](int s) { return std::sinh(16.0 * (2.0 * s / samples - 1.0)) * 1e-3; };
    bool rests = false;
    for (int s = 0; s <= samples; ++s) {
      const double T = tension(s);
      rests = rests || (std::abs(along(0, T)) <= limit(0, T) && std::abs(along(1, T)) <= limit(1, T));
    }
    if (rests) found.push_back(0.0);
    for (const double sign : {1.0, -1.0}) {
      const auto apart = [&](double T) { return speed_up(0, T, sign) - speed_up(1, T, sign); };
      for (int s = 0; s < samples; ++s) {
        double low = tension(s), high = tension(s + 1);
        const bool rises = apart(low) < 0.0;
        if (rises == (apart(high) < 0.0)) continue;
        for (int pass = 0; pass < 100; ++pass) {
          const double middle = 0.5 * (low + high);
          ((apart(middle) < 0.0) == rises ? low : high) = middle;
        }
        const double u = speed_up(0, low, sign);
        if (sign * u > 0.0) found.push_back(c[0] * u);
      }
    }
    return found;
  }
};

TEST(FrictionModes, BeadsAtRestHaveAsManyMotionsAsTheLaw) {
  int several = 0, unique = 0, held = 0, proven = 0;
  const int tried = tests_are_long() ? 120 : 60;
  for (unsigned seed = 1; seed <= static_cast<unsigned>(tried); ++seed) {
    const TwoBeads beads(seed);
    const std::vector<double> all = beads.find_all();
    const System system = beads.system();
    Dynamics dynamics(system);
    std::vector<double> w(6);
    const SolveReport report = dynamics.solve(
        {.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w});
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + std::to_string(all.size()) + " motions; " +
                 report.outcome.what);
    if (all.size() == 1) {
      ++unique;
      held += all[0] == 0.0 ? 1 : 0;
      EXPECT_TRUE(report.outcome.ok());
      EXPECT_NE(report.friction.uniqueness, Uniqueness::Several);
      proven += report.friction.uniqueness == Uniqueness::Proven ? 1 : 0;
      const double along = Vector3d(w[0], w[1], w[2]).dot(beads.line[0]);
      EXPECT_NEAR(along, all[0], 1e-9 * (1.0 + std::abs(all[0])));
    } else if (all.size() > 1) {
      ++several;
      EXPECT_EQ(report.outcome.status, Status::NotUnique);
      EXPECT_EQ(report.friction.uniqueness, Uniqueness::Several);
      EXPECT_NE(report.outcome.what.find(std::to_string(all.size()) + " accelerations"), std::string::npos);
    } else {
      EXPECT_EQ(report.outcome.status, Status::NoSolution);
    }
    const Simulation simulation(system);
    EXPECT_EQ(simulation.outcome().status, report.outcome.status) << simulation.outcome().what;
  }
  EXPECT_GT(unique, tried * 2 / 3);
  EXPECT_GT(held, tried / 6);
  EXPECT_EQ(proven, unique);
  EXPECT_GT(several, tried / 40);
}

// ---- where the law says less than a motion ----

TEST(FrictionModes, APlaneGivenTwiceSharesItsReactionByConvention) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.velocities = {1.0, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Planes{"a", {0}, Vector3{0.0, 0.0, 1.0}, 0.0}, Planes{"b", {0}, Vector3{0.0, 0.0, 1.0}, 0.0}};
  system.forces = {Gravity{"", {0.0, 0.0, -10.0}}};
  system.friction = {Coulomb{.name = "rough", .at = {"a"}, .coefficient = 0.1}};
  for (const double v : {1.0, 0.0}) {
    system.velocities[0] = v;
    Dynamics dynamics(system);
    std::vector<double> w(3);
    const SolveReport report = dynamics.solve(
        {.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w});
    ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
    EXPECT_EQ(report.friction.uniqueness, Uniqueness::Unproven);
    EXPECT_NE(report.friction.uniqueness_reason.find("by convention"), std::string::npos);
  }
}

// ---- cases/10b in runs ----

/// Returns the first number of each "(x, y, z)" in a text, in ascending order.
std::vector<double> first_numbers(const std::string& text) {
  std::vector<double> result;
  for (std::size_t k = text.find('('); k != std::string::npos; k = text.find('(', k + 1))
    result.push_back(std::stod(text.substr(k + 1)));
  std::sort(result.begin(), result.end());
  return result;
}

TEST(FrictionModes, AStartWithSeveralAccelerationsIsRefusedWithAllOfThem) {
  for (const auto& [f2, wanted] : {std::pair{1.0, std::vector{-19.423818516974819713, -0.62435140649000290110}},
                                   {-30.0, std::vector{-180.00596629147985736, -24.311703482994491729}}}) {
    const System system = scenes::make_rails({0.6, f2});
    for (const bool in_run : {false, true}) {
      Outcome outcome;
      if (in_run) {
        const Simulation simulation(system);
        outcome = simulation.outcome();
        EXPECT_EQ(simulation.report().friction.uniqueness, Uniqueness::Several);
      } else {
        Dynamics dynamics(system);
        std::vector<double> w(6);
        outcome = dynamics
                      .solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                             {.accelerations = w})
                      .outcome;
      }
      EXPECT_EQ(outcome.status, Status::NotUnique);
      EXPECT_NE(outcome.what.find("t = 0"), std::string::npos) << outcome.what;
      EXPECT_NE(outcome.what.find("rust at rough[0], point 0"), std::string::npos) << outcome.what;
      const std::vector<double> found = first_numbers(outcome.what);
      ASSERT_EQ(found.size(), 2u) << outcome.what;
      for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(found[k], wanted[k], 5e-4 * std::abs(wanted[k]));
    }
  }
  const Simulation none(scenes::make_rails({0.6, 30.0}));
  EXPECT_EQ(none.outcome().status, Status::NoSolution) << none.outcome().what;
}

TEST(FrictionModes, ARegularisedLawMayHaveSeveralMotions) {
  System system = scenes::make_rails({0.6, 1.0});
  std::get<Coulomb>(system.friction[0]).regularisation = 1e-9;
  const Simulation simulation(system);
  EXPECT_EQ(simulation.outcome().status, Status::NotUnique) << simulation.outcome().what;
}

// ---- several and none in the middle of a run ----

/// The rails of case 10b have a rod whose length changes such that its upper end runs D(t) = 0.4 + 0.2 cos t ahead.
/// With F + D'' pulling at the upper bead and c/s = D of the rod's slope, both beads have the acceleration of the lower
/// one plus 0 and D'':
///
///   2 c T + mu |g + s T| = -F,   a = F + c T
///
/// has one solution while D > mu/2, a = F - (F + mu g) D/(2 D + mu) for F < 2 g D. For D < mu/2 there is another one
/// for F < 2 g D, and none for F > 2 g D.
struct Telescope {
  static constexpr double mu = 0.6, g = 9.81, pi = 3.14159265358979323846;
  static constexpr double enters = 2.0 * pi / 3.0, leaves = 4.0 * pi / 3.0;  // D = mu/2

  static double ahead(double t) { return 0.4 + 0.2 * std::cos(t); }
  static double acceleration(double F_now, double t) {
    return F_now - (F_now + mu * g) * ahead(t) / (2.0 * ahead(t) + mu);
  }
};

TEST(FrictionModes, ARunThroughSeveralMotionsKeepsItsOwnAndCountsThem) {
  constexpr double h = 1e-3;
  for (const MotionOptions& options : {MotionOptions{.method = Method::Rk4, .step = h},
                                       MotionOptions{.method = Method::Dopri5, .max_step = h, .rtol = 1e-10}}) {
    Simulation simulation(scenes::make_telescope("1"), options);
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    EXPECT_EQ(simulation.report().friction.uniqueness, Uniqueness::Proven);
    const FrictionSummary& friction = simulation.report().friction;
    double v = 30.0;
    std::size_t at_leaving = 0;
    for (int k = 1; k <= 50; ++k) {
      const double t = 0.1 * k;
      ASSERT_TRUE(simulation.advance_to(t).ok()) << simulation.outcome().what;
      EXPECT_EQ(simulation.time(), t);
      EXPECT_NEAR(simulation.accelerations()[0], Telescope::acceleration(1.0, t), 1e-9) << t;
      // Simpson's rule takes 0.1 s in 100 parts.
      for (int i = 0; i < 100; ++i) {
        const double from = t - 0.1 + 1e-3 * i;
        v += 1e-3 / 6.0 *
             (Telescope::acceleration(1.0, from) + 4.0 * Telescope::acceleration(1.0, from + 5e-4) +
              Telescope::acceleration(1.0, from + 1e-3));
      }
      EXPECT_NEAR(simulation.velocities()[0], v, 1e-8) << t;
      if (t < Telescope::enters) {
        EXPECT_EQ(friction.several, 0u);
        EXPECT_EQ(friction.uniqueness, Uniqueness::Proven);
      } else {
        EXPECT_EQ(friction.uniqueness, Uniqueness::Several);
        EXPECT_GE(friction.first_several, Telescope::enters);
        EXPECT_LE(friction.first_several, Telescope::enters + 1.001 * h);
      }
      if (t < Telescope::leaves) at_leaving = friction.several;
    }
    // The wanted number counts the ends of steps in between.
    const auto wanted =
        static_cast<std::size_t>(Telescope::leaves / h) - static_cast<std::size_t>(Telescope::enters / h);
    EXPECT_GE(friction.several, at_leaving);
    if (options.method == Method::Rk4) {
      EXPECT_EQ(friction.several, wanted);
    } else {
      EXPECT_GE(friction.several, wanted);
    }
  }
}

TEST(FrictionModes, ARunEndsWhereNoMotionIsLeft) {
  // F = 1 + t^2/2 meets 2 g D inside the region without a second solution to go on with.
  double low = Telescope::enters, high = 3.0;
  for (int pass = 0; pass < 100; ++pass) {
    const double middle = 0.5 * (low + high);
    (1.0 + 0.5 * middle * middle < 2.0 * Telescope::g * Telescope::ahead(middle) ? low : high) = middle;
  }
  for (const Method method : {Method::Rk4, Method::Dopri5, Method::Dop853}) {
    MotionOptions options{.method = method, .rtol = 1e-9};
    if (method == Method::Rk4) options.step = 1e-3;
    Simulation simulation(scenes::make_telescope("1 + 0.5*t^2"), options);
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    ASSERT_TRUE(simulation.advance_to(2.0).ok()) << simulation.outcome().what;
    EXPECT_EQ(simulation.report().friction.several, 0u);

    const Outcome outcome = simulation.advance_to(4.0);

    // Steps that follow a tolerance fail where none is short enough, and say why.
    EXPECT_EQ(outcome.status, Status::NoSolution) << outcome.what;
    EXPECT_NE(outcome.what.find("rust at rough[0], point 0"), std::string::npos) << outcome.what;
    EXPECT_NE(outcome.what.find("no accelerations obey the law, all modes were tried"), std::string::npos)
        << outcome.what;
    EXPECT_LE(simulation.time(), low + 1e-9);
    EXPECT_GE(simulation.time(), low - (method == Method::Rk4 ? 1e-3 : 1e-6));
    // The accelerations after a fixed step that failed are those of its last stage, up to a step away.
    if (method != Method::Rk4) {
      EXPECT_NEAR(simulation.accelerations()[0],
                  Telescope::acceleration(1.0 + 0.5 * std::pow(simulation.time(), 2), simulation.time()), 1e-7);
    }
    EXPECT_GT(simulation.report().friction.several, 0u);
  }
}

}  // namespace
}  // namespace tanor
