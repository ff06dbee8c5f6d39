/// The tests compare ln det S and its gradient with closed forms and differences.

#include <gtest/gtest.h>
#include <tanor/user_kernel.hpp>

#include <limits>
#include <random>

#include "host/velocity_verlet.hpp"

namespace tanor::host {
namespace {

/// Two rods meet at an angle, so that det S = (1/m0 + 1/m1)(1/m1 + 1/m2) - (cos/m1)^2.
TEST(LogDet, IsFixmansFormulaForATrimer) {
  const double cosine = std::cos(1.1), sine = std::sin(1.1);
  const std::vector<double> masses{1.0, 2.0, 5.0}, r{1.3, 0, 0, 0, 0, 0, 0.7 * cosine, 0.7 * sine, 0};
  Constrainer constrainer(masses, {Rods{"rods", {{0, 1}, {2, 1}}, {}, {}}}, r);

  const LogDeterminant found = constrainer.log_det(r);

  ASSERT_TRUE(found.outcome.ok());
  EXPECT_NEAR(found.value, std::log((1.0 + 0.5) * (0.5 + 0.2) - 0.25 * cosine * cosine), 1e-14);
}

/// A net of rings with a support and a shared tail.
struct Net {
  std::vector<double> masses{1.0, 2.0, 0.5, 1.5, infinity, 3.0, 0.7};
  std::vector<double> r{0,   0.1, 0.2, 1,   0.5, -0.1, 2,    0,   0.3, 1.2, -0.7,
                        0.1, 0.2, 1.4, 0.9, 2.8, 0.6,  -0.4, 3.1, 1.5, 0.2};
  Rods rods{"rods", {{0, 1}, {1, 2}, {2, 3}, {0, 3}, {1, 4}, {2, 5}, {5, 6}, {6, 2}, {1, 3}}, {}, {}};
};

/// Compares the gradient at r with central differences.
void expect_gradient_of_differences(Constrainer* constrainer, const std::vector<double>& r, double time = 0.0) {
  std::vector<double> gradient(r.size());
  ASSERT_TRUE(constrainer->log_det(r, gradient, time).outcome.ok());
  const double e = 1e-5;
  for (std::size_t k = 0; k < r.size(); ++k) {
    std::vector<double> moved = r;
    moved[k] += e;
    const double above = constrainer->log_det(moved, {}, time).value;
    moved[k] -= 2.0 * e;
    const double below = constrainer->log_det(moved, {}, time).value;
    EXPECT_NEAR(gradient[k], (above - below) / (2.0 * e), 1e-8 * (1.0 + std::abs(gradient[k]))) << k;
  }
}

TEST(LogDet, HasTheGradientThatDifferencesHave) {
  const Net net;
  Constrainer constrainer(net.masses, {net.rods}, net.r);
  expect_gradient_of_differences(&constrainer, net.r);
  std::vector<double> away = net.r;  // rods need not have their lengths
  for (std::size_t k = 0; k < away.size(); ++k) away[k] += 0.1 * std::sin(5.0 * static_cast<double>(k));
  expect_gradient_of_differences(&constrainer, away);
}

/// Draws a system of two islands in which every kind of constraint meets others, at moving points and at a support.
struct Mixture {
  std::vector<double> masses, r;
  std::vector<Constraint> constraints;

  explicit Mixture(unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const auto draw = [&] { return Vector3{normal(random), normal(random), normal(random)}; };
    for (std::size_t i = 0; i < 16; ++i) {
      masses.push_back(i == 3 ? infinity : 0.5 + std::abs(normal(random)));
      for (const double x : draw()) r.push_back(1.5 * x);
    }
    const auto twist = make_constraint_kernel<3>(
        [](const auto& x, const auto& t) { return x[0] * x[4] - x[1] * x[3] + 0.5 * x[8] * x[8] - (1.0 + 0.1 * t); });
    const VectorFunction drifting(ScalarFunction::formula("0.2*t"), ScalarFunction::formula("0.3*t*t"), 0.05);
    constraints = {Rods{"rods", {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {6, 7}, {7, 8}, {8, 9}}, {}, {}},
                   Rods{"shifted", {{0, 5}}, {}, {draw()}},
                   Angles{"angles", {{0, 1, 2}, {2, 3, 4}, {6, 7, 8}}, {}},
                   Planes{"planes", {5}, draw(), {}},
                   Spheres{"spheres", {6}, drifting, {}},
                   Lines{"lines", {10}, draw(), draw()},
                   Circles{"circles", {11}, draw(), draw(), {}},
                   Ellipsoids{"ellipsoids", {12}, draw(), {1.0, 2.0, 1.5}, {draw(), draw()}},
                   Helices{"helices", {13}, draw(), draw(), 1.2, 0.8, {}},
                   Pulleys{"pulleys", {{9, 12}}, draw(), draw(), {}, 1.7},
                   Linears{"linears", {{13, 14, 15}}, {draw(), draw(), draw()}, {}},
                   UserConstraints{"twists", {{10, 11, 14}, {3, 13, 15}}, twist},
                   Rods{"joints", {{9, 10}, {11, 12}, {12, 13}}, {}, {}}};
  }
};

TEST(LogDet, HasTheGradientOfAllKindsOfConstraint) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Mixture mixture(seed);
    Constrainer constrainer(mixture.masses, mixture.constraints, mixture.r);
    expect_gradient_of_differences(&constrainer, mixture.r);
    expect_gradient_of_differences(&constrainer, mixture.r, 0.7);
    if (testing::Test::HasFailure()) FAIL() << "seed " << seed;
  }
}

TEST(LogDet, IsSingularForDependentRowsAndNamesOne) {
  const double a = 0.629;
  const std::vector<double> r{0, 0, 0, a, a, a, a, -a, -a, -a, a, -a, -a, -a, a};
  Constrainer constrainer(std::vector{12.0, 1.0, 1.0, 1.0, 1.0}, {make_all_distances(5)}, r);

  const Outcome outcome = constrainer.log_det(r).outcome;

  EXPECT_EQ(outcome.status, Status::Singular);
  EXPECT_EQ(outcome.what.substr(0, 5), "rods[");
}

/// The gradient belongs to the rods where they are, whatever length they ought to have.
TEST(LogDet, TakesRodsAsLongAsTheyAre) {
  const std::vector<double> r{0, 0, 0, 1, 0, 0, 1.5, 0.5, 0};
  const std::vector<double> masses{1.0, 2.0, 3.0};
  std::vector<double> gradient(9), expected(9);
  Rods rods{"rods", {{0, 1}, {1, 2}}, {}, {}};
  Constrainer drawn(masses, {rods}, r);
  ASSERT_TRUE(drawn.log_det(r, expected).outcome.ok());
  EXPECT_GT(std::abs(expected[7]), 0.01);

  for (const double length : {std::numeric_limits<double>::denorm_min(), 1e8}) {
    rods.length = length;
    Constrainer other(masses, {rods}, r);
    ASSERT_TRUE(other.log_det(r, gradient).outcome.ok());
    for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(gradient[k], expected[k], 1e-15) << k;
  }
}

/// The function has a slope at the start, but no second derivative.
TEST(LogDet, HasNoGradientWhereSecondDerivativesAreNotFinite) {
  const std::vector<double> r{0, 0, 0, 1, 0, 0};
  const UserConstraints edge{"edge", {{0}}, make_constraint_kernel<1>([](const auto& x, const auto&) {
                               using std::sqrt;
                               return x[2] + x[0] * sqrt(x[0] * x[0] + x[1] * x[1]);
                             })};
  std::vector<double> gradient(6, 7.0);
  Constrainer constrainer(std::vector{1.0, 2.0}, {edge, Planes{"planes", {1}, Vector3{0, 0, 1}, 0.0}}, r);

  EXPECT_EQ(constrainer.log_det(r, gradient).outcome.status, Status::NotFinite);

  EXPECT_EQ(gradient, std::vector<double>(6, 7.0));
}

/// The image of a rod is another one, but the determinant is that of the molecule as a whole.
TEST(LogDet, HasTheSameGradientInACell) {
  const Net net;
  Constrainer open(net.masses, {net.rods}, net.r);
  std::vector<double> wrapped = net.r, expected(net.r.size()), gradient(net.r.size());
  const double edge = 6.5;
  for (double& x : wrapped) x -= edge * std::floor(x / edge);
  Constrainer closed(net.masses, {net.rods}, wrapped,
                     {.cell = {.edges = {Vector3{edge, 0, 0}, Vector3{0, edge, 0}, Vector3{0, 0, edge}}}});

  ASSERT_TRUE(open.log_det(net.r, expected).outcome.ok());
  ASSERT_TRUE(closed.log_det(wrapped, gradient).outcome.ok());

  EXPECT_NE(wrapped, net.r);
  for (std::size_t k = 0; k < gradient.size(); ++k) EXPECT_NEAR(gradient[k], expected[k], 1e-12) << k;
}

}  // namespace
}  // namespace tanor::host
