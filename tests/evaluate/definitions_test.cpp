/// The second definition of every constraint is compared with known values, and with the families on random systems.

#include "evaluate/definitions.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "evaluate/constraints.hpp"
#include "random_systems.hpp"

namespace tanor {
using namespace detail;
namespace {

struct Found {
  std::vector<double> xi, rate, second;
};

Found taylor(const System& system, double t, const std::vector<double>& v, const std::vector<double>& w,
             int threads = 1) {
  const Definitions definitions(system, 0.0);
  const std::size_t d = definitions.num_rows();
  Found found{std::vector<double>(d), std::vector<double>(d), std::vector<double>(d)};
  definitions.taylor(Parallel(threads), t, system.positions, v, w, found.xi, found.rate, found.second);
  return found;
}

System make_system(std::vector<double> positions, Constraint constraint) {
  System system;
  system.positions = std::move(positions);
  system.masses.assign(system.positions.size() / 3, 1.0);
  system.constraints = {std::move(constraint)};
  return system;
}

/// The rod has length 5 along (0.6, 0.8, 0). Its rate is 3*0.6 = 1.8 less the 2 of the wanted length, and phi = (9 -
/// 1.8^2)/5 + unit.w - 6.
TEST(Definitions, RodWithSides3And4HasItsNumbersByHand) {
  const System system =
      make_system({1, 1, 1, 4, 5, 1}, Rods{"", {{0, 1}}, ScalarFunction::formula("2 + 2*t + 3*t^2"), {}});

  const Found found = taylor(system, 0.0, {0, 0, 0, 3, 0, 0}, {1, 0, 0, 0, 2, 0});

  EXPECT_DOUBLE_EQ(found.xi[0], 3.0);
  EXPECT_NEAR(found.rate[0], 1.8 - 2.0, 1e-15);
  EXPECT_NEAR(found.second[0], (9.0 - 1.8 * 1.8) / 5.0 + (-0.6 + 1.6) - 6.0, 1e-14);
}

/// The point is at (0, 2, 3) beside a circle of radius 2 about z. Its height is 3 and its distance is right. At 4 m/s
/// its acceleration towards the axis is 4^2/2.
TEST(Definitions, CircleHasHeightAndDistanceFromItsAxis) {
  const System system = make_system({0, 2, 3}, Circles{"", {0}, Vector3{}, Vector3{0, 0, 7}, 2.0});

  const Found found = taylor(system, 0.0, {4, 0, 5}, {0, 1, 2});

  EXPECT_EQ(found.xi, (std::vector<double>{3.0, 0.0}));
  EXPECT_EQ(found.rate, (std::vector<double>{5.0, 0.0}));
  EXPECT_EQ(found.second, (std::vector<double>{2.0, 8.0 + 1.0}));
}

/// The right angle is at the origin, so that cos = 0. The gradient at the end of an arm of length 2 is 1/2 along the
/// other arm.
TEST(Definitions, RightAngleReactsAcrossItsArms) {
  const System system = make_system({2, 0, 0, 0, 0, 0, 0, 4, 0}, Angles{"", {{0, 1, 2}}, 0.0});
  std::vector<double> eta(9);

  Definitions(system, 0.0).reactions(0.0, system.positions, std::vector<double>{8.0}, eta);

  EXPECT_EQ(eta, (std::vector<double>{0, 4, 0, -2, -4, 0, 2, 0, 0}));
}

/// "initial" parameters are those of the start, so that nothing is violated there, whatever moves.
TEST(Definitions, InitialParametersHoldAtTheStart) {
  System system = make_system({1, 2, 3, 4, -1, 0.5}, Rods{"", {{0, 1}}, {}, {{0.5, 0, 0}}});
  const VectorFunction moving(ScalarFunction::formula("1 + t"), 1.0, ScalarFunction::formula("2*t"));
  system.constraints.push_back(Planes{"", {0, 1}, moving, {}});
  system.constraints.push_back(Spheres{"", {0, 1}, moving, {}});
  system.constraints.push_back(Circles{"", {1}, Vector3{1, 0, 0}, moving, {}});
  system.constraints.push_back(Pulleys{"", {{0, 1}}, {0, 0, 9}, {1, 1, 9}, {}, 2.0});
  system.constraints.push_back(Linears{"", {{0, 1}}, {{1, 2, 3}, {4, 5, 6}}, {}});
  constexpr double t0 = 0.25;
  const Definitions definitions(system, t0);
  const std::vector<double> zero(6, 0.0);
  std::vector<double> xi(definitions.num_rows(), NAN), rate(xi), second(xi);

  definitions.taylor(Parallel(1), t0, system.positions, zero, zero, xi, rate, second);

  ASSERT_EQ(xi.size(), 9u);
  for (std::size_t a = 0; a < xi.size(); ++a) EXPECT_EQ(xi[a], a == 5 ? xi[5] : 0.0) << a;
  EXPECT_NE(xi[5], 0.0) << "the height over the circle's plane is no parameter";
}

/// Both definitions agree on all kinds at once, in values, rates, K'w + phi, K lambda and K'w.
RC_GTEST_PROP(DefinitionsProperty, AgreeWithTheFamiliesOnRandomSystems, ()) {
  RandomSystem random = any_system({.forces = false});
  System& system = random.system;
  if (system.num_points() > 1) {
    system.constraints.push_back(UserConstraints{"", {{0, 1}, {1, 0}}, formula_constraint("x1*y2 - t^2*z2*x1^3", 2)});
  }
  const Numbering numbering = number(system);
  Constraints families(system, numbering);
  families.set_time(random.t);
  families.choose_frames();
  const Definitions definitions(system, 0.0);
  const std::size_t d = families.num_rows(), size = system.positions.size();
  RC_ASSERT(definitions.num_rows() == d);
  const auto inner = [&](const std::vector<double>& user) {
    std::vector<double> result(user.size());
    numbering.gather_points(user, result);
    return result;
  };
  const auto user_rows = [&](const std::vector<double>& rows) {
    std::vector<double> result(d);
    numbering.scatter_rows(rows, result);
    return result;
  };
  const auto largest = [](const std::vector<double>& a) {
    double result = 1.0;
    for (const double x : a) result = std::max(result, std::abs(x));
    return result;
  };
  // Lengths are at least 0.3, since derivatives grow with the curvature that phi contains.
  const auto expect_close = [&](const std::vector<double>& a, const std::vector<double>& b, double scale) {
    RC_ASSERT(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) RC_ASSERT(std::abs(a[i] - b[i]) <= 1e-13 * scale);
  };
  std::vector<double> w(size), lambda(d);
  for (std::size_t i = 0; i < size; ++i) w[i] = std::cos(3.0 * static_cast<double>(i));
  for (std::size_t a = 0; a < d; ++a) lambda[a] = std::sin(1.0 + 2.0 * static_cast<double>(a));

  Found found{std::vector<double>(d), std::vector<double>(d), std::vector<double>(d)};
  std::vector<double> y(d), eta(size);
  definitions.taylor(Parallel(1), random.t, random.positions, random.velocities, w, found.xi, found.rate, found.second);
  definitions.transposed(Parallel(1), random.t, random.positions, w, y);
  definitions.reactions(random.t, random.positions, lambda, eta);

  const Parallel serial(1);
  const std::vector<double> r = inner(random.positions), v = inner(random.velocities), x = inner(w);
  std::vector<double> xi(d), rate(d), second(d), product(d), blocks(3 * families.num_blocks()), expected_eta(size);
  families.evaluate_values(serial, r.data(), xi.data());
  families.evaluate_rates(serial, r.data(), v.data(), rate.data());
  families.evaluate_right_side(serial, r.data(), v.data(), x.data(), second.data(), blocks.data());
  families.apply_transposed(serial, blocks.data(), x.data(), nullptr, product.data());
  for (const Incidence& incidence : families.list_incidences()) {
    const auto row = static_cast<std::size_t>(numbering.user_row[static_cast<std::size_t>(incidence.row)]);
    const Index point = numbering.user_point[static_cast<std::size_t>(incidence.point)];
    store(expected_eta.data(), point,
          load(expected_eta.data(), point) + incidence.sign * lambda[row] * load(blocks.data(), incidence.block));
  }
  const double scale = largest(random.positions) * largest(random.velocities);
  expect_close(found.xi, user_rows(xi), largest(random.positions));
  expect_close(found.rate, user_rows(rate), 10.0 * scale);
  expect_close(found.second, user_rows(second), 100.0 * scale * largest(found.second));
  expect_close(y, user_rows(product), 10.0 * largest(y));
  expect_close(eta, expected_eta, 10.0 * largest(eta));
}

TEST(Definitions, TwoThreadsGiveTheSameBits) {
  constexpr Index n = 9000;
  Rods rods{"", {}, {}, {}};
  UserConstraints user{"", {}, formula_constraint("sin(x1*t) - exp(y2)", 2)};
  std::vector<double> positions;
  for (Index i = 0; i < n; ++i) {
    positions.insert(positions.end(), {0.1 * i, std::sin(i), std::cos(0.3 * i)});
    if (i > 0) rods.pairs.push_back({i - 1, i});
    if (i > 0) user.tuples.push_back({i, i - 1});
  }
  System system = make_system(positions, rods);
  system.constraints.push_back(user);

  const Found one = taylor(system, 0.3, positions, positions, 1), two = taylor(system, 0.3, positions, positions, 2);

  EXPECT_EQ(one.xi, two.xi);
  EXPECT_EQ(one.rate, two.rate);
  EXPECT_EQ(one.second, two.second);
}

}  // namespace
}  // namespace tanor
