/// The tests compare lanes of formulas with single numbers, and check messages about a wrong text and what a formula
/// knows
/// about itself.

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/error.hpp>
#include <tanor/forward.hpp>
#include <tanor/kernel.hpp>

#include "errors.hpp"
#include "random_numbers.hpp"
#include "system/formula.hpp"

namespace tanor {
using namespace detail;
namespace {

const std::vector<std::string> variables = {"x1", "y1", "z1", "x2", "y2", "z2", "t"};

/// The formulas have each operation, also where branches lie: zeros, equal arguments, deep stacks.
const char* const formulas[] = {
    "x1",
    "t",
    "3",
    "-x1",
    "x1 + y2 - t",
    "x1*y1*z1*x2",
    "x1/(2 + y1)/t",
    "sqrt(x1^2 + 1)",
    "sqrt(x1*x1*0)",
    "sqrt(abs(x1))",
    "exp(x1*t)",
    "log(3 + x1)",
    "sin(x1 + t)",
    "cos(y1*z2)",
    "tan(x1/4)",
    "asin(x1/3)",
    "acos(y1/3)",
    "atan(x1*y1)",
    "atan2(y1, x1 + 3)",
    "sinh(x1)",
    "cosh(y2)",
    "tanh(z2)",
    "abs(x1 - y1)",
    "min(x1, y1, 0)",
    "max(x1, y1)",
    "max(x1, x1*1)",
    "x1^2",
    "x1^3",
    "(x1 + 3)^-2",
    "(x1 + 3)^2.5",
    "(x1 + 3)^y1",
    "2^x2",
    "x1^0",
    "x1+(y1+(z1+(x2+(y2+(z2+(t+(x1*(y1+(z1*(x2+y2))))))))))",
};

bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0 || (std::isnan(a) && std::isnan(b)) || (a == 0.0 && b == 0.0);
}

TEST(FormulaConstraint, EachMemberHasTheBitsOfAFormulaOnOneJetAndOneForward) {
  constexpr std::size_t count = 77;  // two groups of lanes and a part of one
  constexpr double t = 0.7;
  std::vector<double> r = uniform_numbers(6 * count, 1);
  const std::vector<double> v = uniform_numbers(6 * count, 2);
  for (std::size_t i = 0; i < 12; ++i) r[i] = 0.0;
  for (const char* text : formulas) {
    const Formula formula(text, variables);
    const ConstraintKernel kernel = formula_constraint(text, 2);
    std::vector<double> xi(count), rate(count), phi(count), gradient(6 * count), xi_alone(count);

    kernel.evaluate(kernel.context.get(),
                    {count, t, r.data(), v.data(), xi.data(), rate.data(), phi.data(), gradient.data()});
    kernel.evaluate(kernel.context.get(), {count, t, r.data(), nullptr, xi_alone.data(), nullptr, nullptr, nullptr});

    for (std::size_t k = 0; k < count; ++k) {
      std::vector<Jet<2>> jets;
      std::vector<Forward<6>> forwards;
      for (std::size_t i = 0; i < 6; ++i) {
        jets.push_back(Jet<2>::variable(r[6 * k + i], v[6 * k + i]));
        forwards.push_back(Forward<6>::variable(r[6 * k + i], static_cast<int>(i)));
      }
      jets.push_back(Jet<2>::variable(t));
      forwards.emplace_back(t);
      const Jet<2> jet = formula.evaluate(std::span<const Jet<2>>(jets));
      const Forward<6> forward = formula.evaluate(std::span<const Forward<6>>(forwards));
      EXPECT_TRUE(same_bits(xi[k], jet.value())) << text;
      EXPECT_TRUE(same_bits(xi_alone[k], jet.value())) << text;
      EXPECT_TRUE(same_bits(rate[k], jet.derivative(1))) << text << ": " << rate[k] << ", " << jet.derivative(1);
      EXPECT_TRUE(same_bits(phi[k], jet.derivative(2))) << text << ": " << phi[k] << ", " << jet.derivative(2);
      for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_TRUE(same_bits(gradient[6 * k + i], forward.d[i])) << text << ", partial " << i;
      }
    }
  }
}

TEST(FormulaConstraint, KnowsWhetherTimeTakesPart) {
  EXPECT_TRUE(formula_constraint("x1 - t", 1).depends_on_time);
  EXPECT_FALSE(formula_constraint("x1 - y1", 1).depends_on_time);
}

TEST(FormulaConstraint, ErrorsGiveTheColumn) {
  EXPECT_EQ(error_of([] { formula_constraint("x1 + (y1", 1); }),
            "formula \"x1 + (y1\": column 9: found the end, expected an operator or ')'");
  EXPECT_TRUE(error_of([] { formula_constraint("x1 + x3", 2); }).starts_with("formula \"x1 + x3\": column 6: 'x3'"));
  EXPECT_EQ(error_of([] { formula_constraint("x1", 0); }), "a formula on 0 points; 1 to 256 are right");
  EXPECT_EQ(error_of([] { formula_constraint("x1", 257); }), "a formula on 257 points; 1 to 256 are right");
}

// ---- coordinates ---------------------------------------------------------------------------------------------------

TEST(FormulaCoordinates, GivePositionsVelocitiesAndCurvatureOfATurningRing) {
  // The ring is r = ((2 + cos b) cos(a + 3t), (2 + cos b) sin(a + 3t), sin b), and a second point is on the axis, a t
  // high.
  const std::vector<std::string> names = {"a", "b"};
  const std::vector<std::string> components = {
      "(R + cos(b))*cos(a + 3*t)", "(R + cos(b))*sin(a + 3*t)", "sin(b)", "0", "0", "a*t"};
  const CoordinateKernel kernel = formula_coordinates(names, components, {{"R", 2.0}});
  constexpr std::size_t count = 40;
  const std::vector<double> q = uniform_numbers(2 * count, 3), q_dot = uniform_numbers(2 * count, 4);
  std::vector<double> r(6 * count), v(6 * count), psi(6 * count), tangents(12 * count);
  constexpr double t = 0.4;

  kernel.evaluate(kernel.context.get(),
                  {count, t, q.data(), q_dot.data(), r.data(), v.data(), psi.data(), tangents.data()});

  EXPECT_EQ(kernel.num_points, 2);
  EXPECT_EQ(kernel.num_coordinates, 2);
  EXPECT_TRUE(kernel.depends_on_time);
  for (std::size_t k = 0; k < count; ++k) {
    const double a = q[2 * k], b = q[2 * k + 1], a1 = q_dot[2 * k], b1 = q_dot[2 * k + 1];
    const double angle = a + 3.0 * t, turn = a1 + 3.0, rho = 2.0 + std::cos(b), rho1 = -std::sin(b) * b1,
                 rho2 = -std::cos(b) * b1 * b1;
    const double c = std::cos(angle), s = std::sin(angle);
    const double expected_r[] = {rho * c, rho * s, std::sin(b), 0, 0, a * t};
    const double expected_v[] = {
        rho1 * c - rho * s * turn, rho1 * s + rho * c * turn, std::cos(b) * b1, 0, 0, a1 * t + a};
    const double expected_psi[] = {rho2 * c - 2 * rho1 * s * turn - rho * c * turn * turn,
                                   rho2 * s + 2 * rho1 * c * turn - rho * s * turn * turn,
                                   -std::sin(b) * b1 * b1,
                                   0,
                                   0,
                                   2 * a1};
    const double expected_tangents[] = {-rho * s,         rho * c,          0,           0, 0, t,
                                        -std::sin(b) * c, -std::sin(b) * s, std::cos(b), 0, 0, 0};
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_NEAR(r[6 * k + i], expected_r[i], 1e-15 * 4);
      EXPECT_NEAR(v[6 * k + i], expected_v[i], 1e-15 * 20);
      EXPECT_NEAR(psi[6 * k + i], expected_psi[i], 1e-15 * 100);
    }
    for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(tangents[12 * k + i], expected_tangents[i], 1e-15 * 4);
  }
}

TEST(FormulaCoordinates, ErrorsNameTheComponentAndTheCoordinate) {
  const auto make = [](std::vector<std::string> names, std::vector<std::string> components) {
    return error_of([&] { formula_coordinates(names, components, {{"R", 2.0}}); });
  };

  EXPECT_EQ(make({"a"}, {"a", "2*", "0"}),
            "/1: formula \"2*\": column 3: found the end, expected a number, a name or '('");
  EXPECT_EQ(make({"a"}, {"a", "0"}), "2 components; three for each point are right");
  EXPECT_EQ(make({}, {"0", "0", "0"}), "there are no coordinates; a map has at least one");
  EXPECT_EQ(make({"a", "a"}, {"a", "0", "0"}), "the coordinate 'a' has the name of another coordinate");
  EXPECT_EQ(make({"t"}, {"t", "0", "0"}), "the coordinate 't' has the name of time");
  EXPECT_EQ(make({"R"}, {"R", "0", "0"}), "the coordinate 'R' has the name of a constant");
  for (const char* name : {"sin", "pi", "", "2a", "a b", "-a", "1"}) {
    EXPECT_EQ(make({name}, {"1", "0", "0"}), "the coordinate '" + std::string(name) +
                                                 "' has no name of letters, digits and '_' that is neither a function "
                                                 "nor pi");
  }
}

// ---- forces --------------------------------------------------------------------------------------------------------

TEST(FormulaForce, ErrorsNameTheComponent) {
  EXPECT_TRUE(error_of([] { formula_force({"x", "0", "q"}); }).starts_with("/z: formula \"q\": column 1: 'q' is not"));
  EXPECT_TRUE(error_of([] { formula_force({"", "0", "0"}); }).starts_with("/x: formula \"\": column 1: found the end"));
}

}  // namespace
}  // namespace tanor
