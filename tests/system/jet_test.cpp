#include <tanor/jet.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <type_traits>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace tanor {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Runs a check for jets of several orders.
template <class Check>
void for_each_order(const Check& check) {
  check(std::integral_constant<int, 0>());
  check(std::integral_constant<int, 1>());
  check(std::integral_constant<int, 2>());
  check(std::integral_constant<int, 5>());
  check(std::integral_constant<int, 12>());
}

/// Expects c[k] = expected(k), relative to the largest of both.
template <int P>
void expect_coefficients(const Jet<P>& a, const std::function<double(int)>& expected,
                         double tolerance = 100 * epsilon) {
  for (int k = 0; k <= P; ++k)
    EXPECT_NEAR(a.c[k], expected(k), tolerance * (1.0 + std::abs(expected(k)))) << "k = " << k;
}

template <int P>
void expect_equal(const Jet<P>& a, const Jet<P>& b, double tolerance = 1000 * epsilon) {
  expect_coefficients<P>(
      a, [&](int k) { return b.c[k]; }, tolerance);
}

template <int P>
bool is_near(const Jet<P>& a, const Jet<P>& b, double tolerance) {
  for (int k = 0; k <= P; ++k) {
    if (!(std::abs(a.c[k] - b.c[k]) <= tolerance * (1.0 + std::abs(b.c[k])))) return false;
  }
  return true;
}

double factorial(int k) {
  return std::tgamma(k + 1.0);
}

/// Returns p (p - 1) … (p - k + 1)/k!.
double binomial(double p, int k) {
  double result = 1.0;
  for (int j = 0; j < k; ++j) result *= (p - j) / (j + 1);
  return result;
}

/// Returns a random number of three decimals in [low, high].
double draw(double low, double high) {
  return *rc::gen::inRange(static_cast<int>(1000 * low), static_cast<int>(1000 * high) + 1) / 1000.0;
}

template <int P>
Jet<P> draw_jet(double low, double high) {
  Jet<P> a(draw(low, high));
  for (int k = 1; k <= P; ++k) a.c[k] = draw(-1.0, 1.0);
  return a;
}

TEST(Jet, IsAConstantOrAVariable) {
  const Jet<3> constant = 2.5, variable = Jet<3>::variable(2.5, -4.0);

  EXPECT_TRUE(constant.is_constant());
  EXPECT_FALSE(variable.is_constant());
  expect_coefficients(constant, [](int k) { return k == 0 ? 2.5 : 0.0; });
  expect_coefficients(variable, [](int k) { return k == 0 ? 2.5 : k == 1 ? -4.0 : 0.0; });
}

TEST(Jet, DerivativesAreCoefficientsTimesFactorials) {
  Jet<4> a;
  a.c = {1.0, 2.0, 3.0, 4.0, 5.0};

  EXPECT_EQ(a.value(), 1.0);
  EXPECT_EQ(a.derivative(0), 1.0);
  EXPECT_EQ(a.derivative(1), 2.0);
  EXPECT_EQ(a.derivative(2), 6.0);
  EXPECT_EQ(a.derivative(3), 24.0);
  EXPECT_EQ(a.derivative(4), 120.0);
}

TEST(Jet, ArithmeticIsExactOnPolynomials) {
  constexpr auto t = Jet<4>::variable(2.0);

  // By hand (t^2 - 1)/(t - 1) = t + 1, and the product rule gives (2 + e)^3 = 8 + 12 e + 6 e^2 + e^3.
  constexpr auto quotient = (t * t - 1.0) / (t - 1.0);
  constexpr auto cube = t * t * t;
  static_assert(quotient.c == (t + 1.0).c);
  static_assert(cube.c == std::array{8.0, 12.0, 6.0, 1.0, 0.0});
  static_assert((3.0 - t).c == (-(t - 3.0)).c);
  static_assert((t / 2.0).c == (0.5 * t).c && (2.0 / t * t).c == Jet<4>(2.0).c);
}

TEST(Jet, MixesWithNumbersOnBothSides) {
  Jet<2> a = Jet<2>::variable(3.0);

  a += 1.0;
  a -= 2;
  a *= 2.0;
  a /= 4;

  expect_coefficients(a, [](int k) { return k == 0 ? 1.0 : k == 1 ? 0.5 : 0.0; });
  expect_equal(max(a, 7.0), Jet<2>(7.0));
  expect_equal(min(a, 7.0), a);
  expect_equal(max(7.0, a), Jet<2>(7.0));
  expect_equal(min(0.0, a), Jet<2>(0.0));
  expect_equal(pow(2.0, a), exp(std::log(2.0) * a));
  expect_equal(atan2(a, 2.0), atan(a / 2.0));
  expect_equal(atan2(2.0, a), atan(2.0 / a));
}

TEST(Jet, ComparesByValue) {
  const auto a = Jet<2>::variable(1.0, 5.0), b = Jet<2>::variable(2.0, -5.0);

  EXPECT_TRUE(a < b && b > a && a <= b && a != b && a == Jet<2>(1.0));
  EXPECT_TRUE(a > 0.5 && 0.5 < a && a == 1.0 && 3.0 >= b);
}

TEST(Jet, FunctionsHaveTheirClosedTaylorCoefficients) {
  for_each_order([]<int P>(std::integral_constant<int, P>) {
    const double x = 0.7;
    const auto t = Jet<P>::variable(x);

    expect_coefficients<P>(exp(t), [=](int k) { return std::exp(x) / factorial(k); });
    expect_coefficients<P>(log(t), [=](int k) { return k == 0 ? std::log(x) : -std::pow(-1 / x, k) / k; });
    expect_coefficients<P>(sin(t), [=](int k) { return std::sin(x + k * pi / 2) / factorial(k); });
    expect_coefficients<P>(cos(t), [=](int k) { return std::cos(x + k * pi / 2) / factorial(k); });
    expect_coefficients<P>(sinh(t), [=](int k) { return (k % 2 ? std::cosh(x) : std::sinh(x)) / factorial(k); });
    expect_coefficients<P>(cosh(t), [=](int k) { return (k % 2 ? std::sinh(x) : std::cosh(x)) / factorial(k); });
    expect_coefficients<P>(sqrt(t), [=](int k) { return binomial(0.5, k) * std::pow(x, 0.5 - k); });
    expect_coefficients<P>(pow(t, -1.3), [=](int k) { return binomial(-1.3, k) * std::pow(x, -1.3 - k); });
    expect_coefficients<P>(1.0 / t, [=](int k) { return std::pow(-1, k) * std::pow(x, -1 - k); });
    const double y = std::atan(x);
    expect_coefficients<P>(
        atan(t), [=](int k) { return k == 0 ? y : std::pow(std::cos(y), k) * std::sin(k * (y + pi / 2)) / k; });
  });
}

TEST(Jet, LowDerivativesOfTheOtherFunctionsAreTheTextbookOnes) {
  const double x = 0.4, root = std::sqrt(1 - x * x), secant = 1 / std::cos(x), sech = 1 / std::cosh(x);
  const auto t = Jet<2>::variable(x);

  expect_equal(tan(t), [&] {
    Jet<2> r;
    r.c = {std::tan(x), secant * secant, secant * secant * std::tan(x)};
    return r;
  }());
  expect_equal(tanh(t), [&] {
    Jet<2> r;
    r.c = {std::tanh(x), sech * sech, -sech * sech * std::tanh(x)};
    return r;
  }());
  expect_equal(asin(t), [&] {
    Jet<2> r;
    r.c = {std::asin(x), 1 / root, x / (2 * root * root * root)};
    return r;
  }());
  expect_equal(acos(t), [&] {
    Jet<2> r;
    r.c = {std::acos(x), -1 / root, -x / (2 * root * root * root)};
    return r;
  }());
}

TEST(Jet, RateScalesTheKthCoefficientByItsKthPower) {
  for_each_order([]<int P>(std::integral_constant<int, P>) {
    const auto slow = sin(Jet<P>::variable(0.3)), fast = sin(Jet<P>::variable(0.3, -2.0));

    expect_coefficients<P>(fast, [&](int k) { return slow.c[k] * std::pow(-2.0, k); });
  });
}

template <int P>
void check_identities(double tolerance) {
  const auto a = draw_jet<P>(-0.9, 0.9), b = draw_jet<P>(0.5, 3.0), one = Jet<P>(1.0);
  const auto near = [=](const Jet<P>& x, const Jet<P>& y) { return is_near(x, y, tolerance); };

  RC_ASSERT(near(sin(a) * sin(a) + cos(a) * cos(a), one));
  RC_ASSERT(near(cosh(a) * cosh(a) - sinh(a) * sinh(a), one));
  RC_ASSERT(near(tan(a) * cos(a), sin(a)));
  RC_ASSERT(near(tanh(a) * cosh(a), sinh(a)));
  RC_ASSERT(near(exp(log(b)), b));
  RC_ASSERT(near(log(exp(a)), a));
  RC_ASSERT(near(sqrt(b) * sqrt(b), b));
  RC_ASSERT(near(a / b * b, a));
  RC_ASSERT(near(sin(asin(a)), a));
  RC_ASSERT(near(asin(a) + acos(a), Jet<P>(pi / 2)));
  RC_ASSERT(near(atan(tan(a)), a));
  RC_ASSERT(near(atan2(a, b), atan(a / b)));
  RC_ASSERT(near(pow(b, 0.5), sqrt(b)));
  RC_ASSERT(near(pow(b, a), exp(a * log(b))));
  RC_ASSERT(near(pow(b, -2.0) * b * b, one));
  RC_ASSERT(near(exp(a + b), exp(a) * exp(b)));
  RC_ASSERT(near(sin(a + b), sin(a) * cos(b) + cos(a) * sin(b)));
  RC_ASSERT(near(min(a, b) + max(a, b), a + b));
  RC_ASSERT(near(abs(a), sqrt(a * a)) || std::abs(a.value()) < 0.1);
}

RC_GTEST_PROP(Jet, FunctionsKeepTheirIdentitiesAtOrder1, ()) {
  check_identities<1>(1e-13);
}
RC_GTEST_PROP(Jet, FunctionsKeepTheirIdentitiesAtOrder2, ()) {
  check_identities<2>(1e-12);
}
RC_GTEST_PROP(Jet, FunctionsKeepTheirIdentitiesAtOrder6, ()) {
  check_identities<6>(1e-6);
}

RC_GTEST_PROP(Jet, ProductsFollowLeibniz, ()) {
  const auto a = draw_jet<4>(-2.0, 2.0), b = draw_jet<4>(-2.0, 2.0);

  const auto product = a * b;

  // By Leibniz (a b)^(k) = sum over j of (k choose j) a^(j) b^(k-j).
  for (int k = 0; k <= 4; ++k) {
    double sum = 0.0;
    for (int j = 0; j <= k; ++j) sum += binomial(k, j) * a.derivative(j) * b.derivative(k - j);
    RC_ASSERT(std::abs(product.derivative(k) - sum) <= 1e-12 * (1.0 + std::abs(sum)));
  }
}

RC_GTEST_PROP(Jet, LowOrdersDoNotDependOnTheOrderOfTheJet, ()) {
  const double x = draw(0.2, 0.9), rate = draw(-2.0, 2.0);
  const auto compose = [](const auto& t) { return exp(sin(t * t)) / (1.0 + atan(t)) + pow(t, 1.7) * tanh(t); };

  const auto low = compose(Jet<2>::variable(x, rate));
  const auto high = compose(Jet<9>::variable(x, rate));

  for (int k = 0; k <= 2; ++k) RC_ASSERT(std::abs(low.c[k] - high.c[k]) <= 1e-12 * (1.0 + std::abs(high.c[k])));
}

TEST(Jet, ChainOfAllFunctionsAgreesWithDifferences) {
  const auto chain = []<class T>(const T& t) {
    using std::sqrt, std::exp, std::log, std::sin, std::cos, std::tan, std::asin, std::acos, std::atan, std::atan2,
        std::sinh, std::cosh, std::tanh, std::abs, std::min, std::max, std::pow;
    return exp(sin(t * t)) * log(2.0 + cos(3.0 * t)) + tan(t / 2.0) * asin(t / 3.0) - acos(t / 4.0) / sqrt(1.0 + t) +
           atan2(sinh(t), cosh(t)) * atan(t) + tanh(t) * abs(t - 5.0) + pow(t, t) + pow(t, 3.0) + min(t, t * t) +
           max(t, T(0.1));
  };
  const double x = 0.8, h = 0.01;
  const auto at = [&](int k) { return chain(x + k * h); };

  const auto jet = chain(Jet<2>::variable(x));

  // The differences are central ones of order 8.
  const double first = (4.0 / 5 * (at(1) - at(-1)) - 1.0 / 5 * (at(2) - at(-2)) + 4.0 / 105 * (at(3) - at(-3)) -
                        1.0 / 280 * (at(4) - at(-4))) /
                       h;
  const double second = (-205.0 / 72 * at(0) + 8.0 / 5 * (at(1) + at(-1)) - 1.0 / 5 * (at(2) + at(-2)) +
                         8.0 / 315 * (at(3) + at(-3)) - 1.0 / 560 * (at(4) + at(-4))) /
                        (h * h);
  EXPECT_NEAR(jet.value(), chain(x), 1e-14);
  EXPECT_NEAR(jet.derivative(1), first, 1e-10);
  EXPECT_NEAR(jet.derivative(2), second, 1e-9);
}

TEST(Jet, Atan2FollowsAnAngleThroughAllQuadrants) {
  for (const double angle : {0.3, pi / 2, 2.0, 3.1, -0.3, -pi / 2, -2.0, -3.1}) {
    const auto t = Jet<5>::variable(angle);

    expect_equal(atan2(2.0 * sin(t), 2.0 * cos(t)), t);
  }
}

TEST(Jet, IntegerPowersAreExactForAnyBase) {
  const auto t = Jet<3>::variable(-2.0), zero = Jet<3>::variable(0.0);

  EXPECT_EQ(pow(t, 3.0).c, (t * t * t).c);
  EXPECT_EQ(pow(t, 0.0).c, Jet<3>(1.0).c);
  EXPECT_EQ(pow(t, 1.0).c, t.c);
  EXPECT_EQ(pow(t, Jet<3>(2.0)).c, (t * t).c);
  EXPECT_EQ(pow(zero, 0.0).c, Jet<3>(1.0).c);
  EXPECT_EQ(pow(zero, 2.0).c, (std::array{0.0, 0.0, 1.0, 0.0}));
  EXPECT_EQ(pow(zero, 3.0).c, (std::array{0.0, 0.0, 0.0, 1.0}));
  EXPECT_EQ(pow(zero, 70.0).c, Jet<3>(0.0).c);
  expect_equal(pow(t, -2.0), 1.0 / (t * t));
  expect_coefficients(pow(t, 101.0), [](int k) { return binomial(101.0, k) * std::pow(-2.0, 101 - k); });
}

TEST(Jet, RootsOfZeroHaveTheDerivativesThatExist) {
  const auto zero = Jet<3>::variable(0.0);

  // Value, rate and second derivative of t^2.5 vanish at 0, and the third is infinite.
  const auto power = pow(zero, 2.5);
  EXPECT_EQ(power.c[0], 0.0);
  EXPECT_EQ(power.c[1], 0.0);
  EXPECT_EQ(power.c[2], 0.0);
  EXPECT_FALSE(std::isfinite(power.c[3]));
  EXPECT_EQ(sqrt(zero).value(), 0.0);
  EXPECT_FALSE(std::isfinite(sqrt(zero).c[1]));
}

TEST(Jet, AFunctionOfAConstantIsAConstantEvenWhereItHasNoDerivative) {
  const Jet<3> zero = 0.0, one = 1.0;

  EXPECT_EQ(sqrt(zero).c, zero.c);
  EXPECT_EQ(pow(zero, 0.5).c, zero.c);
  EXPECT_EQ(asin(one).c, Jet<3>(std::asin(1.0)).c);
  EXPECT_EQ(acos(one).c, zero.c);
  EXPECT_EQ(atan2(zero, zero).c, zero.c);
  EXPECT_EQ(log(zero).c[1], 0.0);
}

TEST(Jet, TanhKeepsItsTinySlopeFarFromZero) {
  const auto far = tanh(Jet<2>::variable(20.0));

  const double slope = 1.0 / std::cosh(20.0) / std::cosh(20.0);  // 1.7e-17, below the rounding of 1 - tanh^2
  EXPECT_NEAR(far.c[1] / slope, 1.0, 1e-14);
  EXPECT_NEAR(far.c[2] / -slope, 1.0, 1e-14);
}

TEST(Jet, KinksTakeOneBranch) {
  const auto falling = Jet<2>::variable(-3.0, 2.0), at_zero = Jet<2>::variable(0.0, -2.0);

  EXPECT_EQ(abs(falling).c, (-falling).c);
  EXPECT_EQ(abs(at_zero).c, at_zero.c);
  EXPECT_EQ(max(falling, Jet<2>(-3.0)).c, falling.c);
  EXPECT_EQ(min(Jet<2>(-3.0), falling).c, Jet<2>(-3.0).c);
}

}  // namespace
}  // namespace tanor
