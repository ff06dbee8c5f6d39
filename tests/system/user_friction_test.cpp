/// Values and derivatives of users' laws of friction are compared with closed forms.

#include <cmath>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/system.hpp>
#include <tanor/user_kernel.hpp>

#include "random_numbers.hpp"

namespace tanor {
namespace {

/// A Stribeck law on a wire: its value and its derivatives by the multipliers.
///
///     |N| = sqrt(lambda_1^2 + lambda_2^2),  mu = 0.2 + 0.1 exp(-(v/0.1)^2),  tau = -mu |N| v/sqrt(v^2 + 0.01^2)
TEST(UserFriction, LawOfAWireHasItsValueAndItsDerivatives) {
  const FrictionKernel kernel = make_friction_kernel<2>(
      [](const Vector3& r, const Vector3& v, double t, const auto& lambda) {
        using std::sqrt;
        const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        const double mu = 0.2 + 0.1 * std::exp(-square / 0.01), slowing = std::sqrt(square + 1e-4);
        const auto normal = sqrt(lambda[0] * lambda[0] + lambda[1] * lambda[1]);
        const double wear = 1.0 + r[2] + t;
        return std::array{-wear * mu * v[0] / slowing * normal, -wear * mu * v[1] / slowing * normal,
                          -wear * mu * v[2] / slowing * normal};
      },
      false);
  constexpr std::size_t count = 100;
  const std::vector<double> r = uniform_numbers(3 * count, 1), v = uniform_numbers(3 * count, 2),
                            lambda = uniform_numbers(2 * count, 3);
  const double t = 0.7;
  std::vector<double> tau(3 * count), tau_alone(3 * count), derivative(6 * count);

  kernel.evaluate(kernel.context.get(), {count, t, r.data(), v.data(), lambda.data(), tau.data(), derivative.data()});
  kernel.evaluate(kernel.context.get(), {count, t, r.data(), v.data(), lambda.data(), tau_alone.data(), nullptr});

  EXPECT_EQ(kernel.num_multipliers, 2);
  EXPECT_FALSE(kernel.thread_safe);
  for (std::size_t k = 0; k < count; ++k) {
    const double *const u = &v[3 * k], *const l = &lambda[2 * k];
    const double square = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], normal = std::hypot(l[0], l[1]);
    const double factor = -(1.0 + r[3 * k + 2] + t) * (0.2 + 0.1 * std::exp(-square / 0.01)) / std::sqrt(square + 1e-4);
    for (std::size_t i = 0; i < 3; ++i) {
      const double size = std::abs(factor * u[i]);
      EXPECT_NEAR(tau[3 * k + i], factor * u[i] * normal, 1e-15 * size * normal);
      EXPECT_NEAR(tau_alone[3 * k + i], factor * u[i] * normal, 1e-15 * size * normal);
      for (std::size_t a = 0; a < 2; ++a)
        EXPECT_NEAR(derivative[2 * (3 * k + i) + a], factor * u[i] * l[a] / normal, 2e-15 * size);
    }
  }
}

/// The floor of docs/modelling.md has mu = 0.2 + 0.1 exp(-|v|/0.05) and one multiplier, which pushes or pulls.
TEST(UserFriction, LawOfASurfaceIsEvenInItsMultiplier) {
  const FrictionKernel kernel =
      make_friction_kernel<1>([](const Vector3&, const Vector3& v, double, const auto& lambda) {
        using std::abs;
        const double speed = std::hypot(v[0], v[1], v[2]), mu = 0.2 + 0.1 * std::exp(-speed / 0.05);
        const auto size = -mu / std::hypot(speed, 1e-4) * abs(lambda[0]);
        return std::array{v[0] * size, v[1] * size, v[2] * size};
      });
  const double r[6] = {}, v[] = {0.3, -0.4, 0, 0.3, -0.4, 0}, lambda[] = {7.0, -7.0};
  double tau[6], derivative[6];

  kernel.evaluate(kernel.context.get(), {2, 0.0, r, v, lambda, tau, derivative});

  const double mu = (0.2 + 0.1 * std::exp(-10.0)) * 0.5 / std::hypot(0.5, 1e-4);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(tau[3 * k], -mu * 7.0 * 0.6, 1e-15);
    EXPECT_NEAR(tau[3 * k + 1], mu * 7.0 * 0.8, 1e-15);
    EXPECT_EQ(tau[3 * k + 2], 0.0);
    EXPECT_NEAR(derivative[3 * k], (k == 0 ? -mu : mu) * 0.6, 1e-16);
    EXPECT_NEAR(derivative[3 * k + 1], (k == 0 ? mu : -mu) * 0.8, 2e-16);
  }
}

TEST(UserFriction, WhatALawThrowsReachesTheCaller) {
  const FrictionKernel kernel =
      make_friction_kernel<1>([](const Vector3&, const Vector3&, double,
                                 const auto& lambda) -> std::array<std::decay_t<decltype(lambda[0])>, 3> {
        throw std::runtime_error("no law here");
      });
  const double zero[3] = {};
  double tau[3];

  EXPECT_THROW(kernel.evaluate(kernel.context.get(), {1, 0.0, zero, zero, zero, tau, nullptr}), std::runtime_error);
}

}  // namespace
}  // namespace tanor
