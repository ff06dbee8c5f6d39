/// Users' functions serve as constraints, tested by closed forms, the same rod in three ways, threads, exceptions and
/// supports.

#include <tanor/user_kernel.hpp>

#include <atomic>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <tanor/dynamics.hpp>

#include "evaluate/constraints.hpp"
#include "random_numbers.hpp"
#include "reference.hpp"

namespace tanor {
using namespace detail;
namespace {

struct Numbers {
  std::vector<double> xi, rate, phi, gradient;
};

Numbers evaluate(const ConstraintKernel& kernel, double t, const std::vector<double>& r, const std::vector<double>& v) {
  const std::size_t size = 3 * static_cast<std::size_t>(kernel.num_points), count = r.size() / size;
  Numbers result{std::vector<double>(count), std::vector<double>(count), std::vector<double>(count),
                 std::vector<double>(r.size())};
  kernel.evaluate(kernel.context.get(), {count, t, r.data(), v.data(), result.xi.data(), result.rate.data(),
                                         result.phi.data(), result.gradient.data()});
  return result;
}

/// For xi = x^2 + y^2 - R^2 with R = 1 + 0.1 sin 3t each quantity is within a few roundings of its own terms.
TEST(UserKernel, MovingCylinderIsExactToRounding) {
  const ConstraintKernel formula = formula_constraint("x1^2+y1^2-(1+0.1*sin(3*t))^2", 1);
  const ConstraintKernel lambda = make_constraint_kernel<1>([](const auto& x, const auto& t) {
    const auto radius = 1.0 + 0.1 * sin(3.0 * t);
    return x[0] * x[0] + x[1] * x[1] - radius * radius;
  });
  const std::vector<double> r = uniform_numbers(300, 1), v = uniform_numbers(300, 2);
  constexpr double eps = 2.3e-16;
  for (const ConstraintKernel& kernel : {formula, lambda}) {
    for (const double t : {0.0, 0.4, 2.9}) {
      const Numbers found = evaluate(kernel, t, r, v);

      const double R = 1 + 0.1 * std::sin(3 * t), R1 = 0.3 * std::cos(3 * t), R2 = -0.9 * std::sin(3 * t);
      for (std::size_t k = 0; k < 100; ++k) {
        const double x = r[3 * k], y = r[3 * k + 1], vx = v[3 * k], vy = v[3 * k + 1];
        EXPECT_NEAR(found.xi[k], x * x + y * y - R * R, 4 * eps * (x * x + y * y + R * R));
        EXPECT_NEAR(found.rate[k], 2 * (x * vx + y * vy - R * R1), 8 * eps * (std::abs(x * vx) + std::abs(y * vy) + R));
        EXPECT_NEAR(found.phi[k], 2 * (vx * vx + vy * vy - R1 * R1 - R * R2), 8 * eps * (vx * vx + vy * vy + 1.2));
        EXPECT_EQ(found.gradient[3 * k], 2 * x);
        EXPECT_EQ(found.gradient[3 * k + 1], 2 * y);
        EXPECT_EQ(found.gradient[3 * k + 2], 0.0);
      }
    }
  }
}

/// The coordinates are cylindrical ones on a moving cone, from a callable.
TEST(UserKernel, CoordinatesGivePositionsVelocitiesCurvatureAndTangents) {
  const CoordinateKernel kernel = make_coordinate_kernel<1, 2>([](const auto& q, const auto& t) {
    using T = std::decay_t<decltype(t)>;
    return std::array<T, 3>{q[0] * cos(q[1]), q[0] * sin(q[1]), t * t * q[0]};
  });
  const double q[] = {2.0, 0.3}, q_dot[] = {0.5, -1.5}, t = 0.7;
  double r[3], v[3], psi[3], tangents[6], r_alone[3];

  kernel.evaluate(kernel.context.get(), {1, t, q, q_dot, r, v, psi, tangents});
  kernel.evaluate(kernel.context.get(), {1, t, q, nullptr, r_alone, nullptr, nullptr, nullptr});

  const double c = std::cos(0.3), s = std::sin(0.3);
  const double expected_v[] = {0.5 * c + 3.0 * s, 0.5 * s - 3.0 * c, 0.5 * t * t + 4.0 * t};
  // The curvature is rho'' - rho theta'^2 = -4.5 and 2 rho' theta' = -1.5 across the axis, and 2 q + 4 t q' along it.
  const double expected_psi[] = {-4.5 * c + 1.5 * s, -4.5 * s - 1.5 * c, 4.0 + 4.0 * t * 0.5};
  const double expected_tangents[] = {c, s, t * t, -2.0 * s, 2.0 * c, 0.0};
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(r[i], r_alone[i]);
    EXPECT_NEAR(v[i], expected_v[i], 2e-15);
    EXPECT_NEAR(psi[i], expected_psi[i], 4e-15);
  }
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(tangents[i], expected_tangents[i], 1e-15);
}

/// Makes a smooth random expression in the coordinates of two points.
class RandomFormula {
 public:
  explicit RandomFormula(unsigned seed) : random_(seed) {}

  std::string make(int depth) {
    const int choice = std::uniform_int_distribution(0, depth > 0 ? 9 : 1)(random_);
    const auto part = [&] { return make(depth - 1); };
    switch (choice) {
      case 0:
        return names_[std::uniform_int_distribution<std::size_t>(0, 5)(random_)];
      case 1:
        return std::to_string(std::uniform_real_distribution(0.2, 2.0)(random_));
      case 2:
        return "(" + part() + " + " + part() + ")";
      case 3:
        return "(" + part() + " - " + part() + ")";
      case 4:
        return "(" + part() + "*" + part() + ")";
      case 5:
        return "(" + part() + "/(1 + (" + part() + ")^2))";
      case 6:
        return "sin(" + part() + ")";
      case 7:
        return "sqrt(1 + (" + part() + ")^2)";
      case 8:
        return "exp(tanh(" + part() + "))";
      default:
        return "atan2(" + part() + ", 2 + cos(" + part() + "))";
    }
  }

 private:
  std::mt19937 random_;
  const std::vector<std::string> names_ = {"x1", "y1", "z1", "x2", "y2", "z2"};
};

TEST(UserKernel, GradientsOfRandomFormulasAreTheirDirectionalDerivatives) {
  const std::vector<double> r = uniform_numbers(6 * 40, 5), v = uniform_numbers(6 * 40, 6);
  int with_gradient = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const std::string text = RandomFormula(seed).make(5);

    const Numbers found = evaluate(formula_constraint(text, 2), 0.0, r, v);

    for (std::size_t k = 0; k < 40; ++k) {
      // K'v of the forward derivatives is compared with the rate of the jet.
      double sum = 0.0, size = 0.0;
      for (std::size_t i = 6 * k; i < 6 * k + 6; ++i) {
        sum += found.gradient[i] * v[i];
        size += std::abs(found.gradient[i] * v[i]);
      }
      EXPECT_NEAR(found.rate[k], sum, 1e-13 * (size + std::abs(found.xi[k]))) << text;
      with_gradient += size > 0.0;
    }
  }
  EXPECT_GT(with_gradient, 100 * 40);
}

// ---- in a system ---------------------------------------------------------------------------------------------------

constexpr double rod_length = 0.4;

ConstraintKernel jet_rod() {
  return make_constraint_kernel<2>([](const auto& x, const auto&) {
    const auto a = x[3] - x[0], b = x[4] - x[1], c = x[5] - x[2];
    return sqrt(a * a + b * b + c * c) - rod_length;
  });
}
ConstraintKernel formula_rod() {
  return formula_constraint("sqrt((x2-x1)^2 + (y2-y1)^2 + (z2-z1)^2) - l", 2, {{"l", rod_length}});
}

/// Makes a zigzag of rods on a support that swings.
System make_zigzag(Index num_points, const Constraint& rods) {
  System system;
  for (Index i = 0; i < num_points; ++i) {
    system.positions.insert(system.positions.end(), {0.3 * i, 0.1 * (i % 2) * std::sqrt(7.0), 0.0});
  }
  system.masses.assign(static_cast<std::size_t>(num_points), 0.5);
  system.supports = {{"", {0}, {ScalarFunction::formula("0.1*sin(3*t)"), ScalarFunction::formula("t^2"), 0.0}}};
  system.constraints = {rods};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}

UserConstraints make_user_rods(Index num_points, const ConstraintKernel& kernel) {
  UserConstraints user{"", {}, kernel};
  for (Index i = 1; i < num_points; ++i) user.tuples.push_back({i - 1, i});
  return user;
}

TEST(UserConstraints, RodsInThreeWaysGiveTheSameMotionAlsoOnASupportThatMoves) {
  constexpr Index n = 8;
  Rods rods{"", {}, rod_length, {}};
  for (Index i = 1; i < n; ++i) rods.pairs.push_back({i - 1, i});
  const auto solve = [](const Constraint& constraint, std::vector<double>* loads) {
    Dynamics dynamics(make_zigzag(n, constraint));
    std::vector<double> r = dynamics.system().positions, v = uniform_numbers(3 * n, 4), w(3 * n), lambda(n - 1);
    EXPECT_TRUE(dynamics.project_positions({.time = 0.3, .positions = r}).outcome.ok());
    EXPECT_TRUE(dynamics.project_velocities({.time = 0.3, .positions = r, .velocities = v}).outcome.ok());
    loads->resize(3 * n);
    EXPECT_TRUE(dynamics
                    .solve({.time = 0.3, .positions = r, .velocities = v},
                           {.accelerations = w, .multipliers = lambda, .support_forces = *loads})
                    .outcome.ok());
    w.insert(w.end(), lambda.begin(), lambda.end());
    return Eigen::VectorXd(reference::vector(w));
  };
  std::vector<double> loads, user_loads;
  const Eigen::VectorXd expected = solve(rods, &loads);

  for (const ConstraintKernel& kernel : {jet_rod(), formula_rod()}) {
    const Eigen::VectorXd found = solve(make_user_rods(n, kernel), &user_loads);

    EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff());
    EXPECT_LE((reference::vector(user_loads) - reference::vector(loads)).norm(),
              1e-12 * reference::vector(loads).norm());
    EXPECT_GT(reference::vector(loads).norm(), 1.0);
  }
}

struct Evaluation {
  std::vector<double> xi, rate, phi, blocks, y;
  double worst[4];
  bool operator==(const Evaluation&) const = default;
};

Evaluation evaluate_all(Constraints& constraints, int threads) {
  const Parallel parallel(threads);
  const std::size_t d = constraints.num_rows(), size = 3 * (d + 1);
  const std::vector<double> r = uniform_numbers(size, 1), v = uniform_numbers(size, 2), w = uniform_numbers(size, 3);
  Evaluation e{std::vector<double>(d), std::vector<double>(d),
               std::vector<double>(d), std::vector<double>(3 * constraints.num_blocks()),
               std::vector<double>(d), {}};
  e.worst[0] = constraints.evaluate_values(parallel, r.data(), e.xi.data());
  e.worst[1] = constraints.evaluate_rates(parallel, r.data(), v.data(), e.rate.data());
  e.worst[2] = constraints.evaluate_right_side(parallel, r.data(), v.data(), w.data(), e.phi.data(), e.blocks.data());
  e.worst[3] = constraints.apply_transposed(parallel, e.blocks.data(), w.data(), nullptr, e.y.data());
  return e;
}

TEST(UserConstraints, AnyNumberOfThreadsGivesTheSameBits) {
  constexpr Index n = 10001;
  for (const ConstraintKernel& kernel : {jet_rod(), formula_rod()}) {
    const System system = make_zigzag(n, make_user_rods(n, kernel));
    Constraints constraints(system, number(system));

    const Evaluation one = evaluate_all(constraints, 1);

    for (const int threads : {2, 3, 5}) EXPECT_TRUE(one == evaluate_all(constraints, threads)) << threads;
  }
}

TEST(UserConstraints, WhatAUsersFunctionThrowsIsRethrown) {
  constexpr Index n = 10001;
  const ConstraintKernel kernel = make_constraint_kernel<2>([](const auto& x, const auto& t) {
    if (t > 1.0) throw std::runtime_error("behind the end of my table");
    return x[0] - x[3];
  });
  const System system = make_zigzag(n, make_user_rods(n, kernel));
  Constraints constraints(system, number(system));
  constraints.set_time(2.0);

  for (const int threads : {1, 2}) {
    try {
      (void)evaluate_all(constraints, threads);
      FAIL() << threads;
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "behind the end of my table");
    }
  }
}

TEST(UserConstraints, AFunctionThatIsNotThreadSafeIsCalledByOneThread) {
  constexpr Index n = 10001;
  std::atomic<int> strangers{0};
  const auto caller = std::this_thread::get_id();
  for (const bool thread_safe : {true, false}) {
    strangers = 0;
    const System system = make_zigzag(n, make_user_rods(n, make_constraint_kernel<2>(
                                                               [&](const auto& x, const auto&) {
                                                                 strangers += std::this_thread::get_id() != caller;
                                                                 return x[0] - x[3];
                                                               },
                                                               thread_safe)));
    Constraints constraints(system, number(system));

    (void)evaluate_all(constraints, 2);

    EXPECT_EQ(strangers > 0, thread_safe);
  }
}

}  // namespace
}  // namespace tanor
