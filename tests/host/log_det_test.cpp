/// The tests compare ln det S and its gradient with closed forms and differences.

#include <gtest/gtest.h>

#include <limits>

#include "errors.hpp"
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

TEST(LogDet, HasTheGradientThatDifferencesHave) {
  const Net net;
  Constrainer constrainer(net.masses, {net.rods}, net.r);
  std::vector<double> gradient(net.r.size());
  ASSERT_TRUE(constrainer.log_det(net.r, gradient).outcome.ok());

  const double e = 1e-5;
  for (std::size_t k = 0; k < net.r.size(); ++k) {
    std::vector<double> r = net.r;
    r[k] += e;
    const double above = constrainer.log_det(r).value;
    r[k] -= 2.0 * e;
    const double below = constrainer.log_det(r).value;
    EXPECT_NEAR(gradient[k], (above - below) / (2.0 * e), 1e-8) << k;
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

// The gradient has the term 2/length.
TEST(LogDet, HasNoGradientForARodOfNearlyNoLength) {
  const std::vector<double> r{0, 0, 0, 1, 0, 0};
  const double least = std::numeric_limits<double>::denorm_min();
  std::vector<double> gradient(6, 7.0);
  Constrainer constrainer(std::vector{1.0, 2.0}, {Rods{"rods", {{0, 1}}, std::vector{least}, {}}}, r);

  EXPECT_EQ(constrainer.log_det(r, gradient).outcome.status, Status::NotFinite);

  EXPECT_EQ(gradient, std::vector<double>(6, 7.0));
}

TEST(LogDet, KnowsTheGradientOfRodsAlone) {
  const std::vector<double> r{0, 0, 0, 1, 0, 0};
  std::vector<double> gradient(6);
  Constrainer constrainer(std::vector{1.0, 2.0}, {Planes{"planes", {0}, Vector3{0, 0, 1}, 0.0}}, r);
  EXPECT_NEAR(constrainer.log_det(r).value, 0.0, 1e-15);
  EXPECT_EQ(error_of([&] { (void)constrainer.log_det(r, gradient); }),
            "the gradient of log_det is known for rods alone; there are other constraints");
}

}  // namespace
}  // namespace tanor::host
