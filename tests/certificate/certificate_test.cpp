/// The certificate passes what is right, and the tests check what it says otherwise.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <random>

#include <tanor/motion.hpp>

#include "certificate/tampering.hpp"
#include "reference.hpp"

namespace tanor {
namespace {

TEST(Certificate, PassesARightAnswerInEachForm) {
  for (const System& system : {make_driven_chain(), make_chain_with_coordinates(), only_coordinates()}) {
    Case solved(system);

    const Certificate certificate = solved.certify();

    EXPECT_TRUE(certificate.passed()) << certificate.line();
    // All checks count. Differences of places, where there are coordinates, lose the most.
    EXPECT_LE(certificate.certified_to(), system.coordinates.empty() ? 1e-13 : 1e-11);
    double worst = 0.0;
    for (const CertificateCheck& check : certificate.checks) worst = std::max(worst, check.error);
    EXPECT_EQ(certificate.certified_to(), worst);
    EXPECT_EQ(certificate.line().rfind("certified to ", 0), 0u) << certificate.line();
  }
}

TEST(Certificate, FiguresThatAFormDoesNotHaveAreNotANumber) {
  const Certificate constraints = Case(make_driven_chain()).certify();
  const Certificate both = Case(make_chain_with_coordinates()).certify();
  const Certificate coordinates = Case(only_coordinates()).certify();

  EXPECT_TRUE(std::isnan(constraints.forms_agree) && std::isnan(constraints.bases_orthogonal));
  EXPECT_FALSE(std::isnan(constraints.second_factorization) || std::isnan(constraints.normal_identity) ||
               std::isnan(constraints.tangent_identity));
  EXPECT_FALSE(std::isnan(both.forms_agree) || std::isnan(both.normal_identity) || std::isnan(both.tangent_identity) ||
               std::isnan(both.bases_orthogonal));
  EXPECT_TRUE(std::isnan(coordinates.forms_agree) && std::isnan(coordinates.normal_identity));
  EXPECT_FALSE(std::isnan(coordinates.tangent_identity));
  EXPECT_TRUE(std::isnan(both.orthogonality)) << "masses differ";
}

RC_GTEST_PROP(Certificate, PassesRandomSystems, ()) {
  Case solved(any_system(), {.form = Form::Normal});

  const Certificate certificate = solved.certify();

  RC_LOG() << certificate.line() << "\n";
  RC_ASSERT(certificate.passed());
  RC_ASSERT(solved.certify(SecondFactorization::Cholesky).passed());
}

TEST(Certificate, FindsAWrongMultiplierWhoseAccelerationIsRight) {
  for (std::size_t a = 0; a < 4; ++a) {
    Case solved(make_driven_chain());
    solved.lambda[a] *= 1.0 + 1e-7;

    EXPECT_EQ(failed(solved.certify()), "M w = f + K lambda");
  }
}

TEST(Certificate, AFastBystanderHidesNoWrongMultiplier) {
  System system = make_driven_chain();
  system.positions.insert(system.positions.end(), {5.0, 0.0, 0.0});
  system.velocities.insert(system.velocities.end(), {0.0, 1e5, 0.0});
  system.masses.push_back(1.0);
  system.forces.emplace_back(ConstantForce{.name = "rocket", .points = {4}, .force = Vector3{1e10, 0.0, 0.0}});
  ASSERT_TRUE(Case(system).certify().passed());
  for (std::size_t a = 0; a < 4; ++a) {
    Case solved(system);
    solved.lambda[a] *= 1.0 + 1e-7;

    EXPECT_EQ(failed(solved.certify()), "M w = f + K lambda");
  }
}

TEST(Certificate, SecondFactorizationVerifiesMultipliersByItself) {
  for (const SecondFactorization by : {SecondFactorization::Qr, SecondFactorization::Cholesky}) {
    for (std::size_t a = 0; a < 4; ++a) {
      Case solved(make_driven_chain());
      const std::string name = by == SecondFactorization::Qr ? "by QR" : "by another Cholesky";
      const Certificate right = solved.certify(by);
      EXPECT_TRUE(right.passed()) << right.line();
      EXPECT_LE(right.second_factorization, 1e-14);
      solved.lambda[a] *= 1.0 + 1e-7;

      const Certificate wrong = solved.certify(by);

      EXPECT_FALSE(fails(wrong, "w " + name + " = w"));
      EXPECT_TRUE(fails(wrong, "K lambda " + name));
      EXPECT_TRUE(fails(wrong, name.substr(3) + " = lambda"));
      EXPECT_TRUE(wrong.left_out.empty());
    }
  }
}

TEST(Certificate, MultipliersThatAreNotUniqueAreVerifiedByTheirReactions) {
  // The first rod is there twice. Its load may be shared out at will, but its sum may not change.
  System system = make_driven_chain();
  std::get<Rods>(system.constraints[0]).pairs.push_back({0, 1});
  Case solved(system);
  EXPECT_TRUE(solved.certify().passed()) << solved.certify().line();
  const auto& user_row = solved.forms.model.numbering.user_row;
  const auto place = [&](int row) {
    return static_cast<std::size_t>(std::ranges::find(user_row, row) - user_row.begin());
  };
  solved.lambda[place(0)] += 0.5;
  solved.lambda[place(3)] -= 0.5;
  EXPECT_TRUE(solved.certify().passed()) << solved.certify().line();

  solved.lambda[place(3)] += 1e-5;

  EXPECT_TRUE(fails(solved.certify(), "K lambda by QR"));
  EXPECT_FALSE(fails(solved.certify(), "QR = lambda"));
}

/// Makes points near a plane, each joined to each other by a rod, which gives far more rods than 3 n - 6.
System make_flat_frame(Index num_points, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> anywhere(0.0, 1.0);
  System system;
  Rods rods;
  for (Index i = 0; i < num_points; ++i) {
    const double x = anywhere(generator), y = anywhere(generator), z = 0.02 * anywhere(generator);
    system.positions.insert(system.positions.end(), {x, y, z});
    system.masses.push_back(1.0);
    for (Index j = 0; j < i; ++j) rods.pairs.push_back({j, i});
  }
  system.constraints = {rods};
  system.forces = {ConstantForce{"", {0}, {1.0, 2.0, 0.0}}};
  return system;
}

// These are four of 600 in which QR alone takes rounding for a direction. No diagonal entry of R is small, but a
// singular value is.
TEST(Certificate, RedundanciesThatShowInNoDiagonalEntryAreLeftOutOfTheSecondFactorization) {
  for (const std::uint32_t seed : {57u, 235u, 241u, 528u}) {
    Case solved(make_flat_frame(12, seed));

    const Certificate certificate = solved.certify(SecondFactorization::Qr);

    EXPECT_TRUE(certificate.passed()) << seed << ": " << certificate.line();
  }
}

TEST(Certificate, SaysWhatItLeavesOut) {
  System system = make_driven_chain();
  std::get<Rods>(system.constraints[0]).pairs.push_back({0, 1});

  const Certificate certificate = Case(system).certify(SecondFactorization::Cholesky);

  ASSERT_EQ(certificate.left_out.size(), 2u);
  EXPECT_EQ(certificate.left_out[0].rfind("second factorization: ", 0), 0u);
  EXPECT_TRUE(std::isnan(certificate.second_factorization));
  EXPECT_TRUE(certificate.passed()) << certificate.line();
}

TEST(Certificate, InverseDynamicsFindsEtaAndNoControlForce) {
  for (const bool is_one_mass : {false, true}) {
    System system = make_driven_chain();
    if (is_one_mass) system.masses.assign(4, 0.5);
    for (std::size_t i = 0; i < 9; ++i) {
      Case wrong_eta(system), wrong_w(system);
      EXPECT_FALSE(fails(wrong_eta.certify(), "(M w - f) = eta"));
      wrong_eta.eta[i] += 1e-6;
      wrong_w.w[i] += 1e-6;

      EXPECT_TRUE(fails(wrong_eta.certify(), "(M w - f) = eta"));
      EXPECT_FALSE(fails(wrong_eta.certify(), "(M w - f)_T = 0"));
      EXPECT_TRUE(fails(wrong_w.certify(), "(M w - f)_T = 0") || fails(wrong_w.certify(), "(M w - f) = eta"));
      EXPECT_FALSE(fails(wrong_w.certify(), "(15)") || fails(wrong_w.certify(), "(16)")) << "no matter of the answer";
    }
  }
}

TEST(Certificate, OrthogonalityOfTheSplitIsTriedWhereMassesAreEqual) {
  System system = make_driven_chain();
  system.masses.assign(4, 0.5);
  Case solved(system);

  const Certificate certificate = solved.certify();

  EXPECT_LE(certificate.orthogonality, 1e-12);
  EXPECT_TRUE(certificate.passed()) << certificate.line();
}

TEST(Certificate, LineWhoseUnitVectorsJumpIsNoFailure) {
  // The direction turns from z, over x and y, so that the unit vectors jump to other axes on the way.
  const auto f = [](const char* text) { return ScalarFunction::formula(text); };
  System system;
  system.positions = {0.0, 0.0, 1.0};
  system.velocities = {1.0, 0.0, 0.0};
  system.masses = {2.0};
  system.constraints = {
      Lines{"wire", {0}, Vector3{}, VectorFunction(f("sin(t)*cos(0.7*t^2)"), f("sin(t)*sin(0.7*t^2)"), f("cos(t)"))}};
  system.forces = {Gravity{"", {1.0, -2.0, -9.81}}};
  Simulation simulation(system, {.step = 0.01});

  for (int k = 1; k <= 30; ++k) {
    ASSERT_TRUE(simulation.advance_to(0.1 * k).ok());
    const Certificate certificate = simulation.certify();
    EXPECT_TRUE(certificate.passed()) << simulation.time() << ": " << certificate.line();
  }
}

/// Lines and planes that turn together, around a direction that lies in all of them, hold one point more than once.
std::vector<Constraint> list_turning(const char* which) {
  const auto f = [](const char* text) { return ScalarFunction::formula(text); };
  const auto line = [&](const char* name, double scale) {
    const auto by = [&](const char* text) { return f((std::to_string(scale) + "*" + text).c_str()); };
    return Lines{name, {0}, Vector3{}, VectorFunction(by("cos(0.3+t)"), by("sin(0.3+t)"), by("0.2"))};
  };
  const Planes upright{"upright", {0}, VectorFunction(f("-sin(0.3+t)"), f("cos(0.3+t)"), f("0")), 0.0};
  const Planes tilted{"tilted", {0}, VectorFunction(f("-0.2*cos(0.3+t)"), f("-0.2*sin(0.3+t)"), f("1")), 0.0};
  const Planes reversed{"reversed", {0}, VectorFunction(f("2*sin(0.3+t)"), f("-2*cos(0.3+t)"), f("0")), 0.0};
  switch (*which) {
    case 's':
      return {line("a", 1.0), line("b", 1.0)};
    case 'r':
      return {line("a", 1.0), line("b", -1.0)};
    case 'l':
      return {line("a", 1.0), line("b", 3.7)};
    case '3':
      return {line("a", 1.0), line("b", -2.0), line("c", 0.1)};
    case 'p':
      return {upright, reversed};
    default:
      return {line("a", -1.5), upright, tilted, reversed};
  }
}

TEST(Certificate, PassesConstraintsThatTurnTogetherAndHoldAPointTwice) {
  // On the line, s'' = w^2 c^2 s + f.d with d along the line and the part c = 1/|d| of it in the plane: s is known.
  const double length = std::hypot(1.0, 0.2), rate = 1.0 / length;
  for (const char* which : {"same", "reversed", "longer", "3 lines", "planes", "line and planes"}) {
    System system;
    system.positions = {0.0, 0.0, 0.0};
    system.velocities = {0.0, 0.0, 0.0};
    system.masses = {1.0};
    system.constraints = list_turning(which);
    system.forces = {ConstantForce{"", {0}, Vector3{1.0, 0.7, -2.0}}};
    Simulation simulation(system);

    ASSERT_TRUE(simulation.advance_to(1.0).ok()) << which << ": " << simulation.outcome().what;

    const Certificate certificate = simulation.certify();
    EXPECT_TRUE(certificate.passed()) << which << ": " << certificate.line();
    if (*which == 'p') continue;
    // s'' = rate^2 s + (cos(0.3 + t) + 0.7 sin(0.3 + t) - 0.4)/length, from rest
    double s = 0.0, v = 0.0;
    constexpr int steps = 20000;
    for (int k = 0; k < steps; ++k) {
      const double h = 1.0 / steps, t = k * h;
      const auto a = [&](double at, double x) {
        return rate * rate * x + (std::cos(0.3 + at) + 0.7 * std::sin(0.3 + at) - 0.4) / length;
      };
      const double k1 = a(t, s), k2 = a(t + 0.5 * h, s + 0.5 * h * v + 0.125 * h * h * k1);
      const double k3 = a(t + h, s + h * v + 0.5 * h * h * k2);
      s += h * v + h * h * (k1 + 2.0 * k2) / 6.0;
      v += h * (k1 + 4.0 * k2 + k3) / 6.0;
    }
    EXPECT_NEAR(simulation.positions()[2], 0.2 * s / length, 1e-8) << which;
    EXPECT_NEAR(simulation.positions()[0], std::cos(1.3) * s / length, 1e-8) << which;
  }
}

TEST(Certificate, ForceFreeAndFastMotionsPassInEachForm) {
  // No force acts and all masses are equal, so that w_T is nothing but rounding.
  System system;
  system.positions = {1.0, 0.0, 0.0};
  system.velocities = {0.0, 3e3, 0.0};
  system.masses = {2.0};
  system.constraints = {Circles{"rim", {0}, Vector3{}, Vector3{0.0, 0.0, 1.0}, 1.0}};
  system.coordinates = {CircleCoordinates{"angle", {0}, Vector3{}, Vector3{0.0, 0.0, 1.0}, 1.0}};
  for (const Form form : {Form::Normal, Form::Tangent}) {
    const Certificate certificate = Case(system, {.form = form}).certify();
    EXPECT_TRUE(certificate.passed()) << certificate.line();
  }
}

/// Makes two pendulums of rods of 0.1 m that fall from their sides, in angles alone.
System make_pendulums_apart(double distance) {
  System system;
  for (const double x : {0.0, distance}) {
    const auto first = static_cast<Index>(system.masses.size());
    for (int k = 0; k < 3; ++k) {
      system.positions.insert(system.positions.end(), {x + 0.1 * k, 0.0, 0.0});
      system.masses.push_back(1.0);
    }
    system.velocities.insert(system.velocities.end(), {0.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.3, 0.0});
    system.supports.push_back({"", {first}, {}});
    system.coordinates.push_back(ChainAngles{"", {first + 1, first + 2}, first, {}, {}});
  }
  system.forces = {Gravity{"", {0.0, -9.81, 0.0}}};
  return system;
}

TEST(Certificate, PassesMechanismsInCoordinatesHoweverFarApart) {
  for (const double distance : {1.0, 10.0, 1e3, 1e5}) {
    const Certificate certificate = Case(make_pendulums_apart(distance)).certify();
    EXPECT_TRUE(certificate.passed()) << distance << " m: " << certificate.line();
  }
}

TEST(Certificate, PassesFreePointsAndPointsThatCannotMove) {
  System free_points;
  free_points.positions = {1.0, 0.0, 0.0, 2.0, 0.0, 0.0};
  free_points.velocities.assign(6, 1.0);
  free_points.masses = {2.0, 3.0};
  free_points.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  System held = free_points;
  held.velocities.assign(6, 0.0);
  held.supports = {{"", {0, 1}, {}}};
  held.constraints = {Rods{"rod", {{0, 1}}, {}, {}}};

  const Certificate of_free = Case(free_points).certify(), of_held = Case(held).certify();

  EXPECT_TRUE(of_free.passed() && of_free.checks.size() == 1) << of_free.line();
  EXPECT_TRUE(of_held.passed());
  EXPECT_EQ(of_held.line(), "nothing to certify: no point moves");
}

/// Makes twenty rods on a support. All beads but the last have 1 kg, or every other one is heavy. The straight one is
/// nearly taut between its support and a heavy tip, with cond S = 80 ratio.
System make_unequal_chain(double ratio, bool alternates, double curvature = 0.3) {
  System system;
  Rods rods;
  for (Index i = 0; i <= 20; ++i) {
    const double s = 0.1 * i;
    system.positions.insert(system.positions.end(), {s, 0.0, -curvature * s * s});
    system.masses.push_back(i == 20 || (alternates && i % 2 == 0) ? ratio : 1.0);
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  system.supports = {{"", {0}, {}}};
  system.constraints = {rods};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}

TEST(Certificate, UnequalMassesAreProvenToTenDigitsInEachForm) {
  for (const double ratio : {1e3, 1e6, 1e9, 1e12}) {
    for (const bool alternates : {false, true}) {
      System system = make_unequal_chain(ratio, alternates, alternates ? 0.3 : 0.0);
      std::vector<Index> points(20);
      for (Index i = 0; i < 20; ++i) points[static_cast<std::size_t>(i)] = i + 1;
      for (const bool has_coordinates : {false, true}) {
        if (has_coordinates) system.coordinates = {ChainAngles{"chain", points, 0, {}, {}}};
        for (const Form form : {Form::Normal, Form::Tangent}) {
          if (form == Form::Tangent && !has_coordinates) continue;
          const Certificate certificate = Case(system, {.form = form}).certify();

          EXPECT_TRUE(certificate.passed()) << ratio << ": " << certificate.line();
          EXPECT_LE(certificate.certified_to(), 1e-10) << ratio << ": " << certificate.line();
        }
      }
    }
  }
}

TEST(Certificate, NothingIsProvenByFewerThanFourDigits) {
  // S has the reciprocal condition 1e-14. With a bound of 1e3 eps/rcond a projector of any K would pass.
  const System system = make_unequal_chain(1e12, false, 0.0);
  const std::size_t numbers = Tampering::K(Case(system).forms).size();
  for (std::size_t k = 0; k < numbers; ++k) {
    Case solved(system);
    Tampering::K(solved.forms)[k] += 1e-2;

    const Certificate certificate = solved.certify();

    for (const CertificateCheck& check : certificate.checks) EXPECT_LE(check.allowed, Certificate::fewest_digits);
    EXPECT_FALSE(certificate.passed()) << k;
    EXPECT_NE(certificate.line().find("fewer than four digits are proven; the reciprocal condition is"),
              std::string::npos)
        << certificate.line();
  }
}

TEST(Certificate, HeavyTipIsCertifiedAfterRefinement) {
  // For twenty light beads and a heavy one (ratio 1e9) Cholesky of S alone leaves |K'w + phi| = 8e-6
  // (docs/certificate.md).
  Case solved(make_unequal_chain(1e9, false));

  const Certificate certificate = solved.certify();

  EXPECT_TRUE(certificate.passed()) << certificate.line();
  EXPECT_LE(certificate.certified_to(), 1e-13);
}

/// The bead is at rest on a rough incline with slope 0.3 and mu = 0.5.
TEST(Certificate, StickingPointsThatMissTheLawAreRefusedWithoutACertificate) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.velocities = {0.0, 0.0, 0.0};
  system.masses = {2.0};
  system.constraints = {Lines{"incline", {0}, Vector3{}, Vector3{1.0, 0.0, 0.3}}};
  system.forces = {Gravity{"", {0.0, 0.0, -10.0}}};
  system.friction = {Coulomb{.name = "rough", .at = {"incline"}, .coefficient = 0.5}};
  Case solved(system);
  std::vector<double> moving = solved.w;
  moving[0] += 1e-3;

  EXPECT_TRUE(Tampering::check_rest(solved, solved.w, 1.0).ok());
  EXPECT_TRUE(Tampering::check_rest(solved, solved.w, 0.61).ok());
  for (const Outcome& outcome :
       {Tampering::check_rest(solved, solved.w, 0.59), Tampering::check_rest(solved, moving, 1.0)}) {
    EXPECT_EQ(outcome.status, Status::NotConverged);
    EXPECT_NE(outcome.what.find("misses the law: rough at incline[0], point 0 sticks"), std::string::npos)
        << outcome.what;
  }
}

}  // namespace
}  // namespace tanor
