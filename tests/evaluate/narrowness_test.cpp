/// How often formulas may change their course.

#include "evaluate/narrowness.hpp"

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
