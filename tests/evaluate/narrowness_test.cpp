/// How often formulas may change their course.

#include "evaluate/narrowness.hpp"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <tanor/system.hpp>

namespace tanor {
using namespace detail;
namespace {

/// Returns the count while x1 runs from a to b, and y1, z1 and t are 0.
double count_in_x(const std::string& formula, double a, double b) {
  const Narrowness narrowness(*formula_constraint(formula, 1).expression);
  const Pack<> zero{};
  const Intervals variables[] = {{zero + a, zero + b}, {zero, zero}, {zero, zero}, {zero, zero}};
  return narrowness.count(variables)[0];
}

/// The table has the length of the argument's run over the scale of the function.
TEST(Narrowness, EachFunctionCountsOnItsOwnScale) {
  constexpr double none = std::numeric_limits<double>::infinity();
  struct {
    const char* formula;
    double a, b, count;
  } const rows[] = {{"x1*x1-3*x1+y1", -5.0, 5.0, 0.0},
                    {"exp(x1)", -70.0, 3.0, 63.0},
                    {"1/exp(2*x1)", 0.0, 1.5, 6.0},
                    {"sin(2*x1)", 0.0, 2.0, 4.0},
                    {"cos(x1-1)", -1.0, 2.0, 3.0},
                    {"sinh(x1)", 0.0, 1.5, 1.5},
                    {"cosh(x1)", -30.0, 30.0, 40.0},
                    {"tanh(x1)", 0.0, 0.5, 0.5},
                    {"sqrt(x1)", 1.0, M_E, 2.0},
                    {"sqrt(x1)", -1.0, 1.0, none},
                    {"log(x1)", 1.0, M_E, 2.0},
                    {"log(x1)", 0.0, 1.0, none},
                    {"1/x1", 1.0, M_E, 2.0},
                    {"1/(x1-1)", 0.5, 2.0, none},
                    {"exp(1/(x1-1))", 0.5, 2.0, none},
                    {"exp(3-x1)", 0.0, 2.0, 2.0},
                    {"exp(-abs(x1))", 0.0, 2.0, 2.0},
                    {"abs(x1)", -1.0, 2.0, none},
                    {"exp(x1*y1-x1)", 0.0, 2.0, 2.0},
                    {"asin(x1)", -0.5, 0.5, 0.0},
                    {"asin(x1)", 0.0, 1.0, none},
                    {"exp(4*asin(x1))", 0.0, 0.5, 4.0 * std::asin(0.5)},
                    {"atan(x1)", 0.0, std::sinh(1.0), 1.0},
                    {"exp(4*atan(x1))", 0.0, 1.0, M_PI},
                    {"atan2(x1,1)", -1.0, 1.0, 0.5 * M_PI},
                    {"atan2(x1,-1)", -1.0, 1.0, none},
                    {"min(x1,1)", 0.0, 2.0, none},
                    {"exp(min(x1,3))", 0.0, 2.0, 2.0},
                    {"exp(max(x1,-1))", 0.0, 2.0, 2.0},
                    {"max(x1,1)", 2.0, 3.0, 0.0},
                    {"exp(sin(x1))", 0.0, 0.5 * M_PI, 0.5 * M_PI},
                    {"exp(4*sin(x1))", 0.0, M_PI, 4.0},
                    {"exp(8*cos(x1))", -1.0, 1.0, 8.0 - 8.0 * std::cos(1.0)},
                    {"exp(4*cosh(x1))", -2.0, 1.0, 4.0 * std::cosh(2.0) - 4.0},
                    {"exp(sinh(x1))", 0.0, 2.0, std::sinh(2.0)},
                    {"exp(8*tanh(x1))", 0.0, 1.0, 8.0 * std::tanh(1.0)},
                    {"exp(4*sqrt(x1))", 1.0, 4.0, 4.0},
                    {"exp(8*log(x1))", 1.0, 2.0, 8.0 * std::log(2.0)},
                    {"exp(x1^2)", -1.0, 3.0, 9.0},
                    {"exp(8/x1)", 1.0, 2.0, 4.0},
                    {"exp(-1/y1)", 1.0, 2.0, none},
                    {"exp(-(1/y1))", 1.0, 2.0, none}};
  for (const auto& [formula, a, b, count] : rows) EXPECT_DOUBLE_EQ(count_in_x(formula, a, b), count) << formula;
}

/// Where both numbers are equal, intervals of their difference always hold 0.
TEST(Narrowness, OfTheLargerOfANumberAndItsMagnitudeIsThatOfTheMagnitude) {
  for (const std::string formula : {"max(abs(x1),x1)", "max(x1,abs(x1))", "min(abs(x1),x1)"}) {
    EXPECT_EQ(count_in_x(formula + "-z1", 1.0, 2.0), 0.0) << formula;
    EXPECT_EQ(count_in_x(formula + "-z1", -2.0, -1.0), 0.0) << formula;
    EXPECT_EQ(count_in_x(formula + "-z1", -1.0, 1.0), std::numeric_limits<double>::infinity()) << formula;
  }
}

}  // namespace
}  // namespace tanor
