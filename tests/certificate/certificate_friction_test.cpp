/// The certificate with friction passes what is right, and names what is not.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <tanor/motion.hpp>
#include <tanor/user_kernel.hpp>

#include "certificate/certified.hpp"
#include "friction/rough_lines.hpp"

namespace tanor {
namespace {

constexpr const char* law = "tau = tau(r, v, t, lambda)";
constexpr const char* newton = "M w = f + tau + K lambda";
constexpr const char* limit = "|tau| <= mu_s |N|";
constexpr const char* stays = "T'w + phi = 0 where it sticks";

/// Makes a block and a bead on an inclined rough plane with a rod between them.
System make_slope(double mu, double speed) {
  const double c = std::cos(0.4), s = std::sin(0.4);
  System system;
  system.positions = {0.0, 0.0, 0.0, c, -s, 0.0};
  system.masses = {2.0, 0.7};
  system.velocities = {speed * c, -speed * s, 0.0, speed * c, -speed * s, 0.0};
  system.constraints = {Planes{"slope", {0, 1}, Vector3{s, c, 0.0}}, Rods{"rod", {{0, 1}}, {}, {}}};
  system.forces = {Gravity{"", {0.0, -9.81, 0.0}}};
  system.friction = {Coulomb{.name = "rough", .at = {"slope"}, .coefficient = mu}};
  return system;
}

/// Makes a bead on a spoke that turns. It rests on the spoke or glides.
System make_turning_spoke(double mu, double speed) {
  System system;
  system.positions = {1.0, 0.0, 0.0};
  system.masses = {0.5};
  system.velocities = {speed, 2.0, 0.0};
  system.constraints = {
      Lines{"spoke", {0}, Vector3{}, {ScalarFunction::formula("cos(2*t)"), ScalarFunction::formula("sin(2*t)"), 0.0}}};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  system.friction = {Coulomb{.name = "rough", .at = {"spoke"}, .coefficient = mu}};
  return system;
}

/// Makes a block on a belt that accelerates.
System make_belt(double mu) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.masses = {3.0};
  system.velocities = {1.0, 0.0, 0.0};
  system.constraints = {Planes{"belt", {0}, Vector3{0.0, 0.0, 1.0}}};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  system.friction = {Coulomb{
      .name = "", .at = {"belt"}, .coefficient = mu, .velocity = {ScalarFunction::formula("1 + 2*t"), 0.0, 0.0}}};
  return system;
}

/// Makes a bead on a rough sphere, held by a rod, with a given law.
System make_ball(const Friction& friction) {
  System system;
  system.positions = {0.0, 0.0, 1.0, 2.0, 0.0, 1.0};
  system.masses = {0.4, 1.0};
  system.velocities = {0.0, 0.7, 0.0, 0.0, 0.0, 0.0};
  system.supports = {{"", {1}, {}}};
  system.constraints = {Spheres{"ball", {0}, Vector3{}, 1.0}, Rods{"rod", {{0, 1}}, {}, {}}};
  system.forces = {Gravity{"", {0.0, 0.3, -9.81}}};
  system.friction = {friction};
  return system;
}

std::vector<Friction> laws_of_each_kind() {
  return {Coulomb{.name = "", .at = {"ball"}, .coefficient = 0.3},
          Coulomb{.name = "", .at = {"ball"}, .coefficient = 0.3, .reaction = Coulomb::Reaction::Full},
          Coulomb{.name = "", .at = {"ball"}, .coefficient = 0.3, .regularisation = 0.2},
          Viscous{.name = "", .at = {"ball"}, .coefficient = 0.8},
          UserFriction{.name = "",
                       .at = {"ball"},
                       .kernel = make_friction_kernel<1>([](const auto&, const auto& v, double, const auto& lambda) {
                         using std::sqrt;
                         const auto size = 0.1 * sqrt(lambda[0] * lambda[0] + 1.0);
                         return std::array{-size * v[0], -size * v[1], -size * v[2]};
                       })}};
}

System make_slope_by_coordinates(double speed) {
  System system;
  const double c = std::cos(0.4), s = std::sin(0.4);
  system.positions = {0.0, 0.0, 0.0};
  system.masses = {2.0};
  system.velocities = {speed * c, -speed * s, 0.0};
  system.constraints = {Lines{"slope", {0}, Vector3{}, Vector3{c, -s, 0.0}}};
  system.coordinates = {LineCoordinates{"q", {0}, Vector3{}, Vector3{c, -s, 0.0}}};
  system.forces = {Gravity{"", {0.0, -9.81, 0.0}}};
  system.friction = {Coulomb{.name = "", .at = {"slope"}, .coefficient = 0.5}};
  return system;
}

std::string errors(const Certificate& certificate) {
  std::string all;
  for (const CertificateCheck& check : certificate.checks) {
    all += check.identity + " " + std::to_string(check.error * 1e12) + "e-12 of " +
           std::to_string(check.allowed * 1e12) + "e-12" + "\n";
  }
  return all;
}

void expect_certified(System system, const SolverOptions& options = {}, double to = 1e-12) {
  Case solved(std::move(system), options);
  const Certificate certificate = solved.certify();
  EXPECT_TRUE(certificate.passed()) << certificate.line() << "\n" << errors(certificate);
  EXPECT_LE(certificate.certified_to(), to) << certificate.line() << "\n" << errors(certificate);
  EXPECT_FALSE(std::isnan(certificate.friction));
}

TEST(FrictionCertificate, PassesWhatSlidesAndWhatSticks) {
  for (const double speed : {0.0, 1.0}) {
    for (const double mu : {0.2, 0.9}) {
      SCOPED_TRACE("mu " + std::to_string(mu) + ", speed " + std::to_string(speed));
      expect_certified(make_slope(mu, speed));
      expect_certified(make_turning_spoke(mu, speed));
    }
  }
  for (const double mu : {0.1, 0.5}) expect_certified(make_belt(mu));
}

TEST(FrictionCertificate, PassesEachKindOfLaw) {
  for (const Friction& friction : laws_of_each_kind()) expect_certified(make_ball(friction));
}

TEST(FrictionCertificate, PassesBothForms) {
  for (const Form form : {Form::Normal, Form::Tangent, Form::Both}) {
    for (const double speed : {0.0, 1.0}) expect_certified(make_slope_by_coordinates(speed), {.form = form});
  }
}

TEST(FrictionCertificate, PassesRoughLinesWhereTheyHaveOneSolution) {
  int tried = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const System system = make_rough_lines(seed, 5, 0.4, seed % 2 == 0);
    if (DenseFriction(system, 0.4).find_all().size() != 1) continue;
    ++tried;
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_certified(system);
  }
  EXPECT_GT(tried, 20);
}

/// Lines, rods and contacts at rest hold more than can move. The share of each is known to the rounding over the
/// compliance that divides it, 2e-16/1e-4, and the law multiplies it by mu = 20 and the levers of the lines.
TEST(FrictionCertificate, PassesWhatIsHeldMoreThanOnce) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    System system = make_rough_lines(seed, 4, 20.0, false);
    system.velocities.assign(system.velocities.size(), 0.0);
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_certified(system, {}, 2e-10);
  }
}

// ---- corruptions -------------------------------------------------------------------------------------------------

TEST(FrictionCertificate, AWrongCoefficientIsCaughtByTheLawAlone) {
  for (const Friction& friction : laws_of_each_kind()) {
    Case solved(make_ball(friction));
    Friction& known = solved.told_system().friction[0];
    if (auto* coulomb = std::get_if<Coulomb>(&known)) coulomb->coefficient *= 1.0 + 1e-6;
    if (auto* viscous = std::get_if<Viscous>(&known)) viscous->coefficient *= 1.0 + 1e-6;
    if (auto* user = std::get_if<UserFriction>(&known)) {
      user->kernel = make_friction_kernel<1>([](const auto&, const auto& v, double, const auto& lambda) {
        using std::sqrt;
        const auto size = 0.1000001 * sqrt(lambda[0] * lambda[0] + 1.0);
        return std::array{-size * v[0], -size * v[1], -size * v[2]};
      });
    }
    const Certificate certificate = solved.certify();
    EXPECT_TRUE(fails(certificate, law));
    EXPECT_FALSE(fails(certificate, newton));
    EXPECT_NE(certificate.line().find("at point 0"), std::string::npos) << certificate.line();
  }
}

TEST(FrictionCertificate, AWrongLimitIsCaughtWhereItSticks) {
  System system = make_slope_by_coordinates(0.0);
  system.coordinates.clear();
  Case solved(system);
  std::get<Coulomb>(solved.told_system().friction[0]).coefficient = std::tan(0.4) * (1.0 - 1e-6);
  EXPECT_TRUE(fails(solved.certify(), limit));
  std::get<Coulomb>(solved.told_system().friction[0]).coefficient = std::tan(0.4) * (1.0 + 1e-6);
  EXPECT_TRUE(solved.certify().passed());
}

TEST(FrictionCertificate, ScaledFrictionIsCaught) {
  for (const double speed : {0.0, 1.0}) {
    Case solved(make_slope(0.5, speed));
    ASSERT_TRUE(solved.certify().passed());
    for (double& each : solved.tau) each *= 1.0 + 1e-6;
    const Certificate certificate = solved.certify();
    EXPECT_TRUE(fails(certificate, newton));
    if (speed > 0.0) {
      EXPECT_TRUE(fails(certificate, law));
    }
  }
}

/// Newton's law alone does not detect a friction that moves a sticking contact.
TEST(FrictionCertificate, FrictionThatLetsGoIsCaught) {
  Case solved(make_slope(0.5, 0.0));
  const double c = std::cos(0.4), s = std::sin(0.4);
  const std::size_t inner = static_cast<std::size_t>(solved.forms.model.numbering.inner_point[0]);
  const std::size_t other = static_cast<std::size_t>(solved.forms.model.numbering.inner_point[1]);
  for (const std::size_t i : {inner, other}) {
    const double by = 1e-6;  // m/s^2, both together, so that the rod has no part in it
    solved.w[3 * i] += by * c;
    solved.w[3 * i + 1] -= by * s;
    solved.tau[3 * i] += by * c * solved.forms.model.mass[i];
    solved.tau[3 * i + 1] -= by * s * solved.forms.model.mass[i];
  }
  const Certificate certificate = solved.certify();
  EXPECT_TRUE(fails(certificate, stays));
  EXPECT_FALSE(fails(certificate, newton));
  EXPECT_FALSE(fails(certificate, "K'w + phi = 0"));
}

TEST(FrictionCertificate, FrictionAcrossTheGuideIsCaughtThoughNothingElseSeesIt) {
  Case solved(make_slope(0.9, 0.0));
  // The normal force takes over what tau has there, so that w stays.
  const std::size_t i = static_cast<std::size_t>(solved.forms.model.numbering.inner_point[0]);
  const Vec3 n{std::sin(0.4), std::cos(0.4), 0.0}, more = 1e-6 * n;
  store(solved.tau.data(), i, load(solved.tau.data(), i) + more);
  store(solved.eta.data(), i, load(solved.eta.data(), i) - more);
  for (std::size_t a = 0; a < solved.lambda.size(); ++a) {
    if (solved.forms.model.numbering.user_row[a] == 0) solved.lambda[a] -= 1e-6;
  }
  const Certificate certificate = solved.certify();
  EXPECT_TRUE(fails(certificate, law));
  EXPECT_FALSE(fails(certificate, newton));
}

TEST(FrictionCertificate, FrictionThatDrivesIsCaught) {
  Case solved(make_slope(0.3, 1.0));
  for (double& each : solved.tau) each = -each;
  EXPECT_TRUE(fails(solved.certify(), law));
}

/// The multipliers by the three blocks of (43) are compared with those of the smallest form.
TEST(FrictionCertificate, MultipliersThatTheBlocksDoNotFindAreCaught) {
  Case solved(make_ball(Coulomb{.name = "", .at = {"ball"}, .coefficient = 0.3}));
  ASSERT_FALSE(fails(solved.certify(), "by (43)"));
  solved.lambda[0] += 1e-6 * std::abs(solved.lambda[0]);
  EXPECT_TRUE(fails(solved.certify(), "by (43)"));
}

TEST(FrictionCertificate, PassesAtTheEndOfAMotionThatSlidesAndSticks) {
  System held = make_slope_by_coordinates(1.0);
  held.coordinates.clear();
  for (const System& system : {make_slope(0.3, 1.0), held}) {
    Simulation simulation(system, {.method = Method::Dopri5, .rtol = 1e-10, .atol = 1e-12});
    for (const double t : {0.05, 0.4, 1.0}) {
      ASSERT_TRUE(simulation.advance_to(t).ok()) << simulation.outcome().what;
      const Certificate certificate = simulation.certify();
      EXPECT_TRUE(certificate.passed()) << certificate.line() << "\n" << errors(certificate);
    }
  }
}

}  // namespace
}  // namespace tanor
