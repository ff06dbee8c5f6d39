/// The motion is a power series in time, which is tested order by order on random systems of all kinds.

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tanor/user_kernel.hpp>

#include "dynamics/multiplier_form.hpp"
#include "random_systems.hpp"

namespace tanor {
using namespace detail;
namespace {

/// A system in normal form at one instant, and its series.
struct Expanded {
  Workspace work;
  const Model& model{work.model()};
  MultiplierForm form;
  double t;
  std::vector<std::vector<double>> coefficients;
  Outcome outcome;

  Expanded(const RandomSystem& random, int order)
      : work(random.system, {.threads = 1}, random.t),
        form(work, {.threads = 1}),
        t(random.t),
        coefficients(static_cast<std::size_t>(order) + 1, std::vector<double>(form.size())) {
    std::vector<double> r(form.size()), v(form.size());
    model.numbering.gather_points(random.positions, r);
    model.numbering.gather_points(random.velocities, v);
    form.prescribe(t, r.data(), v.data());
    work.prescribe_all(t, r.data(), v.data());
    outcome = form.linearise(t, r.data());
    std::vector<double*> pointers;
    for (std::vector<double>& c : coefficients) pointers.push_back(c.data());
    SeriesExtent extent;
    const Kinematics at{t, r.data(), v.data()};
    Reactions found;
    if (outcome.ok())
      outcome = form.accelerations(at, {Gradients::Keep, true}, {pointers[2], nullptr, nullptr, &found});
    if (outcome.ok() && form.series(nullptr) != nullptr)
      outcome = form.series(nullptr)->expand(at, pointers[2], found, {}, pointers, &extent);
  }

  /// Returns the reason why there is no series, or an empty string if there is one.
  std::string obstacle() {
    std::string why_not;
    (void)form.series(&why_not);
    return why_not;
  }

  /// Returns the derivative 0 (places), 1 (velocities) or 2 (accelerations) of the series at h.
  std::vector<double> at(double h, int derivative) const {
    std::vector<double> sum(form.size(), 0.0);
    for (std::size_t k = coefficients.size(); k-- > static_cast<std::size_t>(derivative);) {
      double factor = 1.0;
      for (int j = 0; j < derivative; ++j) factor *= static_cast<double>(k) - j;
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = h * sum[i] + factor * coefficients[k][i];
    }
    return sum;
  }

  /// Returns the time in which the last terms of the series become equal.
  double radius() const {
    double inverse = 0.0;
    for (std::size_t k = coefficients.size() - 3; k < coefficients.size(); ++k)
      inverse = std::max(inverse, std::pow(model.largest_norm(coefficients[k].data()), 1.0 / static_cast<double>(k)));
    return 1.0 / inverse;
  }

  /// Returns the distance of the series at t + h from the acceleration of the equations there.
  double defect(double h) {
    std::vector<double> r = at(h, 0), v = at(h, 1), w(form.size());
    const std::vector<double> wanted = at(h, 2);
    form.prescribe(t + h, r.data(), v.data());
    const Outcome found = form.accelerations({t + h, r.data(), v.data()}, {.exact = true}, w.data());
    return found.ok() ? model.largest_move(w.data(), wanted.data()) : HUGE_VAL;
  }
  /// Returns true if some point reverses by t + h. Drag |v| v has a kink where v = 0, and the series holds on one side
  /// of it.
  bool turns_round(double h) const {
    const std::vector<double> before = at(0.0, 1), after = at(h, 1);
    for (std::size_t i = 0; i < before.size(); i += 3) {
      if (before[i] * after[i] + before[i + 1] * after[i + 1] + before[i + 2] * after[i + 2] < 0.0) return true;
    }
    return false;
  }

  /// Returns the largest xi at t + h.
  double violation(double h) {
    std::vector<double> r = at(h, 0), v = at(h, 1);
    form.prescribe(t + h, r.data(), v.data());
    return work.position_violation(t + h, r.data());
  }
};

/// Expects that halving h divides the error by 2^slope, or that the error is rounding.
void expect_slope(double slope, double at_h, double at_half, double rounding) {
  RC_LOG() << "at h " << at_h << ", at h/2 " << at_half << ", rounding " << rounding << "\n";
  RC_ASSERT(at_half <= rounding || std::log2(at_h / at_half) > slope - 0.6);
}

constexpr int order = 9;

RC_GTEST_PROP(Series, SatisfiesTheEquationsToItsOrder, ()) {
  const RandomSystem random = any_system();
  Expanded series(random, order);
  RC_PRE(series.obstacle().empty());
  RC_ASSERT(series.outcome.ok());
  const double scale = 1.0 + series.model.largest_norm(series.coefficients[2].data());
  double h = std::min(0.05 * series.radius(), 0.05);
  while (series.turns_round(h)) h *= 0.5;
  // The error of x'' to order P - 2 is O(h^{P-1}), and xi = O(h^{P+1}).
  expect_slope(order - 1, series.defect(h), series.defect(0.5 * h), 1e-9 * scale);
  expect_slope(order + 1, series.violation(h), series.violation(0.5 * h), 1e-13);
}

TEST(Series, MostRandomSystemsHaveSeries) {
  int count = 0;
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    Expanded series(make_random_system(12, seed), 4);
    count += series.obstacle().empty() ? 1 : 0;
  }
  EXPECT_GE(count, 120);  // lines whose direction turns have no series
}

/// Makes functions of every kind in a constraint, a force and a length, with the same motion by formula and by
/// callable.
RandomSystem make_functions(ConstraintKernel surface) {
  RandomSystem random;
  System& system = random.system;
  system.positions = {0.3, 0.2, 0.0, 1.3, 0.2, 0.1};
  system.masses = {1.0, 2.0};
  random.positions = system.positions;
  random.velocities = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  double xi = 0.0, rate = 0.0, phi = 0.0;
  std::vector<double> gradient(3);
  ConstraintBatch batch{1, 0.0, system.positions.data(), random.velocities.data(), &xi, &rate, &phi, gradient.data()};
  surface.evaluate(surface.context.get(), batch);
  // The surface is z1 + something, so that the start can be put on it and follow it.
  system.positions[2] = random.positions[2] = -xi;
  random.velocities[2] = random.velocities[5] = -rate;
  system.velocities = random.velocities;
  system.constraints = {UserConstraints{"surface", {{0}}, std::move(surface)}, Rods{"rod", {{0, 1}}}};
  system.forces = {Gravity{"g", {0, 0, -9.81}},
                   FormulaForce{"field",
                                {1},
                                formula_force({"-x*exp(-x^2) + 0.1*vx*abs(vy-1)", "sinh(0.3*y) - tanh(z)",
                                               "atan2(y, x) + log(2 + x)*cos(t)"})},
                   Springs{"spring", {{0, 1}}, 3.0, 0.2, 0.5}, Drag{"air", {0}, 0.3, 0.0}};
  return random;
}

constexpr const char* surface_text =
    "z1 + 0.2*sin(2*x1)*cos(y1) - 0.1*sqrt(1 + x1^2) + 0.05*atan(y1) + 0.1*asin(0.3*x1) + 0.02*max(x1, -2)^3/(2 + y1) "
    "+ 0.01*tan(0.3*x1) + 0.02*acos(0.2*y1) + 0.03*cosh(x1*y1)*(1 + t)^1.5";

TEST(Series, FormulasOfEveryFunctionSatisfyTheEquations) {
  const RandomSystem random = make_functions(formula_constraint(surface_text, 1));
  Expanded series(random, order);
  ASSERT_TRUE(series.outcome.ok()) << series.outcome.what;
  ASSERT_EQ(series.obstacle(), "");
  const double h = 0.1 * series.radius();
  const double rate = std::log2(series.defect(h) / series.defect(0.5 * h));
  EXPECT_NEAR(rate, order - 1, 0.7);
  EXPECT_NEAR(std::log2(series.violation(h) / series.violation(0.5 * h)), order + 1, 0.7);
}

TEST(Series, CallablesAreFormulas) {
  const auto surface = [](const auto& x, const auto& t) {
    using std::sin, std::cos, std::sqrt, std::atan, std::asin, std::tan, std::acos, std::cosh, std::pow, std::max;
    const auto &x1 = x[0], &y1 = x[1];
    return x[2] + 0.2 * sin(2.0 * x1) * cos(y1) - 0.1 * sqrt(1.0 + x1 * x1) + 0.05 * atan(y1) + 0.1 * asin(0.3 * x1) +
           0.02 * pow(max(x1, -2.0 + 0.0 * x1), 3.0) / (2.0 + y1) + 0.01 * tan(0.3 * x1) + 0.02 * acos(0.2 * y1) +
           0.03 * cosh(x1 * y1) * pow(1.0 + t, 1.5);
  };
  Expanded text(make_functions(formula_constraint(surface_text, 1)), order);
  Expanded code(make_functions(make_constraint_kernel<1>(surface)), order);
  ASSERT_EQ(code.obstacle(), "");
  for (std::size_t k = 0; k < text.coefficients.size(); ++k) {
    for (std::size_t i = 0; i < text.form.size(); ++i)
      EXPECT_NEAR(text.coefficients[k][i], code.coefficients[k][i], 1e-10 * (1.0 + std::abs(text.coefficients[k][i])))
          << k;
  }
}

TEST(Series, FunctionsThatCompareTheirArgumentsHaveNoSeries) {
  const auto step = [](const auto& x, const auto&) { return x[2] < 0.0 ? x[2] : 2.0 * x[2]; };
  EXPECT_EQ(make_constraint_kernel<1>(step).expression, nullptr);
  Expanded series(make_functions(make_constraint_kernel<1>([](const auto& x, const auto& t) {
                    return x[0] > 100.0 ? x[2] : x[2] + 0.1 * x[0] * x[1] + 0.01 * t;
                  })),
                  4);
  EXPECT_EQ(series.obstacle(), "constraints[0] cannot be expanded in time: it is known as a function alone");
}

}  // namespace
}  // namespace tanor
