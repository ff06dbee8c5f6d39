/// A single member runs on plain numbers and several run side by side, with the same series and adjoints.

#include "evaluate/series_program.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <tanor/system.hpp>

namespace tanor {
using namespace detail;
namespace {

constexpr int order = 10;

/// Returns the coefficient k, from 0 to order, of a variable of a member.
double coefficient(std::size_t variable, std::size_t member, int k) {
  return (k == 0 ? 0.9 : 0.3) *
         std::sin(1.0 + 2.3 * static_cast<double>(variable) + 0.7 * static_cast<double>(member) + k);
}

template <class Lane>
void run(const SeriesProgram& program, std::size_t first_member, Lane* lanes) {
  for (int k = 0; k <= order; ++k) {
    for (std::size_t i = 0; i < program.num_variables(); ++i) {
      for (std::size_t m = 0; m < width_of<Lane>; ++m)
        member_of(program.variable(lanes, order, i)[k], m) = coefficient(i, first_member + m, k);
    }
    const Lane seed = Lane{} + (k == 0 ? 1.0 : 0.0);
    program.evaluate(lanes, order, k);
    program.differentiate(lanes, order, k, &seed);
  }
}

class EnergyText : public testing::TestWithParam<const char*> {};

TEST_P(EnergyText, HasTheSameSeriesAloneAndSideBySide) {
  const PotentialKernel kernel = formula_potential(GetParam(), 1);
  const SeriesProgram program(*kernel.expression, true);
  std::vector<double> room(program.num_lanes(order) * series_width), single(program.num_lanes(order));
  auto* const lanes = reinterpret_cast<SeriesLane*>(room.data());
  run(program, 0, lanes);

  for (std::size_t m = 0; m < series_width; ++m) {
    run(program, m, single.data());
    const auto expect_same = [&](const SeriesLane* several, const double* alone) {
      for (int k = 0; k <= order; ++k) EXPECT_NEAR(several[k][m], alone[k], 1e-13 * (1.0 + std::abs(alone[k]))) << k;
    };
    expect_same(program.result(lanes, order, 0), program.result(single.data(), order, 0));
    for (std::size_t i = 0; i < 3; ++i)
      expect_same(program.adjoint(lanes, order, i), program.adjoint(single.data(), order, i));
  }
}

INSTANTIATE_TEST_SUITE_P(Operations, EnergyText,
                         testing::Values("x1^2 - 3*x1*y1", "sqrt(x1^2 + 1)", "x1/(2 + y1^2)", "exp(y1/3)*x1",
                                         "log(2 + z1^2)", "sin(x1*y1) + cos(z1)", "sinh(x1) + cosh(y1*z1)",
                                         "asin(x1/4) + acos(y1/4)", "atan(y1*z1)", "atan2(z1, 2 + x1)", "tanh(x1)",
                                         "abs(x1) + min(x1, y1) + max(y1, z1)"));

/// With e = exp(x), e^2 counts each pair of coefficients once and has the series of exp(2x).
TEST(SeriesProgramTest, SquareOfAnExponentialHasTheSeriesOfItsDouble) {
  const PotentialKernel square = formula_potential("exp(x1)^2", 1), once = formula_potential("exp(2*x1)", 1);
  std::vector<double> results[2];
  for (const PotentialKernel* kernel : {&square, &once}) {
    const SeriesProgram program(*kernel->expression, true);
    std::vector<double> lanes(program.num_lanes(order));
    run(program, 0, lanes.data());
    std::vector<double>& numbers = results[kernel == &once ? 1 : 0];
    for (int k = 0; k <= order; ++k) numbers.push_back(program.result(lanes.data(), order, 0)[k]);
    for (int k = 0; k <= order; ++k) numbers.push_back(program.adjoint(lanes.data(), order, 0)[k]);
  }
  for (std::size_t k = 0; k < results[0].size(); ++k)
    EXPECT_NEAR(results[0][k], results[1][k], 1e-14 * (1.0 + std::abs(results[1][k]))) << k;
}

}  // namespace
}  // namespace tanor
