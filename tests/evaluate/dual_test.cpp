/// The arithmetic of the certificate agrees with that of the kernels, and neither uses the other.

#include "evaluate/dual.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <tanor/forward.hpp>

namespace tanor {
using namespace detail;
namespace {

/// Applies every operation that a definition may use to a, b and c along a curve.
template <class T>
std::vector<T> evaluate_all(const T& a, const T& b, const T& c) {
  using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::cosh, std::exp, std::log, std::max,
      std::min, std::pow, std::sin, std::sinh, std::sqrt, std::tan, std::tanh;
  T sum = a;
  sum += b;
  sum *= c;
  sum -= a;
  sum /= 2.0 + b;
  return {sum,
          a * b - c / a + 2.0 * b,
          -a + 1.0 / c,
          sqrt(a) * b,
          exp(b),
          log(a * c),
          sin(a * b),
          cos(a * b),
          tan(b),
          asin(b),
          acos(b),
          atan(a * c),
          atan2(b, c),
          atan2(a, -c),
          sinh(a),
          cosh(a),
          tanh(a * b),
          abs(b - a),
          min(a, b) * c,
          max(a, b) * c,
          pow(b - a, 3.0),
          pow(a, -2.0),
          pow(a, 0.7),
          pow(a, b)};
}

constexpr double value[] = {1.3, 0.4, 2.1}, first[] = {0.7, -1.1, 0.5}, second[] = {-0.8, 0.3, 1.9};

TEST(Dual, AgreesWithJetsInValueAndBothDerivatives) {
  const auto dual = [](std::size_t i) { return second_dual(value[i], first[i], second[i]); };
  const auto jet = [](std::size_t i) {
    Jet<2> result;
    result.c = {value[i], first[i], 0.5 * second[i]};
    return result;
  };
  const std::vector<SecondDual> duals = evaluate_all(dual(0), dual(1), dual(2));
  const std::vector<Jet<2>> jets = evaluate_all(jet(0), jet(1), jet(2));
  for (std::size_t k = 0; k < jets.size(); ++k) {
    const double allowed = 1e-13 * (1.0 + std::abs(jets[k].derivative(1)) + std::abs(jets[k].derivative(2)));
    EXPECT_NEAR(duals[k].v.v, jets[k].value(), allowed) << k;
    EXPECT_NEAR(duals[k].v.d, jets[k].derivative(1), allowed) << k;
    EXPECT_NEAR(duals[k].d.v, jets[k].derivative(1), allowed) << k;
    EXPECT_NEAR(duals[k].d.d, jets[k].derivative(2), allowed) << k;
  }
}

TEST(Dual, AgreesWithForwardInTheFirstDerivative) {
  const auto forward = [](std::size_t i) {
    Forward<1> result(value[i]);
    result.d[0] = first[i];
    return result;
  };
  const std::vector<Dual<double>> duals =
      evaluate_all<Dual<double>>({value[0], first[0]}, {value[1], first[1]}, {value[2], first[2]});
  const std::vector<Forward<1>> numbers = evaluate_all(forward(0), forward(1), forward(2));
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    EXPECT_NEAR(duals[k].v, numbers[k].value(), 1e-13 * (1.0 + std::abs(numbers[k].value()))) << k;
    EXPECT_NEAR(duals[k].d, numbers[k].d[0], 1e-13 * (1.0 + std::abs(numbers[k].d[0]))) << k;
  }
}

TEST(Dual, ConstantsHaveNoDerivativeWhereAFunctionIsSteep) {
  const SecondDual zero = 0.0, root = sqrt(zero);
  EXPECT_EQ(root.v.v, 0.0);
  EXPECT_EQ(root.v.d, 0.0);
  EXPECT_EQ(root.d.d, 0.0);
}

TEST(Dual, ClockRunsAlongWithTime) {
  const SecondDual now = ClockOf<SecondDual>{2.0}(ScalarFunction::formula("t^3"));
  EXPECT_EQ(now.v.v, 8.0);
  EXPECT_EQ(now.v.d, 12.0);
  EXPECT_EQ(now.d.d, 12.0);
  EXPECT_EQ(ClockOf<Dual<double>>{2.0}(ScalarFunction::formula("t^3")).d, 0.0) << "time stands";
}

}  // namespace
}  // namespace tanor
