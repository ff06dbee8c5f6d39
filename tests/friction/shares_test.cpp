#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tanor/tanor.hpp>

#include "friction/contact_problem.hpp"
#include "friction/rough_contacts.hpp"
#include "long_tests.hpp"
#include "reference.hpp"

/// \file Beads at rest on rough lines can share their load in many ways, with reactions that depend on the share. Where
/// one motion obeys the law it is found, and where several do they are counted, by a dense twin and by tanor.
namespace tanor {
using namespace detail;
namespace {

using Eigen::Vector3d;

struct SharedKind {
  unsigned scenes;
  std::size_t beads, lines;  // the other beads are free
  bool closed, in_plane;     // a rod from the last bead to the first one; everything in the plane z = 0
};

/// Makes beads in a row, joined by rods, with any forces, and coefficients from 0.05 to 3, uniform on a logarithmic
/// scale.
System make_sharing_beads(unsigned seed, const SharedKind& kind) {
  std::mt19937 random(seed * 7919u + 13u);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> log_mass(-1.0, 1.0), log_mu(std::log(0.05), std::log(3.0));
  const auto any = [&] {
    const double x = normal(random), y = normal(random), z = normal(random);
    return Vector3d(x, y, kind.in_plane ? 0.0 : z);
  };
  const auto vector = [](const Vector3d& a) { return Vector3{a(0), a(1), a(2)}; };
  System system;
  Rods rods{"rods", {}, {}, {}};
  for (std::size_t k = 0; k < kind.beads; ++k) {
    const Vector3d r = 1.5 * any(), line = any().normalized(), force = 4.0 * any();
    const auto bead = static_cast<Index>(k);
    system.positions.insert(system.positions.end(), {r(0), r(1), r(2)});
    system.masses.push_back(std::exp(log_mass(random)));
    system.forces.push_back(ConstantForce{"", {bead}, vector(force)});
    const double mu = std::exp(log_mu(random));
    if (k < kind.lines) {
      const std::string name = "l" + std::to_string(k);
      system.constraints.push_back(Lines{name, {bead}, vector(r), vector(line)});
      system.friction.push_back(Coulomb{.name = "", .at = {name}, .coefficient = mu});
    }
    if (k > 0) rods.pairs.push_back({bead - 1, bead});
  }
  if (kind.closed) rods.pairs.push_back({0, static_cast<Index>(kind.beads) - 1});
  system.velocities.assign(3 * kind.beads, 0.0);
  system.constraints.push_back(rods);
  return system;
}

/// The solution for fixed limits is the x with x = P(x - a/A_cc), where P is the projection onto |x_c| <= h_c.
TEST(ConvexLaw, IsSolvedThoughContactsShareTheirLoad) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    ContactProblem problem;
    Eigen::Index size = 0;
    for (Eigen::Index c = 0; c < 8; ++c) {
      const Eigen::Index dimension = c == 0 ? 1 : 1 + c % 2;
      problem.contacts.push_back({size, dimension, c == 0, 0.3});
      size += dimension;
    }
    const Eigen::Index rank = seed % 2 == 0 ? size : size / 2;
    const Eigen::MatrixXd B = Eigen::MatrixXd::NullaryExpr(size, rank, [&] { return normal(random); });
    problem.A = B * B.transpose();
    problem.a0 = B * Eigen::VectorXd::NullaryExpr(rank, [&] { return 3.0 * normal(random); });
    const Eigen::VectorXd limits = Eigen::VectorXd::NullaryExpr(8, [&] { return std::exp(normal(random)); });

    const Eigen::VectorXd x = solve_convex_law(problem, limits);

    const Eigen::VectorXd a = problem.accelerations(x);
    EXPECT_EQ(x(0), limits(0));  // it moves
    for (std::size_t c = 1; c < 8; ++c) {
      const auto& contact = problem.contacts[c];
      const double limit = limits(static_cast<Eigen::Index>(c));
      const Eigen::VectorXd own = x.segment(contact.first, contact.dimension);
      Eigen::VectorXd z = own - a.segment(contact.first, contact.dimension) / problem.mobility(c);
      if (z.norm() > limit) z *= limit / z.norm();
      EXPECT_LT((own - z).norm(), 1e-9 * limits.maxCoeff()) << c;
    }
  }
}

/// Two beads of 1 kg on rough lines along x, 1 m apart, joined by a rod of the slope tan(a) to their normal, under 1 N
/// each and 0.1 N along. With mu > tan(a) they hold with any tension T = ((x_2 - x_1)/2 - 0.05)/sin(a):
///
///   x_1 + x_2 = -0.1,   N_1 = 1 - T cos(a),   N_2 = 1 + T cos(a).
TEST(FrictionShares, OfAWedgeDoNotGrowWhenTheyAreFoundAnew) {
  const double tangent = 0.2;
  ContactProblem problem;
  problem.contacts = {{0, 1, false, 0.5}, {1, 1, false, 0.5}};
  problem.A = Eigen::MatrixXd::Constant(2, 2, 0.5);
  problem.a0 = Eigen::VectorXd::Constant(2, 0.05);
  problem.N0 = Eigen::VectorXd::Zero(6);
  problem.N0(1) = 1.0 + 0.05 / tangent;
  problem.N0(4) = 1.0 - 0.05 / tangent;
  problem.W = Eigen::MatrixXd::Zero(6, 2);
  problem.W.row(1) << 0.5 / tangent, -0.5 / tangent;
  problem.W.row(4) = -problem.W.row(1);
  Eigen::VectorXd x{{-0.7, 0.6}}, weights;

  for (int event = 0; event < 20; ++event) {
    EXPECT_LT(share_load(problem, {1, 1}, false, &x, &weights), 1.0);
    EXPECT_NEAR(x.sum(), -0.1, 1e-12);
    EXPECT_LT(x.norm(), 2.0);
  }
}

/// Two contacts carry 1 N together, within limits of 2 N and 1 N that no share changes.
TEST(FrictionShares, AreMeasuredByTheLimits) {
  ContactProblem problem;
  problem.contacts = {{0, 1, false, 0.5}, {1, 1, false, 0.25}};
  problem.A = Eigen::MatrixXd::Constant(2, 2, 0.5);
  problem.a0 = Eigen::VectorXd::Constant(2, 0.5);
  problem.N0 = Eigen::VectorXd::Zero(6);
  problem.N0(1) = problem.N0(4) = 4.0;
  problem.W = Eigen::MatrixXd::Zero(6, 2);
  Eigen::VectorXd x{{-1.9, 0.9}}, weights;

  const double load = share_load(problem, {1, 1}, false, &x, &weights);

  EXPECT_NEAR(x.sum(), -1.0, 1e-12);
  EXPECT_NEAR(load, std::max(-x(0) / 2.0, -x(1)), 1e-12);
  // The centre, where 1/(4 - a^2) a = b/(1 - b^2) and a + b = 1.
  EXPECT_NEAR(-x(0) / (4.0 - x(0) * x(0)), -x(1) / (1.0 - x(1) * x(1)), 1e-2);
}

TEST(FrictionShares, NoSceneWithOneMotionIsRefusedAndNoAnswerIsWrong) {
  int unique = 0, several = 0, resting = 0, borderline = 0, tried = 0;
  for (const SharedKind& kind :
       {SharedKind{1500, 2, 2, false, false}, SharedKind{1500, 3, 2, false, false}, SharedKind{1500, 2, 2, false, true},
        SharedKind{400, 3, 3, false, false}, SharedKind{400, 3, 3, false, true}, SharedKind{400, 4, 3, true, false},
        SharedKind{60, 4, 4, false, false}}) {
    const auto scenes = static_cast<unsigned>(num_draws(static_cast<int>(kind.scenes)));
    tried += static_cast<int>(scenes);
    for (unsigned seed = 1; seed <= scenes; ++seed) {
      const System system = make_sharing_beads(seed, kind);
      const reference::RoughContacts twin(system);
      const auto counted = twin.find_all();
      if (counted.margin < 1e-6 || !counted.is_certain || counted.motions.empty()) {
        ++borderline;
        continue;
      }
      const auto& motions = counted.motions;
      Dynamics dynamics(system);
      std::vector<double> w(system.positions.size());
      const SolveReport report = dynamics.solve(
          {.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w});
      const Simulation run(system);
      SCOPED_TRACE(std::to_string(kind.beads) + " beads, " + std::to_string(kind.lines) + " lines, seed " +
                   std::to_string(seed) + ": " + std::to_string(motions.size()) + " motions; " + report.outcome.what);
      const bool is_unique = motions.size() == 1;
      (is_unique ? unique : several) += 1;
      EXPECT_EQ(report.outcome.status, is_unique ? Status::Ok : Status::NotUnique);
      EXPECT_EQ(run.outcome().status, is_unique ? Status::Ok : Status::NotUnique) << run.outcome().what;
      if (!is_unique || !report.outcome.ok()) continue;
      const double largest = motions[0].a.lpNorm<Eigen::Infinity>();
      resting += largest < 1e-9 ? 1 : 0;
      for (std::size_t c = 0; c < twin.mu.size(); ++c) {
        const auto bead = static_cast<Index>(twin.points[c]);
        const double wanted = motions[0].a(static_cast<Eigen::Index>(c)), allowed = 1e-8 * (1.0 + largest);
        EXPECT_NEAR(twin.lines[c].dot(reference::point(w, bead)), wanted, allowed);
        EXPECT_NEAR(twin.lines[c].dot(reference::point(run.accelerations(), bead)), wanted, allowed);
      }
    }
  }
  if (tried < 500) return;  // shares of fewer, as TANOR_DRAWS asks for, say nothing
  EXPECT_GT(unique, tried * 13 / 15);
  EXPECT_GT(several, tried / 25);
  EXPECT_GT(resting, tried / 2);
  EXPECT_LE(borderline, 1 + tried / 500);
}

}  // namespace
}  // namespace tanor
