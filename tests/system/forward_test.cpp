/// Forward derivatives are compared with jets: the partial in x of f(x, y) is the rate of f along x. Second derivatives
/// are compared with the curvature along three lines.

#include <tanor/forward.hpp>

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

namespace tanor {
namespace {

using Two = Forward<2>;

/// A function over both scalar types, at a place where it is smooth.
struct Case {
  const char* name;
  std::function<Two(Two, Two)> forward;
  std::function<Jet<1>(Jet<1>, Jet<1>)> jet;
  std::function<Curved<2>(Curved<2>, Curved<2>)> curved;
  std::function<Jet<2>(Jet<2>, Jet<2>)> second_jet;
};

#define TANOR_CASE(name, expression)                                                            \
  Case {                                                                                        \
    name, [](auto x, auto y) { return expression; }, [](auto x, auto y) { return expression; }, \
        [](auto x, auto y) { return expression; }, [](auto x, auto y) { return expression; }    \
  }

const Case cases[] = {
    TANOR_CASE("sum", 2.0 + x + y * 3.0),
    TANOR_CASE("difference", 1.0 - x - (y - 2.0)),
    TANOR_CASE("negative", -x + +y),
    TANOR_CASE("product", x* y * 2.0),
    TANOR_CASE("quotient", x / y / 3.0 + 1.0 / x),
    TANOR_CASE("sqrt", sqrt(x + y * y)),
    TANOR_CASE("exp", exp(x* y)),
    TANOR_CASE("log", log(x / y)),
    TANOR_CASE("sin", sin(x - y)),
    TANOR_CASE("cos", cos(x* y)),
    TANOR_CASE("tan", tan(0.3 * x + y)),
    TANOR_CASE("asin", asin(0.3 * x * y)),
    TANOR_CASE("acos", acos(0.3 * x - 0.2 * y)),
    TANOR_CASE("atan", atan(x* y)),
    TANOR_CASE("atan2", atan2(x, -y) + atan2(y, 2.0) + atan2(-1.0, x)),
    TANOR_CASE("sinh", sinh(x - y)),
    TANOR_CASE("cosh", cosh(x* y)),
    TANOR_CASE("tanh", tanh(x + y)),
    TANOR_CASE("abs", abs(x - 2.0) * abs(y)),
    TANOR_CASE("min", min(x, y) + min(x, 0.5) + min(5.0, y)),
    TANOR_CASE("max", max(x, y) * max(x, 0.5) * max(0.1, y)),
    TANOR_CASE("integer power", pow(x, 3.0) - pow(y, -2.0)),
    TANOR_CASE("real power", pow(x, 1.7) * y),
    TANOR_CASE("power", pow(x, y) + pow(2.0, y)),
};

TEST(Forward, PartialDerivativesAreThoseOfAJetInEachVariable) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> number(0.4, 1.4);
  for (const Case& c : cases) {
    for (int look = 0; look < 50; ++look) {
      const double x = number(generator), y = number(generator);

      const Two f = c.forward(Two::variable(x, 0), Two::variable(y, 1));

      const Jet<1> along_x = c.jet(Jet<1>::variable(x), y), along_y = c.jet(x, Jet<1>::variable(y));
      const double scale = std::max({1.0, std::abs(along_x.c[1]), std::abs(along_y.c[1])});
      EXPECT_NEAR(f.value(), along_x.value(), 1e-15 * std::max(1.0, std::abs(f.value()))) << c.name;
      EXPECT_NEAR(f.d[0], along_x.c[1], 2e-14 * scale) << c.name << " at " << x << ", " << y;
      EXPECT_NEAR(f.d[1], along_y.c[1], 2e-14 * scale) << c.name << " at " << x << ", " << y;
    }
  }
}

TEST(Forward, SecondDerivativesAreTheCurvaturesAlongLines) {
  std::mt19937 generator(2);
  std::uniform_real_distribution<double> number(0.4, 1.4);
  for (const Case& c : cases) {
    for (int look = 0; look < 50; ++look) {
      const double x = number(generator), y = number(generator);

      const Curved<2> f = c.curved(Curved<2>::variable(x, 0), Curved<2>::variable(y, 1));

      for (const auto& [a, b] : {std::pair{1.0, 0.0}, std::pair{0.0, 1.0}, std::pair{0.6, -0.8}}) {
        const Jet<2> along = c.second_jet(Jet<2>::variable(x, a), Jet<2>::variable(y, b));
        const double curvature = a * a * f.second(0, 0) + 2.0 * a * b * f.second(0, 1) + b * b * f.second(1, 1);
        EXPECT_NEAR(f.value(), along.value(), 1e-15 * std::max(1.0, std::abs(f.value()))) << c.name;
        EXPECT_NEAR(curvature, along.derivative(2), 1e-12 * std::max(1.0, std::abs(along.derivative(2)))) << c.name;
      }
    }
  }
}

/// A variable that does not take part keeps the partial 0 where a slope is infinite.
TEST(Forward, WhatDoesNotTakePartStaysOutWhereTheSlopeIsInfinite) {
  const Two x = Two::variable(0.0, 0), one = Two::variable(1.0, 0), none(0.0);
  for (const Two& f : {sqrt(x), pow(x, 0.5), log(x), asin(one), acos(one)}) {
    EXPECT_TRUE(std::isinf(f.d[0]));
    EXPECT_EQ(f.d[1], 0.0);
  }
  for (const Two& f : {sqrt(none), pow(none, 0.5), atan2(none, none), pow(none, Two(0.0))}) {
    EXPECT_EQ(f.d, (std::array<double, 2>{0.0, 0.0}));
  }
}

TEST(Forward, PowersOfZeroAndOfNegativeNumbersHaveTheirDerivatives) {
  EXPECT_EQ(pow(Two::variable(0.0, 0), 2.0).d[0], 0.0);
  EXPECT_EQ(pow(Two::variable(0.0, 0), 1.0).d[0], 1.0);
  EXPECT_EQ(pow(Two::variable(0.0, 0), 1.5).d[0], 0.0);
  EXPECT_EQ(pow(Two::variable(-2.0, 0), 3.0).d[0], 12.0);
  EXPECT_EQ(pow(Two::variable(-2.0, 0), Two(3.0)).d[0], 12.0);
}

TEST(Forward, AngleOfAFarPlaceDoesNotOverflow) {
  const Two angle = atan2(Two::variable(1e200, 0), Two::variable(1e200, 1));

  EXPECT_NEAR(angle.d[0], 0.5e-200, 1e-215);
  EXPECT_NEAR(angle.d[1], -0.5e-200, 1e-215);
}

TEST(Forward, ComparisonsLookAtTheValueAlone) {
  EXPECT_TRUE(Two::variable(1.0, 0) == Two::variable(1.0, 1));
  EXPECT_TRUE(Two::variable(1.0, 0) < 2.0);
  EXPECT_EQ(abs(Two::variable(-3.0, 1)).d[1], -1.0);
  EXPECT_EQ(min(Two::variable(1.0, 0), Two::variable(1.0, 1)).d[0], 1.0) << "the first where both are equal";
  EXPECT_EQ(max(Two::variable(1.0, 0), Two::variable(1.0, 1)).d[0], 1.0);
}

}  // namespace
}  // namespace tanor
