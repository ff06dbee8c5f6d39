#include "friction/friction_solver.hpp"

#include <gtest/gtest.h>
#include <tanor/enum_names.hpp>

#include <cmath>
#include <limits>

#include "friction/instant_of_contacts.hpp"

namespace tanor {
using namespace detail;
namespace {

constexpr double g = 9.81;

/// Makes a bead that slides down a line at the angle alpha to the horizontal.
System make_bead(double alpha, double mu) {
  return make_beads_on_lines({{0.0, 0.0, 0.0}}, {{std::cos(alpha), 0.0, -std::sin(alpha)}}, mu);
}

/// Makes two beads that a rod joins, so that the friction of each changes the reaction of the other.
System make_two_beads(double mu) {
  const double c = std::cos(0.4), s = std::sin(0.4);
  return make_beads_on_lines({{0.0, 0.0, 0.0}, {1.0, 0.5, 0.2}}, {{c, 0.0, -s}, {c, 0.0, -s}}, mu);
}

struct Found {
  Found(const System& system, FrictionMethod method, const UniquenessCheck& check = {})
      : at(system),
        response(at),
        laws(at.model.system, at.model.numbering, at.work.constraints.tangents(), at.model.incidences),
        solver(at.work, laws, method, response),
        lambda(at.b.size(), 0.0),
        w(at.w0),
        b(at.b) {
    solver.set_accelerations(std::vector<double>(at.work.scales.size(), g));
    outcome = solver.find({0.0, at.r.data(), at.v.data(), at.blocks.data()}, at.b.data(), check, lambda.data());
    solver.add(1.0, w.data(), b.data());
    response.solve_refined(b.data(), lambda.data(), nullptr);
  }

  InstantOfContacts at;
  DenseResponse response;
  FrictionLaws laws;
  FrictionSolver solver;
  Outcome outcome;
  std::vector<double> lambda, w, b;  // with friction
};

TEST(FrictionSolver, BeadOnARoughLineHasFrictionOfItsWeightAcrossTheLine) {
  const double alpha = 0.7, mu = 0.3;

  Found found(make_bead(alpha, mu), FrictionMethod::Auto);

  // tau = -mu m g cos(alpha) along the sliding
  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  std::vector<double> tau;
  found.solver.write_contacts(found.lambda.data(), &tau);
  const double size = mu * g * std::cos(alpha);
  EXPECT_NEAR(tau[0], -size * std::cos(alpha), 1e-13 * g);
  EXPECT_NEAR(tau[1], 0.0, 1e-13 * g);
  EXPECT_NEAR(tau[2], size * std::sin(alpha), 1e-13 * g);
  EXPECT_NEAR(found.solver.power(found.lambda.data(), found.at.v.data()), -size, 1e-13 * g);
}

TEST(FrictionSolver, EveryMethodSolvesTheFixedPointOfBeadsThatShareARod) {
  for (const FrictionMethod method : {FrictionMethod::Auto, FrictionMethod::FixedPoint, FrictionMethod::Anderson,
                                      FrictionMethod::Newton, FrictionMethod::Enumeration}) {
    const double mu = 0.3;

    Found found(make_two_beads(mu), method);

    // By (43) friction is mu |N| of the multipliers that it leads to.
    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.solver.report().contacts, 2u);
    EXPECT_LT(found.solver.measure(found.lambda.data()), 1e-11) << name_of(method);
    const FrictionLaws& laws = found.solver.laws();
    for (std::size_t c = 0; c < 2; ++c) {
      const double size = norm(found.solver.force(c, found.lambda.data()));
      EXPECT_GT(size, 0.1);
      EXPECT_NEAR(size, mu * norm(laws.normal_force(c, found.lambda.data())), 1e-11 * g);
    }
  }
}

TEST(FrictionSolver, FrictionThatChangesReactionsByLittleIsProvenUniqueOnlyWhereThatIsAsked) {
  const Found quiet(make_two_beads(0.3), FrictionMethod::Auto);
  const Found asked(make_two_beads(0.3), FrictionMethod::Auto, {.is_wanted = true});

  EXPECT_EQ(quiet.solver.report().uniqueness, Uniqueness::NotAsked);
  EXPECT_EQ(asked.solver.report().uniqueness, Uniqueness::Proven);
}

TEST(FrictionSolver, FrictionThatIsGivenNeedsNoSolve) {
  System system = make_bead(0.7, 0.3);
  system.friction = {Viscous{.name = "oil", .at = {"line0"}, .coefficient = 2.0}};

  Found found(system, FrictionMethod::Auto, {.is_wanted = true});

  ASSERT_TRUE(found.outcome.ok());
  EXPECT_EQ(found.response.num_solves, 1);  // the test itself makes this solve
  EXPECT_EQ(found.solver.report().uniqueness, Uniqueness::Proven);
  std::vector<double> tau(3);
  found.solver.write_given(tau.data());
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(tau[k], -2.0 * found.at.v[k], 1e-14);
}

TEST(FrictionSolver, AddedFrictionIsTakenAwayAgain) {
  Found found(make_two_beads(0.3), FrictionMethod::Auto);

  found.solver.add(-1.0, found.w.data(), found.b.data());

  for (std::size_t i = 0; i < found.w.size(); ++i) EXPECT_NEAR(found.w[i], found.at.w0[i], 1e-14 * g);
  for (std::size_t a = 0; a < found.b.size(); ++a) EXPECT_NEAR(found.b[a], found.at.b[a], 1e-13 * g);
}

}  // namespace
}  // namespace tanor
