/// Problems of many contacts with Coulomb friction.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <Eigen/Dense>

#include "contact/cone.hpp"
#include "contact/cone_solver.hpp"
#include "random_numbers.hpp"

namespace tanor::detail {
namespace {

constexpr double of_earth = 9.81;

/// Makes W = H'M^-1H and q = H'v of the columns H [coordinates, 3 contacts].
ConeProblem make_problem(const Eigen::MatrixXd& H, const Eigen::VectorXd& masses, const Eigen::VectorXd& v,
                         std::vector<double> friction) {
  ConeProblem problem;
  const Eigen::MatrixXd W = H.transpose() * masses.cwiseInverse().asDiagonal() * H;
  const Eigen::VectorXd q = H.transpose() * v;
  problem.q.assign(q.begin(), q.end());
  problem.friction = std::move(friction);
  const auto n = static_cast<int>(problem.friction.size());
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      if (row != column && W.block<3, 3>(3 * row, 3 * column).isZero(0.0)) continue;
      Block3 block;
      for (int k = 0; k < 9; ++k) block.entries[static_cast<std::size_t>(k)] = W(3 * row + k / 3, 3 * column + k % 3);
      problem.columns.push_back(column);
      problem.blocks.push_back(block);
    }
    problem.start.push_back(problem.blocks.size());
  }
  return problem;
}

/// Expects the laws of each contact, relative to the sizes of r and u: u_n >= 0, r in the cone, r_n u_n = 0, and r_t
/// against u_t.
void expect_laws(const ConeProblem& problem, const std::vector<double>& r, double little) {
  std::vector<double> u(r.size());
  problem.find_velocities(r.data(), u.data());
  double of_r = 0.0, of_q = 0.0;
  for (const double each : r) of_r = std::max(of_r, std::abs(each));
  for (const double each : problem.q) of_q = std::max(of_q, std::abs(each));
  for (std::size_t c = 0; c < problem.num_contacts(); ++c) {
    const Vec3 force = load(r.data(), c), velocity = load(u.data(), c);
    const double mu = problem.friction[c];
    EXPECT_GE(velocity.x, -little * of_q) << c;
    EXPECT_LE(tangential(force), mu * force.x + little * of_r) << c;
    EXPECT_LE(std::abs(force.x * velocity.x), little * of_r * of_q) << c;
    EXPECT_LE(std::abs(force.y * velocity.y + force.z * velocity.z + mu * force.x * tangential(velocity)),
              little * of_r * of_q)
        << c;
  }
}

/// Five balls that stand on one another and on the floor carry the weights above.
TEST(ConeSolver, AColumnCarriesItsWeight) {
  constexpr int count = 5;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(3 * count, 3 * count);
  Eigen::VectorXd masses(3 * count), fall = Eigen::VectorXd::Zero(3 * count);
  for (int k = 0; k < count; ++k) {
    masses.segment<3>(3 * k).setConstant(1.0 + 0.25 * k);
    fall[3 * k] = -of_earth;
    H.block<3, 3>(3 * k, 3 * k).setIdentity();
    if (k > 0) H.block<3, 3>(3 * (k - 1), 3 * k) = -Eigen::Matrix3d::Identity();
  }
  const ConeProblem problem = make_problem(H, masses, fall, std::vector<double>(count, 0.4));
  std::vector<double> r(3 * count);
  EXPECT_TRUE(solve_contacts(problem, {}, &r).is_solved);
  const double weights[] = {73.575, 63.765, 51.5025, 36.7875, 19.62};
  for (std::size_t k = 0; k < count; ++k) EXPECT_LT(norm(load(r.data(), k) - Vec3{weights[k], 0.0, 0.0}), 1e-10) << k;
}

/// A stiff table on four legs has one force too many. Its motion is that of rest, and the forces carry its load.
TEST(ConeSolver, ATableOnFourLegsRests) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(3, 12);  // z, and the turns about x and y
  const double at[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  Eigen::VectorXd masses(3), fall(3);
  masses << 9.0, 1.0, 1.0;
  // A load of 5 kg at (0.1, 0.05) on four points of 1 kg: forces -9 g, and moments -5 g y and 5 g x.
  fall << -of_earth, -5.0 * of_earth * 0.05, 5.0 * of_earth * 0.1;
  for (int leg = 0; leg < 4; ++leg) H.col(3 * leg) << 1.0, at[leg][1], -at[leg][0];
  ConeProblem problem = make_problem(H, masses, fall, std::vector<double>(4, 0.0));
  for (std::size_t leg = 0; leg < 4; ++leg) {
    Block3& own = const_cast<Block3&>(problem.own_block(leg));
    own.entries[4] = own.entries[8] = 1.0;  // nothing moves in the plane
  }
  std::vector<double> r(12), u(12);
  EXPECT_TRUE(solve_contacts(problem, {}, &r).is_solved);
  problem.find_velocities(r.data(), u.data());
  for (const double each : u) EXPECT_NEAR(each, 0.0, 1e-10);
  EXPECT_NEAR(r[0] + r[3] + r[6] + r[9], 88.29, 1e-9);
}

/// Random contacts of random bodies, as many as make forces not unique, with q = s - H'v0: the velocity -v0 would part
/// all of them, so that there is a solution (Klarbring and Pang 1998).
RC_GTEST_PROP(ConeSolver, RandomContactsObeyTheLaws, ()) {
  const auto seed = *rc::gen::arbitrary<unsigned>();
  const int contacts = *rc::gen::inRange(1, 25), coordinates = 3 + *rc::gen::inRange(0, 60);
  const double steepest = *rc::gen::element(0.0, 0.3, 1.0);
  const std::vector<double> numbers =
      normal_numbers(static_cast<std::size_t>(3 * contacts * coordinates + coordinates + contacts), seed);
  Eigen::MatrixXd H = Eigen::Map<const Eigen::MatrixXd>(numbers.data(), coordinates, 3 * contacts);
  const Eigen::VectorXd v = Eigen::Map<const Eigen::VectorXd>(numbers.data() + H.size(), coordinates);
  std::vector<double> friction(static_cast<std::size_t>(contacts));
  for (std::size_t c = 0; c < friction.size(); ++c)
    friction[c] = std::min(1.5, steepest * std::abs(numbers[numbers.size() - 1 - c]));
  ConeProblem problem = make_problem(H, Eigen::VectorXd::Ones(coordinates), v, friction);
  for (std::size_t c = 0; c < friction.size(); ++c) problem.q[3 * c] += 0.1;
  std::vector<double> r(problem.q.size());
  const ConeReport report = solve_contacts(problem, {.seconds = 5.0}, &r);
  RC_ASSERT(report.is_solved);
  RC_ASSERT(std::abs(error_of_contacts(problem, r) - report.error) < 1e-14);
  expect_laws(problem, r, 1e-9);
}

/// The error has no units: forces in other units are other numbers with the same error.
TEST(ConeSolver, UnitsChangeNumbersAlone) {
  const std::vector<double> numbers = normal_numbers(9 * 30 + 30, 8);
  const Eigen::MatrixXd H = Eigen::Map<const Eigen::MatrixXd>(numbers.data(), 30, 9);
  const Eigen::VectorXd v = Eigen::Map<const Eigen::VectorXd>(numbers.data() + H.size(), 30);
  const ConeProblem one = make_problem(H, Eigen::VectorXd::Ones(30), v, {0.3, 0.4, 0.5});
  const ConeProblem other = make_problem(H, Eigen::VectorXd::Constant(30, 1e9), 1e-7 * v, {0.3, 0.4, 0.5});
  std::vector<double> r(9), s(9);
  EXPECT_TRUE(solve_contacts(one, {}, &r).is_solved);
  EXPECT_TRUE(solve_contacts(other, {}, &s).is_solved);
  EXPECT_GT(norm(load(r.data(), 0)) + norm(load(r.data(), 1)) + norm(load(r.data(), 2)), 0.05);
  for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(1e-2 * s[k], r[k], 1e-10);
  const ConeReport again = solve_contacts(other, {}, &s);  // a solution is a guess that is good enough
  EXPECT_TRUE(again.is_solved);
  EXPECT_EQ(again.sweeps, 0);
}

/// Where W leaves forces nearly free, they have far to go; the anchors then run ahead.
TEST(ConeSolver, ForcesThatAreNearlyFreeAreFound) {
  constexpr int contacts = 40, coordinates = 120, stiff = 20;
  const std::vector<double> numbers = normal_numbers(3 * contacts * coordinates + coordinates, 10);
  Eigen::MatrixXd H = Eigen::Map<const Eigen::MatrixXd>(numbers.data(), coordinates, 3 * contacts);
  const Eigen::VectorXd v = Eigen::Map<const Eigen::VectorXd>(numbers.data() + H.size(), coordinates);
  H.bottomRows(coordinates - stiff) *= 1e-3;
  const ConeProblem problem =
      make_problem(H, Eigen::VectorXd::Ones(coordinates), v, std::vector<double>(contacts, 0.3));
  std::vector<double> r(3 * contacts);
  const ConeReport report = solve_contacts(problem, {.most_sweeps = 20}, &r);
  EXPECT_TRUE(report.is_solved);
  EXPECT_LE(report.factorizations, 700);  // five times as many where they do not
  expect_laws(problem, r, 1e-9);
}

TEST(ConeSolver, LimitsEndTheSearchWithTheBestForces) {
  const std::vector<double> numbers = normal_numbers(90 * 60 + 60, 9);
  const Eigen::MatrixXd H = Eigen::Map<const Eigen::MatrixXd>(numbers.data(), 60, 90);
  const Eigen::VectorXd v = Eigen::Map<const Eigen::VectorXd>(numbers.data() + H.size(), 60);
  const ConeProblem problem = make_problem(H, Eigen::VectorXd::Ones(60), v, std::vector<double>(30, 0.4));
  std::vector<double> r(90);
  const ConeReport some = solve_contacts(problem, {.most_sweeps = 10, .most_factorizations = 0}, &r);
  EXPECT_FALSE(some.is_solved);
  EXPECT_EQ(some.sweeps, 10);
  EXPECT_EQ(some.factorizations, 0);
  EXPECT_NEAR(some.error, error_of_contacts(problem, r), 1e-14);
  EXPECT_LT(some.error, 0.3);
  // It goes on from there.
  const ConeReport rest = solve_contacts(problem, {.most_sweeps = 0}, &r);
  EXPECT_TRUE(rest.is_solved);
  EXPECT_GT(rest.factorizations, 0);
  EXPECT_LE(rest.factorizations, 5);  // Newton's method converges quadratically
  std::vector<double> none;
  EXPECT_TRUE(solve_contacts(ConeProblem{}, {}, &none).is_solved);
}

}  // namespace
}  // namespace tanor::detail
