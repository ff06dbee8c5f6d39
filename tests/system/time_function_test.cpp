#include <tanor/time_function.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <tanor/error.hpp>

#include "errors.hpp"

namespace tanor {
namespace {

std::vector<double> uniform_times(double first, double last, int rows) {
  std::vector<double> times(rows);
  for (int i = 0; i < rows; ++i) times[i] = first + (last - first) * i / (rows - 1);
  return times;
}

/// Returns times whose steps are between 0.5 and 1.5.
std::vector<double> uneven_times(int rows) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> step(0.5, 1.5);
  std::vector<double> times = {-2.0};
  while (static_cast<int>(times.size()) < rows) times.push_back(times.back() + step(generator));
  return times;
}

template <class Function>
ScalarFunction make_table(const std::vector<double>& times, const Function& function) {
  std::vector<double> values;
  for (const double t : times) values.push_back(function(t));
  return ScalarFunction::table(times, values);
}

TEST(ScalarFunction, IsZeroByDefaultAndAConstantFromANumber) {
  const ScalarFunction zero, constant = 2.5;

  EXPECT_TRUE(zero.is_constant() && constant.is_constant());
  EXPECT_EQ(zero(3.0).c, Jet<2>(0.0).c);
  EXPECT_EQ(constant(3.0).c, Jet<2>(2.5).c);
}

TEST(ScalarFunction, FormulaGivesValueRateAndSecondDerivative) {
  const auto drive = ScalarFunction::formula("0.1*sin(omega*t)", {{"omega", 3.0}});

  const Jet<2> jet = drive(0.4);

  EXPECT_FALSE(drive.is_constant());
  EXPECT_NEAR(jet.value(), 0.1 * std::sin(1.2), 1e-16);
  EXPECT_NEAR(jet.derivative(1), 0.3 * std::cos(1.2), 1e-16);
  EXPECT_NEAR(jet.derivative(2), -0.9 * std::sin(1.2), 1e-15);
}

TEST(ScalarFunction, FormulaWithoutTimeIsAConstant) {
  const auto constant = ScalarFunction::formula("2*pi/omega", {{"omega", 4.0}});

  EXPECT_TRUE(constant.is_constant());
  EXPECT_EQ(constant(1.0).c, Jet<2>(std::acos(0.0)).c);
}

TEST(ScalarFunction, FormulaReportsItsErrors) {
  EXPECT_TRUE(error_of([] {
                ScalarFunction::formula("0.1*sin(3*q)");
              }).starts_with("formula \"0.1*sin(3*q)\": column 11: 'q' is not known; known names: t, pi and"));
}

TEST(ScalarFunction, CustomRunsOnJets) {
  const auto custom = ScalarFunction::custom([](auto t) { return sin(3.0 * t) * t; });

  const Jet<2> jet = custom(0.5);

  EXPECT_FALSE(custom.is_constant());
  EXPECT_NEAR(jet.value(), 0.5 * std::sin(1.5), 1e-15);
  EXPECT_NEAR(jet.derivative(1), std::sin(1.5) + 1.5 * std::cos(1.5), 1e-15);
  EXPECT_NEAR(jet.derivative(2), 6.0 * std::cos(1.5) - 4.5 * std::sin(1.5), 1e-14);
}

TEST(ScalarFunction, CustomMustBeCallable) {
  EXPECT_EQ(error_of([] { ScalarFunction::custom({}); }), "custom function: it is empty, nothing to call");
}

TEST(ScalarFunction, CopiesShareOneTable) {
  const auto table = make_table(uniform_times(0.0, 1.0, 10), [](double t) { return t; });

  const ScalarFunction copy = table;

  EXPECT_EQ(copy(0.3).c, table(0.3).c);
}

TEST(Table, ReproducesPolynomialsUpToDegreeFiveFromSixRowsOn) {
  for (int rows = 6; rows <= 40; ++rows) {
    const std::vector<double> times = uneven_times(rows);
    for (int degree = 0; degree <= 5; ++degree) {
      const auto polynomial = [&](const auto& t) { return 1.0 + t + pow((t - 3.0) / 4.0, degree); };
      const auto table = make_table(times, [&](double t) { return polynomial(Jet<2>(t)).value(); });

      for (double t = times.front(); t < times.back(); t += 0.173) {
        const Jet<2> expected = polynomial(Jet<2>::variable(t)), jet = table(t);
        const double scale = 1.0 + std::pow(rows / 4.0, degree);
        EXPECT_NEAR(jet.c[0], expected.c[0], 1e-12 * scale) << rows << " rows, degree " << degree << ", t = " << t;
        EXPECT_NEAR(jet.c[1], expected.c[1], 1e-11 * scale) << rows << " rows, degree " << degree << ", t = " << t;
        EXPECT_NEAR(jet.c[2], expected.c[2], 1e-10 * scale) << rows << " rows, degree " << degree << ", t = " << t;
      }
    }
  }
}

TEST(Table, IsThePolynomialThroughItsRowsWhenTheyAreFew) {
  for (int rows = 2; rows <= 6; ++rows) {
    const auto polynomial = [&](const auto& t) { return 2.0 - t + pow(t, rows - 1.0); };
    const auto table =
        make_table(uniform_times(-1.0, 2.0, rows), [&](double t) { return polynomial(Jet<2>(t)).value(); });

    for (const double t : {-1.0, -0.3, 0.4, 1.1, 2.0}) {
      const Jet<2> expected = polynomial(Jet<2>::variable(t)), jet = table(t);
      for (int k = 0; k <= 2; ++k) EXPECT_NEAR(jet.c[k], expected.c[k], 2e-12) << rows << " rows, t = " << t;
    }
  }
}

TEST(Table, PassesThroughItsSamples) {
  const std::vector<double> times = uneven_times(200);
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> noise(-1.0, 1.0);
  std::vector<double> values(times.size());
  for (double& value : values) value = noise(generator);

  const auto table = ScalarFunction::table(times, values);

  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(table(times[i]).value(), values[i], 1e-11);
}

TEST(Table, DerivativesAreThoseOfTheValue) {
  const auto table = make_table(uneven_times(30), [](double t) { return std::sin(t); });
  const double h = 1e-3;

  for (const double t : {-1.7, 0.1, 3.3, 10.2}) {
    const double before = table(t - h).value(), now = table(t).value(), after = table(t + h).value();
    EXPECT_NEAR(table(t).derivative(1), (after - before) / (2 * h), 1e-6);
    EXPECT_NEAR(table(t).derivative(2), (after - 2 * now + before) / (h * h), 1e-6);
  }
}

TEST(Table, ConvergesOnSineWithOrderSixAndItsSecondDerivativeWithOrderFour) {
  // Returns the largest errors over [1, 7], ends included.
  const auto errors = [](int rows) {
    const auto table = make_table(uniform_times(1.0, 7.0, rows), [](double t) { return std::sin(t); });
    std::array<double, 3> largest{};
    for (double t = 1.0; t <= 7.0; t += 0.001) {
      const Jet<2> jet = table(t), exact = sin(Jet<2>::variable(t));
      for (int k = 0; k <= 2; ++k) {
        largest[k] = std::max(largest[k], std::abs(jet.derivative(k) - exact.derivative(k)));
      }
    }
    return largest;
  };

  const auto coarse = errors(31), fine = errors(61);

  const std::array<double, 3> orders = {6.0, 5.0, 4.0};
  for (int k = 0; k <= 2; ++k) EXPECT_NEAR(std::log2(coarse[k] / fine[k]), orders[k], 0.4) << "derivative " << k;
  EXPECT_LT(fine[0], 2e-8);
  EXPECT_LT(fine[2], 1e-4);
}

TEST(Table, SecondDerivativesAreSmoothAtTheSamples) {
  // The data are rough, so that a jump of the fourth derivative would show.
  const std::vector<double> times = uneven_times(12);
  std::vector<double> values;
  for (std::size_t i = 0; i < times.size(); ++i) values.push_back(i % 2 ? 1.0 : -1.0);
  const auto table = ScalarFunction::table(times, values);
  const auto second = [&](double t) { return table(t).derivative(2); };
  const double h = 1e-3;

  for (std::size_t i = 1; i + 1 < times.size(); ++i) {
    const double t = times[i];

    // One-sided differences of s = second derivative have errors O(h^2): s, s' and s'' agree from both sides.
    const double left_1 = (3 * second(t - 1e-12) - 4 * second(t - h) + second(t - 2 * h)) / (2 * h);
    const double right_1 = (-3 * second(t) + 4 * second(t + h) - second(t + 2 * h)) / (2 * h);
    const double left_2 =
        (2 * second(t - 1e-12) - 5 * second(t - h) + 4 * second(t - 2 * h) - second(t - 3 * h)) / (h * h);
    const double right_2 = (2 * second(t) - 5 * second(t + h) + 4 * second(t + 2 * h) - second(t + 3 * h)) / (h * h);
    EXPECT_NEAR(second(t - 1e-12), second(t), 1e-8);
    EXPECT_NEAR(left_1, right_1, 1e-2);
    EXPECT_NEAR(left_2, right_2, 1e-2 * (1.0 + std::abs(right_2)));
  }
}

TEST(Table, TimesOutsideItsRangeAreErrorsThatNameTimeAndRange) {
  const auto table = make_table(uniform_times(0.5, 2.0, 10), [](double t) { return t; });

  EXPECT_EQ(error_of([&] { table(2.25); }), "t = 2.25 is outside the table, which reaches from 0.5 to 2");
  EXPECT_EQ(error_of([&] { table(0.25); }), "t = 0.25 is outside the table, which reaches from 0.5 to 2");
  EXPECT_EQ(error_of([&] { table(NAN); }), "t = nan is outside the table, which reaches from 0.5 to 2");
}

TEST(Table, ReachesToTheRoundingOfItsEnds) {
  const auto table = make_table(uniform_times(0.5, 2.0, 10), [](double t) { return t; });

  EXPECT_NEAR(table(std::nextafter(2.0, 3.0)).value(), 2.0, 1e-14);
  EXPECT_NEAR(table(std::nextafter(0.5, 0.0)).value(), 0.5, 1e-14);
}

TEST(Table, WrongSamplesAreErrors) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto error = [](std::vector<double> times, std::vector<double> values) {
    return error_of([&] { ScalarFunction::table(times, values); });
  };

  EXPECT_EQ(error({}, {}), "table: 0 rows; a table needs at least 2");
  EXPECT_EQ(error({0}, {1}), "table: 1 row; a table needs at least 2");
  EXPECT_EQ(error({0, 1}, {1}), "table: 2 times but 1 value; a row has one of each");
  EXPECT_EQ(error({0, 1, 1}, {1, 2, 3}), "table: row 3: time 1 after 1; times must strictly increase");
  EXPECT_EQ(error({0, 1e-300, 2e-300, 3e-300, 1, 2, 3, 4, 5, 6}, {1, -1, 2, 3, 1, -1, 0, 2, 4, 1}),
            "table: its times are too unequal for a smooth curve; wanted steps that do not differ so much");
  EXPECT_EQ(error({0, 1, 0.5}, {1, 2, 3}), "table: row 3: time 0.5 after 1; times must strictly increase");
  EXPECT_EQ(error({0, infinity}, {1, 2}), "table: row 2: time inf is not finite");
  EXPECT_EQ(error({0, 1}, {NAN, 2}), "table: row 1: value nan is not finite");
}

TEST(VectorFunction, IsZeroByDefaultAndAConstantFromAVector) {
  const VectorFunction zero, constant = Vector3{1.0, 2.0, 3.0};

  EXPECT_TRUE(zero.is_constant() && constant.is_constant());
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(zero(1.0)[k].c, Jet<2>(0.0).c);
    EXPECT_EQ(constant(1.0)[k].c, Jet<2>(k + 1.0).c);
  }
}

TEST(VectorFunction, EvaluatesItsComponents) {
  const VectorFunction function(ScalarFunction::formula("t^2"), 5.0, ScalarFunction::formula("-t"));

  const auto [x, y, z] = function(3.0);

  EXPECT_FALSE(function.is_constant());
  EXPECT_EQ(x.c, (std::array{9.0, 6.0, 1.0}));
  EXPECT_EQ(y.c, (std::array{5.0, 0.0, 0.0}));
  EXPECT_EQ(z.c, (std::array{-3.0, -1.0, 0.0}));
}

}  // namespace
}  // namespace tanor
